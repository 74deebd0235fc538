//! Size spread: grains of more than one radius.

use super::catalogue::{Call, Change, Effect};
use crate::scene::{RadiusDistribution, Scene};

/// Size spread.
pub static SIZE_SPREAD: Effect = Effect {
    off: Some(Change {
        words: "off: all of the mean radius",
        apply: |scene| {
            let value = Scene { grain: Vec::new(), start: None, ..scene.clone() }.mean_radius();
            scene.population.iter_mut().for_each(|group| group.radius = RadiusDistribution::Fixed { value });
            scene.insert.iter_mut().for_each(|source| source.radius = RadiusDistribution::Fixed { value });
        },
    }),
    ..Effect::of_scene("size spread", call)
};

fn call(scene: &Scene) -> Result<Call, &'static str> {
    let extremes = |(least, most): (f64, f64), (_, (low, high)): (_, (f64, f64))| (least.min(low), most.max(high));
    let (smallest, largest) = scene.radii().fold((f64::INFINITY, 0.0), extremes);
    if smallest >= largest {
        return Err("all grains are of one size");
    }
    // The first entry with a distribution of radii, or with a radius that differs from that of the first.
    let first = scene.radii().next().map_or(0.0, |(_, (radius, _))| radius);
    let place = scene.radii().find(|(_, range)| *range != (first, first)).map(|(place, _)| place).unwrap_or_default();
    Ok(Call { why: format!("radii from {smallest} to {largest} m"), place })
}
