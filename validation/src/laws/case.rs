//! What a law simulates.

use crate::plan::Scene;
use std::collections::BTreeMap;

/// Named numbers; SI units unless the name says otherwise.
pub(crate) type Values = BTreeMap<String, f64>;

/// Restitution threshold of all cases, m/s, with which the rows on record were made. By the scales of grains of 10 mm it would be 0.0501.
const RESTITUTION_THRESHOLD: f64 = 0.05;

/// One simulation of a law, before a seed is chosen.
pub(crate) struct Case {
    /// Name, unique within the law; a part of file names.
    pub(crate) name: String,
    /// What is simulated; its duration is an upper bound.
    pub(crate) scene: Scene,
    /// What was chosen for it; a part of its row.
    pub(crate) given: Values,
}

impl Case {
    /// A case.
    pub(crate) fn new<const N: usize>(mut scene: Scene, given: [(&str, f64); N]) -> Case {
        scene.solver.restitution_threshold = Some(RESTITUTION_THRESHOLD);
        Case { name: scene.name.clone(), scene, given: values(given) }
    }

    /// What was chosen under a name.
    ///
    /// # Panics
    /// The law did not choose such a value.
    pub(crate) fn of(&self, name: &str) -> f64 {
        self.given[name]
    }
}

/// Named numbers from a list.
pub(crate) fn values<const N: usize>(list: [(&str, f64); N]) -> Values {
    list.into_iter().map(|(name, value)| (name.to_string(), value)).collect()
}
