//! Recording: runs of reference codes are measured and replace those in a scene's references.

use super::{CodeRuns, Reference, ReferenceError, Runs, distinct};
use crate::codes::{Code, CodeError, UNKNOWN_VERSION};
use makadam_frames::output::WriteError;
use makadam_frames::plan::{MeasuredScene, physics_hash};
use makadam_measure::statistics::Ensemble;
use rayon::prelude::*;
use std::path::PathBuf;

/// Default number of seeds without recorded runs.
pub const FEW_SEEDS: u64 = 3;

/// Result of a recording.
pub struct Recorded {
    /// Folder of the references.
    pub folder: PathBuf,
    pub changed: bool,
    /// True if every recorded run has a value of every compared observable.
    pub whole: bool,
    /// Recorded values, one line per code and observable.
    pub lines: Vec<String>,
    /// Interruption by the user, else the first failure of a run, else the reason why recorded runs were not replaced.
    pub failure: Option<RecordError>,
}

/// Error of a recording.
#[derive(Debug, thiserror::Error)]
pub enum RecordError {
    /// The references cannot be read.
    #[error(transparent)]
    Reference(#[from] ReferenceError),
    /// The references cannot be written.
    #[error(transparent)]
    Write(#[from] WriteError),
    /// A run failed.
    #[error(transparent)]
    Code(#[from] CodeError),
    /// New runs do not replace the recorded ones.
    #[error("{0}")]
    Refused(String),
}

/// Replaces the recorded runs of some codes by new ones: from raw recordings where available, else from new runs. Fewer runs than are
/// recorded replace none. `runs` are for measuring, with the folder of raw recordings; their seeds are 1 to `seeds`. Without `seeds`, the
/// scene's registered seeds count, else as many as are recorded, and at least [`FEW_SEEDS`]. `warn` receives a sentence per failed run.
///
/// # Errors
/// [`RecordError::Refused`] for a code of unknown version, before any run; [`RecordError::Reference`] or [`RecordError::Write`] if the
/// references cannot be read or written.
pub fn record(
    codes: &[Box<dyn Code>],
    runs: &Runs<'_>,
    seeds: Option<u64>,
    warn: &dyn Fn(&str),
) -> Result<Recorded, RecordError> {
    if let Some(code) = codes.iter().find(|code| code.version().as_deref() == Some(UNKNOWN_VERSION)) {
        return Err(RecordError::Refused(format!(
            "the version of {} is unknown, and references name the version that they are from; give a program that prints its version",
            code.name()
        )));
    }
    let folder = Reference::folder(runs.scene_file);
    let before = Reference::load(&folder)?.unwrap_or_default();
    let seeds = seeds.or(runs.scene.measure.seeds).unwrap_or_else(|| before.seeds().max(FEW_SEEDS));
    let (runs, hash) = (runs.of_seeds(&(1..=seeds).collect::<Vec<_>>()), physics_hash(runs.scene));
    let simulated: Vec<_> = codes.par_iter().map(|code| runs.simulate(code.as_ref())).collect();
    let mut reference = before.clone();
    let mut recorded = Recorded { folder, changed: false, whole: true, lines: Vec::new(), failure: None };
    let mut failures = Vec::new();
    for (code, simulated) in codes.iter().zip(simulated) {
        let code = code.name();
        for (seed, error) in simulated.failures {
            warn(&format!("{code}, seed {seed}: {error}"));
            failures.push(error);
        }
        let new = CodeRuns::live(code, rayon::current_num_threads(), simulated.harvests);
        match refusal(&new, before.of(code).count()) {
            Some(problem) => recorded.failure = recorded.failure.or(Some(RecordError::Refused(problem))),
            None => reference.replace(new, &hash),
        }
        recorded.whole &= describe(&reference, runs.scene, code, &mut recorded.lines);
    }
    recorded.failure = CodeError::foremost(failures).map(RecordError::Code).or(recorded.failure);
    recorded.changed = !reference.runs.is_empty() && reference.save(&recorded.folder)?;
    Ok(recorded)
}

/// Adds mean and standard deviation of a code's recorded values; returns true if every run has a value of every compared observable.
fn describe(reference: &Reference, scene: &MeasuredScene, code: &str, lines: &mut Vec<String>) -> bool {
    let runs = reference.of(code).count();
    let mut whole = true;
    for expectation in &scene.compare {
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

/// Reason why new runs of a code do not replace the recorded ones.
fn refusal(new: &CodeRuns, recorded: usize) -> Option<String> {
    let (code, ended) = (&new.code, new.runs.len());
    let versions = distinct(new.runs.iter().map(|run| run.version.as_str()));
    match versions[..] {
        [] => Some(format!("no run of {code} ended well; its references stay as they were")),
        [_] if ended >= recorded => None,
        [_] => Some(format!(
            "{recorded} runs of {code} are recorded and {ended} ended well, so the recorded ones stay; try again, or remove them from \
             runs.csv to record fewer"
        )),
        _ => Some(format!("raw recordings of {code} are of versions {}; keep those of one", versions.join(", "))),
    }
}
