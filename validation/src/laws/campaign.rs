//! The campaign of a law: its cases over seeds, each run on one thread, measured, and stored as soon as its row is there.

use super::{Law, Row};
use crate::execution::Execution;
use crate::output::WriteError;
use crate::plan::Scene;
use crate::provenance::{JUDGE, VERSION, scene_hash};
use crate::scenes::{SceneError, named};
use crate::stepping::{Halt, Stepping, steps_in};
use crate::study::{Key, RunCache, run_jobs};
use makadam::snapshot::Snapshot;
use makadam::watch::{Alarm, Watchdog};
use makadam::{BUILD, Simulation};
use std::collections::BTreeMap;
use std::path::Path;
use std::time::Instant;

/// Named numbers; SI units unless the name says otherwise.
pub(crate) type Values = BTreeMap<String, f64>;

/// Restitution threshold of all cases (m/s), with which the rows on record were made. By the scales of grains of 10 mm it would be 0.0501.
const RESTITUTION_THRESHOLD: f64 = 0.05;

/// One simulation of a law, before a seed is chosen.
pub(crate) struct Case {
    /// Name, unique within the law; a part of file names.
    pub(crate) name: String,
    /// What is simulated; its duration is an upper bound.
    pub(crate) scene: Scene,
    /// What was chosen for it; a part of its row.
    pub(crate) given: Values,
}

impl Case {
    /// A case.
    pub(crate) fn new<const N: usize>(mut scene: Scene, given: [(&str, f64); N]) -> Case {
        scene.solver.restitution_threshold = Some(RESTITUTION_THRESHOLD);
        Case { name: scene.name.clone(), scene, given: values(given) }
    }

    /// What was chosen under a name.
    ///
    /// # Panics
    /// The law did not choose such a value.
    pub(crate) fn of(&self, name: &str) -> f64 {
        self.given[name]
    }
}

/// Named numbers from a list.
pub(crate) fn values<const N: usize>(list: [(&str, f64); N]) -> Values {
    list.into_iter().map(|(name, value)| (name.to_string(), value)).collect()
}

/// Runs of a law.
pub(crate) struct Plan<'a> {
    /// Seeds of each case.
    pub(crate) seeds: &'a [u64],
    /// True if stored rows are measured again.
    pub(crate) again: bool,
    /// Folder of the law.
    pub(crate) folder: &'a Path,
}

/// Measures every case with every seed; rows are in the order of the cases, and of the seeds within a case. `progress` receives the
/// fraction that is done.
///
/// # Errors
/// [`LawError`] of the first run that fails.
pub(crate) fn run_cases(
    law: &'static dyn Law,
    cases: &[Case],
    plan: &Plan<'_>,
    progress: &(dyn Fn(f64) + Sync),
) -> Result<Vec<Row>, LawError> {
    let stored = StoredRows::open(law, plan)?;
    let jobs: Vec<(&Case, u64)> =
        cases.iter().flat_map(|case| plan.seeds.iter().map(move |&seed| (case, seed))).collect();
    run_jobs(&jobs, |(case, _)| work(case), progress, |(case, seed), done| stored.take(case, *seed, done))
}

/// Rows of a law, each measured where it is not stored.
pub(crate) struct StoredRows {
    law: &'static dyn Law,
    cache: RunCache,
    again: bool,
}

impl StoredRows {
    /// Opens the rows of a plan.
    ///
    /// # Errors
    /// [`LawError`] if its folder cannot be made.
    pub(crate) fn open(law: &'static dyn Law, plan: &Plan<'_>) -> Result<StoredRows, LawError> {
        Ok(StoredRows { law, cache: RunCache::open(&plan.folder.join("runs"))?, again: plan.again })
    }

    /// Returns the row of a case and a seed; `progress` receives the fraction of its run that is done.
    ///
    /// # Errors
    /// [`LawError`] if it has to be measured and cannot.
    pub(crate) fn take(&self, case: &Case, seed: u64, progress: &(dyn Fn(f64) + Sync)) -> Result<Row, LawError> {
        self.cache.take(&key(case, seed), self.again, || measured(self.law, case, seed, progress))
    }
}

/// Returns the work of a case: grains times steps.
pub(crate) fn work(case: &Case) -> f64 {
    let grains: usize = case.scene.population.iter().map(|population| population.count).sum();
    (grains + case.scene.grain.len()) as f64 * case.scene.duration / case.scene.solver.step
}

/// Returns the key of a row: the scene, the seed, the build, and the sources that measure.
fn key(case: &Case, seed: u64) -> Key {
    Key::new(format!("{}-s{seed}", case.name), &[&hash(case), &seed.to_string(), BUILD, JUDGE])
}

