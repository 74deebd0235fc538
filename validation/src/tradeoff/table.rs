//! From runs to rows: references, points and their deviations.

use super::campaign::Outcome;
use super::chance::Candidate;
use super::convergence::Convergence;
use super::kept::KeptRun;
use super::plan::{Plan, Refinement};
use super::rows::{Bound, Deviation, Point, Reference};
use crate::plan::Scene;
use crate::statistics::median;
use crate::statistics::{Ensemble, mean, standard_error};
use std::collections::BTreeMap;

/// Values of one observable by seed.
type Values = BTreeMap<u64, f64>;

/// Everything that rows are made from.
pub(super) struct Table<'a> {
    pub(super) scene: &'a Scene,
    pub(super) plan: &'a Plan,
    pub(super) outcome: &'a Outcome,
    /// Observables and their units.
    pub(super) names: &'a [(String, String)],
    pub(super) bounds: &'a [Bound],
}

impl Table<'_> {
    /// Young's modulus of the first grains at a stiffness, Pa.
    fn youngs_modulus(&self, factor: f64) -> f64 {
        let listed = self.scene.grain.first().map(|grain| &grain.material);
        let material = listed.or_else(|| self.scene.population.first().map(|population| &population.material));
        material.and_then(|name| self.scene.material.get(name)).map_or(f64::NAN, |m| factor * m.youngs_modulus)
    }

    fn values(&self, place: usize, observable: &str) -> Values {
        let runs = self.outcome.runs[place].iter();
        runs.filter_map(|kept| Some((kept.run.seed, kept.run.value(observable)?))).collect()
    }

    /// The rows of a converged reference.
    pub(super) fn references(&self, refinement: &Refinement) -> Vec<Reference> {
        let configurations = refinement.grids.map(|place| &self.plan.configurations[place]);
        let home = self.plan.refinement(1.0).filter(|_| refinement.stiffness_factor != 1.0);
        let row = |(name, unit): &(String, String)| {
            let grids = refinement.grids.map(|place| self.values(place, name));
            let fine: Vec<f64> = grids[2].values().copied().collect();
            let ensemble = Ensemble::of(&fine)?;
            // Grids are compared seed by seed.
            let common = grids[2].keys().filter(|seed| grids.iter().all(|grid| grid.contains_key(seed)));
            let seeds: Vec<u64> = common.copied().collect();
            let paired = [0, 1, 2].map(|grid| seeds.iter().map(|seed| grids[grid][seed]).collect::<Vec<f64>>());
            let convergence = Convergence::of([&paired[0], &paired[1], &paired[2]]);
            let shifts = home.map(|home| differences(&grids[2], &self.values(home.grids[2], name)));
            Some(Reference {
                stiffness_factor: refinement.stiffness_factor,
                youngs_modulus: self.youngs_modulus(refinement.stiffness_factor),
                setting: configurations[2].setting(),
                observable: name.clone(),
                unit: unit.clone(),
                seeds: ensemble.seeds,
                mean: ensemble.mean,
                standard_deviation: ensemble.standard_deviation,
                standard_error: standard_error(&fine),
                steps: configurations.map(|configuration| configuration.step().unwrap_or_default()),
                grid_means: convergence.is_some().then(|| [0, 1, 2].map(|grid| mean(&paired[grid]))),
                convergence,
                shift: shifts.as_ref().filter(|shifts| !shifts.is_empty()).map(|shifts| mean(shifts)),
                shift_standard_error: shifts.and_then(|shifts| standard_error(&shifts)),
            })
        };
        self.names.iter().filter_map(row).collect()
    }

    /// The row of a configuration; absent if it has not run.
    pub(super) fn point(&self, place: usize) -> Option<Point> {
        let configuration = &self.plan.configurations[place];
        let runs = &self.outcome.runs[place];
        let first = runs.first()?;
        let pace: Vec<f64> = runs.iter().map(KeptRun::pace).collect();
        let deviations: Vec<Deviation> =
            self.names.iter().filter_map(|(name, unit)| self.deviation(place, name, unit)).collect();
        let verdict = |part: fn(&Deviation) -> Option<bool>| {
            let each = self.bounds.iter().map(|bound| {
                deviations.iter().find(|deviation| deviation.observable == bound.observable).and_then(part)
            });
            let all: Option<Vec<bool>> = each.collect();
            all.filter(|all| !all.is_empty()).map(|all| !all.contains(&false))
        };
        let failed = self.outcome.failures.contains_key(&place);
        Some(Point {
            code: configuration.code.clone(),
            version: first.run.version.clone(),
            setting: configuration.setting(),
            short_setting: configuration.short_setting(),
            stiffness_factor: configuration.stiffness_factor,
            youngs_modulus: self.youngs_modulus(configuration.stiffness_factor),
            time_step: first.run.time_step,
            rayleigh_fraction: configuration.rayleigh_fraction(),
            sweeps: configuration.sweeps(),
            variation: configuration.variation().map(String::from),
            seeds: runs.iter().map(|kept| kept.run.seed).collect(),
            wall_seconds_per_simulated_second: median(pace.iter().copied()),
            wall_seconds_per_simulated_second_least: pace.iter().copied().fold(f64::INFINITY, f64::min),
            wall_seconds_per_simulated_second_most: pace.iter().copied().fold(0.0, f64::max),
            core_share_least: runs.iter().filter_map(|kept| kept.core_share).reduce(f64::min),
            simulated_seconds: first.run.simulated_seconds,
            extrapolated: runs.iter().any(|kept: &KeptRun| kept.extrapolated),
            reference: self.plan.refinements.iter().any(|refinement| refinement.grids[2] == place),
            failed,
            within_bounds: verdict(|deviation| deviation.within).map(|within| within && !failed),
            intervals_within_bounds: verdict(|deviation| deviation.interval_within).map(|within| within && !failed),
            deviations,
        })
    }

    /// A configuration that could be the fastest of its code; absent if it has failed or was cut short, or without bounds.
    pub(super) fn candidate(&self, place: usize) -> Option<Candidate> {
        let configuration = &self.plan.configurations[place];
        let runs = &self.outcome.runs[place];
        let failed = self.outcome.failures.contains_key(&place);
        if failed || runs.is_empty() || self.bounds.is_empty() || runs.iter().any(|kept| kept.extrapolated) {
            return None;
        }
        let reference = self.plan.refinement(configuration.stiffness_factor)?.grids[2];
        let differences = self.bounds.iter().map(|bound| {
            let converged = self.values(reference, &bound.observable);
            (by_seed(&self.values(place, &bound.observable), &converged), bound.value)
        });
        Some(Candidate {
            code: configuration.code.clone(),
            stiffness_factor: configuration.stiffness_factor,
            pace: median(runs.iter().map(KeptRun::pace)),
            differences: differences.collect(),
        })
    }

    fn deviation(&self, place: usize, observable: &str, unit: &str) -> Option<Deviation> {
        let factor = self.plan.configurations[place].stiffness_factor;
        let reference = self.plan.refinement(factor)?.grids[2];
        let (own, converged) = (self.values(place, observable), self.values(reference, observable));
        let shared: Vec<f64> =
            own.iter().filter(|(seed, _)| converged.contains_key(seed)).map(|(_, value)| *value).collect();
        let ensemble = Ensemble::of(&differences(&own, &converged))?;
        let at_home = self.plan.refinement(1.0).filter(|_| factor != 1.0);
        let from_scene = at_home.map(|home| differences(&own, &self.values(home.grids[2], observable)));
        let bound = self.bounds.iter().find(|bound| bound.observable == observable).map(|bound| bound.value);
        // The reference's deviation is zero by definition, and says nothing of its interval.
        let interval90 = ensemble.interval90().filter(|_| place != reference);
        Some(Deviation {
            observable: observable.into(),
            unit: unit.into(),
            seeds: ensemble.seeds,
            mean: mean(&shared),
            standard_error: standard_error(&shared),
            deviation: ensemble.mean,
            deviation_standard_error: interval90.map(|_| ensemble.standard_deviation / (ensemble.seeds as f64).sqrt()),
            interval90,
            deviation_from_scene: from_scene.filter(|shifts| !shifts.is_empty()).map(|shifts| mean(&shifts)),
            bound,
            within: bound.map(|bound| ensemble.mean.abs() <= bound),
            interval_within: bound.and_then(|bound| interval90.map(|[low, high]| -bound <= low && high <= bound)),
            on_front: false,
        })
    }
}

/// Differences of the seeds that both have, by seed.
fn by_seed(first: &Values, second: &Values) -> Values {
    first.iter().filter_map(|(seed, value)| Some((*seed, value - second.get(seed)?))).collect()
}

/// The same in the order of seeds.
fn differences(first: &Values, second: &Values) -> Vec<f64> {
    by_seed(first, second).into_values().collect()
}
