//! Checks prescribed motions against the step: a motion that changes within a step is not resolved.

use super::Beforehand;
use crate::scene::document::DocumentPath;
use crate::scene::error::{Fault, rounded_down, short};
use crate::scene::{Motion, Scene};
use std::f64::consts::TAU;

/// Fewest steps per period of a vibration or a rotation. A step moves a wall by its mean velocity: with `n` steps per period, the
/// ratio of the largest velocity to the true one is `sin(pi/n) n/pi`, 0.989 at 12; for the largest acceleration the ratio is the
/// square. Measured for a grain that bounces on a floor at three times gravity: from 12 steps on, mean kinetic energy and height
/// are within a tenth of those at 400 steps per period; the height is lower by two fifths at 9 steps, by nine tenths at 4.
const STEPS_A_PERIOD: f64 = 12.0;

/// Relative tolerance for rounding of a step that was computed from the limit.
const ROUNDING: f64 = 1e-9;

/// Smallest pulse that is checked, as a fraction of the largest gravity.
const PULSE: f64 = 1e-3;

/// Step, simulated time with this step, and path in the scene.
struct Stepping {
    step: f64,
    until: f64,
    at: DocumentPath,
}

/// Returns the faults of motions that the steps of the scene do not resolve.
pub(super) fn faults(scene: &Scene, beforehand: Option<Beforehand>) -> Vec<Fault> {
    let solver = DocumentPath::default().key("solver").key("step");
    let mut all = vec![Stepping { step: scene.solver.step, until: scene.duration, at: solver }];
    if let Some(prepare) = beforehand {
        let at = DocumentPath::default().key("prepare").key("step");
        all.push(Stepping { step: prepare.step, until: prepare.duration, at });
    }
    let of_each = |stepping: &Stepping| {
        let moving = walls(scene, stepping).into_iter().chain(gravity(scene, stepping));
        moving.chain(stepping.nothing_moves()).collect::<Vec<_>>()
    };
    all.iter().flat_map(of_each).collect()
}

/// Returns the longest step (s) that resolves all motions of a scene.
pub(in crate::scene) fn longest_step(scene: &Scene) -> f64 {
    let walls = || scene.wall.iter().enumerate();
    let parts = || walls().flat_map(|(index, wall)| wall.motion.parts().iter().map(move |part| (index, part)));
    let periods = parts().filter_map(|(index, motion)| period(scene, index, motion, scene.duration));
    let lasting = parts().flat_map(|(_, motion)| intervals(motion)).map(|(_, start, end)| (start, end - start));
    let lasting = lasting.filter(|(start, lasts)| *lasts > 0.0 && *start < scene.duration).map(|(_, lasts)| lasts);
    let pulses = pulses(scene).into_iter().filter(|pulse| pulse.start < scene.duration).map(|pulse| 0.5 * pulse.lasts);
    periods.map(|period| period / STEPS_A_PERIOD).chain(lasting).chain(pulses).fold(f64::INFINITY, f64::min)
}

fn walls(scene: &Scene, stepping: &Stepping) -> Vec<Fault> {
    let (step, mut faults) = (short(stepping.step), Vec::new());
    for (index, wall) in scene.wall.iter().enumerate() {
        let (name, at) = (&wall.name, DocumentPath::default().key("wall").index(index).key("motion"));
        for (at, motion) in wall.motion.parts_at(&at) {
            let period = period(scene, index, motion, stepping.until);
            if let Some(period) = period.filter(|period| stepping.misses(*period / STEPS_A_PERIOD)) {
                let (what, turns) = match motion {
                    Motion::Vibrating { .. } => ("a period", "vibration"),
                    _ => ("a turn", "rotation"),
                };
                let (lasts, steps) = (short(period), short((period / stepping.step * 100.0).round() / 100.0));
                let problem = format!(
                    "{what} of wall '{name}' lasts {lasts} s, {steps} steps of {step} s: its {turns} would be another one"
                );
                faults.push(stepping.fault(&at, problem, period / STEPS_A_PERIOD, ""));
            }
            for (key, start, end) in intervals(motion) {
                let lasts = end - start;
                if lasts > 0.0 && stepping.misses(lasts) && start < stepping.until {
                    let problem = format!("wall '{name}' moves for {} s, less than the step of {step} s", short(lasts));
                    faults.push(stepping.fault(&at.key(key), problem, lasts, ", or let it move longer"));
                }
            }
        }
    }
    faults
}

