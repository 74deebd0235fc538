//! Size spread: grains of more than one radius.

use super::catalogue::{Call, Change, Effect};
use crate::scene::{DocumentPath, Population, RadiusDistribution, Scene};

/// Size spread.
pub static SIZE_SPREAD: Effect = Effect {
    off: Some(Change {
        words: "off: all of the mean radius",
        apply: |scene| {
            let value = mean_radius(scene);
            scene.population.iter_mut().for_each(|group| group.radius = RadiusDistribution::Fixed { value });
        },
    }),
    ..Effect::of_scene("size spread", call)
};

fn call(scene: &Scene) -> Result<Call, &'static str> {
    let populations = scene.population.iter().map(|group| group.radius.bounds());
    let ranges: Vec<(f64, f64)> =
        populations.chain(scene.grain.iter().map(|grain| (grain.radius, grain.radius))).collect();
    let smallest = ranges.iter().fold(f64::INFINITY, |least, range| least.min(range.0));
    let largest = ranges.iter().fold(0.0, |most: f64, range| most.max(range.1));
    if smallest >= largest {
        return Err("all grains are of one size");
    }
    // The first entry with a distribution of radii, or with a radius that differs from those of earlier entries.
    let index = ranges.iter().position(|range| *range != (ranges[0].0, ranges[0].0)).unwrap_or(0);
    let (table, entry) = match index.checked_sub(scene.population.len()) {
        Some(grain) => ("grain", grain),
        None => ("population", index),
    };
    let place = DocumentPath::default().key(table).index(entry).key("radius");
    Ok(Call { why: format!("radii from {smallest} to {largest} m"), place })
}

/// Returns the mean radius (m) of the grains of all populations.
fn mean_radius(scene: &Scene) -> f64 {
    let count: usize = scene.population.iter().map(|group| group.count).sum();
    let share = |group: &Population| group.count as f64 / count as f64;
    scene.population.iter().map(|group| share(group) * mean_of(&group.radius)).sum()
}

fn mean_of(radius: &RadiusDistribution) -> f64 {
    match radius {
        RadiusDistribution::Fixed { value } => *value,
        RadiusDistribution::Uniform { mean, .. } | RadiusDistribution::Normal { mean, .. } => *mean,
        RadiusDistribution::Discrete { radii, shares } => {
            let sum: f64 = shares.iter().sum();
            radii.iter().zip(shares).map(|(radius, share)| radius * share / sum).sum()
        }
    }
}
