//! Gravity that changes in time: straight between given moments, constant after the last.
//!
//! ```text
//! g(t) = g_i + (g_(i+1) - g_i) (t - t_i) / (t_(i+1) - t_i)          t_i <= t <= t_(i+1), with t_0 = 0
//! ```
//!
//! A step takes gravity as it is at the step's start. Whatever compares with `g h` - reach of contacts, fall of a step - goes by
//! that; residuals, which a field that passes through zero would leave without a measure, and the scale of energies go by the
//! largest `|g|` of the run.
//!
//! Potential energy is `-m g(t) x`. So a change of the field gives or takes energy at rest, `-m x` times the change of g, which
//! the ledger enters by itself; x is the place half a step earlier there, as in all its potential energies.

use super::catalogue::{Call, Change, Effect};
use crate::scene::{DocumentPath, GravityChange, Scene};
use nalgebra::Vector3;

/// Gravity.
pub static GRAVITY: Effect = Effect::of_scene("gravity", |scene| {
    let [x, y, z] = scene.gravity;
    match scene.gravity == [0.0; 3] {
        true => Err("gravity = [0, 0, 0]"),
        false => Ok(Call { why: format!("gravity = [{x}, {y}, {z}]"), place: DocumentPath::default().key("gravity") }),
    }
});

/// Gravity that changes in time.
pub static CHANGING_GRAVITY: Effect = Effect {
    off: Some(Change { words: "off", apply: |scene| scene.gravity_changes.clear() }),
    ..Effect::of_scene("changing gravity", |scene| {
        let last = scene.gravity_changes.last().ok_or("gravity is constant")?;
        let [x, y, z] = last.gravity;
        let why = format!("gravity = [{x}, {y}, {z}] from {} s on", last.time);
        Ok(Call { why, place: DocumentPath::default().key("gravity_changes") })
    })
};

/// Gravity over time.
#[derive(Clone, Debug, PartialEq)]
pub struct Field {
    start: Vector3<f64>,
    changes: Vec<GravityChange>,
}

impl Field {
    /// The field of a start at time 0 (m/s2) and of changes in the order of their times, which are above 0.
    pub fn new(start: [f64; 3], changes: &[GravityChange]) -> Field {
        Field { start: start.into(), changes: changes.to_vec() }
    }

    /// Gravity at a time (s), m/s2.
    pub fn at(&self, time: f64) -> Vector3<f64> {
        let (mut since, mut gravity) = (0.0, self.start);
        for change in &self.changes {
            let next = Vector3::from(change.gravity);
            if time < change.time {
                return gravity + (next - gravity) * ((time - since) / (change.time - since)).max(0.0);
            }
            (since, gravity) = (change.time, next);
        }
        gravity
    }

    /// Largest magnitude at any time, m/s2, as [`Scene`] has it.
    pub fn largest(&self) -> f64 {
        self.changes.iter().map(|change| Vector3::from(change.gravity).norm()).fold(self.start.norm(), f64::max)
    }

    /// Returns true if it ever changes.
    #[inline(always)]
    pub fn changes(&self) -> bool {
        !self.changes.is_empty()
    }

    /// Returns true if it is the same from one time (s) to another.
    pub fn is_constant(&self, from: f64, to: f64) -> bool {
        let between = self.changes.iter().filter(|change| change.time > from && change.time < to);
        let mut values = between.map(|change| change.gravity.into()).chain([self.at(to)]);
        let first = self.at(from);
        values.all(|value| value == first)
    }
}

impl Scene {
    /// Gravity over time.
    pub fn gravity_field(&self) -> Field {
        Field::new(self.gravity, &self.gravity_changes)
    }
}
