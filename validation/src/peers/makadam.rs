//! Makadam itself, as one of the codes.

use super::{Code, CodeError, Job};
use crate::execution::Execution;
use crate::output::WriteError;
use crate::prepared::{StartError, start};
use crate::provenance::Build;
use crate::recording::Recording;
use crate::stepping::{frame_is_due, steps_in};
use makadam::watch::Watchdog;
use std::time::{Duration, Instant};

/// Makadam, in this process, on one thread.
pub struct Makadam;

impl Code for Makadam {
    fn name(&self) -> &'static str {
        "Makadam"
    }

    fn version(&self) -> Option<String> {
        Some(Build::here().summary())
    }

    fn simulate(&self, job: &Job<'_>) -> Result<Recording, CodeError> {
        let scene = job.scene;
        let interrupted = || CodeError::Interrupted { code: "Makadam" };
        let (mut simulation, _) =
            start(scene, job.seed, job.scene_file, &Execution::serial(), &|_| {}).map_err(|error| match error {
                StartError::Scene(error) => CodeError::Scene(error),
                StartError::Write(WriteError { path, source }) => CodeError::Io { path, source },
                StartError::Checkpoint(error) => CodeError::State(error),
                StartError::Execution(error) => CodeError::Execution(error),
                StartError::Worthless(alarm) => CodeError::Worthless { code: "Makadam", alarm },
                StartError::Interrupted => interrupted(),
            })?;
        let (started, step_seconds) = (simulation.time(), simulation.time_step());
        let steps = steps_in(scene.duration, step_seconds);
        let mut frames = vec![simulation.snapshot()];
        let mut wall = Duration::ZERO;
        let mut watchdog = Watchdog::new(&scene.watch, &simulation);
        for step in 1..=steps {
            let clock = Instant::now();
            let report = simulation.step();
            wall += clock.elapsed();
            let framed = step == steps || frame_is_due(step, step_seconds, scene.measure.interval);
            watchdog
                .check(&simulation, &report, framed)
                .map_err(|alarm| CodeError::Worthless { code: "Makadam", alarm })?;
            if framed {
                frames.push(simulation.snapshot());
            }
            (job.progress)(step as f64 / steps as f64);
            if crate::interrupt::requested() {
                return Err(interrupted());
            }
        }
        Ok(Recording {
            scene: scene.name.clone(),
            code: self.name().into(),
            version: Build::here().summary(),
            seed: job.seed,
            time_step: step_seconds,
            rayleigh_fraction: None,
            stiffness_factor: job.stiffness_factor,
            threads: 1,
            wall_seconds: wall.as_secs_f64(),
            simulated_seconds: simulation.time() - started,
            frames,
        })
    }
}
