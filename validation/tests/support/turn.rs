//! Scenes and frames turned by right angles and shifted.

use makadam::scene::{Axis, Motion, Shape};
use makadam::snapshot::Snapshot;
use makadam_frames::plan::MeasuredScene;
use nalgebra::{Matrix3, Vector3};

/// A rotation by right angles, and a shift after it (m).
#[derive(Clone, Debug)]
pub struct Turn {
    rotation: Matrix3<f64>,
    shift: Vector3<f64>,
}

impl Turn {
    /// One of the 24 rotations of a cube.
    pub fn drawn(number: usize, shift: Vector3<f64>) -> Turn {
        let axes = [[0, 1, 2], [1, 2, 0], [2, 0, 1], [0, 2, 1], [2, 1, 0], [1, 0, 2]];
        let order = axes[number % 6];
        let signs = [(number / 6) & 1, (number / 12) & 1].map(|bit| if bit == 0 { 1.0 } else { -1.0 });
        let columns = |last: f64| {
            let signs = [signs[0], signs[1], last];
            Matrix3::from_columns(&[0, 1, 2].map(|n| signs[n] * Vector3::ith(order[n], 1.0)))
        };
        let rotation = if columns(1.0).determinant() > 0.0 { columns(1.0) } else { columns(-1.0) };
        Turn { rotation, shift }
    }

    fn point(&self, point: &mut [f64; 3]) {
        *point = (self.rotation * Vector3::from(*point) + self.shift).into();
    }

    fn vector(&self, vector: &mut [f64; 3]) {
        *vector = (self.rotation * Vector3::from(*vector)).into();
    }

    fn corners(&self, min: &mut [f64; 3], max: &mut [f64; 3]) {
        self.point(min);
        self.point(max);
        for axis in 0..3 {
            (min[axis], max[axis]) = (min[axis].min(max[axis]), min[axis].max(max[axis]));
        }
    }

    /// Number of the axis that an axis becomes, and whether it is turned round.
    fn axis(&self, axis: usize) -> (usize, bool) {
        let turned = self.rotation * Vector3::ith(axis, 1.0);
        (turned.iamax(), turned[turned.iamax()] < 0.0)
    }

    fn face(&self, face: &mut String) {
        let axis = ["x", "y", "z"].iter().position(|name| face.ends_with(name)).unwrap();
        let (axis, round) = self.axis(axis);
        let sign = if face.starts_with('-') != round { "-" } else { "+" };
        *face = format!("{sign}{}", ["x", "y", "z"][axis]);
    }
}

/// A scene of planes, boxes, cylinders and discs, and frames of it, turned and shifted.
pub fn turned(turn: &Turn, scene: &MeasuredScene, frames: &[Snapshot]) -> (MeasuredScene, Vec<Snapshot>) {
    let (mut scene, mut frames) = (scene.clone(), frames.to_vec());
    turn.vector(&mut scene.gravity);
    scene.gravity_changes.iter_mut().for_each(|change| turn.vector(&mut change.gravity));
    let domain = &mut scene.domain;
    turn.corners(&mut domain.min, &mut domain.max);
    for axis in &mut domain.periodic {
        *axis = [Axis::X, Axis::Y, Axis::Z][turn.axis(axis.number()).0];
    }
    for wall in &mut scene.wall {
        match &mut wall.shape {
            Shape::Plane { point, normal } => {
                turn.point(point);
                turn.vector(normal);
            }
            Shape::Box { min, max, open, .. } => {
                turn.corners(min, max);
                open.iter_mut().for_each(|face| turn.face(face));
            }
            Shape::Cylinder { base, axis, .. } => {
                turn.point(base);
                turn.vector(axis);
            }
            Shape::Disc { centre, normal, .. } => {
                turn.point(centre);
                turn.vector(normal);
            }
            Shape::Spheres { centres, .. } => centres.iter_mut().for_each(|centre| turn.point(centre)),
            other => unreachable!("the turned scenes have no {}", other.kind()),
        }
        match &mut wall.motion {
            Motion::Fixed => {}
            Motion::Rotating { point, axis, .. } => {
                turn.point(point);
                turn.vector(axis);
            }
            Motion::ForceDriven { axis, .. } => turn.vector(axis),
            other => panic!("{other:?} is turned by no test"),
        }
    }
    for frame in &mut frames {
        for grain in &mut frame.particles {
            turn.point(&mut grain.position);
            turn.vector(&mut grain.velocity);
            turn.vector(&mut grain.spin);
        }
        for contact in &mut frame.contacts {
            turn.point(&mut contact.point);
            turn.vector(&mut contact.normal);
            turn.vector(&mut contact.tangential_force);
        }
    }
    (scene, frames)
}
