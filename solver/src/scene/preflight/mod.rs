//! Preflight checks: properties of a scene that depend only on its text, checked before a run. See `docs/scene-checks.md`.
//!
//! Scenes with an error are rejected when they are read or simulated. A warning does not change the scene. The checks predict nothing: the
//! watchdogs ([`crate::watch`]) report a deep overlap, an escaped grain or spurious energy in the step of the violation.

mod meshes;
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

/// Memory per grain in a dense bed during a simulation, candidate list and contacts included, bytes: `docs/memory.md`.
const BYTES_PER_GRAIN: f64 = 1_000.0;
/// Additional peak memory per grain for initial placement and written frames, bytes: measured, 450 to 600.
const BYTES_PER_GRAIN_AT_PEAK: f64 = 500.0;
/// Memory per lattice site of a population, bytes.
const BYTES_PER_SITE: f64 = 24.0;

/// Simulation before the run, if the run starts from a prepared state: the table `prepare` of a document.
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
    /// The scene cannot be simulated as written and is rejected.
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
    /// Runs all preflight checks. Line numbers are from `text`, the text of the scene file, if present.
    ///
    /// Placement without an overlap check takes some tenths of a second for half a million grains.
    pub fn findings(&self, text: Option<&str>) -> Vec<Finding> {
        self.findings_after(None, text)
    }

    /// Runs all preflight checks of a run that starts from a prepared state.
    pub fn findings_after(&self, beforehand: Option<Beforehand>, text: Option<&str>) -> Vec<Finding> {
        let finding = |severity: Severity, fault: Fault| {
            let (problem, remedy) = fault.in_words();
            Finding { severity, problem, remedy, line: text.map(|text| fault.line(text)) }
        };
        let errors = self.motion_faults(beforehand).into_iter().map(|fault| finding(Severity::Error, fault));
        let warnings = self.warnings(beforehand).into_iter().map(|fault| finding(Severity::Warning, fault));
        errors.chain(warnings).collect()
    }

    fn warnings(&self, beforehand: Option<Beforehand>) -> Vec<Fault> {
        let mut warnings = self.in_stages(units::faults);
        warnings.extend(meshes::faults(self));
        warnings.extend(settings::faults(self));
        if !self.stage.is_empty() {
            // Stages have durations of their own.
            warnings.retain(|fault| fault.place() != "duration");
            let of_stages = self.in_stages(settings::faults).into_iter();
            warnings.extend(of_stages.filter(|fault| fault.place().starts_with("stage")));
        }
        // Failed placement is an error of `placed`, reported elsewhere.
        if let Ok(grains) = placed(self, self.seed) {
            warnings.extend(self.in_stages(|scene| speed::faults(scene, &grains, beforehand)));
        }
        warnings
    }

    /// Returns the faults of the scenes of all stages.
    fn in_stages(&self, faults: impl Fn(&Scene) -> Vec<Fault>) -> Vec<Fault> {
        if self.stage.is_empty() {
            return faults(self);
        }
        let mut all = Vec::new();
        for (number, scene) in self.stage_scenes().iter().enumerate() {
            for fault in faults(scene).into_iter().map(|fault| self.fault_in_stage(number, fault)) {
                if !all.contains(&fault) {
                    all.push(fault);
                }
            }
        }
        all
    }

    fn motion_faults(&self, beforehand: Option<Beforehand>) -> Vec<Fault> {
        // A motion that lasts from an earlier stage, or from the scene, begins at a time of another clock.
        self.in_stages(|scene| {
            let whole = Scene { duration: self.duration, ..scene.clone() };
            let of_whole = if self.stage.is_empty() { Vec::new() } else { motion::faults(&whole, beforehand) };
            motion::faults(scene, beforehand).into_iter().chain(of_whole).collect()
        })
    }

    /// Rejects values out of range, motions that are shorter than a step, and a speed-dependent restitution if the step
    /// resolves impacts. The rules for scenes made in code and for scenes from files are the same.
    ///
    /// # Errors
    /// [`SceneError::Invalid`] with the first fault.
    pub fn check(&self) -> Result<(), SceneError> {
        super::check::check(self)?;
        self.check_motion(None)?;
        let resolved = self.in_stages(|scene| scene.resolved_impact().into_iter().collect());
        resolved.into_iter().next().map_or(Ok(()), |fault| Err(fault.into()))
    }

    /// Checks a run that starts from a prepared state.
    ///
    /// # Errors
    /// [`SceneError::Invalid`] with the first fault.
    pub fn check_after(&self, beforehand: Beforehand) -> Result<(), SceneError> {
        self.check()?;
        self.check_motion(Some(beforehand))
    }

    /// Rejects motions that the steps do not resolve.
    pub(super) fn check_motion(&self, beforehand: Option<Beforehand>) -> Result<(), SceneError> {
        self.motion_faults(beforehand).into_iter().next().map_or(Ok(()), |fault| Err(fault.into()))
    }

    /// Estimates the peak memory of a simulation, bytes; grains are assumed to lie in a dense bed.
    pub fn memory(&self) -> u64 {
        let sites = self.population.iter().map(|population| population.sites()).fold(0.0, f64::max);
        let per_grain = BYTES_PER_GRAIN + BYTES_PER_GRAIN_AT_PEAK;
        (self.most_grains() as f64 * per_grain + sites * BYTES_PER_SITE) as u64
    }
}
