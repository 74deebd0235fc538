//! The whole judgement: reference scenes against the recorded references, live runs of the peers, studies, one report.
//!
//! ```text
//! Tier ─> Extent (one table) ─> cases, parts ─> what is timed, alone ─> jobs side by side ─> comparisons, sections ─> Qualification
//!                                                  └───────────────┬───────────┘
//!                                               each run kept as it ends, taken up by the next start
//! ```

mod jobs;
mod one_scene;
mod record;
mod same_runs;
mod scenes;
mod studies;
mod tier;

pub use one_scene::{JudgeError, Judged, OneScene, codes_against, usual_codes};
pub use record::{on_record, studies_on_record};
pub use tier::{Ablated, Extent, Study, TIERS, Tier};

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
use scenes::{AgainstRecorded, Case};
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};
use studies::{Part, Place};

/// Seed of the live runs. It is never recorded: whether a value lies among others of which it is one is no question.
const LIVE_SEED: u64 = 1001;

/// What a qualification needs to know.
pub struct Settings<'a> {
    /// Folders in which `reference-scenes` is looked for.
    pub roots: Vec<PathBuf>,
    /// Folder of the report: finished runs are kept in it, and taken from it by the next start.
    pub folder: PathBuf,
    /// Whether runs that earlier starts have kept are made again.
    pub again: bool,
    /// Whether the peers are run.
    pub live: bool,
    /// Wall time after which a run of a peer is stopped.
    pub time_limit: Duration,
    /// Opens progress displays.
    pub announce: Announce<'a>,
    /// Told what is being done.
    pub say: &'a (dyn Fn(&str) + Sync),
}

impl Settings<'_> {
    /// A run of a scene for measuring.
    fn measuring<'s>(&'s self, scene: &'s Scene, file: &'s Path, seed: u64) -> Runs<'s> {
        Runs::of_one_seed(scene, file, seed, self.time_limit, self.announce)
    }
}

/// Why there is no qualification.
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
    /// Makadam failed, or a peer that must run is missing.
    #[error(transparent)]
    Code(CodeError),
    /// A run of Makadam came to a state that makes its numbers worthless.
    #[error("{0}")]
    Worthless(String),
    /// A study cannot be made.
    #[error("{study}: {problem}")]
    Study {
        /// The study.
        study: &'static str,
        /// What is wrong.
        problem: String,
    },
    /// What is finished cannot be kept.
    #[error(transparent)]
    Write(#[from] WriteError),
    /// A study cannot be written.
    #[error(transparent)]
    Document(#[from] DocumentError),
    /// The user asked to stop. What is finished is kept.
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
            KeptError::Worthless(problem) => QualifyError::Worthless(problem),
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

/// Judges what an extent consists of. Every finished run is kept in the folder of the report.
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
    let open = |name: &&'static str| {
        Case::open(name, extent.fewest_seeds, extent.on_record.is_some(), settings, &peers, &further)
    };
    let mut cases = extent.scenes.iter().map(open).collect::<Result<Vec<Case>, QualifyError>>()?;
    let kept = KeptRuns::open(&settings.folder.join("runs"), settings.again)?;
    let place = Place { settings, kept: &kept };
    let parts = extent.studies.iter().map(|study| studies::open(study, place));
    let parts = parts.collect::<Result<Vec<Box<dyn Part>>, QualifyError>>()?;

    let mut against_recorded = AgainstRecorded::default();
    time(extent, settings, &kept, &mut cases, &peers, &mut against_recorded)?;
    parts.iter().try_for_each(|part| part.alone())?;
    let jobs: Vec<_> = cases
        .iter()
        .flat_map(|case| case.jobs(settings, &kept))
        .chain(parts.iter().flat_map(|part| part.jobs()))
        .collect();
    (settings.say)(&format!("{} runs side by side, those taken that {} holds", jobs.len(), settings.folder.display()));
    jobs::carry_out(jobs)?;
    let studies = parts.iter().map(|part| part.section()).collect::<Result<Vec<StudySection>, QualifyError>>()?;
    let threads = rayon::current_num_threads();
    let comparisons: Vec<Comparison> = cases.into_iter().map(|case| case.compared(threads)).collect();

    let scenes: Vec<&Scene> = comparisons.iter().map(|comparison| &comparison.scene).collect();
    let provenance = account(threads, &scenes);
    let measures_laws = extent.studies.iter().any(|study| matches!(study, Study::Laws(_)));
    Ok(Qualification {
        title: format!("Makadam: {} qualification", extent.name),
        tier: extent.name.into(),
        wall_seconds: clock.elapsed().as_secs_f64(),
        comparisons,
        provenance,
        notes: notes(extent, settings, &kept, &peers)?,
        outside_spread: against_recorded.outside,
        unchecked: against_recorded.unchecked,
        failed_runs: against_recorded.failed,
        laws: if measures_laws { Vec::new() } else { crate::laws::published() },
        on_record: extent.on_record.map_or(Vec::new(), on_record),
        studies,
        studies_on_record: extent.on_record.map_or(Vec::new(), studies_on_record),
    })
}

/// Times the codes, one core each, one after the other: these runs have the machine to themselves. Live runs of the peers are held against
/// their recorded ones.
fn time(
    extent: &Extent,
    settings: &Settings<'_>,
    kept: &KeptRuns,
    cases: &mut [Case],
    peers: &[Box<dyn Code>],
    against_recorded: &mut AgainstRecorded,
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
                Ok(harvest) => case.check(&harvest, confidence, against_recorded),
                Err(KeptError::Code(error @ CodeError::Interrupted { .. })) => return Err(error.into()),
                Err(KeptError::Write(error)) => return Err(error.into()),
                Err(error) => {
                    against_recorded.failed.push(format!("{name}: the live run of {} failed: {error}", peer.name()));
                }
            }
        }
    }
    Ok(())
}

/// What a reader must know of the whole.
fn notes(
    extent: &Extent,
    settings: &Settings<'_>,
    kept: &KeptRuns,
    peers: &[Box<dyn Code>],
) -> Result<Vec<String>, QualifyError> {
    let mut notes = Vec::new();
    if !settings.live {
        notes.push(
            "The other codes were not run: their numbers are the recorded references, and no speeds are compared. \
             With YADE and LIGGGHTS installed (scripts/install-peers), --live runs these two; LAMMPS counts as recorded."
                .into(),
        );
    }
    notes.extend(left_out(extent, settings, peers)?);
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

/// The scenes with recorded references that are not judged, in a sentence.
fn left_out(extent: &Extent, settings: &Settings<'_>, peers: &[Box<dyn Code>]) -> Result<Option<String>, QualifyError> {
    let mut left_out = Vec::new();
    for name in known(&settings.roots).iter().filter(|name| !extent.scenes.contains(&name.as_str())) {
        let Some(reference) = Reference::of_scene(&find(name, &settings.roots)?)? else { continue };
        let codes = reference.codes();
        let lacks: Vec<&str> =
            peers.iter().map(|peer| peer.name()).filter(|peer| !codes.iter().any(|code| code == peer)).collect();
        left_out.push(match lacks.is_empty() {
            true => name.clone(),
            false => format!("{name} (nothing is recorded of {})", lacks.join(" and ")),
        });
    }
    Ok((!left_out.is_empty()).then(|| format!("Recorded, and not judged in this tier: {}.", left_out.join(", "))))
}
