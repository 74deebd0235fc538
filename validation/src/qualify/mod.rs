//! The whole judgement: every reference scene against the recorded references, live runs of the peers, one report.

mod one_scene;
mod record;

pub use one_scene::{JudgeError, Judged, OneScene};
pub use record::on_record;

use crate::compare::{
    Announce, CodeRuns, CodeSummary, Comparison, Harvest, Reference, ReferenceError, Runs, Timed, comparison,
    live_checks,
};
use crate::peers::{Code, CodeError, Liggghts, Makadam, Purpose, Yade};
use crate::plan::Scene;
use crate::provenance::account;
use crate::report::{Qualification, Standing};
use crate::scenes::{self, SceneError};
use makadam::scene::SceneFileError;
use rayon::prelude::*;
use std::path::PathBuf;
use std::time::{Duration, Instant};

/// Scenes of the quick tier; the longest first, so that the last run to end is a short one.
const SCENES: [&str; 4] = ["drum", "drum-caps", "heap", "packing"];

/// Scenes on which the codes are timed one after the other and the peers are run live.
const TIMED: [&str; 2] = ["packing", "drum"];

/// Time step of the live runs over the Rayleigh step: the peers' fastest honest setting.
const LIVE_FRACTION: f64 = 0.2;

/// Makadam runs no fewer seeds than this, however few are recorded: its own are quick, and narrow the intervals.
const FEWEST_SEEDS: u64 = 8;

/// Seed of the live runs.
const LIVE_SEED: u64 = 1;

/// What a qualification needs to know.
pub struct Settings<'a> {
    /// Folders in which `reference-scenes` is looked for.
    pub roots: Vec<PathBuf>,
    /// Whether the peers are run.
    pub live: bool,
    /// Wall time after which a run of a peer is stopped.
    pub time_limit: Duration,
    /// Opens progress displays.
    pub announce: Announce<'a>,
    /// Told what is being done.
    pub say: &'a (dyn Fn(&str) + Sync),
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
    Code(#[from] CodeError),
}

/// A qualification, and what its verdict does not say.
pub struct Qualified {
    /// What the report is made from.
    pub qualification: Qualification,
    /// Live runs that failed, in words.
    pub failed: Vec<String>,
}

impl Qualified {
    /// Whether every test of equivalence passed and every live run lies where the recorded ones said.
    pub fn passes(&self) -> bool {
        self.qualification.verdict().standing == Standing::Agree
    }
}

/// What live runs of the peers came to beside their recorded ones, in sentences.
#[derive(Default)]
struct AgainstRecorded {
    outside: Vec<String>,
    unchecked: Vec<String>,
}

/// A scene with what is recorded on it.
struct Case {
    /// Its folder under `reference-scenes`.
    name: &'static str,
    file: PathBuf,
    scene: Scene,
    recorded: Vec<CodeRuns>,
    seeds: u64,
    notes: Vec<String>,
    timings: Vec<CodeSummary>,
}

/// Runs the quick tier.
///
/// # Errors
/// [`QualifyError`]; a live run of a peer that fails is a note, not an error.
pub fn quick(settings: &Settings<'_>) -> Result<Qualified, QualifyError> {
    let clock = Instant::now();
    let peers: [Box<dyn Code>; 2] = [Box::new(Yade::default()), Box::new(Liggghts::default())];
    if settings.live
        && let Some(missing) = peers.iter().find(|code| code.version().is_none())
    {
        return Err(CodeError::Missing { code: missing.name() }.into());
    }
    let mut cases = SCENES
        .iter()
        .map(|name| Case::open(name, &settings.roots, &peers))
        .collect::<Result<Vec<Case>, QualifyError>>()?;
    let mut against_recorded = AgainstRecorded::default();
    let (mut failed, mut notes) = (Vec::new(), Vec::new());
    // Timed runs have the machine to themselves, one core each, one after the other.
    for name in TIMED {
        let case = cases.iter_mut().find(|case| case.name == name).expect("what is timed is judged");
        (settings.say)(&format!("{name}: timed runs of seed {LIVE_SEED}, one core each, one after the other"));
        case.time(settings, &Makadam)?;
        if !settings.live {
            continue;
        }
        for peer in peers.iter().rev() {
            match case.time(settings, peer.as_ref()) {
                Ok(harvest) => case.check(&harvest, &mut against_recorded),
                Err(error @ CodeError::Interrupted { .. }) => return Err(error.into()),
                Err(error) => failed.push(format!("{name}: the live run of {} failed: {error}", peer.name())),
            }
        }
    }
    if !settings.live {
        notes.push(
            "YADE and LIGGGHTS were not run: their numbers are the recorded references, and no speeds are compared. \
             With both installed (scripts/install-peers), --live runs them."
                .into(),
        );
    }
    (settings.say)("Makadam over the recorded seeds of every scene");
    let comparisons = judge(settings, cases)?;
    notes.extend(failed.iter().cloned());
    let scenes: Vec<&Scene> = comparisons.iter().map(|comparison| &comparison.scene).collect();
    let provenance = account(rayon::current_num_threads(), &scenes);
    let qualification = Qualification {
        title: "Makadam: quick qualification".into(),
        tier: "quick".into(),
        wall_seconds: clock.elapsed().as_secs_f64(),
        comparisons,
        provenance,
        notes,
        outside_spread: against_recorded.outside,
        unchecked: against_recorded.unchecked,
        laws: crate::laws::published(),
        on_record: on_record(),
    };
    Ok(Qualified { qualification, failed })
}

