//! Preflight checks: properties of a scene that its text alone decides, checked before a run. See `docs/scene-checks.md`.
//!
//! An error is refused wherever a scene is read or simulated. A warning leaves the scene as it is. Nothing is predicted here: a deep
//! overlap, an escaped grain or spurious energy is reported by the watchdogs ([`crate::watch`]) in the steps in which it happens.

mod motion;
mod settings;
mod speed;
mod units;

use super::Scene;
use super::error::{Fault, SceneError};
use super::populate::placed;
pub(super) use motion::longest_step;
use serde::{Deserialize, Serialize};
pub(super) use speed::{fall_speed, longest_step_of_walls};
use std::fmt;

/// Bytes of a grain in a dense bed while it is simulated, candidate list and contacts included: `docs/memory.md`.
const BYTES_PER_GRAIN: f64 = 1_000.0;
/// Additional bytes of a grain at the process's peak, where the start is placed and frames are written: measured, 450 to 600.
const BYTES_PER_GRAIN_AT_PEAK: f64 = 500.0;
/// Bytes of a site of the lattice that a population is placed on.
const BYTES_PER_SITE: f64 = 24.0;

/// Simulation before the run begins, where the run starts from a prepared state: the table `prepare` of a document.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Beforehand {
    /// Simulated time, s.
    pub duration: f64,
    /// Time step, s.
    pub step: f64,
}

/// Severity of a finding.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Severity {
    /// The scene cannot be simulated as written: it is refused.
    Error,
    /// The scene runs; a value is unusual, has no effect, or is beyond what the step resolves.
    Warning,
}

/// Result of a preflight check.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Finding {
    /// Error or warning.
    pub severity: Severity,
    /// Problem; begins with the path of the setting, such as `wall[0].motion`.
    pub problem: String,
    /// Remedy.
    pub remedy: String,
    /// Line of the scene's text, from 1; none where there is no text.
    pub line: Option<usize>,
}

impl fmt::Display for Finding {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(out, "{}; {}", self.problem, self.remedy)
    }
}

impl Scene {
    /// Runs all preflight checks. `text` is that of the scene's file, if it has one, for lines.
    ///
    /// Grains are placed without a check of overlaps: some tenths of a second for half a million.
    pub fn findings(&self, text: Option<&str>) -> Vec<Finding> {
        self.findings_after(None, text)
    }

    /// Runs all preflight checks of a run that starts from a prepared state.
    pub fn findings_after(&self, beforehand: Option<Beforehand>, text: Option<&str>) -> Vec<Finding> {
        let finding = |severity: Severity, fault: Fault| {
            let (problem, remedy) = fault.in_words();
            Finding { severity, problem, remedy, line: text.map(|text| fault.line(text)) }
        };
        let errors = motion::faults(self, beforehand).into_iter().map(|fault| finding(Severity::Error, fault));
        let warnings = self.warnings(beforehand).into_iter().map(|fault| finding(Severity::Warning, fault));
        errors.chain(warnings).collect()
    }

    fn warnings(&self, beforehand: Option<Beforehand>) -> Vec<Fault> {
        let mut warnings = units::faults(self);
        warnings.extend(settings::faults(self));
        // Grains that cannot be placed are an error, which placing them reports.
        if let Ok(grains) = placed(self, self.seed) {
            warnings.extend(speed::faults(self, &grains, beforehand));
        }
        warnings
    }

    /// Refuses values out of range, motions that are shorter than a step, and a speed-dependent restitution where the step resolves
    /// impacts. Scenes made in code keep the same rules as those from files.
    ///
    /// # Errors
    /// [`SceneError::Invalid`] with the first of these.
    pub fn check(&self) -> Result<(), SceneError> {
        super::check::check(self)?;
        self.check_motion(None)?;
        self.resolved_impact().map_or(Ok(()), |fault| Err(fault.into()))
    }

    /// Checks a run that starts from a prepared state.
    ///
    /// # Errors
    /// [`SceneError::Invalid`] with the first fault.
    pub fn check_after(&self, beforehand: Beforehand) -> Result<(), SceneError> {
        self.check()?;
        self.check_motion(Some(beforehand))
    }

    /// Refuses motions that the steps do not resolve.
    pub(super) fn check_motion(&self, beforehand: Option<Beforehand>) -> Result<(), SceneError> {
        motion::faults(self, beforehand).into_iter().next().map_or(Ok(()), |fault| Err(fault.into()))
    }

    /// Estimates the peak memory of a simulation, bytes; grains are assumed to lie in a dense bed.
    pub fn memory(&self) -> u64 {
        let sites = self.population.iter().map(|population| population.sites()).fold(0.0, f64::max);
        let per_grain = BYTES_PER_GRAIN + BYTES_PER_GRAIN_AT_PEAK;
        (self.grain_count() as f64 * per_grain + sites * BYTES_PER_SITE) as u64
    }
}
