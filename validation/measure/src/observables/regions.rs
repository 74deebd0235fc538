//! Grains in each region of a scene.

use super::catalogue::{Group, define};
use super::measurement::Readings;
use super::setting::{Properties, Setting};
use super::view::View;
use makadam::snapshot::{Particle, Snapshot};
use makadam_frames::plan::{CountedRegion, Observable};

pub(super) const GROUP: Group = Group {
    observable: Observable::Regions,
    name: "regions",
    read,
    definitions: &[define(
        ["grain_count(region)", "N_R", ""],
        "number of grains with their centre in a region of measure.region, of its material if it names one",
    )],
};

fn read(view: &View<'_>, readings: &mut Readings) -> Result<(), String> {
    for region in &view.setting.scene().measure.region {
        let name = "grain_count(region)".replace("(region)", &format!("({})", region.name));
        readings.add_in(name, "", count(view.setting, view.frame, region));
    }
    Ok(())
}

/// Returns the number of grains of a frame in a region.
fn count(setting: &Setting<'_>, frame: &Snapshot, region: &CountedRegion) -> f64 {
    let counts = |grain: &&Particle| {
        let is_of_material = region.material.as_ref().is_none_or(|name| setting.material_name(frame, grain.id) == name);
        is_of_material && region.within.holds(&grain.position.into())
    };
    frame.particles.iter().filter(counts).count() as f64
}

/// Returns the grains in a region in each frame, by its index: times (s) and numbers.
pub fn over_time(properties: &Properties<'_>, frames: &[Snapshot], region: usize) -> Vec<(f64, f64)> {
    let region = &properties.scene.measure.region[region];
    frames.iter().map(|frame| (frame.time, count(&Setting::new(properties, frame), frame, region))).collect()
}

#[cfg(test)]
#[path = "../../tests/unit/observables_regions.rs"]
mod tests;
