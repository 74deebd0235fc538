//! Walls as surfaces that codes have of their own: planes across an axis of coordinates, and cylinders along one.
//!
//! Both are endless there. So a wall is one only where no grain can come to where the scene's wall has ended: a plane has no end, the faces of
//! a box have none for grains that are inside, and a cylinder has none for grains between two lids that close it, nor has such a lid.

use makadam::scene::{Grain, Motion, Shape, Wall};
use makadam_frames::output::mesh::reach;
use makadam_frames::plan::Scene;
use nalgebra::Vector3;

/// Slack of directions and places, over one and over the radius of a cylinder.
const SLACK: f64 = 1e-9;

/// A surface without an end.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Primitive {
    /// Across an axis.
    Plane {
        /// The axis, 0 to 2.
        axis: usize,
        /// Place on the axis, m.
        at: f64,
    },
    /// Along an axis, seen from inside.
    Cylinder {
        /// The axis, 0 to 2.
        axis: usize,
        /// A point of the centre line, m.
        centre: [f64; 3],
        /// Radius, m.
        radius: f64,
        /// Angular velocity about the axis's positive direction, rad/s, from the start to the end.
        rate: f64,
    },
}

/// The primitives that each wall of a scene is; empty where it is none.
pub(super) fn primitives(scene: &Scene, grains: &[Grain]) -> Vec<Vec<Primitive>> {
    let closed = scene.wall.iter().filter_map(|wall| Tube::of(wall, scene, grains)).collect::<Vec<_>>();
    scene.wall.iter().map(|wall| of_wall(wall, &closed, scene, grains)).collect()
}

fn of_wall(wall: &Wall, closed: &[Tube], scene: &Scene, grains: &[Grain]) -> Vec<Primitive> {
    let fixed = wall.motion == Motion::Fixed;
    match &wall.shape {
        Shape::Plane { point, normal } if fixed => {
            let Some((axis, sign)) = along(normal) else { return Vec::new() };
            let at = point[axis];
            let inside = grains.iter().all(|grain| sign * (grain.position[axis] - at) > 0.0);
            if inside { vec![Primitive::Plane { axis, at }] } else { Vec::new() }
        }
        Shape::Box { min, max, open } if fixed => {
            let faces = (0..3).flat_map(|axis| [(axis, '-', 1.0, min[axis]), (axis, '+', -1.0, max[axis])]);
            let is_open =
                |axis: usize, end: char| open.iter().any(|face| *face == format!("{end}{}", ["x", "y", "z"][axis]));
            let faces: Vec<_> = faces.filter(|(axis, end, ..)| !is_open(*axis, *end)).collect();
            let is_inside =
                |grain: &Grain| faces.iter().all(|&(axis, _, sign, at)| sign * (grain.position[axis] - at) > 0.0);
            match grains.iter().all(is_inside) {
                true => faces.iter().map(|&(axis, _, _, at)| Primitive::Plane { axis, at }).collect(),
                false => Vec::new(),
            }
        }
        Shape::Cylinder { .. } => Tube::of(wall, scene, grains).map(Tube::primitive).into_iter().collect(),
        Shape::Disc { centre, normal, .. } if fixed => match along(normal) {
            Some((axis, sign)) if closed.iter().any(|tube| tube.has_lid(&wall.shape)) => {
                let at = centre[axis];
                let inside = grains.iter().all(|grain| sign * (grain.position[axis] - at) > 0.0);
                if inside { vec![Primitive::Plane { axis, at }] } else { Vec::new() }
            }
            _ => Vec::new(),
        },
        Shape::Plane { .. } | Shape::Box { .. } | Shape::Disc { .. } | Shape::Spheres { .. } => Vec::new(),
    }
}

/// The axis of coordinates along which a direction lies, and its sign.
fn along(direction: &[f64; 3]) -> Option<(usize, f64)> {
    let unit = Vector3::from(*direction).try_normalize(0.0)?;
    let axis = unit.iamax();
    let across = (0..3).filter(|&other| other != axis).all(|other| unit[other].abs() < SLACK);
    across.then(|| (axis, unit[axis].signum()))
}

