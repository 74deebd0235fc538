//! Driven walls: walls that move as a force or a torque, their weight and the grains will have it.
//!
//! A driven wall has one freedom, along an axis a or about it, with the coordinate s (m or rad) and the rate V = ds/dt. With the
//! Jacobian J = dx/ds of a point x of the wall, the impulses P that grains exert on it, and their angular impulses L,
//!
//! ```text
//! along the axis   J = a             M (V' - V) = h (F + M g.a) + sum P.J
//! about the axis   J = a x (x - c)   I (V' - V) = h T           + sum P.J + sum L.a
//! ```
//!
//! F is a force (N) on a mass M (kg), T a torque (N m) on a moment of inertia I (kg m2) about the axis, which goes through the
//! centre of mass: gravity exerts no torque. Position follows by `s' = s + h V'`, as that of grains does (semi-implicit Euler).
//!
//! A driven wall is one body that may touch thousands of grains, so its contacts cannot share a lane group, and their impulses
//! depend on each other through V at once. They are relaxed one after another behind every sweep, each with the rate that the last
//! one left: Gauss-Seidel as elsewhere, and the operator of a contact with unit normal n gets the wall's share,
//!
//! ```text
//! S_n = 1/m + (J.n)^2 / M      S_t = 3.5/m + |J - (J.n) n|^2 / M
//! ```
//!
//! the second a bound of a matrix of two rows, which keeps the relaxation convergent. A wall lighter than the grains that it
//! touches makes it slow: of a difference between two contacts a sweep takes about M/(M + m).

use super::catalogue::{Change, Effect};
use super::vibration::{call_of_wall, stop};
use crate::scene::Motion;
use nalgebra::Vector3;

/// Driven walls.
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

/// A driven wall: what drives it, and how it moves.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Drive {
    /// Number of the wall in the scene.
    pub wall: u32,
    axis: Vector3<f64>,
    /// A point of the axis, where it turns.
    pivot: Option<Vector3<f64>>,
    /// Force, N, or torque, N m.
    effort: f64,
    /// Mass, kg, or moment of inertia, kg m2.
    inertia: f64,
    /// Time at which it is let go, s.
    start: f64,
    /// Displacement from the place in the scene, m or rad.
    pub displacement: f64,
    /// Velocity, m/s or rad/s.
    pub rate: f64,
    /// Velocity at the start of the step.
    pub rate_before: f64,
    /// One over the inertia, 1/kg or 1/(kg m2); zero while it is held.
    pub inverse_inertia: f64,
}

impl Drive {
    /// A drive at rest: of a wall, by its number in the scene, along a unit axis, or about it if it goes through a `pivot` (m); its force
    /// (N) or torque (N m), its mass (kg) or moment of inertia about the axis (kg m2), and the time at which it is let go, s.
    pub(crate) fn new(
        wall: u32,
        axis: Vector3<f64>,
        pivot: Option<Vector3<f64>>,
        effort: f64,
        inertia: f64,
        start: f64,
    ) -> Drive {
        let [displacement, rate, rate_before, inverse_inertia] = [0.0; 4];
        Drive { wall, axis, pivot, effort, inertia, start, displacement, rate, rate_before, inverse_inertia }
    }

    /// Begins a step of length `h` (s) at `time` (s): the force or torque acts, and gravity (m/s2).
    pub(crate) fn begin(&mut self, time: f64, h: f64, gravity: &Vector3<f64>) {
        let weight = if self.pivot.is_none() { self.inertia * gravity.dot(&self.axis) } else { 0.0 };
        let free = time >= self.start;
        (self.inverse_inertia, self.rate) = if free { (1.0 / self.inertia, self.rate) } else { (0.0, 0.0) };
        self.rate_before = self.rate;
        self.rate += self.inverse_inertia * (h * (self.effort + weight));
    }

    /// Moves it for a step of length `h` (s).
    pub(crate) fn advance(&mut self, h: f64) {
        self.displacement += h * self.rate;
    }

    /// Jacobian of a point (m) of the wall, its velocity over the rate: no unit, or m.
    pub fn jacobian(&self, point: &Vector3<f64>) -> Vector3<f64> {
        self.pivot.map_or(self.axis, |pivot| self.axis.cross(&(point - pivot)))
    }

    /// The axis along which or about which it moves.
    pub(crate) fn axis(&self) -> Vector3<f64> {
        self.axis
    }

    /// The axis about which it turns; zero if it does not.
    pub(crate) fn turning(&self) -> Vector3<f64> {
        self.pivot.map_or_else(Vector3::zeros, |_| self.axis)
    }

    /// Takes an effort times time: an impulse times the Jacobian, N s, or an angular one about the axis, N m s.
    #[inline(always)]
    pub(crate) fn push(&mut self, impulse: f64) {
        self.rate += self.inverse_inertia * impulse;
    }
}
