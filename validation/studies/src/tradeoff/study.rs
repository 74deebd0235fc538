//! Study: from runs to rows. Ranking of settings: Pareto fronts, the fastest settings within the bounds, and the effect of chance on
//! that choice.

use super::campaign::Outcome;
use super::plan::{Plan, Refinement};
use super::report::findings;
use super::rows::{Bound, Convergence, Deviation, Fastest, Point, Reference, Values};
use makadam_compare::compare::MeasuredRun;
use makadam_frames::output::JSON_VERSION;
use makadam_frames::plan::MeasuredScene;
use makadam_measure::statistics::{Ensemble, mean, median, standard_error};
use rand_chacha::ChaCha8Rng;
use rand_core::{RngCore, SeedableRng};
use serde::Serialize;
use std::collections::{BTreeMap, BTreeSet};

/// Input of a study apart from its runs.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Terms {
    /// Number of seeds, counted from 1.
    pub seeds: u64,
    /// Tolerated deviations.
    pub bounds: Vec<Bound>,
    /// Wall time after which a run of another code than Makadam is stopped, s.
    pub time_limit: f64,
    /// Provenance, by name.
    pub provenance: BTreeMap<String, String>,
}

impl Terms {
    /// Tolerated deviation of an observable.
    pub(super) fn bound(&self, observable: &str) -> Option<f64> {
        self.bounds.iter().find(|bound| bound.observable == observable).map(|bound| bound.value)
    }
}

/// Accuracy and wall time of the settings of each code on one scene; its fields are documented in `validation/docs/json.md`.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[expect(missing_docs, reason = "validation/docs/json.md describes the fields of documents")]
pub struct Study {
    pub version: u32,
    pub command: String,
    pub scene: String,
    pub particles: usize,
    /// True if all planned runs have ended; failed ones count as ended.
    pub complete: bool,
    #[serde(flatten)]
    pub terms: Terms,
    /// Converged references of Makadam, one observable after the other, by stiffness.
    pub references: Vec<Reference>,
    pub points: Vec<Point>,
    /// Fastest setting within the bounds of each code at each stiffness; empty without bounds.
    pub fastest: Vec<Fastest>,
    pub findings: Vec<String>,
    pub notes: Vec<String>,
}

impl Study {
    /// Converts runs to rows.
    pub fn new(scene: &MeasuredScene, plan: &Plan, outcome: &Outcome, mut terms: Terms) -> Study {
        let names = observables(scene, plan, outcome, &terms.bounds);
        terms.bounds.retain(|bound| names.iter().any(|(name, _)| *name == bound.observable));
        let table = Table { scene, plan, outcome, names: &names, terms: &terms };
        let references = plan.refinements.iter().flat_map(|refinement| table.references(refinement)).collect();
        let mut points: Vec<Point> = (0..plan.configurations.len()).filter_map(|place| table.point(place)).collect();
        mark_fronts(&mut points, &names);
        let mut study = Study {
            version: JSON_VERSION,
            command: "tradeoff".into(),
            scene: scene.name.clone(),
            particles: scene.grain_count(),
            complete: !outcome.interrupted,
            references,
            fastest: fastest(&points, &terms.bounds),
            terms,
            points,
            findings: Vec::new(),
            notes: outcome.sentences(plan),
        };
        study.findings = findings(&study);
        study
    }

    /// Reference of an observable at a stiffness.
    pub fn reference(&self, observable: &str, stiffness_factor: f64) -> Option<&Reference> {
        self.references.iter().find(|row| row.observable == observable && row.stiffness_factor == stiffness_factor)
    }

    /// Names of the observables, bounded ones first.
    pub fn observables(&self) -> Vec<&str> {
        let bounded = self.terms.bounds.iter().map(|bound| bound.observable.as_str());
        let mut names: Vec<&str> = Vec::new();
        for name in bounded.chain(self.references.iter().map(|row| row.observable.as_str())) {
            if !names.contains(&name) {
                names.push(name);
            }
        }
        names
    }

