//! The run as steps: when frames are taken and when walls start and stop.

use makadam::scene::{Motion, Scene};

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
        let coarse = fine * (COARSE_INTERVAL / interval).round().max(1.0) as u64;
        let fine_from = match scene.measure.from {
            Some(from) => (step_at(from).div_ceil(fine) * fine).min(steps),
            None => steps,
        };
        Plan { time_step, steps, fine, coarse, fine_from }
    }

    /// Steps at which frames are taken, rising, the last one at the end.
    pub fn frames(&self) -> Vec<u64> {
        let coarse = (0..self.fine_from).step_by(self.coarse as usize);
        let fine = (self.fine_from..self.steps).step_by(self.fine as usize);
        coarse.chain(fine).chain([self.steps]).collect()
    }

    /// First and last step of a wall's motion; nothing if it never moves within the run.
    pub fn motion_steps(&self, motion: &Motion) -> Option<(u64, u64)> {
        let (start, stop) = match motion {
            Motion::Fixed => return None,
            Motion::Translating { start, stop, .. } | Motion::Rotating { start, stop, .. } => (*start, *stop),
        };
        let step_at = |time: f64| ((time / self.time_step).round() as u64).min(self.steps);
        let (first, last) = (step_at(start), stop.map_or(self.steps, step_at));
        (first < last).then_some((first, last))
    }

    /// Steps at which some wall starts or stops or the frames become denser, rising, with both ends of the run.
    pub fn boundaries(&self, scene: &Scene) -> Vec<u64> {
        let mut at: Vec<u64> = scene
            .wall
            .iter()
            .filter_map(|wall| self.motion_steps(&wall.motion))
            .flat_map(|(first, last)| [first, last])
            .chain([0, self.fine_from, self.steps])
            .collect();
        at.sort_unstable();
        at.dedup();
        at
    }
}
