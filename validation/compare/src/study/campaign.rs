//! Execution of a campaign: jobs of (scene, code, seed, settings) on the thread pool, their results in the order of the jobs.
//!
//! A job takes its result from a [`RunCache`] where an earlier start has stored it, so that a campaign resumes: one file per run, written as a
//! whole. A [`Key`] holds all inputs of a run: scene, seed, settings, builds. A file of another key belongs to another run, and a file with
//! a wrong checksum is damaged: the run counts as missing, and its file is overwritten.

use super::DocumentError;
use crate::codes::CodeError;
use crate::scenes::SceneError;
use makadam::BUILD;
use makadam::checkpoint::checksum;
use makadam_frames::output::{WriteError, create_folder, write_whole};
use makadam_frames::plan::MeasuredScene;
use makadam_frames::provenance::scene_hash;
use rayon::prelude::*;
use serde::de::DeserializeOwned;
use serde::{Deserialize, Serialize};
use std::collections::BTreeSet;
use std::io::ErrorKind;
use std::path::{Path, PathBuf};
use std::sync::Mutex;
use std::sync::atomic::{AtomicU64, Ordering};

/// Error that ended a run; finished runs remain stored.
#[derive(Debug, thiserror::Error)]
pub enum RunError {
    /// The scene is invalid.
    #[error(transparent)]
    Scene(#[from] SceneError),
    /// The code is missing or failed.
    #[error(transparent)]
    Code(CodeError),
    /// The run reached a state that invalidates its numbers; a repetition would, too.
    #[error("{0}")]
    Invalid(String),
    /// The run cannot be stored.
    #[error(transparent)]
    Write(#[from] WriteError),
    /// A solver or a document outside the runs failed.
    #[error("{0}")]
    Failed(String),
    /// The user asked to stop.
    #[error("interrupted")]
    Interrupted,
}

impl RunError {
    /// Returns true if no other run may follow: the user asked to stop, or nothing can be stored.
    pub fn ends_all(&self) -> bool {
        matches!(self, RunError::Write(_) | RunError::Interrupted)
    }
}

impl From<CodeError> for RunError {
    fn from(error: CodeError) -> RunError {
        match error {
            CodeError::Scene(error) => RunError::Scene(error),
            CodeError::Interrupted { .. } => RunError::Interrupted,
            CodeError::InvalidState { .. } => RunError::Invalid(error.to_string()),
            other => RunError::Code(other),
        }
    }
}

impl From<DocumentError> for RunError {
    fn from(error: DocumentError) -> RunError {
        RunError::Failed(error.to_string())
    }
}

/// Runs jobs on the thread pool, those with the most work first; `progress` receives the fraction of the work that is done.
///
/// # Errors
/// Error of a job; the other jobs that have begun end first.
pub fn run_jobs<J: Sync, R: Send, E: Send>(
    jobs: &[J],
    work: impl Fn(&J) -> f64,
    progress: &(dyn Fn(f64) + Sync),
    run: impl Fn(&J, &(dyn Fn(f64) + Sync)) -> Result<R, E> + Sync,
) -> Result<Vec<R>, E> {
    let works: Vec<f64> = jobs.iter().map(work).collect();
    let total: f64 = works.iter().sum();
    let fractions: Vec<AtomicU64> = jobs.iter().map(|_| AtomicU64::new(0)).collect();
    let one = |number: usize| {
        let done = |fraction: f64| {
            fractions[number].store(fraction.to_bits(), Ordering::Relaxed);
            let done = fractions.iter().map(|fraction| f64::from_bits(fraction.load(Ordering::Relaxed)));
            progress(done.zip(&works).map(|(fraction, work)| fraction * work).sum::<f64>() / total);
        };
        let result = run(&jobs[number], &done)?;
        done(1.0);
        Ok((number, result))
    };
    // A long job that begins last would run alone.
    let mut order: Vec<usize> = (0..jobs.len()).collect();
    order.sort_by(|&a, &b| works[b].total_cmp(&works[a]));
    let mut results = order.into_iter().par_bridge().map(one).collect::<Result<Vec<_>, E>>()?;
    results.sort_by_key(|(number, _)| *number);
    Ok(results.into_iter().map(|(_, result)| result).collect())
}

/// Version of the layout; files of another one are damaged.
const VERSION: u32 = 1;

/// Identity of a run, and the name of its file.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Key {
    name: String,
    hash: String,
}

impl Key {
    /// Returns the key of a run that depends on these parts alone, stored in NAME.json.
    pub fn new(name: String, parts: &[&str]) -> Key {
        Key { name, hash: format!("{:016x}", checksum(parts.join("\n").as_bytes())) }
    }

    /// Returns the key of a run of a scene: scene, watchdogs, seed, builds of solver and validation, and further settings.
    pub fn of_run(name: String, scene: &MeasuredScene, seed: u64, settings: &[&str]) -> Key {
        let watch = serde_json::to_string(&scene.watch).expect("a checked scene holds finite numbers and plain text");
        let (hash, seed) = (format!("{:016x}", scene_hash(scene)), seed.to_string());
        Key::new(name, &[&[hash.as_str(), &watch, &seed, BUILD, crate::BUILD], settings].concat())
    }

    /// Name of its file, without the extension.
    pub fn name(&self) -> &str {
        &self.name
    }

