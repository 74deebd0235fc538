//! Surface velocity: a wall whose surface moves along itself while its shape stays, such as a conveyor belt.
//!
//! At a contact with the unit normal n the velocity of the wall is `v + b - n (n.b)`, with the velocity v of its motion and the surface
//! velocity b. So friction carries grains along, and the wall does not push.

use super::catalogue::{Call, Change, Effect};
use crate::scene::DocumentPath;

/// Surface velocity of walls.
pub static SURFACE_VELOCITY: Effect = Effect {
    off: Some(Change {
        words: "zero",
        apply: |scene| scene.wall.iter_mut().for_each(|wall| wall.surface_velocity = [0.0; 3]),
    }),
    ..Effect::of_scene("surface velocity", |scene| {
        let moves = |(index, wall): (usize, &crate::scene::Wall)| {
            let place = DocumentPath::default().key("wall").index(index).key("surface_velocity");
            let why = format!("the surface of wall '{}' moves along itself", wall.name);
            (wall.surface_velocity != [0.0; 3]).then_some(Call { why, place })
        };
        scene.wall.iter().enumerate().find_map(moves).ok_or("no wall has a surface velocity")
    })
};
