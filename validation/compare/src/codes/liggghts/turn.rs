//! A scene in turned coordinates: the decks of LIGGGHTS for timing have a drum about y lie along z, since its primitive cylinders turn about
//! x and z alone.

use makadam::scene::{Domain, Grain, Motion, Shape};
use makadam::snapshot::Snapshot;
use makadam_frames::plan::Scene;

/// True if coordinates are turned: z, x, y instead of x, y, z. A rotation, so that spins turn as positions do.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) struct Turn(bool);

impl Turn {
    /// The turn with which most cylinders of a scene that turn are primitives.
    pub fn of(scene: &Scene) -> Turn {
        let about = |wanted: usize| {
            let turning = scene.wall.iter().filter(|wall| matches!(wall.shape, Shape::Cylinder { .. }));
            let axes = turning.filter_map(|wall| match &wall.motion {
                Motion::Rotating { axis, .. } => Some(axis),
                _ => None,
            });
            axes.filter(|axis| (0..3).all(|at| (axis[at] == 0.0) == (at != wanted))).count()
        };
        // About y before it is about z, and about x it would be about y.
        Turn(about(1) > about(0))
    }

    fn forth(self, [x, y, z]: [f64; 3]) -> [f64; 3] {
        if self.0 { [z, x, y] } else { [x, y, z] }
    }

    fn back(self, [x, y, z]: [f64; 3]) -> [f64; 3] {
        if self.0 { [y, z, x] } else { [x, y, z] }
    }

    /// The scene in these coordinates; its populations stay, since its grains are given.
    pub fn scene(self, scene: &Scene) -> Scene {
        let mut turned = scene.clone();
        turned.gravity = self.forth(scene.gravity);
        let Domain { min, max, .. } = &scene.domain;
        (turned.domain.min, turned.domain.max) = (self.forth(*min), self.forth(*max));
        for wall in &mut turned.wall {
            self.shape(&mut wall.shape);
            self.motion(&mut wall.motion);
        }
        turned
    }

    fn shape(self, shape: &mut Shape) {
        let turn = |vector: &mut [f64; 3]| *vector = self.forth(*vector);
        match shape {
            Shape::Plane { point, normal } => [point, normal].into_iter().for_each(turn),
            Shape::Box { min, max, open } => {
                [min, max].into_iter().for_each(turn);
                open.iter_mut().for_each(|face| *face = self.face(face));
            }
            Shape::Cylinder { base, axis, .. } => [base, axis].into_iter().for_each(turn),
            Shape::Disc { centre, normal, .. } => [centre, normal].into_iter().for_each(turn),
            Shape::Spheres { centres, .. } => centres.iter_mut().for_each(turn),
        }
    }

    /// The name of a face: what is along x before is along y after.
    fn face(self, name: &str) -> String {
        let turn = |letter: char| match letter {
            'x' if self.0 => 'y',
            'y' if self.0 => 'z',
            'z' if self.0 => 'x',
            other => other,
        };
        name.chars().map(turn).collect()
    }

    fn motion(self, motion: &mut Motion) {
        let turn = |vector: &mut [f64; 3]| *vector = self.forth(*vector);
        match motion {
            Motion::Fixed => {}
            Motion::Translating { velocity, .. } => turn(velocity),
            Motion::Rotating { point, axis, .. } | Motion::TorqueDriven { point, axis, .. } => {
                [point, axis].into_iter().for_each(turn)
            }
            Motion::Vibrating { amplitude, .. } => turn(amplitude),
            Motion::ForceDriven { axis, .. } => turn(axis),
        }
    }

    /// Grains in these coordinates.
    pub fn grains(self, grains: &[Grain]) -> Vec<Grain> {
        let turn = |grain: &Grain| Grain {
            position: self.forth(grain.position),
            velocity: self.forth(grain.velocity),
            spin: self.forth(grain.spin),
            ..grain.clone()
        };
        grains.iter().map(turn).collect()
    }

    /// Turns a frame back to the scene's own coordinates.
    pub fn frame_back(self, frame: &mut Snapshot) {
        let turn = |vector: &mut [f64; 3]| *vector = self.back(*vector);
        for grain in &mut frame.particles {
            [&mut grain.position, &mut grain.velocity, &mut grain.spin].into_iter().for_each(turn);
        }
        for contact in &mut frame.contacts {
            [&mut contact.point, &mut contact.normal, &mut contact.tangential_force].into_iter().for_each(turn);
        }
    }
}

#[cfg(test)]
#[path = "../../../tests/unit/codes_liggghts_turn.rs"]
mod tests;
