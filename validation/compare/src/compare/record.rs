//! Recording: what is missing in a scene's references is measured or run, and taken in.

use super::{CodeRuns, Missing, Reference, ReferenceError, Runs, Simulated, Wanted};
use crate::codes::{Code, CodeError};
use makadam_frames::output::WriteError;
use makadam_frames::plan::physics_hash;
use makadam_measure::statistics::Ensemble;
use rayon::prelude::*;
use std::path::{Path, PathBuf};

/// Seeds where nothing is recorded and none are asked for.
pub const FEW_SEEDS: u64 = 3;

/// Records frames and measurements of reference codes as a reference of a scene.
pub struct Recorder<'a> {
    /// Runs for measuring of the scene, but for their seeds, with the folder of raw recordings.
    pub runs: Runs<'a>,
    /// Number of seeds, counted from 1; absent, those that the scene registers, else as many as are recorded, and [`FEW_SEEDS`] at least.
    pub seeds: Option<u64>,
    /// True if all recorded runs are replaced.
    pub again: bool,
    /// Told what will be run.
    pub note: &'a dyn Fn(&str),
    /// Told what will be replaced and what failed.
    pub warn: &'a dyn Fn(&str),
}

/// Result of a recording.
pub struct Recorded {
    /// Folder of the references.
    pub folder: PathBuf,
    pub changed: bool,
    /// True if every recorded run has a value of all that is compared.
    pub whole: bool,
    /// Recorded values, one line per code and observable.
    pub lines: Vec<String>,
    /// That the user asked to stop, else the first failure of a run, else why runs were not taken in; what ended well was.
    pub failure: Option<RecordError>,
}

