//! Where the first driven wall of a scene is.

use super::measurement::{Quantity, Readings};
use super::view::View;
use makadam::scene::Motion;

const ALONG: Quantity = Quantity::mean("driven_wall_displacement", "m");
const ABOUT: Quantity = Quantity::mean("driven_wall_displacement", "rad");

/// Adds `driven_wall_displacement`: how far a force or a torque has moved the first of the scene's walls that one drives, along or
/// about its axis, from where the scene placed it. Nothing is read where none is driven.
pub fn read(view: &View<'_>, readings: &mut Readings) {
    let Some(driven) = view.frame.driven_walls.first() else { return };
    let quantity = match view.setting.scene().wall.get(driven.wall as usize).map(|wall| &wall.motion) {
        Some(Motion::TorqueDriven { .. }) => ABOUT,
        _ => ALONG,
    };
    readings.add(quantity, driven.displacement);
}
