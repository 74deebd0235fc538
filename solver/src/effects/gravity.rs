//! Time-dependent gravity: linear between given times, constant after the last time.
//!
//! ```text
//! g(t) = g_i + (g_(i+1) - g_i) (t - t_i) / (t_(i+1) - t_i)          t_i <= t <= t_(i+1), with t_0 = 0
//! ```
//!
//! A step uses gravity at its start. Comparisons with `g h` - interaction range of contacts, free fall per step - use
//! this value. Residuals, which have no scale in a field that passes through zero, and the scale of energies use the
//! largest `|g|` of the run.
//!
//! Potential energy is `-m g(t) x`. A change of the field therefore adds or removes energy at rest, `-m x` times the change of g, a
//! separate entry of the energy balance. The position x is that half a step earlier, as in all potential energies of the balance.

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

/// Time-dependent gravity.
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
    /// Creates the field from its value at time 0 (m/s2) and from changes in the order of their times, which are above 0.
    pub fn new(start: [f64; 3], changes: &[GravityChange]) -> Field {
        Field { start: start.into(), changes: changes.to_vec() }
    }

    /// Returns gravity (m/s2) at a time (s).
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

    /// Returns the largest magnitude at any time, m/s2, as for [`Scene`].
    pub fn largest(&self) -> f64 {
        self.changes.iter().map(|change| Vector3::from(change.gravity).norm()).fold(self.start.norm(), f64::max)
    }

    /// Returns true if the field changes at any time.
    #[inline(always)]
    pub fn changes(&self) -> bool {
        !self.changes.is_empty()
    }
}

impl Scene {
    /// Returns gravity over time.
    pub fn gravity_field(&self) -> Field {
        Field::new(self.gravity, &self.gravity_changes)
    }
}
