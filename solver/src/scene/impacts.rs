//! Restitution that falls with the speed of impact needs impacts that are over within a step: whether a scene has those.

use super::error::{Fault, Step};
use super::{NormalLaw, Scene};
use crate::effects::compliance::{NormalContact, NormalScheme, damping_ratio, effective_radius};
use nalgebra::Vector3;
use std::collections::BTreeMap;

impl Scene {
    /// The largest grains are the softest against their inertia, and the slowest impacts that matter the longest.
    pub(super) fn resolved_impact(&self) -> Option<Fault> {
        if self.solver.normal_law == NormalLaw::Rigid {
            return None;
        }
        let mut largest: BTreeMap<&str, f64> = BTreeMap::new();
        let populations = self.population.iter().filter(|group| group.count > 0);
        let groups = populations.map(|group| (group.material.as_str(), group.radius.bounds().1));
        for (name, radius) in groups.chain(self.grain.iter().map(|grain| (grain.material.as_str(), grain.radius))) {
            let known = largest.entry(name).or_default();
            *known = known.max(radius);
        }
        let grains = || largest.iter().map(|(name, radius)| (*name, Some(*radius)));
        let walls = self.wall.iter().map(|wall| (wall.material.as_str(), None));
        let partners: Vec<(&str, Option<f64>)> = grains().chain(walls).collect();
        let pairs = largest.iter().flat_map(|first| partners.iter().map(move |second| (first, second)));
        pairs.into_iter().find_map(|((first, radius), (second, other))| self.resolved(first, *radius, second, *other))
    }

    /// Speed (m/s) from which on an impact that the step does not resolve has its restitution: see [`SolverSettings::slowest_impact`],
    /// here with the mean of the radii that the scene gives.
    ///
    /// [`SolverSettings::slowest_impact`]: super::SolverSettings::slowest_impact
    pub fn slowest_impact(&self) -> f64 {
        let placed = self.population.iter().map(|group| (group.count as f64, group.radius.mean()));
        let all = placed.chain(self.grain.iter().map(|grain| (1.0, grain.radius)));
        let (count, sum) = all.fold((0.0, 0.0), |(count, sum), (own, radius)| (count + own, sum + own * radius));
        self.solver.slowest_impact(sum / f64::max(count, 1.0), self.gravity_field().largest())
    }

    /// The fault of impacts of a grain of a radius (m) and another one, or a wall.
    fn resolved(&self, first: &str, radius: f64, second: &str, other: Option<f64>) -> Option<Fault> {
        let pair = self.contact_coefficients(first, second, other.is_none());
        if !pair.restitution_speed.is_finite() {
            return None;
        }
        let settings = &self.solver;
        let scheme = NormalScheme {
            law: settings.normal_law,
            step: settings.step,
            damping_steps: settings.damping_steps,
            restitution_threshold: self.slowest_impact(),
            gravity: Vector3::from(self.gravity).norm(),
        };
        let (one, two) = (&self.material[first], &self.material[second]);
        let softness = |poisson: f64, modulus: f64| (1.0 - poisson * poisson) / modulus;
        let both = softness(one.poisson_ratio, one.youngs_modulus) + softness(two.poisson_ratio, two.youngs_modulus);
        let inverse_mass =
            |density: f64, radius: f64| 0.75 / (std::f64::consts::PI * density * radius * radius * radius);
        // What closes slower is at rest.
        let speed = pair.restitution_speed.max(scheme.restitution_threshold);
        let impact = NormalContact {
            overlap: 0.0,
            velocity: -speed,
            effective_modulus: 1.0 / both,
            effective_radius: other.map_or(radius, |other| effective_radius(radius, other)),
            inverse_mass: inverse_mass(one.density, radius)
                + other.map_or(0.0, |other| inverse_mass(two.density, other)),
            damping_ratio: damping_ratio(pair.restitution),
        };
        let resolved = impact.constraint(&scheme, speed).resolves_impact;
        resolved.then(|| {
            let problem = format!(
                "restitution_speed: the step of {:e} s resolves an impact of '{first}' and '{second}' at {speed} m/s, whose \
                 restitution is that of its damping at any speed",
                settings.step
            );
            let remedy = "use normal_law = { kind = 'rigid' }, a longer step or a higher youngs_modulus";
            Fault::new(self.says_restitution_speed(first, second), problem, remedy)
        })
    }

    /// Where the scene gives the speed of a pair.
    fn says_restitution_speed(&self, first: &str, second: &str) -> Vec<Step> {
        let names =
            |rule: &[String; 2]| (rule[0] == first && rule[1] == second) || (rule[0] == second && rule[1] == first);
        let rule = self.pair.iter().position(|rule| rule.restitution_speed.is_some() && names(&rule.between));
        let table = match rule {
            Some(index) => [Step::Key("pair"), Step::Index(index)],
            None => {
                let own = self.material[second].restitution_speed.is_some();
                [Step::Key("material"), Step::Name(if own { second } else { first }.to_string())]
            }
        };
        table.into_iter().chain([Step::Key("restitution_speed")]).collect()
    }
}
