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

/// Path in a step, over the smallest radius, above which a grain that the wall drives can pass another one.
const DIAMETER: f64 = 2.0;

/// Tells of walls that are too fast for the step: by the overlap that the scene tolerates, and in any case where they move by more than a
/// diameter in a step.
pub(super) fn faults(scene: &Scene, grains: &[Grain]) -> Vec<Fault> {
    let bound = tolerated(scene);
    let smallest = grains.iter().map(|grain| grain.radius).fold(f64::INFINITY, f64::min);
    let step = scene.solver.step;
    let walls = scene.wall.iter().enumerate().filter_map(|(index, wall)| {
        let speed = fastest(scene, wall);
        let path = speed * step / smallest;
        let bound = bound.filter(|bound| can_pass(wall, grains) && OF_THE_WAY * path > *bound);
        let passes = path > DIAMETER && drives(wall, grains);
        (bound.is_some() || passes).then(|| {
            let at = DocumentPath::default().key("wall").index(index).key("motion");
            let problem = format!(
                "wall '{}' moves at up to {} m/s, {} of the smallest radius in a step of {} s{}",
                wall.name,
                short((speed * 100.0).round() / 100.0),
                short((path * 10.0).round() / 10.0),
                short(step),
                if passes { ": the step does not resolve which grains it drives into others" } else { "" }
            );
            let most = bound.map_or(DIAMETER, |bound| (bound / OF_THE_WAY).min(DIAMETER));
            let would_do = floor(most * smallest / speed);
            at.fault(problem, &format!("lower solver.step to {would_do:e} s, or slow the wall down"))
        })
    });
    walls.collect()
}

/// Longest step (s) that no wall is too fast for.
pub(super) fn longest_step(scene: &Scene, grains: &[Grain]) -> f64 {
    let bound = tolerated(scene);
    let smallest = grains.iter().map(|grain| grain.radius).fold(f64::INFINITY, f64::min);
    let steps = scene.wall.iter().map(|wall| {
        let by_overlap = bound.filter(|_| can_pass(wall, grains)).map_or(f64::INFINITY, |bound| bound / OF_THE_WAY);
        let by_path = if drives(wall, grains) { DIAMETER } else { f64::INFINITY };
        match fastest(scene, wall) {
            speed if speed > 0.0 => by_overlap.min(by_path) * smallest / speed,
            _ => f64::INFINITY,
        }
    });
    steps.fold(f64::INFINITY, f64::min)
}

/// Reports whether a wall can drive grains into others as fast as its fastest point in the domain: how far from its axis the grains of a plane
/// that turns are is not known.
fn drives(wall: &Wall, grains: &[Grain]) -> bool {
    let endless = matches!((&wall.shape, &wall.motion), (Shape::Plane { .. }, Motion::Rotating { .. }));
    grains.len() >= 2 && !endless
}

/// Reports whether a wall can run into a bed, or pass grains even where they are few: what has no inside can.
fn can_pass(wall: &Wall, grains: &[Grain]) -> bool {
    let thin = !matches!(wall.shape, Shape::Plane { .. } | Shape::Box { .. }) && !stays(wall);
    thin || grains.len() >= BED
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