    /// Returns true if some setting of a code, other than the reference, is within all bounds at the scene's stiffness; absent
    /// without bounds or without points of the code.
    pub fn reaches_bounds(&self, code: &str) -> Option<bool> {
        let own = |point: &&Point| point.code == code && point.stiffness_factor == 1.0 && !point.reference;
        let judged: Vec<bool> = self.points.iter().filter(own).filter_map(|point| point.within_bounds).collect();
        (!judged.is_empty()).then(|| judged.contains(&true))
    }
}

/// Names and units of the observables that are compared by the scene or bounded, if a reference has them.
fn observables(scene: &MeasuredScene, plan: &Plan, outcome: &Outcome, bounds: &[Bound]) -> Vec<(String, String)> {
    let mut names: Vec<(String, String)> = Vec::new();
    let finest = plan.refinements.iter().flat_map(|refinement| &outcome.runs[refinement.grids[2]]);
    for measurement in finest.flat_map(|run| &run.measurements) {
        let name = &measurement.observable;
        let asked = scene.compare.is_empty()
            || scene.compare.iter().any(|expectation| expectation.observable == *name)
            || bounds.iter().any(|bound| bound.observable == *name);
        if asked && !names.iter().any(|(known, _)| known == name) {
            names.push((name.clone(), measurement.unit.clone()));
        }
    }
    // In the order of the scene, which puts the most significant first.
    let rank = |name: &str| scene.compare.iter().position(|e| e.observable == name).unwrap_or(usize::MAX);
    names.sort_by_key(|(name, _)| rank(name));
    names
}

/// Input of all rows.
struct Table<'a> {
    scene: &'a MeasuredScene,
    plan: &'a Plan,
    outcome: &'a Outcome,
    /// Observables and their units.
    names: &'a [(String, String)],
    terms: &'a Terms,
}

