//! The run as steps: when frames are taken and when walls start and stop.

use super::Job;
use makadam::scene::Motion;
use makadam::snapshot::Snapshot;
use makadam_frames::plan::Scene;
use makadam_frames::recording::Recording;

/// Time between the frames before measuring begins, s.
const COARSE_INTERVAL: f64 = 0.25;

/// One run in time steps.
pub(super) struct Plan {
    /// Time step, s: a whole number of them fills the interval between frames.
    pub time_step: f64,
    /// Number of steps.
    pub steps: u64,
    /// Steps between frames once measuring has begun.
    pub fine: u64,
    /// Steps between frames before that; a multiple of `fine`.
    pub coarse: u64,
    /// Step of the first measured frame.
    pub fine_from: u64,
}

/// A part of a wall's motion that a code can be told at once: at one velocity, or a vibration.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct MotionPhase {
    /// Step at which it begins.
    pub first: u64,
    /// Step at which it ends.
    pub last: u64,
    /// 1 as the scene says, -1 the other way.
    pub direction: f64,
}

impl Plan {
    /// Divides a scene's duration by a step of at most `largest_step`.
    pub fn new(scene: &Scene, largest_step: f64) -> Plan {
        let interval = scene.measure.interval;
        let fine = (interval / largest_step - 1e-9).ceil().max(1.0);
        // An interval below the step does not shrink the step further than to itself.
        let time_step = interval / fine;
        let step_at = |time: f64| (time / time_step).round() as u64;
        let steps = step_at(scene.duration).max(1);
        let fine = fine as u64;
        let coarse = fine.saturating_mul((COARSE_INTERVAL / interval).round().max(1.0) as u64);
        let fine_from = match scene.measure.from {
            Some(from) => (step_at(from).div_ceil(fine) * fine).min(steps),
            None => steps,
        };
        Plan { time_step, steps, fine, coarse, fine_from }
    }

    /// The frames of a run of this plan by an explicit code, on one core, with where they came from.
    pub fn recording(
        &self,
        code: &str,
        version: String,
        job: &Job<'_>,
        wall_seconds: f64,
        frames: Vec<Snapshot>,
    ) -> Recording {
        Recording {
            time_step: self.time_step,
            rayleigh_fraction: Some(job.rayleigh_fraction),
            stiffness_factor: job.stiffness_factor,
            wall_seconds,
            simulated_seconds: self.steps as f64 * self.time_step,
            ..Recording::new(job.scene, code, version, job.seed, frames)
        }
    }

    /// Steps at which frames are taken, rising, the last one at the end.
    pub fn frames(&self) -> Vec<u64> {
        let coarse = (0..self.fine_from).step_by(self.coarse as usize);
        let fine = (self.fine_from..self.steps).step_by(self.fine as usize);
        coarse.chain(fine).chain([self.steps]).collect()
    }

    /// The step of the run that begins nearest to a time (s).
    pub fn step_at(&self, time: f64) -> u64 {
        ((time / self.time_step).round() as u64).min(self.steps)
    }

    /// The phases of a wall's motion within the run, in their order; a driven wall has none.
    pub fn phases(&self, motion: &Motion) -> Vec<MotionPhase> {
        let (start, stop, reverse) = match motion {
            Motion::Fixed | Motion::ForceDriven { .. } | Motion::TorqueDriven { .. } => return Vec::new(),
            Motion::Translating { start, stop, .. } | Motion::Vibrating { start, stop, .. } => (*start, *stop, None),
            Motion::Rotating { start, stop, reverse, .. } => (*start, *stop, *reverse),
        };
        let step_at = |time: f64| self.step_at(time);
        let (first, last) = (step_at(start), stop.map_or(self.steps, step_at));
        let turn = reverse.map_or(last, step_at).clamp(first, last.max(first));
        let forth = MotionPhase { first, last: turn, direction: 1.0 };
        let back = MotionPhase { first: turn, last, direction: -1.0 };
        [forth, back].into_iter().filter(|phase| phase.first < phase.last).collect()
    }

    /// Steps at which some wall starts or stops or the frames become denser, rising, with both ends of the run.
    pub fn boundaries(&self, scene: &Scene) -> Vec<u64> {
        let mut at: Vec<u64> = scene
            .wall
            .iter()
            .flat_map(|wall| self.phases(&wall.motion))
            .flat_map(|phase| [phase.first, phase.last])
            .chain([0, self.fine_from, self.steps])
            .collect();
        at.sort_unstable();
        at.dedup();
        at
    }
}
