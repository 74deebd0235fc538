//! Rotating drum: its axis, its size, its rotation, and coordinates in its cross-section.

use super::walls::PlacedWalls;
use makadam::scene::{Motion, Shape, Wall};
use makadam::snapshot::Snapshot;
use makadam_frames::plan::MeasuredScene;
use nalgebra::Vector3;

/// Sine of an angle, and fraction of a drum's radius, within which two axes coincide: a file has few digits.
const SAME_AXIS: f64 = 1e-6;

/// Cylinder with rotation about its own axis, which is level or nearly so.
#[derive(Clone, Debug, PartialEq)]
pub struct Drum {
    /// Centre of the drum, m.
    pub centre: Vector3<f64>,
    /// Unit vector along the axis.
    pub axis: Vector3<f64>,
    /// Unit vector across the axis, towards the side at which the rotating shell lifts the grains.
    pub across: Vector3<f64>,
    /// Unit vector across the axis, against gravity.
    pub up: Vector3<f64>,
    /// Inner radius, m.
    pub radius: f64,
    /// Length, m.
    pub length: f64,
    /// Angular velocity about `axis`, rad/s; zero without rotation.
    pub rate: f64,
    /// Walls that rotate with the drum, including the shell, by their index in the scene; empty without rotation.
    pub walls: Vec<u32>,
    shell: usize,
}

impl Drum {
    /// Finds the drum of a scene: the first cylinder with a rotation about its own axis, at an angle of at least 45 degrees to
    /// gravity (m/s2). Its state is that before the motion begins.
    pub fn find(scene: &MeasuredScene, gravity: Vector3<f64>) -> Option<Drum> {
        let gravity = gravity.try_normalize(1e-12)?;
        scene.wall.iter().enumerate().find_map(|(shell, wall)| {
            let Shape::Cylinder { base, axis, radius, length } = &wall.shape else { return None };
            let axis = Vector3::from(*axis).normalize();
            let centre = Vector3::from(*base) + axis * (0.5 * length);
            let up = -(gravity - axis * gravity.dot(&axis)).try_normalize(std::f64::consts::FRAC_1_SQRT_2)?;
            let (across, rate, walls) = (-axis.cross(&up), 0.0, Vec::new());
            let drum = Drum { centre, axis, across, up, radius: *radius, length: *length, rate, walls, shell };
            drum.is_pivot_of(wall).then_some(drum)
        })
    }

    /// Returns the drum with its rotation at the time of a frame.
    pub fn at(mut self, scene: &MeasuredScene, frame: &Snapshot) -> Drum {
        let walls = PlacedWalls::at(scene, frame);
        let spin = walls.spin_of(self.shell);
        self.rate = spin.dot(&self.axis);
        // The lowest point of the shell moves along axis x (-up) if the rate is positive.
        self.across = -self.axis.cross(&self.up) * if self.rate < 0.0 { -1.0 } else { 1.0 };
        let turns_with_it = |(number, wall): (usize, &Wall)| {
            let is_as_fast = (walls.spin_of(number) - spin).norm() <= SAME_AXIS * spin.norm();
            (self.rate != 0.0 && is_as_fast && self.is_pivot_of(wall)).then_some(number as u32)
        };
        self.walls = scene.wall.iter().enumerate().filter_map(turns_with_it).collect();
        self
    }

    /// Returns true if a wall rotates about the drum's axis.
    fn is_pivot_of(&self, wall: &Wall) -> bool {
        let (Motion::Rotating { point, axis, .. } | Motion::TorqueDriven { point, axis, .. }) = &wall.motion else {
            return false;
        };
        let beside = (Vector3::from(*point) - self.centre).cross(&self.axis).norm();
        let aslant = Vector3::from(*axis).normalize().cross(&self.axis).norm();
        beside <= SAME_AXIS * self.radius && aslant <= SAME_AXIS
    }

    /// Returns the sense of rotation about the axis: 1, -1, or 0 without rotation.
    pub fn sense(&self) -> f64 {
        if self.rate == 0.0 { 0.0 } else { self.rate.signum() }
    }

    /// Returns the coordinates of a point in the cross-section, m: along [`Self::across`] and along [`Self::up`], from the axis.
    pub fn section(&self, point: &Vector3<f64>) -> [f64; 2] {
        let arm = point - self.centre;
        [arm.dot(&self.across), arm.dot(&self.up)]
    }

    /// Returns the distance of a point from the nearer end of the drum, m; negative beyond it.
    pub fn distance_to_ends(&self, point: &Vector3<f64>) -> f64 {
        0.5 * self.length - (point - self.centre).dot(&self.axis).abs()
    }
}