/// A cylinder along an axis of coordinates, closed at both ends, that holds all grains.
struct Tube {
    axis: usize,
    centre: [f64; 3],
    radius: f64,
    /// Places of its ends on the axis.
    ends: [f64; 2],
    rate: f64,
}

impl Tube {
    /// Converts a wall, if it is such a cylinder.
    fn of(wall: &Wall, scene: &Scene, grains: &[Grain]) -> Option<Tube> {
        let Shape::Cylinder { base, axis: direction, radius, length } = &wall.shape else { return None };
        let (axis, sign) = along(direction)?;
        let (one, other) = (base[axis], base[axis] + sign * length);
        let rate = Tube::rate(&wall.motion, axis, base, scene.duration)?;
        let tube = Tube { axis, centre: *base, radius: *radius, ends: [one.min(other), one.max(other)], rate };
        let limits = reach(&scene.domain);
        let beyond = [tube.ends[0] <= limits.min[axis], tube.ends[1] >= limits.max[axis]];
        let is_closed = |end: usize| beyond[end] || scene.wall.iter().any(|wall| tube.is_closed_by(wall, end));
        (grains.iter().all(|grain| tube.holds(grain.position)) && is_closed(0) && is_closed(1)).then_some(tube)
    }

    /// Angular velocity of a cylinder that stays where it is and turns all the time or not at all.
    fn rate(motion: &Motion, axis: usize, base: &[f64; 3], duration: f64) -> Option<f64> {
        match motion {
            Motion::Fixed => Some(0.0),
            Motion::Rotating { point, axis: direction, rate, start, stop, reverse } => {
                let (about, sign) = along(direction)?;
                let own = about == axis && (0..3).all(|at| at == axis || (point[at] - base[at]).abs() < SLACK);
                let lasts = |until: &Option<f64>| until.is_none_or(|until| until >= duration);
                (own && *start <= 0.0 && lasts(stop) && lasts(reverse)).then_some(sign * rate)
            }
            _ => None,
        }
    }

    fn holds(&self, position: [f64; 3]) -> bool {
        let across = |at: usize| if at == self.axis { 0.0 } else { position[at] - self.centre[at] };
        let along = position[self.axis];
        (0..3).map(|at| across(at).powi(2)).sum::<f64>() < self.radius * self.radius
            && self.ends[0] < along
            && along < self.ends[1]
    }

    fn is_central(&self, point: &[f64; 3]) -> bool {
        (0..3).all(|at| at == self.axis || (point[at] - self.centre[at]).abs() <= SLACK * self.radius)
    }

    /// Returns true if a disc lies across it from side to side, at one of its ends or between them.
    fn has_lid(&self, shape: &Shape) -> bool {
        let Shape::Disc { centre, normal, radius, hole } = shape else { return false };
        let slack = SLACK * self.radius;
        let centred = self.is_central(centre);
        let within = self.ends[0] - slack <= centre[self.axis] && centre[self.axis] <= self.ends[1] + slack;
        along(normal).is_some_and(|(axis, _)| axis == self.axis)
            && *hole == 0.0
            && centred
            && within
            && *radius >= self.radius - slack
    }

    /// Returns true if a wall that does not leave its place closes an end, 0 the lower one.
    fn is_closed_by(&self, wall: &Wall, end: usize) -> bool {
        let inwards = [1.0, -1.0][end];
        let faces = |normal: &[f64; 3]| along(normal) == Some((self.axis, inwards));
        // Between the end and the middle, so that the cylinder goes at least as far as the lid.
        let before = |at: f64| inwards * (at - self.ends[end]) >= -SLACK * self.radius;
        match (&wall.shape, &wall.motion) {
            (Shape::Disc { normal, .. }, Motion::Fixed) => faces(normal) && self.has_lid(&wall.shape),
            (Shape::Disc { normal, .. }, Motion::Rotating { point, axis, .. }) => {
                let about_own = along(axis).is_some_and(|(about, _)| about == self.axis) && self.is_central(point);
                faces(normal) && self.has_lid(&wall.shape) && about_own
            }
            (Shape::Plane { point, normal }, Motion::Fixed) => faces(normal) && before(point[self.axis]),
            _ => false,
        }
    }

    fn primitive(self) -> Primitive {
        Primitive::Cylinder { axis: self.axis, centre: self.centre, radius: self.radius, rate: self.rate }
    }
}
