//! What came of the cases.

use super::Case;
use crate::study::Finding;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;

/// How a case ended in one code.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Verdict {
    /// Every figure keeps its bounds.
    AsStated,
    /// A figure leaves its bounds.
    NotAsStated,
    /// The run broke off, lost grains, gave something that is not a number, or energy from nowhere.
    Crashed,
    /// The run was stopped at its time limit.
    TookTooLong,
    /// The code has no words for the scene.
    CannotBeExpressed,
}

impl Verdict {
    /// The verdict in words.
    pub fn words(self) -> &'static str {
        match self {
            Verdict::AsStated => "as stated",
            Verdict::NotAsStated => "not as stated",
            Verdict::Crashed => "crashed or NaN",
            Verdict::TookTooLong => "took too long",
            Verdict::CannotBeExpressed => "cannot be expressed",
        }
    }
}

/// How one case ended in one code.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Outcome {
    /// Name of the code.
    pub code: String,
    /// How it ended.
    pub verdict: Verdict,
    /// What was measured; empty where there was nothing to measure.
    pub findings: Vec<Finding>,
    /// Why there was nothing to measure.
    pub reason: Option<String>,
    /// Time step of the run, s; none where it did not end.
    pub time_step: Option<f64>,
    /// Wall time, s.
    pub wall_seconds: f64,
}

impl Outcome {
    /// The figure that tells most: the one furthest outside its bounds, or the first.
    pub fn telling(&self) -> Option<&Finding> {
        let worst = self.findings.iter().max_by(|a, b| a.excess().total_cmp(&b.excess()))?;
        if worst.holds() { self.findings.first() } else { Some(worst) }
    }
}

/// One case and how it ended in every code that was asked.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct CaseResult {
    /// Name of the case.
    pub name: String,
    /// Its group.
    pub group: &'static str,
    /// What must come of it.
    pub right: String,
    /// Why.
    pub source: &'static str,
    /// Whether it belongs to the long catalogue only.
    pub long: bool,
    /// Hash of the scene, 16 hexadecimal digits.
    pub scene_hash: String,
    /// By code, in the order of the columns.
    pub outcomes: Vec<Outcome>,
}

impl CaseResult {
    /// A case with its outcomes.
    pub fn new(case: &Case, outcomes: Vec<Outcome>) -> CaseResult {
        CaseResult {
            name: case.name.clone(),
            group: case.group,
            right: case.right.clone(),
            source: case.source,
            long: case.long,
            scene_hash: format!("{:016x}", crate::provenance::scene_hash(&case.scene)),
            outcomes,
        }
    }
}

/// Everything that a run of `makadam stability` found.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Study {
    /// Version of this document.
    pub version: u32,
    /// Always "stability".
    pub command: &'static str,
    /// Whether all cases ended as stated in Makadam.
    pub as_stated: bool,
    /// The cases that are finished, in the order of the catalogue.
    pub cases: Vec<CaseResult>,
    /// Names of the cases that are not.
    pub unfinished: Vec<String>,
    /// Version of each code that ran.
    pub codes: BTreeMap<String, String>,
    /// Wall time after which a run was stopped, s.
    pub time_limit: f64,
    /// Where the numbers came from, by name.
    pub provenance: BTreeMap<String, String>,
}

impl Study {
    /// Whether all cases that ran in Makadam ended as stated.
    pub fn all_as_stated(cases: &[CaseResult]) -> bool {
        let outcomes = cases.iter().flat_map(|case| &case.outcomes).filter(|outcome| outcome.code == "Makadam");
        outcomes.map(|outcome| outcome.verdict).all(|verdict| verdict == Verdict::AsStated)
    }
}
