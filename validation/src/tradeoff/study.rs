//! A trade-off: what the runs say, in rows.

use super::campaign::Outcome;
use super::chance::{Candidate, fill_intervals};
use super::plan::Plan;
use super::ranking::{fastest, mark_fronts, variations};
use super::rows::{Bound, Fastest, Point, Reference, Varied};
use super::table::Table;
use crate::output::JSON_VERSION;
use crate::plan::Scene;
use serde::Serialize;
use std::collections::BTreeMap;

/// What a study is told beside its runs.
#[derive(Clone, Debug, PartialEq)]
pub struct Terms {
    /// Whether few configurations were asked for.
    pub quick: bool,
    /// Number of seeds, counted from 1.
    pub seeds: u64,
    /// Tolerated deviations.
    pub bounds: Vec<Bound>,
    /// Wall time beyond which a run is cut short, s.
    pub time_limit: f64,
    /// Where it came from, by name.
    pub provenance: BTreeMap<String, String>,
}

/// What accuracy costs in time on one scene; its fields are documented in `validation/docs/json.md`.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Study {
    /// [`JSON_VERSION`].
    pub version: u32,
    /// Always "tradeoff".
    pub command: String,
    /// Name of the scene.
    pub scene: String,
    /// Number of grains.
    pub particles: usize,
    /// Whether everything that was planned has run; what failed counts as run.
    pub complete: bool,
    /// Whether few configurations were asked for.
    pub quick: bool,
    /// Number of seeds, counted from 1.
    pub seeds: u64,
    /// Wall time beyond which a run was cut short, s.
    pub time_limit: f64,
    /// Tolerated deviations of observables that were measured.
    pub bounds: Vec<Bound>,
    /// Converged references of Makadam, an observable after the other, by stiffness.
    pub references: Vec<Reference>,
    /// Configurations that have run.
    pub points: Vec<Point>,
    /// The fastest setting within the bounds of each code at each stiffness; empty without bounds.
    pub fastest: Vec<Fastest>,
    /// What Makadam's solver does with another method, precision, warm start or other sweeps, at the scene's stiffness; empty
    /// where none was run.
    pub variations: Vec<Varied>,
    /// What was found, as sentences.
    pub findings: Vec<String>,
    /// What a reader must know: runs that failed, files that were damaged.
    pub notes: Vec<String>,
    /// Where it came from.
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
        Study {
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
        }
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

    /// Whether some setting of a code, other than the reference, keeps all bounds at the scene's stiffness; absent
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
