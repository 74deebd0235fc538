//! Force, torque and power of each wall, and its wear.
//!
//! Frames of Makadam state the mean load over the time since the measured frame before, summed over all steps. For frames of other
//! codes, the load is that of the contacts at the time of the frame: its mean over many frames is the same number.

use super::catalogue::{Group, WALL_CONTACTS, define};
use super::measurement::Readings;
use super::view::View;
use makadam::snapshot::{Partner, WallLoad};
use makadam_frames::plan::Observable;
use nalgebra::Vector3;

pub(super) const LOADS: Group = Group {
    observable: Observable::Walls,
    name: "walls",
    read: read_loads,
    definitions: &[
        define(["force_x(wall)", "F_x", "N"], "mean force of the grains on a wall along x").needs(WALL_CONTACTS),
        define(["force_y(wall)", "F_y", "N"], "mean force of the grains on a wall along y").needs(WALL_CONTACTS),
        define(["force_z(wall)", "F_z", "N"], "mean force of the grains on a wall along z").needs(WALL_CONTACTS),
        define(["torque_x(wall)", "M_x", "N m"], "mean torque of the grains on a wall about the point of its axis of rotation, or about the origin without one").needs(WALL_CONTACTS),
        define(["torque_y(wall)", "M_y", "N m"], "as M_x").needs(WALL_CONTACTS),
        define(["torque_z(wall)", "M_z", "N m"], "as M_x").needs(WALL_CONTACTS),
        define(
            ["torque(wall)", "M", "N m"],
            "torque along the axis of rotation, by the right-hand rule",
        )
        .needs(WALL_CONTACTS),
        define(
            ["power(wall)", "P", "W"],
            "mean power of a wall on the grains, −Σ f·v",
        )
        .needs(WALL_CONTACTS),
    ],
};

pub(super) const WEAR: Group = Group {
    observable: Observable::Wear,
    name: "wear",
    read: read_wear,
    definitions: &[
        define(
            ["archard(wall)", "W_A", "J"],
            "Σ f_n |s| over the slip s at a wall by the last frame; the worn volume is K/H times it",
        )
        .source("Archard, J. Appl. Phys. 24, 981 (1953)")
        .largest(),
        define(
            ["finnie(wall)", "W_F", "J"],
            "Σ m u² f(α) over impacts by the last frame, f = sin 2α − 3 sin²α if tan α < 1/3, else cos²α/3",
        )
        .source("Finnie, Wear 3, 87 (1960)")
        .largest(),
    ],
};

fn read_loads(view: &View<'_>, readings: &mut Readings) -> Result<(), String> {
    let (scene, frame) = (view.setting.scene(), view.frame);
    if frame.wall_loads.is_empty() && frame.contacts.is_empty() && frame.time <= 0.0 {
        return Ok(());
    }
    let at_once = || (0..scene.wall.len()).map(|wall| load_of_contacts(view, wall)).collect();
    let loads = if frame.wall_loads.is_empty() { at_once() } else { frame.wall_loads.clone() };
    for (wall, WallLoad { force, torque, power }) in scene.wall.iter().zip(loads) {
        let ([force_x, force_y, force_z], [torque_x, torque_y, torque_z]) = (force, torque);
        readings.add_of("force_x(wall)", &wall.name, force_x);
        readings.add_of("force_y(wall)", &wall.name, force_y);
        readings.add_of("force_z(wall)", &wall.name, force_z);
        readings.add_of("torque_x(wall)", &wall.name, torque_x);
        readings.add_of("torque_y(wall)", &wall.name, torque_y);
        readings.add_of("torque_z(wall)", &wall.name, torque_z);
        if let Some((_, axis)) = wall.motion.axis() {
            readings.add_of("torque(wall)", &wall.name, Vector3::from(axis).normalize().dot(&Vector3::from(torque)));
        }
        readings.add_of("power(wall)", &wall.name, power);
    }
    Ok(())
}

/// Returns the load of a wall by the contacts of a frame.
fn load_of_contacts(view: &View<'_>, wall: usize) -> WallLoad {
    let axis = view.setting.scene().wall[wall].motion.axis();
    let pivot = axis.map_or_else(Vector3::zeros, |(point, _)| point.into());
    let (mut force, mut torque, mut power) = (Vector3::zeros(), Vector3::zeros(), 0.0);
    for contact in view.frame.contacts.iter().filter(|contact| contact.second == Partner::Wall(wall as u32)) {
        let (on_wall, point) = (contact.force_on_partner(), Vector3::from(contact.point));
        force += on_wall;
        torque += (point - pivot).cross(&on_wall);
        power -= on_wall.dot(&view.walls.velocity_at(wall, &point, &contact.normal.into()));
    }
    WallLoad { force: force.into(), torque: torque.into(), power }
}

fn read_wear(view: &View<'_>, readings: &mut Readings) -> Result<(), String> {
    let wear = &view.frame.wear;
    for (number, wall) in view.setting.scene().wall.iter().enumerate().filter(|_| !wear.is_empty()) {
        let own = || wear.iter().filter(|face| face.wall as usize == number);
        readings.add_of("archard(wall)", &wall.name, own().map(|face| face.archard).sum());
        readings.add_of("finnie(wall)", &wall.name, own().map(|face| face.finnie).sum());
    }
    Ok(())
}
