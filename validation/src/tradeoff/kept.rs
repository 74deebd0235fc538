//! Finished runs on disk: one small file a run, written whole or not at all.

use super::configuration::Configuration;
use crate::compare::MeasuredRun;
use crate::output::{WriteError, create_folder, write_whole};
use crate::plan::Scene;
use crate::prepared::file_stem;
use crate::provenance::{Build, scene_hash};
use makadam::checkpoint::checksum;
use serde::{Deserialize, Serialize};
use std::io::ErrorKind;
use std::path::{Path, PathBuf};

/// Version of the layout; files of another one are not read.
const VERSION: u32 = 1;

/// What is kept of one run.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct KeptRun {
    /// How it was run.
    pub configuration: Configuration,
    /// Whether it was stopped before the scene's end, so that it tells wall time and nothing else.
    pub extrapolated: bool,
    /// Share of a core that the run got, 0 to 1; absent where the system does not tell.
    pub core_share: Option<f64>,
    /// Its measurements and times.
    pub run: MeasuredRun,
    /// The program that started it, and the machine.
    pub build: Build,
    /// The command line.
    pub command: String,
}

impl KeptRun {
    /// Wall time of the stepping on a core of its own, s: as measured, times the share of a core that the run got.
    pub fn core_seconds(&self) -> f64 {
        self.run.wall_seconds * self.core_share.unwrap_or(1.0)
    }

    /// The same over simulated time.
    pub fn pace(&self) -> f64 {
        self.core_seconds() / self.run.simulated_seconds
    }
}

/// What a file holds: the run, and a seal by which damage is seen.
#[derive(Serialize, Deserialize)]
struct Sealed {
    version: u32,
    key: String,
    /// 64-bit FNV-1a hash of the run as compact JSON, 16 hexadecimal digits.
    seal: String,
    kept: KeptRun,
}

/// What tells a run from every other one.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Key {
    stem: String,
    hash: String,
}

impl Key {
    /// The key of a seed's run: scene, knobs, seed, the code and its version (which holds the [key of the build](makadam::BUILD)
    /// where the code is Makadam), and the processor, since a wall time of another one is another number.
    pub fn new(scene: &Scene, configuration: &Configuration, version: &str, seed: u64, processor: &str) -> Key {
        let scene = configuration.scene(scene);
        let knobs = serde_json::to_string(configuration).expect("a configuration holds only numbers and plain text");
        let text = format!("{:016x}\n{knobs}\n{version}\n{seed}\n{processor}", scene_hash(&scene));
        let stem = format!("{}-{}-s{seed}", file_stem(&scene.name), configuration.code.to_lowercase());
        Key { stem, hash: format!("{:016x}", checksum(text.as_bytes())) }
    }
}

/// What a folder holds of a run.
#[derive(Debug)]
pub enum Found {
    /// Nothing.
    Nothing,
    /// The run.
    Run(Box<KeptRun>),
    /// A file that is not what was written; it was moved out of the way to this path.
    Damaged(PathBuf),
}

/// A folder of finished runs.
pub struct Shelf {
    folder: PathBuf,
}

impl Shelf {
    /// The folder, which is made if it is not there.
    ///
    /// # Errors
    /// [`WriteError`] if the system refuses.
    pub fn open(folder: &Path) -> Result<Shelf, WriteError> {
        create_folder(folder)?;
        Ok(Shelf { folder: folder.to_path_buf() })
    }

    /// File of a run.
    pub fn file(&self, key: &Key) -> PathBuf {
        self.folder.join(format!("{}-{}.json", key.stem, key.hash))
    }

    /// What is there of a run. A damaged file is kept under another name, and the run counts as missing.
    ///
    /// # Errors
    /// [`WriteError`] if the file cannot be read or moved.
    pub fn find(&self, key: &Key) -> Result<Found, WriteError> {
        let file = self.file(key);
        let bytes = match std::fs::read(&file) {
            Ok(bytes) => bytes,
            Err(error) if error.kind() == ErrorKind::NotFound => return Ok(Found::Nothing),
            Err(error) => return Err(WriteError::new(&file, error)),
        };
        if let Some(kept) = unseal(&bytes, key) {
            return Ok(Found::Run(Box::new(kept)));
        }
        let aside = file.with_extension("damaged");
        std::fs::rename(&file, &aside).map_err(|error| WriteError::new(&file, error))?;
        Ok(Found::Damaged(aside))
    }

    /// Keeps a run.
    ///
    /// # Errors
    /// [`WriteError`] if the system refuses.
    pub fn keep(&self, key: &Key, kept: &KeptRun) -> Result<(), WriteError> {
        write_whole(&self.file(key), &sealed(kept, key))
    }
}

/// Bytes of the file of a run.
pub fn sealed(kept: &KeptRun, key: &Key) -> Vec<u8> {
    let sealed = Sealed { version: VERSION, key: key.hash.clone(), seal: seal(kept), kept: kept.clone() };
    serde_json::to_vec_pretty(&sealed).expect("a run holds only numbers and plain text")
}

/// The run in the bytes of a file; `None` unless they are, to the number, what was [`sealed`] under the key.
pub fn unseal(bytes: &[u8], key: &Key) -> Option<KeptRun> {
    let sealed: Sealed = serde_json::from_slice(bytes).ok()?;
    let whole = sealed.version == VERSION && sealed.key == key.hash && sealed.seal == seal(&sealed.kept);
    whole.then_some(sealed.kept)
}

fn seal(kept: &KeptRun) -> String {
    let text = serde_json::to_vec(kept).expect("a run holds only numbers and plain text");
    format!("{:016x}", checksum(&text))
}
