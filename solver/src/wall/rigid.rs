//! Rigid transforms: rotation and translation of a wall from its position in the scene.

use super::Vector;
use crate::surface::Rotation;
use nalgebra::{Quaternion, UnitQuaternion};
use serde::{Deserialize, Serialize};

/// Rigid transform `x = R X + t`, with the rotation R as a unit quaternion.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub(crate) struct Rigid {
    turn: UnitQuaternion<f64>,
    shift: Vector,
}

impl Rigid {
    /// Returns a translation, m.
    pub fn by(shift: Vector) -> Rigid {
        Rigid { turn: UnitQuaternion::identity(), shift }
    }

    /// Returns a rotation by a rotation vector (rad) about an axis through `centre` (m); sine and cosine are from a portable library.
    pub fn about(centre: Vector, vector: Vector) -> Rigid {
        let angle = vector.norm();
        if angle == 0.0 {
            return Rigid::default();
        }
        let (sine, cosine) = libm::sincos(0.5 * angle);
        let turn = UnitQuaternion::new_unchecked(Quaternion::from_parts(cosine, vector * (sine / angle)));
        Rigid { turn, shift: centre - turn * centre }
    }

    /// Returns this transform, followed by another one.
    pub fn then(&self, next: &Rigid) -> Rigid {
        Rigid { turn: next.turn * self.turn, shift: next.place(&self.shift) }
    }

    /// Transforms a point, m.
    pub fn place(&self, point: &Vector) -> Vector {
        self.turn * point + self.shift
    }

    /// Returns the displacement of a point (m), without the rounding of its new position.
    pub fn displacement(&self, point: &Vector) -> Vector {
        (self.turn * point - point) + self.shift
    }

    /// Returns the inverse transform.
    pub fn inverse(&self) -> Rigid {
        let turn = self.turn.inverse();
        Rigid { turn, shift: -(turn * self.shift) }
    }

    /// Rotates a vector.
    pub fn turn(&self, vector: &Vector) -> Vector {
        self.turn * vector
    }

    /// Returns the rotation vector (rad), of at most half a turn.
    pub fn vector(&self) -> Vector {
        self.rotation().map_or(Vector::zeros(), |rotation| rotation.vector())
    }

    /// Returns the displacement of the origin, m.
    pub fn shift(&self) -> Vector {
        self.shift
    }

    /// Returns the rotation; `None` for a translation.
    pub fn rotation(&self) -> Option<Rotation> {
        // Of at most half a turn.
        let sign = if self.turn.w < 0.0 { -1.0 } else { 1.0 };
        let (along, axis) = (sign * self.turn.w, self.turn.imag() * sign);
        let sine = axis.norm();
        (sine > 0.0).then(|| Rotation::of(axis / sine, [2.0 * sine * along, along * along - sine * sine]))
    }

    /// Returns true if the values are valid for a run.
    pub fn is_sound(&self) -> bool {
        (self.turn.norm() - 1.0).abs() < 1e-6 && self.shift.iter().all(|component| component.abs() < 1e9)
    }
}
