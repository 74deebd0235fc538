//! Size spread: grains of more than one radius.

use super::catalogue::{Call, Change, Effect};
use crate::scene::{DocumentPath, RadiusDistribution, Scene};

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
    let populations = scene.population.iter().map(|group| group.radius.bounds());
    let sources = scene.insert.iter().map(|source| source.radius.bounds());
    let grains = scene.listed().map(|grain| (grain.radius, grain.radius));
    let ranges: Vec<(f64, f64)> = populations.chain(sources).chain(grains).collect();
    let smallest = ranges.iter().fold(f64::INFINITY, |least, range| least.min(range.0));
    let largest = ranges.iter().fold(0.0, |most: f64, range| most.max(range.1));
    if smallest >= largest {
        return Err("all grains are of one size");
    }
    // The first entry with a distribution of radii, or with a radius that differs from those of earlier entries.
    let index = ranges.iter().position(|range| *range != (ranges[0].0, ranges[0].0)).unwrap_or(0);
    let (populations, sources) = (scene.population.len(), scene.insert.len());
    let (table, entry) = match index {
        _ if index < populations => ("population", index),
        _ if index < populations + sources => ("insert", index - populations),
        _ => ("grain", index - populations - sources),
    };
    let place = match table == "grain" && entry >= scene.grain.len() {
        true => DocumentPath::default().key("start").key("file"),
        false => DocumentPath::default().key(table).index(entry).key("radius"),
    };
    Ok(Call { why: format!("radii from {smallest} to {largest} m"), place })
}
