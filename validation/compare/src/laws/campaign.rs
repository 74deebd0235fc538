//! Runs of a law: its cases over seeds, each on one thread, measured and stored at its end.

use super::{Law, Row};
use crate::codes::CodeError;
use crate::scenes::named;
use crate::study::{Key, RunCache, RunError, run_jobs};
use makadam::Simulation;
use makadam::snapshot::Snapshot;
use makadam::watch::Watchdog;
use makadam_frames::execution::Execution;
use makadam_frames::plan::MeasuredScene;
use makadam_frames::provenance::{VERSION, scene_hash};
use makadam_frames::stepping::{Halt, Stepping, steps_in};
use std::collections::BTreeMap;
use std::time::Instant;

/// Named numbers; SI units unless the name says otherwise.
pub type Values = BTreeMap<String, f64>;

/// One simulation of a law, before a seed is chosen.
pub struct Case {
    /// Name, unique within the law; a part of file names.
    pub name: String,
    /// Scene; its duration is an upper bound.
    pub scene: MeasuredScene,
    /// Chosen values, a part of its row.
    pub(crate) given: Values,
}

impl Case {
    pub(crate) fn new<const N: usize>(scene: MeasuredScene, given: [(&str, f64); N]) -> Case {
        Case { name: scene.name.clone(), scene, given: values(given) }
    }

    /// Returns a chosen value.
    ///
    /// # Panics
    /// The law did not choose such a value.
    pub(crate) fn of(&self, name: &str) -> f64 {
        self.given[name]
    }

    /// Hash of the scene, 16 hexadecimal digits.
    pub(super) fn hash(&self) -> String {
        format!("{:016x}", scene_hash(&self.scene))
    }
}

/// Named numbers from a list.
pub(crate) fn values<const N: usize>(list: [(&str, f64); N]) -> Values {
    list.into_iter().map(|(name, value)| (name.to_string(), value)).collect()
}

/// Measures every case with every seed; rows are in the order of the cases, and of the seeds within a case. `progress` receives the
/// completed fraction.
pub fn run_cases(
    law: &Law,
    cases: &[Case],
    seeds: &[u64],
    cache: &RunCache,
    progress: &(dyn Fn(f64) + Sync),
) -> Result<Vec<Row>, RunError> {
    let jobs: Vec<(&Case, u64)> = cases.iter().flat_map(|case| seeds.iter().map(move |&seed| (case, seed))).collect();
    run_jobs(&jobs, |(case, _)| work(case), progress, |(case, seed), done| row_of(law, case, *seed, cache, done))
}

/// Returns the work of a case: grains times steps.
pub fn work(case: &Case) -> f64 {
    case.scene.grain_count() as f64 * case.scene.duration / case.scene.solver.step
}

/// Returns the row of a case and a seed, from the cache or from a new run; `progress` receives the completed fraction of the run.
pub fn row_of(
    law: &Law,
    case: &Case,
    seed: u64,
    cache: &RunCache,
    progress: &(dyn Fn(f64) + Sync),
) -> Result<Row, RunError> {
    cache.take(&Key::of_run(format!("{}-s{seed}", case.name), &case.scene, seed, &[]), || {
        let start = Instant::now();
        let mut run = Run::start(case, seed, progress)?;
        let mut values = (law.measure)(case, &mut run)?;
        values.extend(case.given.clone());
        Ok(Row {
            case: case.name.clone(),
            seed,
            values,
            scene_hash: case.hash(),
            makadam: VERSION.into(),
            grains: run.frame().particles.len(),
            steps: run.steps(),
            wall_seconds: start.elapsed().as_secs_f64(),
        })
    })
}

/// Simulation in progress.
pub struct Run<'a> {
    simulation: Simulation,
    watchdog: Watchdog,
    name: &'a str,
    duration: f64,
    progress: &'a (dyn Fn(f64) + Sync),
}

impl<'a> Run<'a> {
    /// Starts a simulation; `progress` receives the completed fraction.
    pub(crate) fn start(case: &'a Case, seed: u64, progress: &'a (dyn Fn(f64) + Sync)) -> Result<Run<'a>, RunError> {
        let mut simulation = Simulation::new(&case.scene, seed).map_err(named(&case.name))?;
        Execution::serial().apply(&mut simulation).map_err(CodeError::from)?;
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
    pub(crate) fn to(&mut self, time: f64) -> Result<(), RunError> {
        let steps = steps_in(time, self.simulation.time_step()).saturating_sub(self.steps());
        let (from, duration, progress) = (self.time(), self.duration, self.progress);
        let report = |fraction: f64| progress((from + fraction * (time - from)) / duration);
        let stepping = Stepping::new(steps, &report).watched(&mut self.watchdog);
        stepping.carry_out(&mut self.simulation, |_, _| {}).map(|_| ()).map_err(|halt| match halt {
            Halt::InvalidState(alarm) => RunError::Invalid(format!("{}: {alarm}", self.name)),
            Halt::Interrupted | Halt::OutOfTime(_) => RunError::Interrupted,
        })
    }

    /// Steps to a time (s) and takes frames at an interval (s), without the one at the start.
    pub(crate) fn sample(
        &mut self,
        until: f64,
        interval: f64,
        mut take: impl FnMut(&Snapshot),
    ) -> Result<(), RunError> {
        let from = self.time();
        let frames = ((until - from) / interval).round().max(1.0) as u64;
        for number in 1..=frames {
            self.to(from + (until - from) * number as f64 / frames as f64)?;
            take(&self.frame());
        }
        Ok(())
    }
}
