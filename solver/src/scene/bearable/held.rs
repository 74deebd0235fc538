//! Grains that nothing will hold: they fall out of the domain.

use super::bed::{Bed, Fall};
use crate::scene::error::{Fault, short};
use crate::scene::populate::origin;
use crate::scene::{Grain, Reaction, Scene};

/// Tells of grains that leave the domain within the scene's time, straight down, with no wall beneath them.
///
/// Nothing is told where a wall may come their way, where they are thrown so fast that they land elsewhere, or of grains of a material
/// that coheres: they may stick to a ceiling or to other grains.
pub(super) fn fault(scene: &Scene, grains: &[Grain], bed: &Bed) -> Option<Fault> {
    if !bed.walls_stay || scene.watch.on_escape == Reaction::Ignore || scene.watch.every == 0 {
        return None;
    }
    let leaves = |index: usize| {
        let Fall::Out(distance) = bed.falls[index] else { return false };
        if coheres(scene, &grains[index].material) {
            return false;
        }
        let speed = grains[index].velocity.iter().map(|v| v * v).sum::<f64>().sqrt();
        let time = (2.0 * distance.max(0.0) / bed.gravity).sqrt();
        time < scene.duration && speed * time < 4.0 * grains[index].radius
    };
    let mut leaving = (0..grains.len()).filter(|&index| leaves(index));
    let first = leaving.next()?;
    let count = 1 + leaving.count();
    let [x, y, z] = grains[first].position.map(short);
    let who = match count {
        1 => format!("grain {first} at ({x}, {y}, {z}) m falls"),
        _ => format!("{count} grains, the first of them grain {first} at ({x}, {y}, {z}) m, fall"),
    };
    let problem = format!("{who} out of the domain: no wall is beneath");
    let remedy =
        "put a wall there, or move the grains into the container; watch.on_escape = 'ignore' says that it is meant";
    Some(Fault::new(origin(scene, first), problem, remedy))
}

/// Returns true if grains of a material cohere with any wall or grain of the scene.
fn coheres(scene: &Scene, material: &str) -> bool {
    let with = |other: &str, wall: bool| scene.contact_coefficients(material, other, wall).cohesion.is_some();
    scene.wall.iter().any(|wall| with(&wall.material, true)) || scene.material.keys().any(|other| with(other, false))
}
