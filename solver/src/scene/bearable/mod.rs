//! Whether a scene can be carried out with its settings, told before it runs: see `docs/scene-checks.md`.
//!
//! An error is what cannot be carried out as it is said, and is refused wherever a scene is read or simulated. A warning is what
//! is expected to go wrong, by laws whose constants were measured.

mod bed;
mod held;
mod impact;
mod memory;
mod motion;
mod pace;
mod ray;
mod shear;
mod slow;
mod units;
mod vain;

use super::Scene;
use super::error::{Fault, SceneError};
use super::populate::placed;
use bed::Bed;
use serde::{Deserialize, Serialize};
use std::fmt;

/// What is simulated of a scene before its run begins, where the run starts from a state that this comes to: the document says so in
/// a table `prepare`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Beforehand {
    /// Simulated time, s.
    pub duration: f64,
    /// Time step, s.
    pub step: f64,
}

/// How bad a finding is.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Severity {
    /// The scene cannot be carried out as it is said: it is refused.
    Error,
    /// The scene runs, and is expected to go wrong, or says something that has no effect.
    Warning,
}

/// Something that a scene cannot bear with its settings.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Finding {
    /// Whether it is refused.
    pub severity: Severity,
    /// What is wrong; begins with the path of the setting, such as `wall[0].motion`.
    pub problem: String,
    /// The setting that would do.
    pub remedy: String,
    /// Line of the scene's text that the problem is about, from 1; none where there is no text.
    pub line: Option<usize>,
}

impl fmt::Display for Finding {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(out, "{}; {}", self.problem, self.remedy)
    }
}

/// Longest step (s) that all motions of a scene can be carried out with, and that no warning of impacts or walls is about.
pub(super) fn longest_step(scene: &Scene) -> f64 {
    let by_motion = motion::longest_step(scene);
    // Grains that cannot be placed are an error of the scene, which placing them tells.
    let Ok(grains) = placed(scene, scene.seed) else { return by_motion };
    let bed = Bed::new(scene, &grains);
    by_motion.min(impact::longest_step(scene, &grains, &bed)).min(shear::longest_step(scene, &grains))
}

impl Scene {
    /// What the scene cannot bear with its settings. `text` is that of its file, if it has one, for lines.
    ///
    /// Grains are placed for that, without a look at whether they overlap: some tenths of a second for half a million.
    pub fn findings(&self, text: Option<&str>) -> Vec<Finding> {
        self.findings_after(None, text)
    }

    /// The same where the run starts from what the grains have come to beforehand.
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
        warnings.extend(vain::faults(self));
        // Grains that cannot be placed are an error of the scene, which placing them tells.
        let Ok(grains) = placed(self, self.seed) else { return warnings };
        let bed = Bed::new(self, &grains);
        warnings.extend(held::fault(self, &grains, &bed));
        warnings.extend(impact::fault(self, &grains, &bed, beforehand));
        warnings.extend(shear::faults(self, &grains));
        warnings.extend(pace::fault(self, &grains, beforehand));
        warnings.extend(slow::fault(self, &grains, &bed));
        warnings
    }

    /// Refuses what cannot be carried out: values out of range, motions that the step passes over, a restitution that falls where
    /// the step resolves impacts. Scenes made in code keep the same rules as those from files.
    ///
    /// # Errors
    /// [`SceneError::Invalid`] with the first of these.
    pub fn check(&self) -> Result<(), SceneError> {
        self.first_fault().map_or(Ok(()), |fault| Err(fault.into()))
    }

    /// The same where the run starts from what the grains have come to beforehand.
    ///
    /// # Errors
    /// [`SceneError::Invalid`] with the first of these.
    pub fn check_after(&self, beforehand: Beforehand) -> Result<(), SceneError> {
        self.check()?;
        self.unbearable(Some(beforehand)).map_or(Ok(()), |fault| Err(fault.into()))
    }

    fn first_fault(&self) -> Option<Fault> {
        super::check::check(self).err().or_else(|| self.unbearable(None)).or_else(|| self.resolved_impact())
    }

    /// The first error among the findings.
    pub(super) fn unbearable(&self, beforehand: Option<Beforehand>) -> Option<Fault> {
        motion::faults(self, beforehand).into_iter().next()
    }
}
