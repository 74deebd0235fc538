//! Stress tests: a case, its outcome in a code, and the cases that are known to fail.

use super::Evidence;
use crate::plan::Scene;
use crate::study::Finding;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;

/// A hard case.
pub struct Case {
    /// Name, unique in the catalogue.
    pub name: String,
    /// Group of cases that ask the same question.
    pub group: &'static str,
    /// What must come of it.
    pub right: String,
    /// Why: the law, derivation or publication that says so.
    pub source: &'static str,
    /// Whether it is left to the long catalogue.
    pub long: bool,
    /// Time step that explicit codes have to take too, s; they take their own where there is none.
    pub peer_step: Option<f64>,
    /// The scene.
    pub scene: Scene,
    /// Measures what came of it.
    pub judge: Judge,
}

/// Takes figures from a run, each with the bounds that it must keep.
pub type Judge = Box<dyn Fn(&Evidence<'_>) -> Vec<Finding> + Send + Sync>;

impl Case {
    /// A case of the quick catalogue in which every code takes its own time step.
    pub fn new(
        group: &'static str,
        scene: Scene,
        right: impl Into<String>,
        source: &'static str,
        judge: impl Fn(&Evidence<'_>) -> Vec<Finding> + Send + Sync + 'static,
    ) -> Case {
        Case {
            name: scene.name.clone(),
            group,
            right: right.into(),
            source,
            long: false,
            peer_step: None,
            scene,
            judge: Box::new(judge),
        }
    }

    /// The same, in the long catalogue only.
    pub fn long(self) -> Case {
        Case { long: true, ..self }
    }

    /// The same, with one time step for all codes.
    pub fn at_one_step(self) -> Case {
        Case { peer_step: Some(self.scene.solver.step), ..self }
    }
}

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

/// Each with the reason; `validation/docs/stability.md` tells more. One that does end as stated is to be taken off.
pub const KNOWN_EXCEPTIONS: [(&str, &str); 1] = [(
    "impossible-gap-rigid",
    "two rigid contacts that contradict each other have no solution: impulses grow with sweeps",
)];

/// The reason why a case is known not to end as stated; absent where it must.
pub fn known_exception(case: &str) -> Option<&'static str> {
    KNOWN_EXCEPTIONS.iter().find(|(name, _)| *name == case).map(|(_, reason)| *reason)
}
