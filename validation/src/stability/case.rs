//! One hard case: what is simulated, what must come of it and why, and how that is measured.

use super::Evidence;
use crate::plan::Scene;
use serde::Serialize;

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

/// A figure that was measured, and the bounds that the right outcome sets for it.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Finding {
    /// What was measured.
    pub what: String,
    /// Its unit; empty for a number.
    pub unit: &'static str,
    /// The figure.
    pub value: f64,
    /// Least right value; minus infinity where there is none.
    pub low: f64,
    /// Largest right value; infinity where there is none.
    pub high: f64,
}

impl Finding {
    /// A figure between two bounds.
    pub fn between(what: impl Into<String>, unit: &'static str, value: f64, low: f64, high: f64) -> Finding {
        Finding { what: what.into(), unit, value, low, high }
    }

    /// A figure that may deviate by so much from a target.
    pub fn near(what: impl Into<String>, unit: &'static str, value: f64, target: f64, deviation: f64) -> Finding {
        Finding::between(what, unit, value, target - deviation, target + deviation)
    }

    /// A figure with an upper bound.
    pub fn at_most(what: impl Into<String>, unit: &'static str, value: f64, high: f64) -> Finding {
        Finding::between(what, unit, value, f64::NEG_INFINITY, high)
    }

    /// A figure with a lower bound.
    pub fn at_least(what: impl Into<String>, unit: &'static str, value: f64, low: f64) -> Finding {
        Finding::between(what, unit, value, low, f64::INFINITY)
    }

    /// Its least and its largest right value, where there are any.
    pub fn bounds(&self) -> [Option<f64>; 2] {
        [self.low, self.high].map(|bound| bound.is_finite().then_some(bound))
    }

    /// Whether it keeps its bounds; what is not a number keeps none.
    pub fn holds(&self) -> bool {
        self.value >= self.low && self.value <= self.high
    }

    /// By how many times its room it leaves its bounds; below 1 inside. Orders findings by how wrong they are.
    pub fn excess(&self) -> f64 {
        match (self.holds(), self.value.is_finite()) {
            (true, _) => 0.0,
            (false, false) => f64::INFINITY,
            (false, true) => {
                let nearest = if self.value > self.high { self.high } else { self.low };
                (self.value - nearest).abs() / nearest.abs().max(1e-300)
            }
        }
    }
}