impl Table<'_> {
    /// Young's modulus of the first grains at a stiffness, Pa.
    fn youngs_modulus(&self, factor: f64) -> f64 {
        let listed = self.scene.listed().next().map(|grain| &grain.material);
        let material = listed.or_else(|| self.scene.population.first().map(|population| &population.material));
        material.and_then(|name| self.scene.material.get(name)).map_or(f64::NAN, |m| factor * m.youngs_modulus)
    }

    fn values(&self, place: usize, observable: &str) -> Values {
        let runs = self.outcome.runs[place].iter();
        runs.filter_map(|run| Some((run.seed, run.value(observable)?))).collect()
    }

    /// Differences from the reference at a stiffness, of the seeds common to both.
    fn differences(&self, values: &Values, factor: f64, observable: &str) -> Option<Values> {
        let converged = self.values(self.plan.refinement(factor)?.grids[2], observable);
        Some(values.iter().filter_map(|(seed, value)| Some((*seed, value - converged.get(seed)?))).collect())
    }

    /// Rows of a converged reference.
    fn references(&self, refinement: &Refinement) -> Vec<Reference> {
        let configurations = refinement.grids.map(|place| &self.plan.configurations[place]);
        let factor = refinement.stiffness_factor;
        let row = |(name, unit): &(String, String)| {
            let grids = refinement.grids.map(|place| self.values(place, name));
            let fine: Vec<f64> = grids[2].values().copied().collect();
            let ensemble = Ensemble::of(&fine)?;
            // Grids are compared seed by seed.
            let is_common = |seed: &&u64| grids.iter().all(|grid| grid.contains_key(*seed));
            let seeds: Vec<&u64> = grids[2].keys().filter(is_common).collect();
            let paired = grids.each_ref().map(|grid| seeds.iter().map(|seed| grid[*seed]).collect::<Vec<f64>>());
            let convergence = Convergence::of(paired.each_ref().map(Vec::as_slice));
            let shifts = self.differences(&grids[2], 1.0, name).filter(|shifts| factor != 1.0 && !shifts.is_empty());
            let shifts: Option<Vec<f64>> = shifts.map(|shifts| shifts.into_values().collect());
            Some(Reference {
                stiffness_factor: factor,
                youngs_modulus: self.youngs_modulus(factor),
                setting: configurations[2].setting(),
                observable: name.clone(),
                unit: unit.clone(),
                seeds: ensemble.seeds,
                mean: ensemble.mean,
                standard_deviation: ensemble.standard_deviation,
                standard_error: standard_error(&fine),
                steps: configurations.map(|configuration| configuration.step().unwrap_or_default()),
                grid_means: convergence.map(|_| paired.each_ref().map(|grid| mean(grid))),
                convergence,
                shift: shifts.as_deref().map(mean),
                shift_standard_error: shifts.as_deref().and_then(standard_error),
            })
        };
        self.names.iter().filter_map(row).collect()
    }

    /// Row of a configuration; absent if it has not run.
    fn point(&self, place: usize) -> Option<Point> {
        let configuration = &self.plan.configurations[place];
        let runs = &self.outcome.runs[place];
        let first = runs.first()?;
        let pace = || runs.iter().map(MeasuredRun::pace);
        let deviations: Vec<Deviation> =
            self.names.iter().filter_map(|(name, unit)| self.deviation(place, name, unit)).collect();
        let failed = self.outcome.failures.contains_key(&place);
        let verdict = |part: fn(&Deviation) -> Option<bool>| {
            let each = self.terms.bounds.iter().map(|bound| {
                deviations.iter().find(|deviation| deviation.observable == bound.observable).and_then(part)
            });
            let all: Option<Vec<bool>> = each.collect();
            all.filter(|all| !all.is_empty()).map(|all| !all.contains(&false) && !failed)
        };
        Some(Point {
            code: configuration.code.clone(),
            version: first.version.clone(),
            setting: configuration.setting(),
            stiffness_factor: configuration.stiffness_factor,
            youngs_modulus: self.youngs_modulus(configuration.stiffness_factor),
            time_step: first.time_step,
            rayleigh_fraction: configuration.rayleigh_fraction(),
            sweeps: configuration.sweeps(),
            variation: configuration.variation().map(String::from),
            seeds: runs.iter().map(|run| run.seed).collect(),
            wall_seconds_per_simulated_second: median(pace()),
            wall_seconds_per_simulated_second_least: pace().fold(f64::INFINITY, f64::min),
            wall_seconds_per_simulated_second_most: pace().fold(0.0, f64::max),
            simulated_seconds: first.simulated_seconds,
            reference: self.plan.refinements.iter().any(|refinement| refinement.grids[2] == place),
            failed,
            within_bounds: verdict(|deviation| deviation.within),
            intervals_within_bounds: verdict(|deviation| deviation.interval_within),
            deviations,
        })
    }

    fn deviation(&self, place: usize, observable: &str, unit: &str) -> Option<Deviation> {
        let factor = self.plan.configurations[place].stiffness_factor;
        let own = self.values(place, observable);
        let differences = self.differences(&own, factor, observable)?;
        let shared: Vec<f64> = differences.keys().map(|seed| own[seed]).collect();
        let ensemble = Ensemble::of(&differences.values().copied().collect::<Vec<f64>>())?;
        let bound = self.terms.bound(observable);
        // The reference's deviation is zero by definition, and carries no information on its interval.
        let is_reference = self.plan.refinement(factor)?.grids[2] == place;
        let interval90 = ensemble.interval90().filter(|_| !is_reference);
        Some(Deviation {
            observable: observable.into(),
            unit: unit.into(),
            seeds: ensemble.seeds,
            mean: mean(&shared),
            standard_error: standard_error(&shared),
            deviation: ensemble.mean,
            deviation_standard_error: interval90.map(|_| ensemble.standard_deviation / (ensemble.seeds as f64).sqrt()),
            interval90,
            bound,
            within: bound.map(|bound| ensemble.mean.abs() <= bound),
            interval_within: bound.and_then(|bound| interval90.map(|[low, high]| -bound <= low && high <= bound)),
            on_front: false,
            differences,
        })
    }
}

