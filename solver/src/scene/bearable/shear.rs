//! Walls that move far in a step: they run into a bed, or drag it, before it can give way.

use super::impact::{BED, floor, tolerated};
use super::ray::stays;
use crate::scene::document_path::DocumentPath;
use crate::scene::error::{Fault, short};
use crate::scene::{Grain, Motion, Scene, Shape, Wall};
use nalgebra::Vector3;
use std::f64::consts::TAU;

/// Overlap that a wall makes over its way in a step, for grains of one size: measured in drums, `docs/scene-checks.md`.
const OF_THE_WAY: f64 = 0.5;

/// Tells of walls that are too fast for the step.
pub(super) fn faults(scene: &Scene, grains: &[Grain]) -> Vec<Fault> {
    let Some(bound) = tolerated(scene) else { return Vec::new() };
    let smallest = grains.iter().map(|grain| grain.radius).fold(f64::INFINITY, f64::min);
    let step = scene.solver.step;
    let walls = scene.wall.iter().enumerate().filter_map(|(index, wall)| {
        // What has no inside can pass grains even where they are few.
        let thin = !matches!(wall.shape, Shape::Plane { .. } | Shape::Box { .. }) && !stays(wall);
        let speed = fastest(scene, wall);
        let overlap = OF_THE_WAY * speed * step / smallest;
        let too_fast = (thin || grains.len() >= BED) && overlap > bound;
        too_fast.then(|| {
            let at = DocumentPath::default().key("wall").index(index).key("motion");
            let problem = format!(
                "wall '{}' moves at up to {} m/s, {} of the smallest radius in a step of {} s",
                wall.name,
                short((speed * 100.0).round() / 100.0),
                short((speed * step / smallest * 10.0).round() / 10.0),
                short(step)
            );
            let would_do = floor(bound * smallest / (OF_THE_WAY * speed));
            at.fault(problem, &format!("lower solver.step to {would_do:e} s, or slow the wall down"))
        })
    });
    walls.collect()
}

/// Largest speed of a wall's points within the scene's time, m/s.
fn fastest(scene: &Scene, wall: &Wall) -> f64 {
    let began = |start: f64| start < scene.duration;
    match wall.motion {
        Motion::Translating { velocity, start, .. } if began(start) => Vector3::from(velocity).norm(),
        Motion::Vibrating { amplitude, frequency, start, .. } if began(start) => {
            TAU * frequency * Vector3::from(amplitude).norm()
        }
        Motion::Rotating { point, axis, rate, start, .. } if began(start) => {
            let axis = Vector3::from(axis).normalize();
            let arm = |of: Vector3<f64>| (of - Vector3::from(point)).cross(&axis).norm();
            rate.abs() * furthest(scene, &wall.shape, arm)
        }
        _ => 0.0,
    }
}

/// Largest distance from an axis of the points of a shape that lie in the domain, or a little more, m.
fn furthest(scene: &Scene, shape: &Shape, arm: impl Fn(Vector3<f64>) -> f64) -> f64 {
    let corners = |min: &[f64; 3], max: &[f64; 3]| {
        let corner =
            |number: usize| Vector3::from_fn(|axis, _| if number >> axis & 1 == 0 { min[axis] } else { max[axis] });
        (0..8).map(corner).map(&arm).fold(0.0, f64::max)
    };
    let in_domain = corners(&scene.domain.min, &scene.domain.max);
    let of_shape = match shape {
        Shape::Plane { .. } => f64::INFINITY,
        Shape::Box { min, max, .. } => corners(min, max),
        Shape::Cylinder { base, axis, radius, length } => {
            let base = Vector3::from(*base);
            let end = base + Vector3::from(*axis).normalize() * *length;
            arm(base).max(arm(end)) + radius
        }
        Shape::Disc { centre, radius, .. } => arm(Vector3::from(*centre)) + radius,
        Shape::Spheres { centres, radius } => {
            centres.iter().map(|centre| arm(Vector3::from(*centre))).fold(0.0, f64::max) + radius
        }
    };
    of_shape.min(in_domain)
}