/// Runs Makadam over as many seeds as are recorded, all scenes at once, and compares.
fn judge(settings: &Settings<'_>, cases: Vec<Case>) -> Result<Vec<Comparison>, QualifyError> {
    let jobs: Vec<(usize, u64)> =
        cases.iter().enumerate().flat_map(|(place, case)| (1..=case.seeds).map(move |seed| (place, seed))).collect();
    // One job at a time is taken from the list, so the long ones at its head do not pile up on one thread.
    let harvests: Vec<(usize, Harvest)> = jobs
        .into_par_iter()
        .with_max_len(1)
        .map(|(place, seed)| Ok((place, cases[place].run(settings, &Makadam, seed)?)))
        .collect::<Result<_, CodeError>>()?;
    let mut by_case: Vec<Vec<Harvest>> = cases.iter().map(|_| Vec::new()).collect();
    harvests.into_iter().for_each(|(place, harvest)| by_case[place].push(harvest));
    let threads = rayon::current_num_threads();
    let mut comparisons: Vec<(&str, Comparison)> = cases
        .into_iter()
        .zip(by_case)
        .map(|(case, harvests)| {
            let mut codes = vec![CodeRuns::live("Makadam", threads, harvests)];
            codes.extend(case.recorded);
            let mut comparison = comparison(&case.scene, &codes, case.notes);
            comparison.codes.extend(case.timings);
            (case.name, comparison)
        })
        .collect();
    comparisons.sort_by_key(|(name, _)| match *name {
        "packing" => 0,
        "drum" => 1,
        "drum-caps" => 2,
        _ => 3,
    });
    Ok(comparisons.into_iter().map(|(_, comparison)| comparison).collect())
}

impl Case {
    fn open(name: &'static str, roots: &[PathBuf], peers: &[Box<dyn Code>]) -> Result<Case, QualifyError> {
        let file = scenes::find(name, roots)?;
        let scene = scenes::load(&file)?;
        // Without a margin the scene would be judged by nothing, and no count of the others would tell.
        if scene.compare.iter().all(|expectation| expectation.margin.is_none()) {
            let problem = "no observable has a margin, so that there is nothing to judge".into();
            let remedy = "give a margin under [[compare]]".into();
            return Err(SceneError::from(SceneFileError::Invalid { file, line: None, problem, remedy }).into());
        }
        let reference = Reference::of_scene(&file)?.unwrap_or_default();
        let mut case = Case {
            name,
            seeds: reference.seeds().max(FEWEST_SEEDS),
            file,
            scene,
            recorded: Vec::new(),
            notes: Vec::new(),
            timings: Vec::new(),
        };
        for peer in peers {
            let code = peer.name();
            let missing = || QualifyError::NotRecorded { code: code.into(), scene: name.into() };
            case.recorded.push(reference.code(code).ok_or_else(missing)?);
            case.notes.extend(reference.out_of_date(code, peer.contact_law(), &case.scene));
        }
        Ok(case)
    }

    fn run(&self, settings: &Settings<'_>, code: &dyn Code, seed: u64) -> Result<Harvest, CodeError> {
        self.runs(settings, seed).one(code, &self.scene, seed)
    }

    fn runs<'a>(&'a self, settings: &Settings<'a>, seed: u64) -> Runs<'a> {
        Runs {
            scene: &self.scene,
            scene_file: &self.file,
            purpose: Purpose::Measuring,
            seeds: vec![seed],
            rayleigh_fraction: LIVE_FRACTION,
            stiffness_factor: 1.0,
            time_limit: settings.time_limit,
            recordings: None,
            announce: settings.announce,
        }
    }

    /// Times a code, nothing else of this command running, and notes how long it took.
    fn time(&mut self, settings: &Settings<'_>, code: &dyn Code) -> Result<Harvest, CodeError> {
        let Timed { summary, harvest } = self.runs(settings, LIVE_SEED).time(code, LIVE_SEED)?;
        self.timings.push(summary);
        Ok(harvest)
    }

    /// Holds a live run of a peer against the spread of its recorded runs.
    fn check(&mut self, harvest: &Harvest, found: &mut AgainstRecorded) {
        let run = &harvest.run;
        let recorded = self.recorded.iter().find(|recorded| recorded.code == run.code);
        let recorded = recorded.expect("a case is opened with what is recorded of every peer");
        let percent = 100.0 * LIVE_FRACTION;
        let head = format!("live {} (seed {}, {percent:.0}% of the Rayleigh step)", run.code, run.seed);
        let (scene, mut inside) = (&self.scene.name, Vec::new());
        for check in live_checks(&self.scene, run, recorded) {
            let name = &check.observable;
            match (check.value, check.interval, check.inside) {
                (Some(value), Some([low, high]), Some(true)) => {
                    inside.push(format!("{name} {value:.4} ({low:.4} to {high:.4})"));
                }
                (Some(value), Some([low, high]), _) => found.outside.push(format!(
                    "{scene}: {head} lies outside the 99% interval of the recorded seeds: {name} {value:.4} ({low:.4} to {high:.4})"
                )),
                (None, _, _) => found.unchecked.push(format!("{scene}: {head} has no value of {name}")),
                (Some(_), None, _) => found.unchecked.push(format!(
                    "{scene}: {name} of the {head} has no recorded spread to be held against"
                )),
            }
        }
        if !inside.is_empty() {
            let listed = inside.join(", ");
            self.notes.push(format!("{head} lies inside the 99% interval of the recorded seeds: {listed}"));
        }
    }
}