/// Indices of the points of each code and stiffness, in the order of the plan.
fn groups(points: &[Point]) -> Vec<Vec<usize>> {
    let mut groups: Vec<Vec<usize>> = Vec::new();
    for (place, point) in points.iter().enumerate() {
        let is_own = |group: &&mut Vec<usize>| {
            let first = &points[group[0]];
            first.code == point.code && first.stiffness_factor == point.stiffness_factor
        };
        match groups.iter_mut().find(is_own) {
            Some(group) => group.push(place),
            None => groups.push(vec![place]),
        }
    }
    groups
}

/// Marks the Pareto front of every code and observable at every stiffness. The reference is not a point of it: its error
/// is zero by definition.
fn mark_fronts(points: &mut [Point], names: &[(String, String)]) {
    for group in groups(points) {
        for (name, _) in names {
            let ranked = |place: &usize| Some(&points[*place]).filter(|point| !point.reference && !point.failed);
            let member = |place| {
                let point = ranked(&place)?;
                let Deviation { deviation, deviation_standard_error, .. } = point.deviation(name)?;
                let coordinates = [point.wall_seconds_per_simulated_second, deviation.abs()];
                Some((place, coordinates, *deviation_standard_error))
            };
            let members: Vec<(usize, [f64; 2], Option<f64>)> = group.iter().copied().filter_map(member).collect();
            // Seed noise: the smallest error that can be distinguished from zero.
            let noise = median(members.iter().filter_map(|member| member.2));
            let coordinates: Vec<[f64; 2]> = members.iter().map(|member| member.1).collect();
            for place in pareto_front(&coordinates, if noise.is_finite() { noise } else { 0.0 }) {
                let point = &mut points[members[place].0];
                point.deviations.iter_mut().filter(|d| d.observable == *name).for_each(|d| d.on_front = true);
            }
        }
    }
}

/// Fastest setting within all bounds, by stiffness and code in the order of the plan.
fn fastest(points: &[Point], bounds: &[Bound]) -> Vec<Fastest> {
    if bounds.is_empty() {
        return Vec::new();
    }
    let row = |group: &Vec<usize>| {
        let first = &points[group[0]];
        let best = fastest_within(group.iter().map(|&place| &points[place]));
        let makadam = points.iter().filter(|point| point.is_of("Makadam", first.stiffness_factor));
        let wall = best.map(|best| best.wall_seconds_per_simulated_second);
        let other = fastest_within(makadam).map(|best| best.wall_seconds_per_simulated_second);
        Fastest {
            code: first.code.clone(),
            stiffness_factor: first.stiffness_factor,
            youngs_modulus: first.youngs_modulus,
            setting: best.map(|best| best.setting.clone()),
            wall_seconds_per_simulated_second: wall,
            intervals_within_bounds: best.and_then(|best| best.intervals_within_bounds),
            ratio_to_makadam: wall.zip(other).map(|(own, makadam)| own / makadam),
            ratio_low: None,
            ratio_high: None,
        }
    };
    let mut rows: Vec<Fastest> = groups(points).iter().map(row).collect();
    fill_intervals(&mut rows, points, bounds);
    rows.sort_by(|a, b| a.stiffness_factor.total_cmp(&b.stiffness_factor));
    rows
}

/// Returns the fastest of some points that are within all bounds.
fn fastest_within<'a>(points: impl Iterator<Item = &'a Point>) -> Option<&'a Point> {
    let pace = |point: &Point| point.wall_seconds_per_simulated_second;
    points.filter(|point| point.within_bounds == Some(true)).min_by(|a, b| pace(a).total_cmp(&pace(b)))
}

