//! Grains whose velocities at the start take them past each other in a step, `|v_a - v_b| h > r_a + r_b`: such a step does not resolve which
//! grains meet.

use super::Beforehand;
use super::impact::floor;
use crate::scene::error::{Fault, short};
use crate::scene::populate::origin;
use crate::scene::{Grain, Scene};
use nalgebra::Vector3;

/// Reports the first pair of grains that move by more than a diameter in a step.
pub(super) fn fault(scene: &Scene, grains: &[Grain], beforehand: Option<Beforehand>) -> Option<Fault> {
    let (step, key) = match beforehand {
        Some(prepare) => (prepare.step, "prepare.step"),
        None => (scene.solver.step, "solver.step"),
    };
    let (first, second) = passing(grains, step)?;
    let velocity = |grain: usize| Vector3::from(grains[grain].velocity);
    let path = (velocity(first) - velocity(second)).norm() * step;
    let touch = grains[first].radius + grains[second].radius;
    let problem = format!(
        "grains {first} and {second} move by {} m against each other in a step of {} s, more than the sum of their radii, {} m: the step \
         does not resolve which grains meet",
        short(path),
        short(step),
        short(touch)
    );
    Some(Fault::new(
        origin(scene, first),
        problem,
        format!("lower {key} to {:e} s, or the velocities", floor(step * touch / path)),
    ))
}

/// Two grains whose relative velocity takes them past each other in a step (s).
fn passing(grains: &[Grain], step: f64) -> Option<(usize, usize)> {
    let velocities: Vec<Vector3<f64>> = grains.iter().map(|grain| Vector3::from(grain.velocity)).collect();
    let mean = velocities.iter().sum::<Vector3<f64>>() / grains.len().max(1) as f64;
    let smallest = grains.iter().map(|grain| grain.radius).fold(f64::INFINITY, f64::min);
    // One of two that are so fast is half as fast against the mean.
    let fast = (0..grains.len()).filter(|&grain| (velocities[grain] - mean).norm() * step > smallest);
    fast.into_iter().find_map(|first| {
        let passes = |&second: &usize| {
            let touch = grains[first].radius + grains[second].radius;
            (velocities[first] - velocities[second]).norm() * step > touch
        };
        (0..grains.len()).find(passes).map(|second| (first.min(second), first.max(second)))
    })
}
