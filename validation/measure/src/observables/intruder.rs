//! Intruder: the first listed grain of a scene, such as a ball shot into a bed.

use super::catalogue::{Group, VELOCITIES, define};
use super::measurement::Readings;
use super::setting::{Properties, Setting};
use super::view::View;
use makadam::snapshot::{Particle, Snapshot};
use makadam_frames::plan::{MeasuredScene, Observable, lasting_number};
use nalgebra::Vector3;

pub(super) const GROUP: Group = Group {
    observable: Observable::Intruder,
    name: "intruder",
    read,
    definitions: &[
        define(
            ["intruder_height", "z_i", "m"],
            "height of the centre of the first grain that the scene lists by itself above the origin, against \
             gravity",
        ),
        define(
            ["largest_intruder_depth", "d_i", "m"],
            "largest depth of the centre of the first grain that the scene lists by itself below the origin, along gravity",
        )
        .largest(),
        define(["intruder_speed", "v_i", "m/s"], "speed of the first grain that the scene lists by itself")
            .needs(VELOCITIES),
    ],
};

/// Returns the intruder in a frame. Listed grains have the first numbers, so its lasting number is 0.
fn of<'f>(scene: &MeasuredScene, frame: &'f Snapshot) -> Option<&'f Particle> {
    scene.grain.first()?;
    frame.particles.iter().find(|grain| lasting_number(frame, grain.id) == 0)
}

/// Returns the height of the intruder above the origin, against gravity, m; `None` without gravity, or without this grain in the frame.
fn height(setting: &Setting<'_>, frame: &Snapshot) -> Option<f64> {
    Some(Vector3::from(of(setting.scene(), frame)?.position).dot(&setting.up?))
}

fn read(view: &View<'_>, readings: &mut Readings) -> Result<(), String> {
    if let Some(height) = height(view.setting, view.frame) {
        readings.add("intruder_height", height);
        readings.add("largest_intruder_depth", -height);
    }
    if let Some(grain) = of(view.setting.scene(), view.frame) {
        readings.add("intruder_speed", Vector3::from(grain.velocity).norm());
    }
    Ok(())
}

/// Returns the height in each frame: times (s) and heights (m).
pub fn over_time(properties: &Properties<'_>, frames: &[Snapshot]) -> Vec<(f64, f64)> {
    let at = |frame: &Snapshot| Some((frame.time, height(&Setting::new(properties, frame), frame)?));
    frames.iter().filter_map(at).collect()
}

#[cfg(test)]
#[path = "../../tests/unit/observables_intruder.rs"]
mod tests;
