//! One simulation of a case, on one thread.

use super::Case;
use crate::execution::Execution;
use crate::output::WriteError;
use crate::scenes::{SceneError, named};
use crate::stepping::{Halt, Stepping, steps_in};
use makadam::Simulation;
use makadam::snapshot::Snapshot;
use makadam::watch::{Alarm, Watchdog};

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
    /// A simulation at its start; `progress` is told the share that is done.
    ///
    /// # Errors
    /// [`LawError`] if the case cannot be populated.
    pub(crate) fn start(case: &'a Case, seed: u64, progress: &'a (dyn Fn(f64) + Sync)) -> Result<Run<'a>, LawError> {
        let mut simulation = Simulation::new(&case.scene, seed).map_err(named(&case.name))?;
        Execution::serial().apply(&mut simulation)?;
        let watchdog = Watchdog::new(&case.scene.watch, &simulation);
        Ok(Run { simulation, watchdog, name: &case.name, duration: case.scene.duration, progress })
    }

    /// Simulated time, s.
    pub(crate) fn time(&self) -> f64 {
        self.simulation.time()
    }

    /// Steps taken.
    pub(crate) fn steps(&self) -> u64 {
        self.simulation.steps_taken()
    }

    /// Whether it has gone on to a time (s), which need not be a whole number of steps: the nearest counts.
    pub(crate) fn has_reached(&self, time: f64) -> bool {
        self.steps() >= steps_in(time, self.simulation.time_step())
    }

    /// Grains and contacts as they are.
    pub(crate) fn frame(&self) -> Snapshot {
        self.simulation.snapshot()
    }

    /// Goes on to a time (s), which need not be a whole number of steps: the nearest counts.
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

    /// Goes on to a time (s), and takes frames at an interval (s) on the way; the one at the start is not taken.
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
