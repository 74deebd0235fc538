//! Displacement of the first dynamic wall of a scene.

use super::catalogue::{Group, define};
use super::measurement::Readings;
use super::view::View;
use makadam::scene::Motion;
use makadam_frames::plan::Observable;
use makadam_frames::recording::Content;

pub(super) const GROUP: Group = Group {
    observable: Observable::DrivenWall,
    name: "driven-wall",
    read,
    definitions: &[define(
        ["driven_wall_displacement", "x_w", "m or rad"],
        "how far a force or a torque has moved the first driven wall, along or about its axis",
    )
    .needs(&[Content::DrivenWalls])],
};

fn read(view: &View<'_>, readings: &mut Readings) -> Result<(), String> {
    let Some(driven) = view.frame.driven_walls.first() else { return Ok(()) };
    let unit = match view.setting.scene().wall.get(driven.wall as usize).map(|wall| &wall.motion) {
        Some(Motion::TorqueDriven { .. }) => "rad",
        _ => "m",
    };
    readings.add_in("driven_wall_displacement", unit, driven.displacement);
    Ok(())
}
