//! Ablation: the scene with each effect off or on, over several seeds, judged by the equivalence test.

use crate::compare::{Announce, CodeRuns, Outcome, Runs};
use crate::peers::{CodeError, Makadam};
use crate::statistics::{Ensemble, Equivalence, equivalence};
use makadam::scene::{Motion, NormalLaw, RadiusDistribution, Scene};
use serde::Serialize;
use std::path::Path;
use std::time::Duration;

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

/// Whether the scene needs an effect, as far as one observable tells.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Need {
    /// The observable moves beyond its margin without it (or with it, where the scene has none).
    Needed,
    /// It stays within its margin.
    NotNeeded,
    /// Too few seeds to tell.
    Undecided,
    /// The change leaves nothing to measure.
    NotMeasurable,
}

/// One observable under one variation.
#[derive(Clone, Debug, Serialize)]
pub struct Ablated {
    /// The effect.
    pub effect: &'static str,
    /// What was changed.
    pub change: String,
    /// The observable.
    pub observable: String,
    /// Mean with the scene as it is.
    pub mean: f64,
    /// Mean with the change; absent where it cannot be measured.
    pub changed_mean: Option<f64>,
    /// 90% interval of the difference.
    pub interval90: Option<[f64; 2]>,
    /// Margin of the scene.
    pub margin: f64,
    /// Verdict.
    pub need: Need,
}

/// The variations of a scene over seeds.
#[derive(Clone, Debug, Serialize)]
pub struct Ablation {
    /// Seeds of each.
    pub seeds: Vec<u64>,
    /// One a variation and observable.
    pub rows: Vec<Ablated>,
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
        for group in &mut scene.population {
            let value = mean_radius(&group.radius);
            group.radius = RadiusDistribution::Fixed { value };
        }
    });
    add("wall motion", "off".into(), &|scene| scene.wall.iter_mut().for_each(|wall| wall.motion = Motion::Fixed));
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

fn mean_radius(radius: &RadiusDistribution) -> f64 {
    match radius {
        RadiusDistribution::Fixed { value } => *value,
        RadiusDistribution::Uniform { mean, .. } | RadiusDistribution::Normal { mean, .. } => *mean,
        RadiusDistribution::Discrete { radii, shares } => {
            let sum: f64 = shares.iter().sum();
            radii.iter().zip(shares).map(|(radius, share)| radius * share / sum).sum()
        }
    }
}

impl Ablation {
    /// Runs the scene and its variations over the seeds, and judges each observable that has a margin.
    ///
    /// # Errors
    /// [`CodeError`] if the scene itself cannot be run; a variation that cannot is not measurable.
    pub fn run(
        scene: &Scene,
        file: &Path,
        seeds: &[u64],
        time_limit: Duration,
        announce: Announce<'_>,
    ) -> Result<Ablation, CodeError> {
        let runs = |scene: &Scene| {
            let asked = Runs {
                scene,
                scene_file: file,
                seeds: seeds.to_vec(),
                rayleigh_fraction: 0.2,
                stiffness_factor: 1.0,
                time_limit,
                recordings: None,
                announce,
            };
            let simulated = asked.simulate(&Makadam);
            (CodeRuns::live("Makadam", String::new(), simulated.harvests), simulated.failures)
        };
        let (base, failures) = runs(scene);
        if let Some((_, error)) = failures.into_iter().next() {
            return Err(error);
        }
        let mut rows = Vec::new();
        for variation in variations(scene) {
            let (changed, failures) = runs(&variation.scene);
            if let Some((_, error @ CodeError::Interrupted { .. })) = failures.into_iter().next() {
                return Err(error);
            }
            for expectation in &scene.compare {
                let Some(margin) = expectation.margin else { continue };
                let observable = &expectation.observable;
                let Some(own) = Ensemble::of(&base.values(observable)) else { continue };
                let other = Ensemble::of(&changed.values(observable));
                let test = other.as_ref().map(|other| equivalence(&own, other, Some(margin), 2));
                rows.push(Ablated {
                    effect: variation.effect,
                    change: variation.change.clone(),
                    observable: observable.clone(),
                    mean: own.mean,
                    changed_mean: other.map(|other| other.mean),
                    interval90: test.as_ref().and_then(|test| test.interval90),
                    margin,
                    need: need(test.as_ref()),
                });
            }
        }
        Ok(Ablation { seeds: seeds.to_vec(), rows })
    }
}

fn need(test: Option<&Equivalence>) -> Need {
    match test.map(|test| test.outcome) {
        Some(Some(Outcome::Agree)) => Need::NotNeeded,
        Some(Some(Outcome::Disagree)) => Need::Needed,
        Some(_) => Need::Undecided,
        None => Need::NotMeasurable,
    }
}
