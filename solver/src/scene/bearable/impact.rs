//! How deep grains run into each other where they fall on others, or lie under them.
//!
//! ```text
//! by stiffness   d/r = (15/16 M v^2 / (E* sqrt(R') n))^(2/5) / r      n = (R/r)^(3/2), the grains that one falls on
//! by the step    d/r = c v h / r                                      c = max(3/4, R/(10 r))
//! ```
//!
//! for a grain of mass M and radius R that meets the smallest ones, of radius r, at the speed v: Hertz's law for the energy that n
//! grains take up (R' the effective radius), and the way that a bed goes on into itself while its sweeps have not yet told all of it
//! that it is stopped. The constants are measured, and so is that the two add up: `docs/scene-checks.md`.

use super::Beforehand;
use super::bed::{Bed, Fall};
use crate::scene::error::{Fault, Step, short};
use crate::scene::populate::origin;
use crate::scene::{Grain, NormalLaw, Reaction, Scene};
use std::collections::BTreeMap;
use std::f64::consts::PI;

/// Fewest grains of a bed: fewer are solved to the end in a step.
pub(super) const BED: usize = 64;
/// Overlap that the step makes over the way of a step, for grains of one size.
const OF_THE_WAY: f64 = 0.75;
/// The same over the ratio of radii.
const OF_THE_RATIO: f64 = 0.1;

/// Overlap over the smaller radius at which a grain's centre is on the surface of the other.
const PASSING: f64 = 1.0;

/// The deepest overlap to be expected.
struct Impact {
    grain: usize,
    speed: f64,
    fall: f64,
    /// Overlaps over the smallest radius.
    by_stiffness: f64,
    by_step: f64,
}

/// Tells of an impact whose overlap is larger than the scene tolerates.
pub(super) fn fault(scene: &Scene, grains: &[Grain], bed: &Bed, beforehand: Option<Beforehand>) -> Option<Fault> {
    let watched = tolerated(scene)?;
    // Nobody watches while a flow is prepared, which then forgets its start; but grains must not pass each other.
    let bound = if beforehand.is_some() { watched.max(PASSING) } else { watched };
    let smallest = grains.iter().map(|grain| grain.radius).fold(f64::INFINITY, f64::min);
    let step = beforehand.map_or(scene.solver.step, |prepare| prepare.step);
    let stiffness = Stiffness::of(scene);
    let impacts = impacts(scene, grains, bed, &stiffness, smallest, step);
    let worst = impacts.max_by(|a, b| (a.by_stiffness + a.by_step).total_cmp(&(b.by_stiffness + b.by_step)))?;
    if grains.len() >= 2 && worst.by_stiffness + worst.by_step > bound {
        let problem = format!(
            "grain {} of {} m falls {} m and meets grains of {} m at {} m/s: some {} of their radius will overlap, {} of it by the \
             step of {} s",
            worst.grain,
            short(grains[worst.grain].radius),
            two(worst.fall),
            short(smallest),
            two(worst.speed),
            two(worst.by_stiffness + worst.by_step),
            two(worst.by_step),
            short(step)
        );
        // Half of what is tolerated for each of the two.
        let mut remedies = Vec::new();
        if worst.by_step > 0.5 * bound {
            let key = if beforehand.is_some() { "prepare.step" } else { "solver.step" };
            remedies.push(format!("lower {key} to {:e} s", floor(step * 0.5 * bound / worst.by_step)));
        }
        if worst.by_stiffness > 0.5 * bound {
            remedies.push(stiffness.remedy((worst.by_stiffness / (0.5 * bound)).powf(2.5)));
        }
        remedies.push("let the grains start lower".into());
        return Some(Fault::new(origin(scene, worst.grain), problem, remedies.join(", ")));
    }
    load(scene, bed, &stiffness, smallest, watched)
}

/// Longest step (s) whose part in the overlap of every impact is tolerated: what the stiffness leaves of the bound, at least half of it.
pub(super) fn longest_step(scene: &Scene, grains: &[Grain], bed: &Bed) -> f64 {
    let Some(bound) = tolerated(scene).filter(|_| grains.len() >= 2) else { return f64::INFINITY };
    let smallest = grains.iter().map(|grain| grain.radius).fold(f64::INFINITY, f64::min);
    let stiffness = Stiffness::of(scene);
    let of_a_second = impacts(scene, grains, bed, &stiffness, smallest, 1.0);
    let steps = of_a_second.filter(|impact| impact.by_step > 0.0).map(|impact| {
        let left = (bound - impact.by_stiffness).max(0.5 * bound);
        left / impact.by_step
    });
    steps.fold(f64::INFINITY, f64::min)
}

