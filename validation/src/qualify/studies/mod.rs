//! Studies that are a part of a qualification: each is made by its own room, in a folder of its own, from runs that are kept there.

mod ablation;
mod contact_problems;
mod convergence;
mod hard_cases;
mod laws;
mod own_settings;
mod tradeoff;

use super::jobs::Job;
use super::tier::Study;
use super::{QualifyError, Settings};
use crate::compare::KeptRuns;
use crate::plan::Scene;
use crate::report::{StudyOutcome, StudySection, StudyTest};
use crate::scenes;
use std::path::{Path, PathBuf};

/// A study under way.
pub(super) trait Part: Sync {
    /// Does what has to have the machine to itself.
    ///
    /// # Errors
    /// [`QualifyError`] if the user asked to stop, or it cannot be done at all.
    fn alone(&self) -> Result<(), QualifyError> {
        Ok(())
    }

    /// What can be done side by side.
    fn jobs(&self) -> Vec<Job<'_>> {
        Vec::new()
    }

    /// Writes the study from what has been kept, and says what came of it.
    ///
    /// # Errors
    /// [`QualifyError`] if it cannot be written.
    fn section(&self) -> Result<StudySection, QualifyError>;
}

/// What a part needs to know.
#[derive(Clone, Copy)]
pub(super) struct Place<'a> {
    pub(super) settings: &'a Settings<'a>,
    /// Runs that the scenes of the qualification have too.
    pub(super) kept: &'a KeptRuns,
}

impl Place<'_> {
    /// Folder of a study's results.
    fn folder(&self, study: &str) -> PathBuf {
        self.settings.folder.join(study)
    }
}

/// A scene by the name that the table has of it, with its file.
type Named = (&'static str, PathBuf, Scene);

/// The scenes of these names.
fn scenes_named(names: &[&'static str], place: Place<'_>) -> Result<Vec<Named>, QualifyError> {
    let open = |&name: &&'static str| {
        let file = scenes::find(name, &place.settings.roots)?;
        let scene = scenes::load(&file)?;
        Ok((name, file, scene))
    };
    names.iter().map(open).collect()
}

/// The part that a study of the table is.
///
/// # Errors
/// [`QualifyError`] if a scene of it cannot be had.
pub(super) fn open<'a>(study: &Study, place: Place<'a>) -> Result<Box<dyn Part + 'a>, QualifyError> {
    Ok(match study {
        Study::HardCases(filters) => Box::new(hard_cases::HardCases::new(filters, place)),
        Study::Laws(laws) => Box::new(laws::Laws::open(laws, place)?),
        Study::Ablation(scenes) => Box::new(ablation::Ablations::open(scenes, place)?),
        Study::Convergence(scenes) => Box::new(convergence::Convergence::open(scenes, place)?),
        Study::ContactProblems => Box::new(contact_problems::ContactProblems::open(place)?),
        Study::Tradeoff(scenes) => Box::new(tradeoff::Tradeoff::open(scenes, place)?),
    })
}

/// A test whose outcome is that of a condition.
fn test(name: String, measured: String, right: String, passed: bool) -> StudyTest {
    let outcome = if passed { StudyOutcome::Passed } else { StudyOutcome::Failed };
    StudyTest { name, measured, right, outcome, remark: None }
}

/// A path below the folder of the report, as a page links to it.
fn link(folder: &Path, file: &Path) -> String {
    let below = file.strip_prefix(folder).unwrap_or(file);
    below.iter().map(|part| part.to_string_lossy()).collect::<Vec<_>>().join("/")
}
