//! Stress tests: difficult scenes for simulators, each with the expected outcome, its source and a measured verdict.
//!
//! ```text
//! catalogue -> Case -> run in a code -> Evidence (frames) -> judge -> Finding -> Verdict -> report
//! ```
//!
//! The figures of every code are measured from its frames in the same way. A failed run is an outcome like any other.

mod campaign;
mod catalogue;
mod evidence;

use crate::study::Finding;
pub use campaign::Campaign;
pub use catalogue::catalogue;
pub(crate) use evidence::Evidence;
use makadam_frames::plan::MeasuredScene;
use makadam_view::draw::numbers::four_digits;
use serde::{Deserialize, Serialize};

/// A stress test.
#[derive(Serialize)]
pub struct Case {
    /// Name, unique in the catalogue.
    pub name: String,
    /// Group of cases on one question.
    pub group: &'static str,
    /// Expected outcome.
    pub right: String,
    /// Law, derivation or publication behind it.
    pub source: &'static str,
    /// True if the case belongs to the long catalogue only.
    pub long: bool,
    /// Time step of explicit codes too, s; absent where they choose their own.
    #[serde(skip)]
    pub peer_step: Option<f64>,
    /// Scene.
    #[serde(skip)]
    pub scene: MeasuredScene,
    #[serde(skip)]
    pub(crate) judge: Judge,
}

/// Takes figures from a run, each with its bounds.
type Judge = Box<dyn Fn(&Evidence<'_>) -> Vec<Finding> + Send + Sync>;

impl Case {
    /// Returns a case of the quick catalogue in which every code chooses its own time step.
    pub(crate) fn new(
        group: &'static str,
        scene: MeasuredScene,
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

    /// Moves the case to the long catalogue.
    pub(crate) fn long(self) -> Case {
        Case { long: true, ..self }
    }

    /// Gives all codes the time step of the scene.
    pub(crate) fn at_one_step(self) -> Case {
        Case { peer_step: Some(self.scene.solver.step), ..self }
    }

    /// Returns true if a text is part of the name or the group.
    pub fn matches(&self, text: &str) -> bool {
        self.name.contains(text) || self.group.contains(text)
    }
}

/// Verdict on a case in one code.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Verdict {
    /// Every figure is within its bounds.
    AsStated,
    /// A figure is outside its bounds.
    NotAsStated,
    /// The run broke off, or a number is not finite.
    Crashed,
    /// The run was stopped at its time limit.
    TookTooLong,
    /// The code cannot express the scene.
    CannotBeExpressed,
}

impl Verdict {
    pub(crate) const ALL: [Verdict; 5] =
        [Verdict::AsStated, Verdict::NotAsStated, Verdict::Crashed, Verdict::TookTooLong, Verdict::CannotBeExpressed];

    /// Returns the name of the verdict.
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

/// Outcome of a case in one code.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Outcome {
    /// Name of the code.
    pub code: String,
    /// Verdict.
    pub verdict: Verdict,
    /// Measured figures; empty if there was nothing to measure.
    pub findings: Vec<Finding>,
    /// Reason why there was nothing to measure.
    pub reason: Option<String>,
    /// Time step of the run, s; absent if the run did not end.
    pub time_step: Option<f64>,
    /// Wall time, s.
    pub wall_seconds: f64,
}

impl Outcome {
    /// Returns the figure furthest outside its bounds, or the first.
    pub fn telling(&self) -> Option<&Finding> {
        let worst = self.findings.iter().max_by(|a, b| a.excess().total_cmp(&b.excess()))?;
        if worst.holds() { self.findings.first() } else { Some(worst) }
    }

    /// Returns the verdict and the decisive figure with its name.
    pub fn text(&self) -> String {
        let words = self.verdict.words();
        match self.telling() {
            Some(finding) => format!("{words}: {} {}", finding.what, figure(finding.value, &finding.unit)),
            None => words.into(),
        }
    }
}

pub(crate) fn figure(value: f64, unit: &str) -> String {
    format!("{} {unit}", four_digits(value)).trim_end().into()
}

/// Cases that are known to fail, each with the reason (`validation/docs/stability.md`). A case that passes must be removed.
const KNOWN_EXCEPTIONS: [(&str, &str); 1] = [(
    "impossible-gap-rigid",
    "two rigid contacts that contradict each other have no solution: impulses grow with sweeps",
)];

/// Returns the reason why a case is known to fail; `None` where it must pass.
pub fn known_exception(case: &str) -> Option<&'static str> {
    KNOWN_EXCEPTIONS.iter().find(|(name, _)| *name == case).map(|(_, reason)| *reason)
}
