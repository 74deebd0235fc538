//! Present pace of this machine: the time per unit of work, from the simulation of a small bed, and the work of a scene.
//!
//! ```text
//! wall time = [ steps x grains x (step + contacts per grain x sweeps x sweep) + frames x grains x frame ] / speed-up
//! ```

use super::frames;
use makadam::Simulation;
use makadam::scene::Stop;
use makadam_compare::prepared::is_ready;
use makadam_frames::execution::threads_for;
use makadam_frames::plan::MeasuredScene;
use makadam_frames::stepping::steps_in;

/// Simulated bed: 400 grains in a box, in contact from the start or soon after.
const BED: &str = include_str!("pace.toml");
/// Steps until the grains have settled, and timed steps.
const STEPS: [usize; 2] = [200, 100];
/// Contacts per grain in the sweeps, in a bed and without compression: reference scenes have 1.9 to 3.0 and
/// 0.1.
const CONTACTS: [f64; 2] = [2.2, 0.1];
/// Sweeps of a solve with a residual criterion, typical of tolerances of some percent of g h.
const TYPICAL_SWEEPS: f64 = 20.0;
/// Smallest number of grains of a bed too large for the cache, and the factors on the times of a step and of a sweep there.
const LARGE: usize = 10_000;
const BEYOND_CACHE: [f64; 2] = [1.3, 1.8];
/// Time to measure and write a grain of a frame, in units of its time per step without sweeps.
const OF_A_FRAME: f64 = 20.0;
/// Loss of speed-up per additional thread: 1.9 on 2 and 7 on 16 threads.
const LOSS: f64 = 0.08;

/// Times per unit of work, s.
#[derive(Clone, Copy, Debug)]
pub(super) struct Pace {
    /// Time per grain and step, without sweeps.
    step: f64,
    /// Time per contact and sweep.
    sweep: f64,
}

/// Work of a scene.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Work {
    /// Grains times steps.
    steps: f64,
    /// Contacts times sweeps times steps.
    pub(super) contact_sweeps: f64,
    /// Grains times frames.
    frames: f64,
    grains: usize,
    /// Wall time budget of the solves in the scene, s.
    given: f64,
}

impl Pace {
    /// Measures the pace of this machine under its present load, on one thread: a tenth of a second.
    pub(super) fn here() -> Pace {
        let scene = MeasuredScene::parse(BED).expect("the bed is a scene");
        let mut simulation = Simulation::new(&scene, scene.seed).expect("the bed has its grains");
        let [until, timed] = STEPS;
        (0..until).for_each(|_| {
            simulation.step();
        });
        let (before, sweeps) = (simulation.phase_seconds(), simulation.contact_sweeps());
        (0..timed).for_each(|_| {
            simulation.step();
        });
        let (after, sweeps) = (simulation.phase_seconds(), simulation.contact_sweeps() - sweeps);
        let others =
            after.detect + after.constrain + after.integrate - (before.detect + before.constrain + before.integrate);
        Pace {
            step: others / (timed * scene.grain_count()) as f64,
            sweep: (after.sweep - before.sweep) / sweeps.max(1) as f64,
        }
    }

    /// Returns the wall time of work, s, on a run's default number of threads.
    pub(super) fn seconds(self, work: &Work) -> f64 {
        let [step, sweep] = if work.grains < LARGE { [1.0; 2] } else { BEYOND_CACHE };
        let alone = self.step * step * work.steps + self.sweep * sweep * work.contact_sweeps;
        let threads = threads_for(work.grains) as f64;
        (alone + work.given) * (1.0 + LOSS * (threads - 1.0)) / threads + self.step * OF_A_FRAME * work.frames
    }
}

impl Work {
    /// Returns the work of a run of a scene, including the preparation of a flow if none is stored.
    pub(super) fn of(scene: &MeasuredScene, seed: u64) -> Work {
        let grains = scene.most_grains();
        let prepare = scene.prepare.as_ref().filter(|_| !is_ready(scene, seed));
        let steps = scene.most_steps() + prepare.map_or(0, |prepare| steps_in(prepare.duration, prepare.step));
        let (sweeps, given) = match scene.solver.stop {
            Stop::Sweeps { sweeps } => (f64::from(sweeps), 0.0),
            Stop::Residual { max_sweeps, .. } => (f64::from(max_sweeps).min(TYPICAL_SWEEPS), 0.0),
            Stop::TimeBudget { seconds, .. } => (0.0, seconds * steps as f64),
        };
        let pressed = scene.gravity_field().largest() > 0.0
            || scene.material.values().any(|material| material.cohesion.is_some());
        let contacts = CONTACTS[usize::from(!pressed)] * grains as f64;
        Work {
            steps: (steps as usize * grains) as f64,
            contact_sweeps: contacts * sweeps * f64::from(scene.solver.inner_sweeps) * steps as f64,
            frames: (frames(scene) as usize * grains) as f64,
            grains,
            given,
        }
    }
}

#[cfg(test)]
#[path = "../../tests/unit/forecast_pace.rs"]
mod tests;