    /// Adds the hash to the name of the file, so that several runs of that name can be stored.
    pub fn apart(self) -> Key {
        Key { name: format!("{}-{}", self.name, self.hash), ..self }
    }
}

/// Content of a file.
#[derive(Serialize, Deserialize)]
struct Sealed<T> {
    version: u32,
    key: String,
    /// 64-bit FNV-1a hash of the run as compact JSON, 16 hexadecimal digits.
    seal: String,
    /// Run, or the reason why its numbers are invalid.
    kept: Result<T, String>,
}

/// Folder of finished runs.
pub struct RunCache {
    folder: PathBuf,
    /// True if runs of earlier starts are repeated.
    again: bool,
    /// Names of the runs made by this start, and of those taken from earlier ones.
    made: Mutex<BTreeSet<String>>,
    taken: Mutex<BTreeSet<String>>,
}

impl RunCache {
    /// Opens a folder, creating it if missing. With `again`, runs of earlier starts count as missing.
    ///
    /// # Errors
    /// [`WriteError`] if the system refuses.
    pub fn open(folder: &Path, again: bool) -> Result<RunCache, WriteError> {
        create_folder(folder)?;
        Ok(RunCache { folder: folder.to_path_buf(), again, made: Mutex::default(), taken: Mutex::default() })
    }

    fn file(&self, key: &Key) -> PathBuf {
        self.folder.join(format!("{}.json", key.name))
    }

    /// Returns a stored run. A damaged file counts as missing.
    ///
    /// # Errors
    /// [`RunError::Invalid`] of a run whose numbers are invalid; [`RunError::Write`] if the file cannot be read.
    pub fn find<T: Serialize + DeserializeOwned>(&self, key: &Key) -> Result<Option<T>, RunError> {
        let own = names(&self.made).contains(key.name());
        if self.again && !own {
            return Ok(None);
        }
        let file = self.file(key);
        let bytes = match std::fs::read(&file) {
            Ok(bytes) => bytes,
            Err(error) if error.kind() == ErrorKind::NotFound => return Ok(None),
            Err(error) => return Err(WriteError::new(&file, error).into()),
        };
        let Some(sealed) = whole::<T>(&bytes).filter(|sealed| sealed.key == key.hash) else { return Ok(None) };
        if !own {
            names(&self.taken).insert(key.name.clone());
        }
        sealed.kept.map(Some).map_err(RunError::Invalid)
    }

    /// Stores a run. JSON represents only finite numbers: a run with another number is not stored, and the next start repeats it.
    ///
    /// # Errors
    /// [`WriteError`] if the system refuses.
    pub fn keep<T: Serialize + DeserializeOwned>(&self, key: &Key, run: &T) -> Result<(), WriteError> {
        self.store(key, Ok(run))
    }

    fn store<T: Serialize + DeserializeOwned>(&self, key: &Key, run: Result<&T, String>) -> Result<(), WriteError> {
        let bytes = sealed(run, key);
        if whole::<T>(&bytes).is_some() {
            write_whole(&self.file(key), &bytes)?;
        }
        names(&self.made).insert(key.name.clone());
        Ok(())
    }

    /// Returns the stored run, or makes and stores it.
    ///
    /// # Errors
    /// [`RunError`] of `make`, or if the run cannot be stored. A run with invalid numbers is stored as such.
    pub fn take<T: Serialize + DeserializeOwned>(
        &self,
        key: &Key,
        make: impl FnOnce() -> Result<T, RunError>,
    ) -> Result<T, RunError> {
        if let Some(run) = self.find(key)? {
            return Ok(run);
        }
        let made = make();
        match &made {
            Ok(run) => self.store(key, Ok(run))?,
            Err(RunError::Invalid(problem)) => self.store::<T>(key, Err(problem.clone()))?,
            Err(_) => {}
        }
        made
    }

    /// Numbers of runs made by this start, and taken from earlier ones.
    pub fn counts(&self) -> [usize; 2] {
        [&self.made, &self.taken].map(|set| names(set).len())
    }
}

fn names(set: &Mutex<BTreeSet<String>>) -> std::sync::MutexGuard<'_, BTreeSet<String>> {
    set.lock().expect("nothing panics while it holds the lock")
}

/// Bytes of the file of a run, or of the reason why its numbers are invalid.
pub fn sealed<T: Serialize>(kept: Result<&T, String>, key: &Key) -> Vec<u8> {
    let sealed = Sealed { version: VERSION, key: key.hash.clone(), seal: hash(&kept), kept };
    serde_json::to_vec_pretty(&sealed).expect("a run holds only numbers and plain text")
}

/// Returns the run in the bytes of a file; `None` unless the bytes equal those that [`sealed`] gives for the run under the key.
pub fn unseal<T: Serialize + DeserializeOwned>(bytes: &[u8], key: &Key) -> Option<T> {
    whole(bytes).filter(|sealed| sealed.key == key.hash)?.kept.ok()
}

fn whole<T: Serialize + DeserializeOwned>(bytes: &[u8]) -> Option<Sealed<T>> {
    let sealed: Sealed<T> = serde_json::from_slice(bytes).ok()?;
    (sealed.version == VERSION && sealed.seal == hash(&sealed.kept)).then_some(sealed)
}

fn hash(run: &impl Serialize) -> String {
    let text = serde_json::to_vec(run).expect("a run holds only numbers and plain text");
    format!("{:016x}", checksum(&text))
}

#[cfg(test)]
#[path = "../../tests/unit/study_campaign.rs"]
mod tests;
