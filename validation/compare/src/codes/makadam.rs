//! Makadam itself, as one of the codes.

use super::process::ThreadClock;
use super::{Code, CodeError, Job};
use crate::prepared::{StartError, start};
use crate::scenes::in_file;
use makadam::Simulation;
use makadam::scene::{Grain, populate};
use makadam::watch::Watchdog;
use makadam_frames::execution::Execution;
use makadam_frames::output::WriteError;
use makadam_frames::provenance::Build;
use makadam_frames::recording::{Noticed, Recording};
use makadam_frames::stepping::{Halt, Stepping, Taken};

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
        let mut simulation = started(job)?;
        scene.record_walls(&mut simulation);
        let (beginning, step_seconds) = (simulation.time(), simulation.time_step());
        let steps = scene.most_steps();
        let mut frames = vec![simulation.snapshot()];
        let mut watchdog = Watchdog::new(&scene.watch, &simulation);
        let stepping = Stepping::new(steps, job.progress).framed(scene.measure.interval).watched(&mut watchdog);
        let keep = |simulation: &Simulation, taken: &Taken| frames.extend(taken.framed.then(|| simulation.snapshot()));
        let clock = ThreadClock::start();
        let wall = stepping.carry_out(&mut simulation, keep).map_err(|halt| match halt {
            Halt::InvalidState(alarm) => CodeError::InvalidState { code: "Makadam", alarm },
            Halt::Interrupted | Halt::OutOfTime(_) => CodeError::Interrupted { code: "Makadam" },
        })?;
        Ok(Recording {
            time_step: step_seconds,
            stiffness_factor: job.stiffness_factor,
            wall_seconds: wall.as_secs_f64(),
            core_seconds: clock.core_seconds(wall),
            simulated_seconds: simulation.time() - beginning,
            alarms: Noticed::by(&watchdog),
            ..Recording::new(scene, self.name(), Build::here().summary(), job.seed, frames)
        })
    }
}

/// Returns the simulation at the start of a job's run, on one thread: the jittered lattice, or the state that the scene prepares.
fn started(job: &Job<'_>) -> Result<Simulation, CodeError> {
    let (simulation, _) =
        start(job.scene, job.seed, job.scene_file, &Execution::serial(), &|_| {}).map_err(|error| match error {
            StartError::Scene(error) => CodeError::Scene(error),
            StartError::Write(WriteError { path, source }) => CodeError::Io { path, source },
            StartError::Checkpoint(error) => CodeError::State(error),
            StartError::Execution(error) => CodeError::Execution(error),
            StartError::InvalidState(alarm) => CodeError::InvalidState { code: "Makadam", alarm },
            StartError::Interrupted => CodeError::Interrupted { code: "Makadam" },
        })?;
    Ok(simulation)
}

/// Returns the grains at the start of a job's run. Makadam prepares the state of a scene that requires one; all codes start from the same state.
///
/// # Errors
/// [`CodeError`] if the scene cannot be populated or its state not prepared.
pub fn starting_grains(job: &Job<'_>) -> Result<Vec<Grain>, CodeError> {
    starting_grains_if(job, |_| Ok(()))
}

/// Grains at the start of a job's run, after `check` has accepted the grains as placed: a refusal does not wait for the preparation of a
/// state.
pub(super) fn starting_grains_if(
    job: &Job<'_>,
    check: impl FnOnce(&[Grain]) -> Result<(), CodeError>,
) -> Result<Vec<Grain>, CodeError> {
    let mut grains = populate(job.scene, job.seed).map_err(in_file(job.scene_file))?;
    check(&grains)?;
    if job.scene.prepare.is_some() {
        for particle in started(job)?.snapshot().particles {
            let grain = &mut grains[particle.id as usize];
            (grain.position, grain.velocity, grain.spin) = (particle.position, particle.velocity, particle.spin);
        }
    }
    Ok(grains)
}