fn measured(law: &dyn Law, case: &Case, seed: u64, progress: &(dyn Fn(f64) + Sync)) -> Result<Row, LawError> {
    let start = Instant::now();
    let mut run = Run::start(case, seed, progress)?;
    let mut values = law.measure(case, &mut run)?;
    values.extend(case.given.clone());
    Ok(Row {
        case: case.name.clone(),
        seed,
        values,
        scene_hash: hash(case),
        makadam: VERSION.into(),
        grains: run.frame().particles.len(),
        steps: run.steps(),
        wall_seconds: start.elapsed().as_secs_f64(),
    })
}

/// Returns the hash of a case's scene, 16 hexadecimal digits.
pub(super) fn hash(case: &Case) -> String {
    format!("{:016x}", scene_hash(&case.scene))
}

/// Why a law could not be measured.
#[derive(Debug, thiserror::Error)]
pub(crate) enum LawError {
    /// A scene cannot be populated.
    #[error(transparent)]
    Scene(#[from] SceneError),
    /// The machine cannot run it.
    #[error(transparent)]
    Execution(#[from] makadam::SettingError),
    /// A row cannot be kept.
    #[error(transparent)]
    Write(#[from] WriteError),
    /// The simulation came to a state that makes its numbers worthless.
    #[error("{case}: {alarm}")]
    Worthless {
        /// The case.
        case: String,
        /// What was noticed.
        alarm: Alarm,
    },
    /// The user asked to stop.
    #[error("interrupted")]
    Interrupted,
}

/// A simulation under way.
pub(crate) struct Run<'a> {
    simulation: Simulation,
    watchdog: Watchdog,
    name: &'a str,
    duration: f64,
    progress: &'a (dyn Fn(f64) + Sync),
}

impl<'a> Run<'a> {
    /// Starts a simulation; `progress` receives the fraction that is done.
    ///
    /// # Errors
    /// [`LawError`] if the case cannot be populated.
    pub(crate) fn start(case: &'a Case, seed: u64, progress: &'a (dyn Fn(f64) + Sync)) -> Result<Run<'a>, LawError> {
        let mut simulation = Simulation::new(&case.scene, seed).map_err(named(&case.name))?;
        Execution::serial().apply(&mut simulation)?;
        let watchdog = Watchdog::new(&case.scene.watch, &simulation);
        Ok(Run { simulation, watchdog, name: &case.name, duration: case.scene.duration, progress })
    }

    /// Returns the simulated time, s.
    pub(crate) fn time(&self) -> f64 {
        self.simulation.time()
    }

    /// Returns the number of steps taken.
    pub(crate) fn steps(&self) -> u64 {
        self.simulation.steps_taken()
    }

    /// Returns true if the nearest whole number of steps to a time (s) is taken.
    pub(crate) fn has_reached(&self, time: f64) -> bool {
        self.steps() >= steps_in(time, self.simulation.time_step())
    }

    /// Returns the present grains and contacts.
    pub(crate) fn frame(&self) -> Snapshot {
        self.simulation.snapshot()
    }

    /// Steps to the nearest whole number of steps to a time (s).
    ///
    /// # Errors
    /// [`LawError`] if the user asked to stop, or the watchdog found a state that ends a run.
    pub(crate) fn to(&mut self, time: f64) -> Result<(), LawError> {
        let steps = steps_in(time, self.simulation.time_step()).saturating_sub(self.steps());
        let (from, duration, progress) = (self.time(), self.duration, self.progress);
        let told = |share: f64| progress((from + share * (time - from)) / duration);
        let stepping = Stepping::new(steps, &told).watched(&mut self.watchdog);
        stepping.carry_out(&mut self.simulation, |_, _| {}).map(|_| ()).map_err(|halt| match halt {
            Halt::Worthless(alarm) => LawError::Worthless { case: self.name.into(), alarm },
            Halt::Interrupted | Halt::OutOfTime(_) => LawError::Interrupted,
        })
    }

    /// Steps to a time (s) and takes frames at an interval (s), without the one at the start.
    ///
    /// # Errors
    /// As [`Run::to`].
    pub(crate) fn sample(
        &mut self,
        until: f64,
        interval: f64,
        mut take: impl FnMut(&Snapshot),
    ) -> Result<(), LawError> {
        let from = self.time();
        let frames = ((until - from) / interval).round().max(1.0) as u64;
        for number in 1..=frames {
            self.to(from + (until - from) * number as f64 / frames as f64)?;
            take(&self.frame());
        }
        Ok(())
    }
}
