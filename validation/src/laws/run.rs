//! One simulation of a case, on one thread.

use super::Case;
use crate::execution::{Execution, ExecutionError};
use crate::output::WriteError;
use crate::prepared::steps_in;
use makadam::Simulation;
use makadam::scene::SceneError;
use makadam::snapshot::Snapshot;
use std::path::Path;

/// Why a law could not be measured.
#[derive(Debug, thiserror::Error)]
pub(crate) enum LawError {
    /// A scene cannot be populated.
    #[error(transparent)]
    Scene(#[from] SceneError),
    /// The machine cannot run it.
    #[error(transparent)]
    Execution(#[from] ExecutionError),
    /// A row cannot be kept.
    #[error(transparent)]
    Write(#[from] WriteError),
    /// The simulation broke down.
    #[error("{case}: grain {grain} is not finite after {time} s; run its scene with a smaller solver.step to see why")]
    NotFinite {
        /// The case.
        case: String,
        /// The grain.
        grain: u32,
        /// Simulated time, s.
        time: f64,
    },
    /// The user asked to stop.
    #[error("interrupted")]
    Interrupted,
}

/// A simulation under way.
pub(crate) struct Run<'a> {
    simulation: Simulation,
    name: &'a str,
    duration: f64,
    progress: &'a (dyn Fn(f64) + Sync),
}

impl<'a> Run<'a> {
    /// Steps from one look for interruption, and for numbers that are not finite, to the next.
    const LOOK: u64 = 20;

    /// A simulation at its start; `progress` is told the share that is done.
    ///
    /// # Errors
    /// [`LawError`] if the case cannot be populated.
    pub(crate) fn start(case: &'a Case, seed: u64, progress: &'a (dyn Fn(f64) + Sync)) -> Result<Run<'a>, LawError> {
        let mut simulation = Simulation::new(&case.scene, seed, Path::new(&case.name))?;
        Execution::serial().apply(&mut simulation)?;
        Ok(Run { simulation, name: &case.name, duration: case.scene.duration, progress })
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

    /// Goes on to a time, s.
    ///
    /// # Errors
    /// [`LawError`] if the user asked to stop or a number is not finite.
    pub(crate) fn to(&mut self, time: f64) -> Result<(), LawError> {
        while !self.has_reached(time) {
            self.simulation.step();
            if self.steps().is_multiple_of(Self::LOOK) || self.has_reached(time) {
                self.look()?;
            }
        }
        Ok(())
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

    fn look(&self) -> Result<(), LawError> {
        (self.progress)(self.time() / self.duration);
        if crate::interrupt::requested() {
            return Err(LawError::Interrupted);
        }
        match self.simulation.not_finite() {
            Some(grain) => Err(LawError::NotFinite { case: self.name.into(), grain, time: self.time() }),
            None => Ok(()),
        }
    }
}
