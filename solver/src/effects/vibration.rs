//! Vibration: sinusoidal motion of a wall about its position in the scene.
//!
//! ```text
//! x(t) = A sin(2 pi f s)          s = t - start, from 0 up to stop - start
//! ```
//!
//! with the amplitude vector A (m) and the frequency f (Hz); the largest acceleration is `A (2 pi f)^2`.
//!
//! A step moves grains by their velocity at its end, so the velocity of a wall in a step is the mean
//! `(x(t+h) - x(t))/h`. A grain that stays in contact therefore follows the wall exactly, under the force `m (g + a)`
//! with `a` the second difference of x over `h^2`. The approach speed at the start of the step, which distinguishes
//! impacts from rest, is relative to the wall's mean velocity in the previous step: an accelerating wall does not
//! impact resting grains. A start or a stop is a jump, as for any other motion.

use super::catalogue::{Call, Change, Effect};
use crate::scene::{DocumentPath, Motion, Scene};

/// Prescribed motion of walls, including vibration.
pub static WALL_MOTION: Effect = Effect {
    off: Some(Change { words: "off", apply: |scene| stop(scene, |motion| !motion.is_driven()) }),
    ..Effect::of_scene("wall motion", |scene| {
        call_of_wall(scene, |name, motion| match motion {
            Motion::Fixed | Motion::ForceDriven { .. } | Motion::TorqueDriven { .. } => None,
            Motion::Table { .. } => Some(format!("wall '{name}' moves by a table")),
            Motion::List(parts) => Some(format!("wall '{name}' has {} motions", parts.len())),
            Motion::Translating { .. } => Some(format!("wall '{name}' translates")),
            Motion::Rotating { .. } => Some(format!("wall '{name}' rotates")),
            Motion::Vibrating { .. } => Some(format!("wall '{name}' vibrates")),
        })
        .ok_or("no wall moves as prescribed")
    })
};

/// Returns the call of the first wall for which `words` returns a description.
pub(super) fn call_of_wall(scene: &Scene, words: fn(&str, &Motion) -> Option<String>) -> Option<Call> {
    scene.wall.iter().enumerate().find_map(|(index, wall)| {
        let why = words(&wall.name, &wall.motion)?;
        Some(Call { why, place: DocumentPath::default().key("wall").index(index).key("motion") })
    })
}

/// Stops the walls with such a motion.
pub(super) fn stop(scene: &mut Scene, which: fn(&Motion) -> bool) {
    let walls = scene.wall.iter_mut().filter(|wall| which(&wall.motion));
    walls.for_each(|wall| wall.motion = Motion::Fixed);
}

/// Parameters of a vibration.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Vibration {
    /// Largest displacement A, m.
    pub amplitude: [f64; 3],
    /// Frequency f, Hz.
    pub frequency: f64,
    /// Start time, s.
    pub start: f64,
    /// Stop time, s; the wall then remains at its position.
    pub stop: Option<f64>,
}

impl Vibration {
    /// Returns the displacement (m) at a time (s).
    pub fn displacement(&self, time: f64) -> [f64; 3] {
        let elapsed = (self.stop.map_or(time, |stop| time.min(stop)) - self.start).max(0.0);
        let sine = libm::sin(std::f64::consts::TAU * self.frequency * elapsed);
        self.amplitude.map(|component| component * sine)
    }

    /// Returns the velocity (m/s) at a time (s).
    pub fn velocity(&self, time: f64) -> [f64; 3] {
        let moves = time >= self.start && self.stop.is_none_or(|stop| time < stop);
        let rate = std::f64::consts::TAU * self.frequency;
        let speed = if moves { rate * libm::cos(rate * (time - self.start)) } else { 0.0 };
        self.amplitude.map(|component| component * speed)
    }

    /// Returns the mean velocity (m/s) between two times (s).
    pub fn mean_velocity(&self, from: f64, to: f64) -> [f64; 3] {
        let (first, last) = (self.displacement(from), self.displacement(to));
        std::array::from_fn(|axis| (last[axis] - first[axis]) / (to - from))
    }

    /// Returns true if the vibration neither starts nor stops between two times (s).
    pub fn is_smooth(&self, from: f64, to: f64) -> bool {
        from >= self.start && self.stop.is_none_or(|stop| to <= stop)
    }
}

impl Motion {
    /// Returns the vibration of a vibrating wall.
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
