//! A qualification: reference scenes against the recorded references, live runs of the peers, studies, one report.
//!
//! ```text
//! Tier ─> Extent (one table) ─> cases, parts ─> what is timed, alone ─> jobs side by side ─> comparisons, sections ─> Qualification
//!                                                  └───────────────┬───────────┘
//!                                               each run stored as it ends, reused by the next start
//! ```

mod one_scene;
mod scenes;
mod studies;
mod tier;

pub use one_scene::{JudgeError, Judged, OneScene, codes_against, usual_codes};
pub use tier::{Ablated, Extent, Study, Tier};

use crate::compare::{Announce, Comparison, KeptError, KeptRuns, Reference, ReferenceError, Runs};
use crate::output::WriteError;
use crate::peers::{Code, CodeError, CodeName, Makadam, codes_of};
use crate::plan::Scene;
use crate::provenance::account;
use crate::report::{Qualification, StudySection};
use crate::scenes::{SceneError, find, known};
use crate::stability::StabilityError;
use crate::statistics::confidence_of_each;
use crate::study::{DocumentError, damaged_below};
use scenes::{Case, Job};
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};
use studies::{Part, Place};

/// Seed of the live runs. It is never recorded: a value always lies among values that include it.
const LIVE_SEED: u64 = 1001;

/// Settings of a qualification.
pub struct Settings<'a> {
    /// Folders that may hold `reference-scenes`.
    pub roots: Vec<PathBuf>,
    /// Folder of the report, which also stores finished runs for the next start.
    pub folder: PathBuf,
    /// Repeats runs that earlier starts have stored.
    pub again: bool,
    /// Runs the peers.
    pub live: bool,
    /// Wall time after which a run of a peer is stopped.
    pub time_limit: Duration,
    /// Opens progress displays.
    pub announce: Announce<'a>,
    /// Prints the progress.
    pub say: &'a (dyn Fn(&str) + Sync),
}

impl Settings<'_> {
    /// A run of a scene for measuring.
    fn measuring<'s>(&'s self, scene: &'s Scene, file: &'s Path, seed: u64) -> Runs<'s> {
        Runs::of_one_seed(scene, file, seed, self.time_limit, self.announce)
    }
}

