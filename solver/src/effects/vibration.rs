//! Vibration: a wall that moves as a sine about the place that its scene gives it.
//!
//! ```text
//! x(t) = A sin(2 pi f s)          s = t - start, from 0 up to stop - start
//! ```
//!
//! with the amplitude vector A (m) and the frequency f (Hz); the largest acceleration is `A (2 pi f)^2`.
//!
//! A step moves grains by the velocity that it ends with, so a wall counts in it with the mean velocity `(x(t+h) - x(t))/h`: a
//! grain that stays in touch is exactly where the wall is at the next step, and bears `m (g + a)` with `a` the second
//! difference of x over `h^2`. The speed of approach at the start of the step, by which impacts are told from rest, is against
//! the mean velocity of the step before, as that of a grain is: a wall that speeds up does not hit what rests on it. A start
//! or a stop is a jump, as of any other motion.

use super::catalogue::{Call, Change, Effect};
use crate::scene::{DocumentPath, Motion, Scene};

/// Prescribed motion of walls, of which vibration is one kind.
pub static WALL_MOTION: Effect = Effect {
    off: Some(Change { words: "off", apply: |scene| stop(scene, |motion| !motion.is_driven()) }),
    ..Effect::of_scene("wall motion", |scene| {
        call_of_wall(scene, |name, motion| match motion {
            Motion::Fixed | Motion::ForceDriven { .. } | Motion::TorqueDriven { .. } => None,
            Motion::Translating { .. } => Some(format!("wall '{name}' translates")),
            Motion::Rotating { .. } => Some(format!("wall '{name}' rotates")),
            Motion::Vibrating { .. } => Some(format!("wall '{name}' vibrates")),
        })
        .ok_or("no wall moves as prescribed")
    })
};

/// The call of the first wall whose name and motion have words for it.
pub(super) fn call_of_wall(scene: &Scene, words: fn(&str, &Motion) -> Option<String>) -> Option<Call> {
    scene.wall.iter().enumerate().find_map(|(index, wall)| {
        let why = words(&wall.name, &wall.motion)?;
        Some(Call { why, place: DocumentPath::default().key("wall").index(index).key("motion") })
    })
}

/// Stops the walls that move so.
pub(super) fn stop(scene: &mut Scene, which: fn(&Motion) -> bool) {
    let walls = scene.wall.iter_mut().filter(|wall| which(&wall.motion));
    walls.for_each(|wall| wall.motion = Motion::Fixed);
}

/// A vibration.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Vibration {
    /// Largest displacement A, m.
    pub amplitude: [f64; 3],
    /// Frequency f, Hz.
    pub frequency: f64,
    /// Time at which it begins, s.
    pub start: f64,
    /// Time at which it ends, s; the wall stays where it is then.
    pub stop: Option<f64>,
}

impl Vibration {
    /// Displacement at a time (s), m.
    pub fn displacement(&self, time: f64) -> [f64; 3] {
        let elapsed = (self.stop.map_or(time, |stop| time.min(stop)) - self.start).max(0.0);
        let sine = libm::sin(std::f64::consts::TAU * self.frequency * elapsed);
        self.amplitude.map(|component| component * sine)
    }

    /// Velocity at a time (s), m/s.
    pub fn velocity(&self, time: f64) -> [f64; 3] {
        let moves = time >= self.start && self.stop.is_none_or(|stop| time < stop);
        let rate = std::f64::consts::TAU * self.frequency;
        let speed = if moves { rate * libm::cos(rate * (time - self.start)) } else { 0.0 };
        self.amplitude.map(|component| component * speed)
    }

    /// Mean velocity between two times (s), m/s.
    pub fn mean_velocity(&self, from: f64, to: f64) -> [f64; 3] {
        let (first, last) = (self.displacement(from), self.displacement(to));
        std::array::from_fn(|axis| (last[axis] - first[axis]) / (to - from))
    }

    /// Returns true if it goes on without a start or a stop between two times (s).
    pub fn is_smooth(&self, from: f64, to: f64) -> bool {
        from >= self.start && self.stop.is_none_or(|stop| to <= stop)
    }
}

impl Motion {
    /// The vibration, if it is one.
    #[inline(always)]
    pub fn vibration(&self) -> Option<Vibration> {
        match *self {
            Motion::Vibrating { amplitude, frequency, start, stop } => {
                Some(Vibration { amplitude, frequency, start, stop })
            }
            _ => None,
        }
    }
}
