//! The intruder: the first grain that a scene lists by itself, such as a ball that is shot into a bed.

use super::measurement::{Quantity, Readings};
use super::setting::{Properties, Setting};
use super::view::View;
use crate::plan::{Scene, lasting_number};
use makadam::snapshot::{Particle, Snapshot};
use nalgebra::Vector3;

/// Name of the height, of which there is a series over time.
pub const HEIGHT_NAME: &str = "intruder_height";

const HEIGHT: Quantity = Quantity::mean(HEIGHT_NAME, "m");
const SPEED: Quantity = Quantity::mean("intruder_speed", "m/s");

/// The grain itself. Listed grains are numbered before all others, so its lasting number is 0.
fn of<'f>(scene: &Scene, frame: &'f Snapshot) -> Option<&'f Particle> {
    scene.grain.first()?;
    frame.particles.iter().find(|grain| lasting_number(frame, grain.id) == 0)
}

/// Its height above the origin, against gravity, m; `None` where there is no gravity, or no such grain in the frame.
fn height(setting: &Setting<'_>, frame: &Snapshot) -> Option<f64> {
    Some(Vector3::from(of(setting.scene(), frame)?.position).dot(&setting.up?))
}

/// Adds `intruder_height` and `intruder_speed`. Nothing is read where the scene lists no grain by itself.
pub fn read(view: &View<'_>, readings: &mut Readings) {
    if let Some(height) = height(view.setting, view.frame) {
        readings.add(HEIGHT, height);
    }
    if let Some(grain) = of(view.setting.scene(), view.frame) {
        readings.add(SPEED, Vector3::from(grain.velocity).norm());
    }
}

/// Its height in each frame: times in s, heights in m.
pub fn over_time(properties: &Properties<'_>, frames: &[Snapshot]) -> Vec<(f64, f64)> {
    let at = |frame: &Snapshot| Some((frame.time, height(&Setting::new(properties, frame), frame)?));
    frames.iter().filter_map(at).collect()
}

#[cfg(test)]
#[path = "../../tests/unit/observables_intruder.rs"]
mod tests;