/// The impact of each grain that falls or starts with a speed, for a step (s).
fn impacts<'a>(
    scene: &'a Scene,
    grains: &'a [Grain],
    bed: &'a Bed,
    stiffness: &'a Stiffness,
    smallest: f64,
    step: f64,
) -> impl Iterator<Item = Impact> + 'a {
    let densities: BTreeMap<&str, f64> =
        scene.material.iter().map(|(name, material)| (name.as_str(), material.density)).collect();
    grains.iter().enumerate().filter_map(move |(index, grain)| {
        let start = grain.velocity.iter().map(|v| v * v).sum::<f64>().sqrt();
        let fall = match bed.falls[index] {
            Fall::Down(fall) => fall,
            Fall::Unknown => 0.0,
            Fall::Out(_) => return None,
        };
        let speed = (start * start + 2.0 * bed.gravity * fall).sqrt().min(start + bed.gravity * scene.duration);
        let mass = densities.get(grain.material.as_str())? * 4.0 / 3.0 * PI * grain.radius.powi(3);
        let ratio = grain.radius / smallest;
        let way = if grains.len() >= BED { OF_THE_WAY.max(OF_THE_RATIO * ratio) } else { 0.0 };
        Some(Impact {
            grain: index,
            speed,
            fall,
            by_stiffness: stiffness.impact(mass, speed, grain.radius, smallest) / smallest,
            by_step: way * speed * step / smallest,
        })
    })
}

/// Tells of a bed so deep that its weight alone makes too large an overlap.
fn load(scene: &Scene, bed: &Bed, stiffness: &Stiffness, smallest: f64, bound: f64) -> Option<Fault> {
    let density = scene.material.values().map(|material| material.density).fold(0.0, f64::max);
    let pressure = density * bed.gravity * bed.solid_depth;
    let force = pressure * 4.0 * smallest * smallest;
    let overlap = stiffness.rest(force, smallest) / smallest;
    (overlap > bound).then(|| {
        let problem = format!(
            "under the weight of the bed, {} Pa, grains will overlap by some {} of their radius",
            two(pressure),
            two(overlap)
        );
        let path = vec![Step::Key("material")];
        Fault::new(path, problem, stiffness.remedy((overlap / (0.5 * bound)).powf(1.5)))
    })
}

/// Largest overlap that the scene tolerates, over the smaller radius; none if it does not look.
pub(super) fn tolerated(scene: &Scene) -> Option<f64> {
    (scene.watch.every > 0 && scene.watch.on_overlap != Reaction::Ignore).then_some(scene.watch.overlap)
}

/// Of the softest contact.
enum Stiffness {
    Rigid,
    /// N/m.
    Linear(f64),
    /// Effective and Young's modulus, Pa.
    Hertz(f64, f64),
}

impl Stiffness {
    fn of(scene: &Scene) -> Stiffness {
        let effective = |modulus: f64, poisson: f64| modulus / (2.0 * (1.0 - poisson * poisson));
        let named = |name: &str| {
            let grains = scene.grain.iter().any(|grain| grain.material == name);
            grains || scene.population.iter().any(|population| population.material == name)
        };
        match scene.solver.normal_law {
            NormalLaw::Rigid => Stiffness::Rigid,
            NormalLaw::Linear { stiffness } => Stiffness::Linear(stiffness),
            NormalLaw::Hertz => {
                let materials = scene.material.iter().filter(|(name, _)| named(name)).map(|(_, material)| material);
                let moduli = materials.map(|material| {
                    (effective(material.youngs_modulus, material.poisson_ratio), material.youngs_modulus)
                });
                moduli.min_by(|a, b| a.0.total_cmp(&b.0)).map_or(Stiffness::Rigid, |(e, y)| Stiffness::Hertz(e, y))
            }
        }
    }

    /// Largest overlap (m) of a grain that falls on grains of a radius, and of these.
    fn impact(&self, mass: f64, speed: f64, radius: f64, smallest: f64) -> f64 {
        let fallen_on = (radius / smallest).powf(1.5);
        let energy = mass * speed * speed / fallen_on;
        match self {
            Stiffness::Rigid => 0.0,
            Stiffness::Linear(stiffness) => (energy / stiffness).sqrt(),
            Stiffness::Hertz(modulus, _) => {
                let effective = radius * smallest / (radius + smallest);
                (15.0 / 16.0 * energy / (modulus * effective.sqrt())).powf(0.4)
            }
        }
    }

    /// Overlap (m) of grains of a radius under a force (N).
    fn rest(&self, force: f64, radius: f64) -> f64 {
        match self {
            Stiffness::Rigid => 0.0,
            Stiffness::Linear(stiffness) => force / stiffness,
            Stiffness::Hertz(modulus, _) => (0.75 * force / (modulus * (0.5 * radius).sqrt())).powf(2.0 / 3.0),
        }
    }

    fn remedy(&self, factor: f64) -> String {
        match self {
            Stiffness::Rigid => "use stiffer grains".into(),
            Stiffness::Linear(stiffness) => {
                format!("raise the stiffness of normal_law to {:.0e} N/m", stiffness * factor)
            }
            Stiffness::Hertz(_, youngs) => format!("raise youngs_modulus to {:.0e} Pa", youngs * factor),
        }
    }
}

/// Two digits of a number.
fn two(value: f64) -> String {
    short(format!("{value:.1e}").parse().unwrap_or(value))
}

/// One digit of a number, rounded downwards.
pub(super) fn floor(value: f64) -> f64 {
    let scale = 10_f64.powf(value.log10().floor());
    format!("{:.0e}", (value / scale).floor() * scale).parse().unwrap_or(value)
}
