//! Makadam itself, as one of the codes.

use super::{Code, CodeError, Job};
use crate::execution::Execution;
use crate::output::WriteError;
use crate::prepared::{StartError, start, steps_in};
use crate::provenance::Build;
use crate::recording::Recording;
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

/// Whether a frame is due after a step: the first one at or after each multiple of the interval.
pub fn frame_is_due(step: u64, step_seconds: f64, interval: f64) -> bool {
    // A thousandth of a step absorbs rounding where the interval is a whole number of steps.
    let intervals = |step: u64| ((step as f64 + 1e-3) * step_seconds / interval).floor();
    step > 0 && intervals(step) > intervals(step - 1)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn frames_fall_on_multiples_of_the_interval() {
        let due: Vec<u64> = (0..=300).filter(|&step| frame_is_due(step, 5e-4, 0.05)).collect();
        assert_eq!(due, [100, 200, 300]);
        let due: Vec<u64> = (0..=10).filter(|&step| frame_is_due(step, 1.0, 2.5)).collect();
        assert_eq!(due, [3, 5, 8, 10]);
    }
}