/// Failures of a qualification.
#[derive(Debug, thiserror::Error)]
pub enum QualifyError {
    /// A scene is invalid.
    #[error(transparent)]
    Scene(#[from] SceneError),
    /// Recorded references cannot be read.
    #[error(transparent)]
    Reference(#[from] ReferenceError),
    /// Nothing is recorded of a code.
    #[error("nothing is recorded of {code} on the scene {scene}; record it with 'makadam compare {scene} --record'")]
    NotRecorded {
        /// The code.
        code: String,
        /// The scene.
        scene: String,
    },
    /// Makadam failed, or a required peer is missing.
    #[error(transparent)]
    Code(CodeError),
    /// A run of Makadam came to an invalid state, or a study failed.
    #[error("{0}")]
    Failed(String),
    /// A finished run cannot be stored.
    #[error(transparent)]
    Write(#[from] WriteError),
    /// A study cannot be written.
    #[error(transparent)]
    Document(#[from] DocumentError),
    /// The user asked to stop; finished runs are stored.
    #[error("interrupted")]
    Interrupted,
}

impl From<CodeError> for QualifyError {
    fn from(error: CodeError) -> QualifyError {
        match error {
            CodeError::Interrupted { .. } => QualifyError::Interrupted,
            other => QualifyError::Code(other),
        }
    }
}

impl From<KeptError> for QualifyError {
    fn from(error: KeptError) -> QualifyError {
        match error {
            KeptError::Code(error) => error.into(),
            KeptError::Worthless(problem) => QualifyError::Failed(problem),
            KeptError::Write(error) => error.into(),
        }
    }
}

impl From<StabilityError> for QualifyError {
    fn from(error: StabilityError) -> QualifyError {
        match error {
            StabilityError::Interrupted(_) => QualifyError::Interrupted,
            StabilityError::Scene(error) => error.into(),
            StabilityError::Code(error) => error.into(),
            StabilityError::Write(error) => error.into(),
        }
    }
}

/// Runs a qualification of the given extent.
///
/// # Errors
/// [`QualifyError`]; a live run of a peer that fails is a part of the verdict, not an error.
pub fn qualify(extent: &Extent, settings: &Settings<'_>) -> Result<Qualification, QualifyError> {
    let clock = Instant::now();
    let peers = codes_of(&CodeName::REFEREES);
    let further = codes_of(&CodeName::FURTHER_REFEREES);
    if settings.live
        && let Some(missing) = peers.iter().find(|code| code.version().is_none())
    {
        return Err(CodeError::Missing { code: missing.name() }.into());
    }
    let open = |name: &&'static str| Case::open(name, extent.fewest_seeds, settings, &peers, &further);
    let mut cases = extent.scenes.iter().map(open).collect::<Result<Vec<Case>, QualifyError>>()?;
    let kept = KeptRuns::open(&settings.folder.join("runs"), settings.again)?;
    let place = Place { settings, kept: &kept };
    let parts = extent.studies.iter().map(|study| studies::open(study, place));
    let parts = parts.collect::<Result<Vec<Box<dyn Part>>, QualifyError>>()?;

    let mut qualification = Qualification::default();
    time(extent, settings, &kept, &mut cases, &peers, &mut qualification)?;
    let of_scenes = cases.iter().flat_map(|case| case.jobs(settings, &kept));
    let jobs: Vec<Job<'_>> = of_scenes.chain(parts.iter().flat_map(|part| part.jobs())).collect();
    (settings.say)(&format!("{} runs, those taken that {} holds", jobs.len(), settings.folder.display()));
    scenes::run(jobs)?;
    let studies = parts.iter().map(|part| part.section()).collect::<Result<Vec<StudySection>, QualifyError>>()?;
    let threads = rayon::current_num_threads();
    let comparisons: Vec<Comparison> = cases.into_iter().map(|case| case.compared(threads)).collect();

    let scenes: Vec<&Scene> = comparisons.iter().map(|comparison| &comparison.scene).collect();
    let provenance = account(threads, &scenes);
    Ok(Qualification {
        title: format!("Makadam: {} qualification", extent.name),
        tier: extent.name.into(),
        wall_seconds: clock.elapsed().as_secs_f64(),
        comparisons,
        provenance,
        notes: notes(extent, settings, &kept)?,
        studies,
        ..qualification
    })
}

/// Times the codes, one core each, one after the other: these runs have the machine to themselves. Compares live runs of the peers with their
/// recorded ones.
fn time(
    extent: &Extent,
    settings: &Settings<'_>,
    kept: &KeptRuns,
    cases: &mut [Case],
    peers: &[Box<dyn Code>],
    found: &mut Qualification,
) -> Result<(), QualifyError> {
    let margins = |case: &&Case| extent.timed.contains(&case.name).then_some(case.margins());
    let values = peers.len() * cases.iter().filter_map(|case| margins(&case)).sum::<usize>();
    let confidence = confidence_of_each(values);
    for name in extent.timed {
        let case = cases.iter_mut().find(|case| case.name == *name).expect("what is timed is judged");
        (settings.say)(&format!("{name}: timed runs of seed {LIVE_SEED}, one core each, one after the other"));
        case.time(settings, kept, &Makadam)?;
        for peer in peers.iter().rev().filter(|_| settings.live) {
            match case.time(settings, kept, peer.as_ref()) {
                Ok(harvest) => case.check(&harvest, confidence, found),
                Err(KeptError::Code(error @ CodeError::Interrupted { .. })) => return Err(error.into()),
                Err(KeptError::Write(error)) => return Err(error.into()),
                Err(error) => {
                    found.failed_runs.push(format!("{name}: the live run of {} failed: {error}", peer.name()));
                }
            }
        }
    }
    Ok(())
}

/// Notes on the whole qualification.
fn notes(extent: &Extent, settings: &Settings<'_>, kept: &KeptRuns) -> Result<Vec<String>, QualifyError> {
    let mut notes = Vec::new();
    if !settings.live {
        notes.push(
            "The other codes were not run: their numbers are the recorded references, and no speeds are compared. \
             With YADE and LIGGGHTS installed (scripts/install-peers), --live runs these two; LAMMPS counts as recorded."
                .into(),
        );
    }
    notes.extend(left_out(extent, settings)?);
    let [made, taken] = kept.counts();
    if taken > 0 {
        let total = made + taken;
        notes.push(format!(
            "{taken} of {total} runs of scenes were taken from an earlier start in this folder; their wall times are those of then."
        ));
    }
    let damaged = damaged_below(&settings.folder).into_iter();
    notes.extend(
        damaged
            .map(|file| format!("a kept run was damaged and has been made again; the file is now {}", file.display())),
    );
    Ok(notes)
}

/// Lists the scenes with recorded references that are not judged.
fn left_out(extent: &Extent, settings: &Settings<'_>) -> Result<Option<String>, QualifyError> {
    let mut left_out = Vec::new();
    for name in known(&settings.roots).into_iter().filter(|name| !extent.scenes.contains(&name.as_str())) {
        if Reference::of_scene(&find(&name, &settings.roots)?)?.is_some() {
            left_out.push(name);
        }
    }
    Ok((!left_out.is_empty()).then(|| format!("Recorded, and not judged in this tier: {}.", left_out.join(", "))))
}
