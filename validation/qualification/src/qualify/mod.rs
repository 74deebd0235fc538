//! Qualification: reference scenes compared with the recorded references, live runs of the reference codes, studies, one report.
//!
//! ```text
//! Tier ─> Extent (one table) ─> cases, parts ─> timed runs, alone ─> jobs in parallel ─> comparisons, sections ─> Qualification
//!                                                  └───────────────┬───────────┘
//!                                               each run stored as it ends, reused by the next start
//! ```

mod one_scene;
mod scenes;
mod studies;
mod tier;

use crate::report::{Qualification, StudySection};
use makadam_compare::codes::{Code, CodeError, CodeName, Makadam, codes_of};
use makadam_compare::compare::{Announce, Comparison, Reference, ReferenceError, Runs};
use makadam_compare::scenes::{SceneError, find, known};
use makadam_compare::study::{DocumentError, RunCache, RunError};
use makadam_frames::output::WriteError;
use makadam_frames::plan::MeasuredScene;
use makadam_frames::provenance::account;
use makadam_measure::statistics::confidence_of_each;
pub use one_scene::{Judged, OneScene, codes_against, usual_codes};
use scenes::{Case, Job};
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};
use studies::{Part, Place};
pub use tier::{Ablated, Extent, Study, Tier};

/// Seed of the live runs. This seed is never recorded: a value always lies within a set that contains it.
const LIVE_SEED: u64 = 1001;

/// Settings of a qualification.
pub struct Settings<'a> {
    /// Folders that may hold `reference-scenes`.
    pub roots: Vec<PathBuf>,
    /// Folder of the report, which also stores finished runs for the next start.
    pub folder: PathBuf,
    /// Repeats runs that earlier starts have stored.
    pub again: bool,
    /// Runs the reference codes.
    pub live: bool,
    /// Wall time after which a run of a reference code is stopped.
    pub time_limit: Duration,
    /// Opens progress displays.
    pub announce: Announce<'a>,
    /// Prints the progress.
    pub say: &'a (dyn Fn(&str) + Sync),
}

impl Settings<'_> {
    fn measuring<'s>(&'s self, scene: &'s MeasuredScene, file: &'s Path, seed: u64) -> Runs<'s> {
        Runs::of_one_seed(scene, file, seed, self.time_limit, self.announce)
    }
}

