//! Dynamic walls: walls that move under a force or a torque, their weight and the contact forces of grains.
//!
//! A dynamic wall has one degree of freedom, along an axis a or about it, with the coordinate s (m or rad) and the rate V = ds/dt. With the
//! Jacobian J = dx/ds of a point x of the wall, the impulses P of grains on the wall, and their angular impulses L,
//!
//! ```text
//! along the axis   J = a             M (V' - V) = h (F + M g.a) + sum P.J
//! about the axis   J = a x (x - c)   I (V' - V) = h T           + sum P.J + sum L.a
//! ```
//!
//! F is a force (N) on a mass M (kg), T a torque (N m) on a moment of inertia I (kg m2) about the axis through the centre of
//! mass: gravity exerts no torque. The position follows from `s' = s + h V'`, as for grains (semi-implicit Euler).
//!
//! A largest speed bounds V'. The impulse of this bound acts against V' and does no positive work. Such a wall is a press: it approaches at its
//! largest speed and holds its force.
//!
//! A dynamic wall is one body with up to thousands of contacts, so its contacts cannot share a lane group, and all their impulses are coupled through
//! V. They are relaxed one after another at the end of every sweep, each with the updated rate of the previous one: Gauss-Seidel as for grains. The
//! operator of a contact with unit normal n includes a term of the wall,
//!
//! ```text
//! S_n = 1/m + (J.n)^2 / M      S_t = 3.5/m + |J - (J.n) n|^2 / M
//! ```
//!
//! The second is a bound of a matrix of two rows, and the relaxation converges. Convergence is slow for a wall that is
//! lighter than the grains in contact: a sweep removes about M/(M + m) of a difference between two contacts.

use super::catalogue::{Change, Effect};
use super::vibration::{call_of_wall, stop};
use crate::scene::Motion;
use nalgebra::Vector3;

/// Dynamic walls.
pub static DRIVEN_WALLS: Effect = Effect {
    off: Some(Change { words: "off: fixed", apply: |scene| stop(scene, Motion::is_driven) }),
    ..Effect::of_scene("driven walls", |scene| {
        call_of_wall(scene, |name, motion| match motion {
            Motion::ForceDriven { .. } => Some(format!("a force drives wall '{name}'")),
            Motion::TorqueDriven { .. } => Some(format!("a torque drives wall '{name}'")),
            _ => None,
        })
        .ok_or("no force or torque drives a wall")
    })
};

/// Dynamic wall: its drive and its motion.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Drive {
    /// Index of the wall in the scene.
    pub wall: u32,
    axis: Vector3<f64>,
    /// Point of the axis of a rotating wall.
    pivot: Option<Vector3<f64>>,
    /// Force, N, or torque, N m.
    effort: f64,
    /// Mass, kg, or moment of inertia, kg m2.
    inertia: f64,
    /// Largest speed, m/s or rad/s.
    largest_speed: f64,
    /// Time of release, s.
    start: f64,
    /// Displacement from the position in the scene, m or rad.
    pub displacement: f64,
    /// Velocity, m/s or rad/s.
    pub rate: f64,
    /// Velocity at the start of the step.
    pub rate_before: f64,
    /// Velocity without the limit of the speed.
    unlimited: f64,
    /// Inverse inertia, 1/kg or 1/(kg m2); zero until the release.
    pub inverse_inertia: f64,
}

impl Drive {
    /// Creates a drive at rest, of a wall with its index in the scene, along a unit axis, or about the axis with a `pivot` (m).
    /// Force (N) or torque (N m) with mass (kg) or moment of inertia about the axis (kg m2), largest speed (m/s or rad/s), and time of
    /// release (s) follow.
    pub(crate) fn new(
        wall: u32,
        axis: Vector3<f64>,
        pivot: Option<Vector3<f64>>,
        [effort, inertia]: [f64; 2],
        largest_speed: Option<f64>,
        start: f64,
    ) -> Drive {
        let largest_speed = largest_speed.unwrap_or(f64::INFINITY);
        Drive { wall, axis, pivot, effort, inertia, largest_speed, start, ..Drive::default() }
    }

    /// Begins a step of length `h` (s) at `time` (s) under the force or torque and gravity (m/s2).
    pub(crate) fn begin(&mut self, time: f64, h: f64, gravity: &Vector3<f64>) {
        let weight = if self.pivot.is_none() { self.inertia * gravity.dot(&self.axis) } else { 0.0 };
        let free = time >= self.start;
        (self.inverse_inertia, self.rate) = if free { (1.0 / self.inertia, self.rate) } else { (0.0, 0.0) };
        self.rate_before = self.rate;
        self.unlimited = self.rate;
        self.push(h * (self.effort + weight));
    }

    /// Moves the wall for a step of length `h` (s).
    pub(crate) fn advance(&mut self, h: f64) {
        self.displacement += h * self.rate;
    }

    /// Returns the Jacobian of a point (m) of the wall, its velocity over the rate: dimensionless, or m.
    pub fn jacobian(&self, point: &Vector3<f64>) -> Vector3<f64> {
        self.pivot.map_or(self.axis, |pivot| self.axis.cross(&(point - pivot)))
    }

    crate::getters! {
        /// Returns the axis of the translation or rotation.
        pub(crate) axis: Vector3<f64> = |drive| drive.axis;
        /// Returns the axis of the rotation; zero for a translation.
        pub(crate) turning: Vector3<f64> = |drive| drive.pivot.map_or_else(Vector3::zeros, |_| drive.axis);
    }

    /// Returns true if another drive has the same axis.
    pub(crate) fn has_axis_of(&self, other: &Drive) -> bool {
        (self.axis, self.pivot) == (other.axis, other.pivot)
    }

    /// Returns the rate and the rate without its limit, which impulses change.
    pub(crate) fn speeds(&self) -> [f64; 2] {
        [self.rate, self.unlimited]
    }

    /// Sets these rates.
    pub(crate) fn set_speeds(&mut self, speeds: [f64; 2]) {
        [self.rate, self.unlimited] = speeds;
    }

    /// Adds an impulse times the Jacobian (N s), or an angular impulse about the axis (N m s).
    #[inline(always)]
    pub(crate) fn push(&mut self, impulse: f64) {
        self.unlimited += self.inverse_inertia * impulse;
        self.rate = self.unlimited.clamp(-self.largest_speed, self.largest_speed);
    }
}
