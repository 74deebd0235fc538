//! A rotating drum: its axis, its size, and coordinates in its cross-section.

use crate::plan::Scene;
use makadam::scene::{Motion, Shape};
use nalgebra::Vector3;

/// A cylinder that turns about its own axis, which is level or nearly so.
#[derive(Clone, Debug, PartialEq)]
pub struct Drum {
    /// Centre of the drum, m.
    pub centre: Vector3<f64>,
    /// Unit vector along the axis.
    pub axis: Vector3<f64>,
    /// Unit vector across the axis, towards the side to which the turning shell carries the grains up.
    pub across: Vector3<f64>,
    /// Unit vector across the axis, against gravity.
    pub up: Vector3<f64>,
    /// Inner radius, m.
    pub radius: f64,
    /// Length, m.
    pub length: f64,
    /// Angular velocity about `axis`, rad/s.
    pub rate: f64,
    /// The walls that turn with it, the shell among them, by their place in the scene.
    pub walls: Vec<u32>,
}

impl Drum {
    /// Finds the drum of a scene: the first rotating cylinder whose axis is at least 45 degrees from gravity (m/s2).
    pub fn find(scene: &Scene, gravity: Vector3<f64>) -> Option<Drum> {
        let gravity = gravity.try_normalize(1e-12)?;
        scene.wall.iter().find_map(|wall| {
            let (Shape::Cylinder { base, axis, radius, length }, Motion::Rotating { axis: spin, rate, .. }) =
                (&wall.shape, &wall.motion)
            else {
                return None;
            };
            let axis = Vector3::from(*axis).normalize();
            let rate = rate * Vector3::from(*spin).normalize().dot(&axis).signum();
            let up = -(gravity - axis * gravity.dot(&axis)).try_normalize(std::f64::consts::FRAC_1_SQRT_2)?;
            // The lowest point of the shell moves along axis x (-up) if the rate is positive.
            let across = -axis.cross(&up) * if rate < 0.0 { -1.0 } else { 1.0 };
            Some(Drum {
                centre: Vector3::from(*base) + axis * (0.5 * length),
                axis,
                across,
                up,
                radius: *radius,
                length: *length,
                rate,
                walls: (scene.wall.iter().enumerate())
                    .filter(|(_, wall)| matches!(wall.motion, Motion::Rotating { .. }))
                    .map(|(index, _)| index as u32)
                    .collect(),
            })
        })
    }

    /// Coordinates of a point in the cross-section, m: along [`Self::across`] and along [`Self::up`], from the axis.
    pub fn section(&self, point: &Vector3<f64>) -> [f64; 2] {
        let arm = point - self.centre;
        [arm.dot(&self.across), arm.dot(&self.up)]
    }

    /// Distance of a point from the nearer end of the drum, m; negative beyond it.
    pub fn from_ends(&self, point: &Vector3<f64>) -> f64 {
        0.5 * self.length - (point - self.centre).dot(&self.axis).abs()
    }
}
