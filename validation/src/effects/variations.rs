//! What an ablation changes: the scene with one effect off, or on.

use crate::plan::Scene;
use makadam::scene::{Motion, NormalLaw, Population, RadiusDistribution};

/// Coefficient with which rolling and twisting resistance are tried where a scene has none.
const TRIED: f64 = 0.1;

/// A scene with one effect changed.
#[derive(Clone, Debug)]
pub struct Variation {
    /// The effect.
    pub effect: &'static str,
    /// What was changed, in words.
    pub change: String,
    /// The scene.
    pub scene: Scene,
}

/// Every effect of the scene turned off, and resistance to turning turned on where there is none.
pub fn variations(scene: &Scene) -> Vec<Variation> {
    let mut all = Vec::new();
    let mut add = |effect, change: String, adapt: &dyn Fn(&mut Scene)| {
        let mut changed = scene.clone();
        adapt(&mut changed);
        // An accuracy would choose another step for another scene; here only the effect may differ.
        changed.accuracy = None;
        if changed.material != scene.material
            || changed.pair != scene.pair
            || changed.wall != scene.wall
            || changed.population != scene.population
            || changed.solver != scene.solver
            || changed.gravity_changes != scene.gravity_changes
            || changed.domain != scene.domain
        {
            all.push(Variation { effect, change, scene: changed });
        }
    };
    add("Coulomb friction", "off".into(), &|scene| {
        for one in scene.material.values_mut() {
            (one.friction, one.kinetic_friction) = (0.0, None);
        }
        for pair in &mut scene.pair {
            (pair.friction, pair.kinetic_friction) = (None, None);
        }
    });
    add("kinetic friction", "off".into(), &|scene| {
        scene.material.values_mut().for_each(|one| one.kinetic_friction = None);
        scene.pair.iter_mut().for_each(|pair| pair.kinetic_friction = None);
    });
    add("falling restitution", "off".into(), &|scene| {
        scene.material.values_mut().for_each(|one| one.restitution_speed = None);
        scene.pair.iter_mut().for_each(|pair| pair.restitution_speed = None);
    });
    add("restitution", "off".into(), &|scene| {
        scene.material.values_mut().for_each(|one| one.restitution = 0.0);
        scene.pair.iter_mut().for_each(|pair| pair.restitution = None);
    });
    add("elastic compliance", "off: rigid".into(), &|scene| scene.solver.normal_law = NormalLaw::Rigid);
    add("size spread", "off: all of the mean radius".into(), &|scene| {
        let value = mean_radius(scene);
        scene.population.iter_mut().for_each(|group| group.radius = RadiusDistribution::Fixed { value });
    });
    let stop = |scene: &mut Scene, driven: bool| {
        let walls = scene.wall.iter_mut().filter(|wall| wall.motion.is_driven() == driven);
        walls.for_each(|wall| wall.motion = Motion::Fixed);
    };
    add("wall motion", "off".into(), &|scene| stop(scene, false));
    add("driven walls", "off: fixed".into(), &|scene| stop(scene, true));
    add("periodic axes", "off".into(), &|scene| scene.domain.periodic.clear());
    add("changing gravity", "off".into(), &|scene| scene.gravity_changes.clear());
    add("cohesion", "off".into(), &|scene| {
        scene.material.values_mut().for_each(|one| one.cohesion = None);
        scene.pair.iter_mut().for_each(|pair| pair.cohesion = None);
    });
    let rolls = scene.material.values().any(|one| one.rolling_friction > 0.0);
    add("rolling resistance", toggled(rolls), &|scene| {
        let value = if rolls { 0.0 } else { TRIED };
        scene.material.values_mut().for_each(|one| one.rolling_friction = value);
        scene.pair.iter_mut().for_each(|pair| pair.rolling_friction = None);
    });
    let twists = scene.material.values().any(|one| one.twisting_friction > 0.0);
    add("twisting resistance", toggled(twists), &|scene| {
        let value = if twists { 0.0 } else { TRIED };
        scene.material.values_mut().for_each(|one| one.twisting_friction = value);
        scene.pair.iter_mut().for_each(|pair| pair.twisting_friction = None);
    });
    all
}

fn toggled(on: bool) -> String {
    if on { "off".into() } else { format!("on: {TRIED}") }
}

/// Mean radius over the grains of all populations, m.
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
