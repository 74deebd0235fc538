//! The study: from runs to rows.

use super::campaign::{KeptRun, Outcome};
use super::plan::{Plan, Refinement};
use super::ranking::{Candidate, fastest, fill_intervals, mark_fronts, variations};
use super::report::findings;
use super::rows::{Bound, Convergence, Deviation, Fastest, Point, Reference, Varied};
use makadam_frames::output::JSON_VERSION;
use makadam_frames::plan::Scene;
use makadam_measure::statistics::{Ensemble, mean, median, standard_error};
use serde::Serialize;
use std::collections::BTreeMap;

/// Input of a study apart from its runs.
#[derive(Clone, Debug, PartialEq)]
pub struct Terms {
    /// True if few configurations were asked for.
    pub quick: bool,
    /// Number of seeds, counted from 1.
    pub seeds: u64,
    /// Tolerated deviations.
    pub bounds: Vec<Bound>,
    /// Wall time beyond which a run is cut short, s.
    pub time_limit: f64,
    /// Provenance, by name.
    pub provenance: BTreeMap<String, String>,
}

/// Accuracy and wall time of the settings of each code on one scene; its fields are documented in `validation/docs/json.md`.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[expect(missing_docs, reason = "validation/docs/json.md describes the fields of documents")]
pub struct Study {
    pub version: u32,
    pub command: String,
    pub scene: String,
    pub particles: usize,
    /// True if everything that was planned has run; what failed counts as run.
    pub complete: bool,
    pub quick: bool,
    pub seeds: u64,
    /// Wall time beyond which a run was cut short, s.
    pub time_limit: f64,
    pub bounds: Vec<Bound>,
    /// Converged references of Makadam, an observable after the other, by stiffness.
    pub references: Vec<Reference>,
    pub points: Vec<Point>,
    /// The fastest setting within the bounds of each code at each stiffness; empty without bounds.
    pub fastest: Vec<Fastest>,
    pub variations: Vec<Varied>,
    pub findings: Vec<String>,
    pub notes: Vec<String>,
    pub provenance: BTreeMap<String, String>,
}

impl Study {
    /// Puts runs into rows.
    pub fn new(scene: &Scene, plan: &Plan, outcome: &Outcome, terms: Terms) -> Study {
        let names = observables(scene, plan, outcome, &terms.bounds);
        let known = |bound: &Bound| names.iter().any(|(name, _)| *name == bound.observable);
        let bounds: Vec<Bound> = terms.bounds.into_iter().filter(known).collect();
        let table = Table { scene, plan, outcome, names: &names, bounds: &bounds };
        let references = plan.refinements.iter().flat_map(|refinement| table.references(refinement)).collect();
        let mut points: Vec<Point> = (0..plan.configurations.len()).filter_map(|place| table.point(place)).collect();
        mark_fronts(&mut points, &names);
        let mut fastest = fastest(&points, &bounds);
        let candidates: Vec<Candidate> =
            (0..plan.configurations.len()).filter_map(|place| table.candidate(place)).collect();
        fill_intervals(&mut fastest, &candidates);
        let mut study = Study {
            version: JSON_VERSION,
            command: "tradeoff".into(),
            scene: scene.name.clone(),
            particles: scene.grain_count(),
            complete: !outcome.interrupted,
            quick: terms.quick,
            seeds: terms.seeds,
            time_limit: terms.time_limit,
            references,
            fastest,
            variations: variations(&points),
            points,
            bounds,
            findings: Vec::new(),
            notes: outcome.sentences(plan),
            provenance: terms.provenance,
        };
        study.findings = findings(&study);
        study
    }

    /// Stiffness factors of the study, rising.
    pub fn stiffness_factors(&self) -> Vec<f64> {
        let mut factors: Vec<f64> = self.points.iter().map(|point| point.stiffness_factor).collect();
        factors.sort_by(f64::total_cmp);
        factors.dedup();
        factors
    }

    /// The reference of an observable at a stiffness.
    pub fn reference(&self, observable: &str, stiffness_factor: f64) -> Option<&Reference> {
        self.references.iter().find(|row| row.observable == observable && row.stiffness_factor == stiffness_factor)
    }

    /// Names of the observables, bounded ones first.
    pub fn observables(&self) -> Vec<&str> {
        let bounded = self.bounds.iter().map(|bound| bound.observable.as_str());
        let mut names: Vec<&str> = Vec::new();
        for name in bounded.chain(self.references.iter().map(|row| row.observable.as_str())) {
            if !names.contains(&name) {
                names.push(name);
            }
        }
        names
    }

    /// True if some setting of a code, other than the reference, keeps all bounds at the scene's stiffness; absent
    /// without bounds or without points of the code.
    pub fn reaches_bounds(&self, code: &str) -> Option<bool> {
        let own = |point: &&Point| point.code == code && point.stiffness_factor == 1.0 && !point.reference;
        let judged: Vec<bool> = self.points.iter().filter(own).filter_map(|point| point.within_bounds).collect();
        (!judged.is_empty()).then(|| judged.contains(&true))
    }
}

/// Names and units of what is compared: what the scene compares and what is bounded, as far as a reference has it.
fn observables(scene: &Scene, plan: &Plan, outcome: &Outcome, bounds: &[Bound]) -> Vec<(String, String)> {
    let mut names: Vec<(String, String)> = Vec::new();
    let finest = plan.refinements.iter().flat_map(|refinement| &outcome.runs[refinement.grids[2]]);
    for measurement in finest.flat_map(|kept| &kept.run.measurements) {
        let name = &measurement.observable;
        let asked = scene.compare.is_empty()
            || scene.compare.iter().any(|expectation| expectation.observable == *name)
            || bounds.iter().any(|bound| bound.observable == *name);
        if asked && !names.iter().any(|(known, _)| known == name) {
            names.push((name.clone(), measurement.unit.clone()));
        }
    }
    // In the order of the scene, which puts the most telling first.
    let rank = |name: &str| scene.compare.iter().position(|e| e.observable == name).unwrap_or(usize::MAX);
    names.sort_by_key(|(name, _)| rank(name));
    names
}

/// Values of one observable by seed.
type Values = BTreeMap<u64, f64>;

/// Everything that rows are made from.
struct Table<'a> {
    scene: &'a Scene,
    plan: &'a Plan,
    outcome: &'a Outcome,
    /// Observables and their units.
    names: &'a [(String, String)],
    bounds: &'a [Bound],
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
    fn references(&self, refinement: &Refinement) -> Vec<Reference> {
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
    fn point(&self, place: usize) -> Option<Point> {
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
    fn candidate(&self, place: usize) -> Option<Candidate> {
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

/// Differences in the order of seeds.
fn differences(first: &Values, second: &Values) -> Vec<f64> {
    by_seed(first, second).into_values().collect()
}
