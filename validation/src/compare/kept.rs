//! Finished runs of codes on disk, measured: whoever asks for one that is there, now or at the next start, gets that one.

use super::{Harvest, Runs};
use crate::output::{WriteError, file_stem};
use crate::peers::{Code, CodeError, Purpose};
use crate::plan::Scene;
use crate::provenance::{JUDGE, machine, scene_hash};
use crate::study::{Found, Key, RunCache, sealed, unseal};
use makadam::BUILD;
use serde::{Deserialize, Serialize};
use std::collections::BTreeSet;
use std::path::Path;
use std::sync::Mutex;

/// Seed of the run that pictures and curves over time are made from; of the others the numbers alone are kept.
const PICTURED_SEED: u64 = 1;

/// A folder of finished runs.
///
/// The key of a run is all that it follows from: scene, watchdogs, seed, settings, the code with its version and contact law, the keys
/// of Makadam's build and of the judge's sources.
pub struct KeptRuns {
    cache: RunCache,
    /// Whether runs of earlier starts are made again.
    again: bool,
    /// Names of the runs that were made by this start.
    made: Mutex<BTreeSet<String>>,
    /// Names of those that it took from an earlier one.
    taken: Mutex<BTreeSet<String>>,
}

/// Why there is no run.
#[derive(Debug, thiserror::Error)]
pub enum KeptError {
    /// The code failed, or the user asked to stop.
    #[error(transparent)]
    Code(CodeError),
    /// The run came to a state that makes its numbers worthless, now or when it was kept: it would do so again.
    #[error("{0}")]
    Worthless(String),
    /// The run cannot be kept.
    #[error(transparent)]
    Write(#[from] WriteError),
}

impl KeptError {
    /// Whether nothing else is to be run after it: the user asked to stop, or nothing can be kept. Otherwise the run alone has failed.
    pub fn ends_all(&self) -> bool {
        matches!(self, KeptError::Write(_) | KeptError::Code(CodeError::Interrupted { .. }))
    }
}

impl From<CodeError> for KeptError {
    fn from(error: CodeError) -> KeptError {
        match error {
            worthless @ CodeError::Worthless { .. } => KeptError::Worthless(worthless.to_string()),
            other => KeptError::Code(other),
        }
    }
}

/// What a file holds.
#[derive(Clone, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
enum Kept {
    Run(Box<Harvest>),
    Worthless(String),
}

impl KeptRuns {
    /// The runs of a folder, which is made if it is not there; with `again`, runs of earlier starts count as missing.
    ///
    /// # Errors
    /// [`WriteError`] if the system refuses.
    pub fn open(folder: &Path, again: bool) -> Result<KeptRuns, WriteError> {
        Ok(KeptRuns { cache: RunCache::open(folder)?, again, made: Mutex::default(), taken: Mutex::default() })
    }

    /// A run of a code, which is made if it is not there. It may have been made beside others or alone on the machine.
    ///
    /// # Errors
    /// [`KeptError`] if it has to be made and cannot.
    pub fn take(&self, runs: &Runs<'_>, code: &dyn Code, seed: u64) -> Result<Harvest, KeptError> {
        let scene = runs.scene.with_stiffness_factor(runs.stiffness_factor);
        let key = key(runs, &scene, code, seed);
        for known in [&key, &alone(runs, &scene, code, seed)] {
            if let Some(kept) = self.find(known)? {
                return kept;
            }
        }
        self.make(&key, runs, &scene, code, seed)
    }

    /// The same of a run that had the machine to itself: see to it that it has where it is made.
    ///
    /// # Errors
    /// As [`KeptRuns::take`].
    pub fn take_alone(&self, runs: &Runs<'_>, code: &dyn Code, seed: u64) -> Result<Harvest, KeptError> {
        let scene = runs.scene.with_stiffness_factor(runs.stiffness_factor);
        let key = alone(runs, &scene, code, seed);
        match self.find(&key)? {
            Some(kept) => kept,
            None => self.make(&key, runs, &scene, code, seed),
        }
    }

    /// What tells a run from every other one.
    pub fn identity(runs: &Runs<'_>, code: &dyn Code, seed: u64) -> String {
        key(runs, &runs.scene.with_stiffness_factor(runs.stiffness_factor), code, seed).name().into()
    }

    /// Runs that this start made, and runs that it took from an earlier one.
    pub fn counts(&self) -> [usize; 2] {
        [&self.made, &self.taken].map(|names| names.lock().expect("nothing panics while it holds the lock").len())
    }

    fn find(&self, key: &Key) -> Result<Option<Result<Harvest, KeptError>>, KeptError> {
        let own = self.made.lock().expect("nothing panics while it holds the lock").contains(key.name());
        if self.again && !own {
            return Ok(None);
        }
        let Found::Run(kept) = self.cache.find(key)? else { return Ok(None) };
        if !own {
            self.taken.lock().expect("nothing panics while it holds the lock").insert(key.name().into());
        }
        Ok(Some(match kept {
            Kept::Run(harvest) => Ok(*harvest),
            Kept::Worthless(problem) => Err(KeptError::Worthless(problem)),
        }))
    }

    fn make(
        &self,
        key: &Key,
        runs: &Runs<'_>,
        scene: &Scene,
        code: &dyn Code,
        seed: u64,
    ) -> Result<Harvest, KeptError> {
        let made = runs.one(code, scene, seed).map_err(KeptError::from).map(|harvest| match seed {
            PICTURED_SEED => harvest,
            _ => Harvest { series: Vec::new(), final_state: None, ..harvest },
        });
        let kept = match &made {
            Ok(harvest) => Kept::Run(Box::new(harvest.clone())),
            Err(KeptError::Worthless(problem)) => Kept::Worthless(problem.clone()),
            Err(_) => return made,
        };
        // A number that is not finite does not come back from JSON: such a run is made again by the next start.
        if unseal::<Kept>(&sealed(&kept, key), key).is_some() {
            self.cache.keep(key, &kept)?;
        }
        self.made.lock().expect("nothing panics while it holds the lock").insert(key.name().into());
        made
    }
}

/// The key of a run.
fn key(runs: &Runs<'_>, scene: &Scene, code: &dyn Code, seed: u64) -> Key {
    keyed(runs, scene, code, seed, "", "")
}

/// The key of a run that is alone on the machine: its wall time is of this processor.
fn alone(runs: &Runs<'_>, scene: &Scene, code: &dyn Code, seed: u64) -> Key {
    keyed(runs, scene, code, seed, "-alone", &machine())
}

fn keyed(runs: &Runs<'_>, scene: &Scene, code: &dyn Code, seed: u64, mark: &str, machine: &str) -> Key {
    let name = format!("{}-{}-s{seed}{mark}", file_stem(&scene.name), code.name().to_lowercase());
    let watch = serde_json::to_string(&scene.watch).expect("a checked scene holds finite numbers and plain text");
    // Where a code is timed by the input that it is measured by, one run is both.
    let timing = runs.purpose == Purpose::Timing && code.timing_input().is_some();
    let parts = [
        format!("{:016x}", scene_hash(scene)),
        watch,
        seed.to_string(),
        format!("{} {}", runs.rayleigh_fraction, runs.stiffness_factor),
        format!("{} {}, {}", code.name(), code.version().unwrap_or_default(), code.contact_law()),
        BUILD.to_string(),
        JUDGE.to_string(),
        machine.to_string(),
        String::from(if timing { "timing" } else { "" }),
    ];
    Key::new(name, &parts.each_ref().map(String::as_str)).apart()
}
