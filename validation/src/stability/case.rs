//! One hard case: what is simulated, what must come of it and why, and how that is measured.

use super::Evidence;
use crate::plan::Scene;
use crate::study::Finding;

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