/// Error of a recording.
#[derive(Debug, thiserror::Error)]
pub enum RecordError {
    /// The references cannot be read.
    #[error(transparent)]
    Reference(#[from] ReferenceError),
    /// They cannot be written.
    #[error(transparent)]
    Write(#[from] WriteError),
    /// A run failed.
    #[error(transparent)]
    Code(#[from] CodeError),
    /// New runs cannot be merged with the recorded ones.
    #[error("{0}")]
    Refused(String),
}

impl Recorder<'_> {
    /// Records what is missing of some codes. What ended well is taken in even if other seeds failed.
    ///
    /// # Errors
    /// [`RecordError::Reference`] or [`RecordError::Write`] if the references cannot be read or written.
    pub fn record(&self, codes: Vec<Box<dyn Code>>) -> Result<Recorded, RecordError> {
        let folder = Reference::folder(self.runs.scene_file);
        let (mut reference, aside) = self.known(&folder)?;
        let seeds: Vec<u64> =
            (1..=self.seeds.or(self.runs.scene.measure.seeds).unwrap_or_else(|| reference.seeds().max(FEW_SEEDS)))
                .collect();
        let hash = physics_hash(self.runs.scene);
        // Said before the hours that the runs may take, so that a fraction mistyped is noticed in time.
        let plan = |code: Box<dyn Code>| {
            let missing = self.missing(code.as_ref(), &reference, &hash, &seeds);
            self.say(code.name(), &missing, &reference, &seeds);
            (code, missing)
        };
        let plans: Vec<(Box<dyn Code>, Missing)> = codes.into_iter().map(plan).collect();
        let jobs: Vec<(&dyn Code, Runs<'_>)> =
            plans.iter().map(|(code, missing)| (code.as_ref(), self.runs.of_seeds(&missing.seeds))).collect();
        let simulated: Vec<_> = jobs.par_iter().map(|(code, runs)| runs.simulate(*code)).collect();
        let mut recorded = Recorded { folder, changed: false, whole: true, lines: Vec::new(), failure: None };
        let mut failures = Vec::new();
        for ((code, missing), simulated) in plans.iter().zip(simulated) {
            let code = code.name();
            let (new, failed) = self.split(code, simulated);
            match self.take_in(&mut reference, new, missing, failed.is_empty(), &hash) {
                Ok(taken) => recorded.changed |= taken,
                Err(problem) => {
                    (self.warn)(&format!("{code}: its references stay as they were: {problem}"));
                    recorded.failure = recorded.failure.or(Some(problem));
                }
            }
            failures.extend(failed);
            recorded.whole &= self.describe(&reference, code, &mut recorded.lines);
        }
        recorded.failure = CodeError::foremost(failures).map(RecordError::Code).or(recorded.failure);
        // Nothing new leaves the files alone, down to their dates.
        if recorded.changed {
            if let Some(aside) = aside {
                std::fs::rename(&recorded.folder, &aside)
                    .map_err(|source| WriteError::new(&recorded.folder, source))?;
            }
            reference.save(&recorded.folder)?;
        }
        Ok(recorded)
    }

    /// Reads the references of a folder. Where all is replaced, unreadable ones count as none, and the path to move them to is returned.
    fn known(&self, folder: &Path) -> Result<(Reference, Option<PathBuf>), RecordError> {
        match Reference::load(folder) {
            Ok(reference) => Ok((reference.unwrap_or_default(), None)),
            Err(problem) if self.again => {
                let aside = aside(folder);
                (self.warn)(&format!(
                    "{problem}; --restart starts from nothing, and moves {} to {} once a run has ended: runs of codes that are not \
                     recorded now are in that folder alone, so ask for these codes too, with --codes",
                    folder.display(),
                    aside.display()
                ));
                Ok((Reference::default(), Some(aside)))
            }
            Err(problem) => Err(problem.into()),
        }
    }

    fn missing(&self, code: &dyn Code, reference: &Reference, hash: &str, seeds: &[u64]) -> Missing {
        if self.again {
            let recorded = reference.of(code.name()).next();
            return Missing { seeds: seeds.to_vec(), replaces: recorded.map(|_| "--restart asks for it".into()) };
        }
        reference.missing(&Wanted {
            code: code.name(),
            version: code.version().as_deref(),
            contact_law: code.contact_law(),
            scene_hash: hash,
            rayleigh_fraction: self.runs.rayleigh_fraction,
            seeds,
        })
    }

    /// Says what will be kept and what will be replaced.
    fn say(&self, code: &str, missing: &Missing, reference: &Reference, seeds: &[u64]) {
        let recorded = reference.of(code).count();
        match &missing.replaces {
            Some(reason) => (self.warn)(&format!(
                "{code}: all {recorded} recorded runs will be replaced by seeds 1 to {}, not mixed with them: {reason}",
                seeds.len()
            )),
            None => (self.note)(&format!(
                "{code}: {} of {} seeds are recorded already, {} to measure or run",
                seeds.len() - missing.seeds.len(),
                seeds.len(),
                missing.seeds.len()
            )),
        }
    }

    /// The runs that ended well, and the failures of the others, all of which are said.
    fn split(&self, code: &str, simulated: Simulated) -> (CodeRuns, Vec<CodeError>) {
        let said = |(seed, error): (u64, CodeError)| {
            (self.warn)(&format!("{code}, seed {seed}: {error}"));
            error
        };
        let failures = simulated.failures.into_iter().map(said).collect();
        (CodeRuns::live(code, rayon::current_num_threads(), simulated.harvests), failures)
    }

    /// Puts new runs beside the recorded ones or in their place; whether anything changed, or why the references stay.
    fn take_in(
        &self,
        reference: &mut Reference,
        new: CodeRuns,
        missing: &Missing,
        complete: bool,
        hash: &str,
    ) -> Result<bool, RecordError> {
        if missing.replaces.is_some() && !complete {
            // Half a replacement would cost recorded runs, and the raw recordings keep what was run.
            let problem = "some seeds that were to replace them failed; the runs that ended are kept, so try again";
            return Err(RecordError::Refused(problem.into()));
        }
        if new.runs.is_empty() {
            return Ok(false);
        }
        match missing.replaces {
            Some(_) => reference.replace(new, hash),
            None => reference.add(new, hash).map_err(RecordError::Refused)?,
        }
        Ok(true)
    }

    /// Adds mean and standard deviation of what is recorded of a code; whether every run has a value of all that is compared.
    fn describe(&self, reference: &Reference, code: &str, lines: &mut Vec<String>) -> bool {
        let runs = reference.of(code).count();
        let mut whole = true;
        for expectation in &self.runs.scene.compare {
            let observable = &expectation.observable;
            let recorded = reference.of(code);
            let values: Vec<f64> = recorded.filter_map(|run| run.value(observable)).collect();
            let lacking = match runs - values.len() {
                0 => String::new(),
                _ => format!("; not measured in {} of {runs}", runs - values.len()),
            };
            whole &= lacking.is_empty() && runs > 0;
            let text = match Ensemble::of(&values) {
                Some(ensemble) => format!(
                    "{:.5} +- {:.5} ({} seeds{lacking})",
                    ensemble.mean, ensemble.standard_deviation, ensemble.seeds
                ),
                None => format!("not measured in any of {runs} seeds"),
            };
            lines.push(format!("{code:<10} {observable:<28} {text}"));
        }
        whole
    }
}

/// Returns a free path next to damaged references, to move them to.
fn aside(folder: &Path) -> PathBuf {
    let name = folder.file_name().unwrap_or_default().to_string_lossy();
    let numbered = (2..).map(|number| format!("{name}-damaged-{number}"));
    let names = std::iter::once(format!("{name}-damaged")).chain(numbered);
    let mut places = names.map(|name| folder.with_file_name(name));
    places.find(|place| place.symlink_metadata().is_err()).expect("numbers do not end")
}
