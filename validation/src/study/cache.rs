//! Finished runs on disk: one small file a run, written whole or not at all, taken up by the next start.
//!
//! A [`Key`] holds all that a run follows from: scene, seed, settings, the build of the code. A file of another key is of another
//! run: it counts as missing and is written over. A file whose seal does not fit is damaged: it is moved aside, and the run
//! counts as missing. Nothing else makes a run invalid.

use crate::output::{WriteError, create_folder, write_whole};
use makadam::checkpoint::checksum;
use serde::de::DeserializeOwned;
use serde::{Deserialize, Serialize};
use std::io::ErrorKind;
use std::path::{Path, PathBuf};

/// Version of the layout; files of another one are damaged.
const VERSION: u32 = 1;

/// Ending of the name of a file that was damaged.
const DAMAGED: &str = "damaged";

/// What tells a run from every other one, and the name of its file.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Key {
    name: String,
    hash: String,
}

impl Key {
    /// The key of a run that follows from these parts alone, kept in NAME.json.
    pub fn new(name: String, parts: &[&str]) -> Key {
        Key { name, hash: hash_of(parts) }
    }

    /// The name of its file, without the ending.
    pub fn name(&self) -> &str {
        &self.name
    }

    /// The same with its hash in the name of the file too, so that other runs of that name stay beside it.
    pub fn apart(self) -> Key {
        Key { name: format!("{}-{}", self.name, self.hash), ..self }
    }
}

fn hash_of(parts: &[&str]) -> String {
    format!("{:016x}", checksum(parts.join("\n").as_bytes()))
}

/// What a file holds: the run, and a seal by which damage is seen.
#[derive(Serialize, Deserialize)]
struct Sealed<T> {
    version: u32,
    key: String,
    /// 64-bit FNV-1a hash of the run as compact JSON, 16 hexadecimal digits.
    seal: String,
    kept: T,
}

/// What a folder holds of a run.
#[derive(Debug)]
pub enum Found<T> {
    /// Nothing.
    Nothing,
    /// The run.
    Run(T),
    /// A file that is not what was written; it was moved out of the way to this path.
    Damaged(PathBuf),
}

/// A folder of finished runs.
pub struct RunCache {
    folder: PathBuf,
}

impl RunCache {
    /// The folder, which is made if it is not there.
    ///
    /// # Errors
    /// [`WriteError`] if the system refuses.
    pub fn open(folder: &Path) -> Result<RunCache, WriteError> {
        create_folder(folder)?;
        Ok(RunCache { folder: folder.to_path_buf() })
    }

    fn file(&self, key: &Key) -> PathBuf {
        self.folder.join(format!("{}.json", key.name))
    }

    /// What is there of a run. A damaged file is kept under another name, and the run counts as missing.
    ///
    /// # Errors
    /// [`WriteError`] if the file cannot be read or moved.
    pub fn find<T: Serialize + DeserializeOwned>(&self, key: &Key) -> Result<Found<T>, WriteError> {
        let file = self.file(key);
        let bytes = match std::fs::read(&file) {
            Ok(bytes) => bytes,
            Err(error) if error.kind() == ErrorKind::NotFound => return Ok(Found::Nothing),
            Err(error) => return Err(WriteError::new(&file, error)),
        };
        match whole(&bytes) {
            Some(sealed) if sealed.key == key.hash => Ok(Found::Run(sealed.kept)),
            Some(_) => Ok(Found::Nothing),
            None => {
                let aside = file.with_extension(DAMAGED);
                std::fs::rename(&file, &aside).map_err(|error| WriteError::new(&file, error))?;
                Ok(Found::Damaged(aside))
            }
        }
    }

    /// Keeps a run.
    ///
    /// # Errors
    /// [`WriteError`] if the system refuses.
    pub fn keep(&self, key: &Key, run: &impl Serialize) -> Result<(), WriteError> {
        write_whole(&self.file(key), &sealed(run, key))
    }

    /// The run that is kept, unless it is to be made `again`; else the one that is made now, which is kept.
    ///
    /// # Errors
    /// Those of `make`, and [`WriteError`] if it cannot be kept.
    pub fn take<T, E>(&self, key: &Key, again: bool, make: impl FnOnce() -> Result<T, E>) -> Result<T, E>
    where
        T: Serialize + DeserializeOwned,
        E: From<WriteError>,
    {
        if !again && let Found::Run(run) = self.find(key)? {
            return Ok(run);
        }
        let run = make()?;
        self.keep(key, &run)?;
        Ok(run)
    }
}

/// Files in a folder, and in those that it holds, that were damaged and moved aside, at this start or an earlier one, sorted.
pub fn damaged_below(folder: &Path) -> Vec<PathBuf> {
    let mut damaged = Vec::new();
    for path in std::fs::read_dir(folder).into_iter().flatten().flatten().map(|entry| entry.path()) {
        // No link is followed: a folder may hold one to itself.
        match path.symlink_metadata() {
            Ok(about) if about.is_dir() => damaged.extend(damaged_below(&path)),
            Ok(_) if path.extension().is_some_and(|extension| extension == DAMAGED) => damaged.push(path),
            _ => {}
        }
    }
    damaged.sort();
    damaged
}

/// Bytes of the file of a run.
pub fn sealed<T: Serialize>(run: &T, key: &Key) -> Vec<u8> {
    let sealed = Sealed { version: VERSION, key: key.hash.clone(), seal: seal(run), kept: run };
    serde_json::to_vec_pretty(&sealed).expect("a run holds only numbers and plain text")
}

/// The run in the bytes of a file; `None` unless they are, to the number, what was [`sealed`] under the key.
pub fn unseal<T: Serialize + DeserializeOwned>(bytes: &[u8], key: &Key) -> Option<T> {
    whole(bytes).filter(|sealed| sealed.key == key.hash).map(|sealed| sealed.kept)
}

fn whole<T: Serialize + DeserializeOwned>(bytes: &[u8]) -> Option<Sealed<T>> {
    let sealed: Sealed<T> = serde_json::from_slice(bytes).ok()?;
    (sealed.version == VERSION && sealed.seal == seal(&sealed.kept)).then_some(sealed)
}

fn seal(run: &impl Serialize) -> String {
    let text = serde_json::to_vec(run).expect("a run holds only numbers and plain text");
    format!("{:016x}", checksum(&text))
}

#[cfg(test)]
#[path = "../../tests/unit/study_cache.rs"]
mod tests;