fn gravity<'s>(scene: &'s Scene, stepping: &'s Stepping) -> impl Iterator<Item = Fault> + 's {
    let missed = |pulse: &Pulse| stepping.misses(0.5 * pulse.lasts) && pulse.start < stepping.until;
    pulses(scene).into_iter().filter(missed).map(|pulse| {
        let at = DocumentPath::default().key("gravity_changes").index(pulse.index);
        let (lasts, step) = (short(pulse.lasts), short(stepping.step));
        let problem = format!("gravity changes and goes back within {lasts} s, less than two steps of {step} s");
        stepping.fault(&at, problem, 0.5 * pulse.lasts, ", or let the change last longer")
    })
}

impl Stepping {
    /// Returns true if the step is longer than the limit (s).
    fn misses(&self, longest: f64) -> bool {
        self.step * (1.0 - ROUNDING) > longest
    }

    /// Returns the fault of a simulated time shorter than half a step, which has no steps.
    fn nothing_moves(&self) -> Option<Fault> {
        let taken = (self.until / self.step).round() >= 1.0;
        let problem = format!("no step of {} s is taken in {} s", short(self.step), short(self.until));
        (self.until > 0.0 && !taken).then(|| self.fault(&self.at, problem, self.until, ", or simulate longer"))
    }

    fn fault(&self, at: &DocumentPath, problem: String, largest: f64, or_else: &str) -> Fault {
        // Rounding down makes the suggested value valid.
        let remedy = format!("give {} at most {:e} s{or_else}", self.at, rounded_down(largest, 3));
        at.fault(problem, &remedy).see(self.at.clone())
    }
}

/// Returns the period of a motion (s), if the motion is periodic and starts before `until`.
fn period(scene: &Scene, wall: usize, motion: &Motion, until: f64) -> Option<f64> {
    let (rate, start) = match *motion {
        Motion::Vibrating { amplitude, frequency, start, .. } if amplitude != [0.0; 3] => (TAU * frequency, start),
        // Rotations of one wall may add up.
        Motion::Rotating { start, .. } => {
            let rate = |part: &Motion| if let Motion::Rotating { rate, .. } = part { rate.abs() } else { 0.0 };
            (scene.course(wall).parts().iter().map(rate).sum(), start)
        }
        _ => return None,
    };
    (rate > 0.0 && start < until).then(|| TAU / rate)
}

/// Returns the intervals of uniform motion of a wall (start and end, s), each with the key of its end.
fn intervals(motion: &Motion) -> Vec<(&'static str, f64, f64)> {
    match *motion {
        Motion::Translating { start, stop, .. } | Motion::Vibrating { start, stop, .. } => {
            stop.map(|stop| ("stop", start, stop)).into_iter().collect()
        }
        Motion::Rotating { start, stop, reverse, .. } => {
            let turns = reverse.filter(|reverse| stop.is_none_or(|stop| *reverse < stop));
            let first = turns.or(stop).map(|end| (if turns.is_some() { "reverse" } else { "stop" }, start, end));
            let second = turns.zip(stop).map(|(reverse, stop)| ("stop", reverse, stop));
            first.into_iter().chain(second).collect()
        }
        Motion::Table { ref content, start, .. } => {
            let rows = content.rows().windows(2);
            rows.map(|rows| ("file", start + rows[0][0], start + rows[1][0])).collect()
        }
        _ => Vec::new(),
    }
}

/// Temporary change of gravity. The samples at the steps have the mean of the pulse if its duration is at least two
/// steps, because the sum is exact for linear interpolation.
struct Pulse {
    /// Index of the change at the peak.
    index: usize,
    start: f64,
    lasts: f64,
}

fn pulses(scene: &Scene) -> Vec<Pulse> {
    let bound = PULSE * scene.largest_gravity();
    let start = (0.0, scene.gravity);
    let moments: Vec<(f64, [f64; 3])> = std::iter::once(start)
        .chain(scene.gravity_changes.iter().map(|change| (change.time, change.gravity)))
        .collect();
    let peaks = moments.windows(3).enumerate().filter(|(_, three)| {
        (0..3).any(|axis| {
            let [before, peak, after] = [0, 1, 2].map(|moment: usize| three[moment].1[axis]);
            peak > before.max(after) + bound || peak < before.min(after) - bound
        })
    });
    peaks.map(|(index, three)| Pulse { index, start: three[0].0, lasts: three[2].0 - three[0].0 }).collect()
}
