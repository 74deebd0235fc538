//! Distance of a point from the walls, wherever their motion has brought them.

use crate::plan::Scene;
use makadam::effects::period::Period;
use makadam::scene::{Domain, Motion, Shape, Wall};
use makadam::snapshot::Snapshot;
use nalgebra::{Rotation3, Unit, Vector3};

/// The walls of a scene at one time, as flat and round primitives.
pub struct PlacedWalls(Vec<Placed>);

/// A primitive and the motion that takes a point of the world back to where the scene placed the wall.
struct Placed {
    primitive: Primitive,
    shift: Vector3<f64>,
    turn: Option<(Vector3<f64>, Rotation3<f64>)>,
}

enum Primitive {
    Plane { point: Vector3<f64>, normal: Vector3<f64> },
    Shell { base: Vector3<f64>, axis: Vector3<f64>, radius: f64, length: f64 },
    Disc { centre: Vector3<f64>, normal: Vector3<f64>, radius: f64, hole: f64 },
    Ball { centre: Vector3<f64>, radius: f64, period: Period },
}

impl PlacedWalls {
    /// The walls of a scene at the time of a frame.
    ///
    /// The ends of a periodic axis count as walls: a frame does not have the neighbours that grains there have beyond.
    pub fn at(scene: &Scene, frame: &Snapshot) -> Self {
        let displacement = |index: u32| {
            let driven = frame.driven_walls.iter().find(|driven| driven.wall == index);
            driven.map_or(0.0, |driven| driven.displacement)
        };
        let walls = (0..).zip(&scene.wall);
        let walls =
            walls.flat_map(|(index, wall)| place(wall, &scene.domain.period(), frame.time, displacement(index)));
        Self(walls.chain(ends(&scene.domain)).collect())
    }

    /// Distance of a point from the nearest wall, m; infinite where there is no wall.
    ///
    /// It is negative behind a plane or a box's face. Thin shells and discs have no behind.
    pub fn distance(&self, point: &Vector3<f64>) -> f64 {
        self.0.iter().map(|wall| wall.distance(point)).fold(f64::INFINITY, f64::min)
    }

    /// Number of walls nearer than `reach` (m) to a point; a box counts once a face.
    pub fn within(&self, point: &Vector3<f64>, reach: f64) -> usize {
        self.0.iter().filter(|wall| wall.distance(point) < reach).count()
    }
}

/// Both ends of every periodic axis.
fn ends(domain: &Domain) -> impl Iterator<Item = Placed> + '_ {
    let faces = domain.periodic.iter().flat_map(|axis| {
        [(domain.min, 1.0), (domain.max, -1.0)]
            .map(|(corner, sign)| Primitive::Plane { point: corner.into(), normal: Vector3::ith(axis.number(), sign) })
    });
    faces.map(|primitive| Placed { primitive, shift: Vector3::zeros(), turn: None })
}

/// A wall at a time (s), `driven` (m or rad) from where the scene placed it if a force or a torque drives it.
fn place(wall: &Wall, period: &Period, time: f64, driven: f64) -> Vec<Placed> {
    let elapsed = |start: f64, stop: Option<f64>| (time.min(stop.unwrap_or(f64::INFINITY)) - start).max(0.0);
    let (mut shift, mut turn) = (Vector3::zeros(), None);
    match &wall.motion {
        Motion::Fixed => {}
        Motion::Translating { velocity, start, stop } => shift = Vector3::from(*velocity) * elapsed(*start, *stop),
        Motion::Rotating { point, axis, rate, start, stop, reverse } => {
            let axis = Unit::new_normalize(Vector3::from(*axis));
            let backwards = reverse.map_or(0.0, |reverse| elapsed(reverse, *stop));
            let back = Rotation3::from_axis_angle(&axis, -rate * (elapsed(*start, *stop) - 2.0 * backwards));
            turn = Some((Vector3::from(*point), back));
        }
        Motion::Vibrating { amplitude, frequency, start, stop } => {
            let phase = std::f64::consts::TAU * frequency * elapsed(*start, *stop);
            shift = Vector3::from(*amplitude) * phase.sin();
        }
        Motion::ForceDriven { axis, .. } => shift = Vector3::from(*axis).normalize() * driven,
        Motion::TorqueDriven { point, axis, .. } => {
            let axis = Unit::new_normalize(Vector3::from(*axis));
            turn = Some((Vector3::from(*point), Rotation3::from_axis_angle(&axis, -driven)));
        }
    }
    primitives(&wall.shape, period).into_iter().map(|primitive| Placed { primitive, shift, turn }).collect()
}

fn primitives(shape: &Shape, period: &Period) -> Vec<Primitive> {
    match shape {
        Shape::Plane { point, normal } => {
            vec![Primitive::Plane { point: (*point).into(), normal: Vector3::from(*normal).normalize() }]
        }
        Shape::Box { min, max, open } => (["x", "y", "z"].iter().enumerate())
            .flat_map(|(axis, name)| [(format!("-{name}"), min, axis, 1.0), (format!("+{name}"), max, axis, -1.0)])
            .filter(|(face, ..)| !open.contains(face))
            .map(|(_, corner, axis, sign)| Primitive::Plane {
                point: (*corner).into(),
                normal: Vector3::ith(axis, sign),
            })
            .collect(),
        Shape::Cylinder { base, axis, radius, length } => vec![Primitive::Shell {
            base: (*base).into(),
            axis: Vector3::from(*axis).normalize(),
            radius: *radius,
            length: *length,
        }],
        Shape::Spheres { centres, radius } => (centres.iter())
            .map(|centre| Primitive::Ball { centre: (*centre).into(), radius: *radius, period: *period })
            .collect(),
        Shape::Disc { centre, normal, radius, hole } => vec![Primitive::Disc {
            centre: (*centre).into(),
            normal: Vector3::from(*normal).normalize(),
            radius: *radius,
            hole: *hole,
        }],
    }
}

impl Placed {
    fn distance(&self, point: &Vector3<f64>) -> f64 {
        let mut point = point - self.shift;
        if let Some((pivot, back)) = &self.turn {
            point = pivot + back * (point - pivot);
        }
        match &self.primitive {
            Primitive::Plane { point: origin, normal } => normal.dot(&(point - origin)),
            Primitive::Shell { base, axis, radius, length } => {
                let arm = point - base;
                let along = arm.dot(axis);
                let past_end = (-along).max(along - length).max(0.0);
                ((arm - axis * along).norm() - radius).hypot(past_end)
            }
            Primitive::Ball { centre, radius, period } => period.arm(centre, &point).norm() - radius,
            Primitive::Disc { centre, normal, radius, hole } => {
                let arm = point - centre;
                let height = arm.dot(normal);
                let across = (arm - normal * height).norm();
                height.hypot(across - across.clamp(*hole, *radius))
            }
        }
    }
}