/// Indices of the points of the Pareto front, from the cheapest to the most accurate.
///
/// A point is a wall time and an error. Errors below `floor`, the error of the reference itself, count as equal to it: the cheapest
/// of these points ends the front.
pub fn pareto_front(points: &[[f64; 2]], floor: f64) -> Vec<usize> {
    let error = |place: &usize| points[*place][1].max(floor);
    let mut order: Vec<usize> =
        (0..points.len()).filter(|&place| points[place].iter().all(|x| x.is_finite())).collect();
    order.sort_by(|a, b| points[*a][0].total_cmp(&points[*b][0]).then(error(a).total_cmp(&error(b))));
    let mut least = f64::INFINITY;
    order.retain(|place| {
        let better = error(place) < least;
        least = least.min(error(place));
        better
    });
    order
}

/// Number of samples of the seeds.
const SAMPLES: usize = 2_000;

/// Fraction of the samples outside the interval, at either end.
const TAIL: f64 = 0.05;

/// Returns true if the mean deviations of a point over a sample of seeds are within all bounds.
fn keeps_bounds(point: &Point, bounds: &[Bound], sample: &[u64]) -> bool {
    !point.failed
        && bounds.iter().all(|bound| {
            let differences = point.deviation(&bound.observable).map(|deviation| &deviation.differences);
            let values: Vec<f64> = sample.iter().filter_map(|seed| differences?.get(seed).copied()).collect();
            !values.is_empty() && mean(&values).abs() <= bound.value
        })
}

/// Fills in the intervals of the ratios: seeds are drawn with replacement, the same for every configuration, since all start from
/// the same grains. Each sample has its own fastest settings, and a code that has none is slower than any number (percentile
/// bootstrap, Efron and Tibshirani, An Introduction to the Bootstrap, 1993, chapter 13).
fn fill_intervals(rows: &mut [Fastest], points: &[Point], bounds: &[Bound]) {
    let deviations = points.iter().filter(|point| !point.failed).flat_map(|point| &point.deviations);
    let bounded = deviations.filter(|deviation| deviation.bound.is_some());
    let seeds: BTreeSet<u64> = bounded.flat_map(|deviation| deviation.differences.keys().copied()).collect();
    let seeds: Vec<u64> = seeds.into_iter().collect();
    if seeds.len() < 2 {
        return;
    }
    let mut random = ChaCha8Rng::seed_from_u64(1);
    let mut ratios: Vec<Vec<f64>> = vec![Vec::with_capacity(SAMPLES); rows.len()];
    for _ in 0..SAMPLES {
        let sample: Vec<u64> = seeds.iter().map(|_| seeds[(random.next_u64() % seeds.len() as u64) as usize]).collect();
        let kept: Vec<&Point> = points.iter().filter(|point| keeps_bounds(point, bounds, &sample)).collect();
        let least = |code: &str, factor: f64| {
            let own = kept.iter().filter(|point| point.is_of(code, factor));
            own.map(|point| point.wall_seconds_per_simulated_second).fold(f64::INFINITY, f64::min)
        };
        for (row, ratios) in rows.iter().zip(&mut ratios) {
            ratios.push(least(&row.code, row.stiffness_factor) / least("Makadam", row.stiffness_factor));
        }
    }
    for (row, mut ratios) in rows.iter_mut().zip(ratios) {
        if row.code == "Makadam" || ratios.iter().any(|ratio| ratio.is_nan()) {
            continue;
        }
        ratios.sort_by(f64::total_cmp);
        let at = |share: f64| Some(ratios[(share * (SAMPLES - 1) as f64).round() as usize]).filter(|r| r.is_finite());
        [row.ratio_low, row.ratio_high] = [at(TAIL), at(1.0 - TAIL)];
    }
}