/// Error that ended a qualification or a comparison; finished runs remain stored.
#[derive(Debug, thiserror::Error)]
pub enum QualifyError {
    /// The scene has no compared observables.
    #[error("{0} names nothing to compare; add observables under [[compare]], or measure it with 'makadam run'")]
    NothingToCompare(String),
    /// Recorded references cannot be read.
    #[error(transparent)]
    Reference(#[from] ReferenceError),
    /// No runs of a code are recorded.
    #[error(
        "nothing is recorded of {code} on the scene {scene}; record it with 'makadam compare {scene} --record', run it with --live \
         (scripts/install-codes installs it), or leave it out (name the others with --codes)"
    )]
    NotRecorded {
        /// Code.
        code: &'static str,
        /// Scene.
        scene: String,
    },
    /// A scene is invalid, a run or a study failed, a required code is missing, or the user asked to stop.
    #[error(transparent)]
    Run(#[from] RunError),
    /// A study cannot be written.
    #[error(transparent)]
    Document(#[from] DocumentError),
}

macro_rules! of_runs {
    ($($error:ty),*) => {
        $(impl From<$error> for QualifyError {
            fn from(error: $error) -> QualifyError {
                QualifyError::Run(error.into())
            }
        })*
    };
}
of_runs!(CodeError, SceneError, WriteError);

/// Runs a qualification of the given extent.
///
/// # Errors
/// [`QualifyError`]; a failed live run of a reference code is a part of the verdict, not an error.
pub fn qualify(extent: &Extent, settings: &Settings<'_>) -> Result<Qualification, QualifyError> {
    let clock = Instant::now();
    let reference_codes = codes_of(&CodeName::REFEREES);
    let further = codes_of(&CodeName::FURTHER_REFEREES);
    if settings.live
        && let Some(missing) = reference_codes.iter().find(|code| code.version().is_none())
    {
        return Err(CodeError::Missing { code: missing.name() }.into());
    }
    let open = |name: &&'static str| Case::open(name, extent.fewest_seeds, settings, &reference_codes, &further);
    let mut cases = extent.scenes.iter().map(open).collect::<Result<Vec<Case>, QualifyError>>()?;
    let cache = RunCache::open(&settings.folder.join("runs"), settings.again)?;
    let place = Place { settings, cache: &cache };
    let parts = extent.studies.iter().map(|study| studies::open(study, place));
    let mut parts = parts.collect::<Result<Vec<Part<'_>>, QualifyError>>()?;

    let mut qualification = Qualification::default();
    time(extent, settings, &cache, &mut cases, &reference_codes, &mut qualification)?;
    let of_scenes = cases.iter().flat_map(|case| case.jobs(settings, &cache));
    let jobs: Vec<Job<'_>> = of_scenes.chain(parts.iter_mut().flat_map(Part::jobs)).collect();
    (settings.say)(&format!("{} runs, those taken that {} holds", jobs.len(), settings.folder.display()));
    scenes::run(jobs)?;
    let studies = parts.into_iter().map(Part::section).collect::<Result<Vec<StudySection>, RunError>>()?;
    let threads = rayon::current_num_threads();
    let comparisons: Vec<Comparison> = cases.into_iter().map(|case| case.compared(threads)).collect();

    let scenes: Vec<&MeasuredScene> = comparisons.iter().map(|comparison| &comparison.scene).collect();
    let provenance = account(threads, &scenes);
    Ok(Qualification {
        title: format!("Makadam: {} qualification", extent.name),
        tier: extent.name.into(),
        wall_seconds: clock.elapsed().as_secs_f64(),
        comparisons,
        provenance,
        notes: notes(extent, settings, &cache)?,
        studies,
        ..qualification
    })
}

/// Times the codes, one core each, one after the other: these runs have the machine to themselves. Compares live runs of the reference codes with
/// their recorded ones.
fn time(
    extent: &Extent,
    settings: &Settings<'_>,
    cache: &RunCache,
    cases: &mut [Case],
    reference_codes: &[Box<dyn Code>],
    found: &mut Qualification,
) -> Result<(), QualifyError> {
    let margins = |case: &&Case| extent.timed.contains(&case.name).then_some(case.margins());
    let values = reference_codes.len() * cases.iter().filter_map(|case| margins(&case)).sum::<usize>();
    let confidence = confidence_of_each(values);
    for name in extent.timed {
        let case = cases.iter_mut().find(|case| case.name == *name).expect("what is timed is judged");
        (settings.say)(&format!("{name}: timed runs of seed {LIVE_SEED}, one core each, one after the other"));
        case.time(settings, cache, &Makadam)?;
        for reference_code in reference_codes.iter().rev().filter(|_| settings.live) {
            match case.time(settings, cache, reference_code.as_ref()) {
                Ok(harvest) => case.check(&harvest, confidence, found),
                Err(error) if error.ends_all() => return Err(error.into()),
                Err(error) => {
                    found
                        .failed_runs
                        .push(format!("{name}: the live run of {} failed: {error}", reference_code.name()));
                }
            }
        }
    }
    Ok(())
}

/// Notes on the whole qualification.
fn notes(extent: &Extent, settings: &Settings<'_>, cache: &RunCache) -> Result<Vec<String>, QualifyError> {
    let mut notes = Vec::new();
    if !settings.live {
        notes.push(
            "The other codes were not run: their numbers are the recorded references, and no speeds are compared. \
             With YADE and LIGGGHTS installed (scripts/install-codes), --live runs these two; LAMMPS counts as recorded."
                .into(),
        );
    }
    notes.extend(left_out(extent, settings)?);
    let [made, taken] = cache.counts();
    if taken > 0 {
        let total = made + taken;
        notes.push(format!(
            "{taken} of {total} runs of scenes were taken from an earlier start in this folder; their wall times are those of then."
        ));
    }
    Ok(notes)
}

/// Lists the scenes with recorded references that are not compared.
fn left_out(extent: &Extent, settings: &Settings<'_>) -> Result<Option<String>, QualifyError> {
    let mut left_out = Vec::new();
    for name in known(&settings.roots).into_iter().filter(|name| !extent.scenes.contains(&name.as_str())) {
        if Reference::of_scene(&find(&name, &settings.roots)?)?.is_some() {
            left_out.push(name);
        }
    }
    Ok((!left_out.is_empty()).then(|| format!("Recorded, and not judged in this tier: {}.", left_out.join(", "))))
}
