//! How far a grain can go straight on until it meets a wall.

use crate::effects::period::Period;
use crate::scene::{Motion, Scene, Shape, Wall};
use nalgebra::Vector3;

type Vector = Vector3<f64>;

/// A grain on its way.
pub(super) struct Ray {
    pub centre: Vector,
    /// Of unit length.
    pub along: Vector,
    pub radius: f64,
}

impl Ray {
    /// Distance to the first wall where it is placed, m; grains that would but graze a rim count as held by it.
    pub fn to_wall(&self, scene: &Scene, period: &Period) -> Option<f64> {
        let meetings = scene.wall.iter().filter_map(|wall| self.to_shape(&wall.shape, period));
        meetings.min_by(f64::total_cmp)
    }

    /// Distance to where the centre leaves the domain, m; infinite along periodic axes.
    pub fn to_end(&self, scene: &Scene, period: &Period) -> f64 {
        let ends = (0..3).filter(|&axis| !period.is_periodic(axis) && self.along[axis] != 0.0).map(|axis| {
            let end = if self.along[axis] > 0.0 { scene.domain.max } else { scene.domain.min };
            (end[axis] - self.centre[axis]) / self.along[axis]
        });
        ends.fold(f64::INFINITY, f64::min)
    }

    fn to_shape(&self, shape: &Shape, period: &Period) -> Option<f64> {
        match shape {
            Shape::Plane { point, normal } => self.to_plane(&Vector::from(*point), &Vector::from(*normal).normalize()),
            Shape::Box { min, max, open } => {
                let faces = (0..3).flat_map(|axis| {
                    let name = ["x", "y", "z"][axis];
                    let face = move |sign: &str, corner: &[f64; 3], inward: f64| {
                        let closed = !open.contains(&format!("{sign}{name}"));
                        closed.then(|| (Vector::from(*corner), Vector::ith(axis, inward)))
                    };
                    [face("-", min, 1.0), face("+", max, -1.0)].into_iter().flatten()
                });
                faces.filter_map(|(point, normal)| self.to_plane(&point, &normal)).min_by(f64::total_cmp)
            }
            Shape::Disc { centre, normal, radius, hole } => {
                let (centre, mut normal) = (Vector::from(*centre), Vector::from(*normal).normalize());
                if normal.dot(&self.along) > 0.0 {
                    normal = -normal;
                }
                if normal.dot(&(self.centre - centre)) < 0.0 {
                    return None;
                }
                let distance = self.to_plane(&centre, &normal)?;
                let across = self.centre + self.along * distance - centre;
                let from_axis = (across - normal * across.dot(&normal)).norm();
                (from_axis <= radius + self.radius && from_axis >= hole - self.radius).then_some(distance)
            }
            Shape::Cylinder { base, axis, radius, length } => {
                let unit = Vector::from(*axis).normalize();
                let endless = (0..3).any(|along| period.is_periodic(along) && axis[along] != 0.0);
                self.to_shell(&Vector::from(*base), &unit, *radius, if endless { f64::INFINITY } else { *length })
            }
            Shape::Spheres { centres, radius } => {
                let meetings = centres.iter().filter_map(|centre| {
                    let arm = -period.arm(&self.centre, &Vector::from(*centre));
                    first_root(1.0, arm.dot(&self.along), arm.norm_squared() - (radius + self.radius).powi(2), 0)
                });
                meetings.min_by(f64::total_cmp)
            }
        }
    }

    fn to_plane(&self, point: &Vector, normal: &Vector) -> Option<f64> {
        let closing = -normal.dot(&self.along);
        (closing > 1e-12).then(|| ((normal.dot(&(self.centre - point)) - self.radius) / closing).max(0.0))
    }

    /// To a shell of a length, from inside or outside.
    fn to_shell(&self, base: &Vector, axis: &Vector, radius: f64, length: f64) -> Option<f64> {
        let arm = self.centre - base;
        let (arm_along, ray_along) = (arm.dot(axis), self.along.dot(axis));
        let (arm_across, ray_across) = (arm - axis * arm_along, self.along - axis * ray_along);
        let closing = ray_across.norm_squared();
        if closing < 1e-18 {
            return None;
        }
        let middle = arm_across.dot(&ray_across);
        // Out through the shell from inside, or in through it from outside.
        let inside = arm_across.norm() < radius;
        let reach = if inside { (radius - self.radius).max(0.0) } else { radius + self.radius };
        let meets = |reach: f64, number: usize| {
            let distance = first_root(closing, middle, arm_across.norm_squared() - reach * reach, number)?;
            let at = arm_along + distance * ray_along;
            let held = length.is_infinite() || (at >= -self.radius && at <= length + self.radius);
            held.then_some(distance)
        };
        match inside {
            true => meets(reach, 1),
            // Past an end, it may come to the shell from inside.
            false => meets(reach, 0).or_else(|| meets((radius - self.radius).max(0.0), 1)),
        }
    }
}

/// A root of `a t^2 + 2 b t + c`, the smaller (0) or the larger one (1), if it lies ahead; a start in between counts as there.
fn first_root(a: f64, b: f64, c: f64, number: usize) -> Option<f64> {
    let discriminant = b * b - a * c;
    if discriminant < 0.0 {
        return None;
    }
    let root = discriminant.sqrt();
    let [first, last] = [(-b - root) / a, (-b + root) / a];
    (last >= 0.0).then_some(if number == 0 { first.max(0.0) } else { last })
}

/// Whether a wall is where it is placed all the time, but for a vibration.
pub(super) fn stays(wall: &Wall) -> bool {
    match (&wall.motion, &wall.shape) {
        (Motion::Fixed | Motion::Vibrating { .. }, _) => true,
        (Motion::Translating { .. } | Motion::ForceDriven { .. }, _) => false,
        (Motion::Rotating { point, axis, .. } | Motion::TorqueDriven { point, axis, .. }, shape) => {
            let (place, own) = match shape {
                Shape::Plane { point, normal } => (point, normal),
                Shape::Cylinder { base, axis, .. } => (base, axis),
                Shape::Disc { centre, normal, .. } => (centre, normal),
                Shape::Box { .. } | Shape::Spheres { .. } => return false,
            };
            let axis = Vector::from(*axis).normalize();
            let off = (Vector::from(*place) - Vector::from(*point)).cross(&axis).norm();
            let parallel = Vector::from(*own).normalize().cross(&axis).norm() < 1e-9;
            parallel && (off < 1e-9 || matches!(shape, Shape::Plane { .. }))
        }
    }
}
