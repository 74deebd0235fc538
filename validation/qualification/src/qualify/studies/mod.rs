//! Studies as parts of a qualification: a study states its jobs, and returns checks, figures and tables; the report writes them.

mod numerics;
mod physics;

use super::scenes::{Job, weight};
use super::tier::Study;
use super::{QualifyError, Settings};
use crate::report::StudySection;
use makadam_compare::scenes;
use makadam_compare::study::{File, RunCache, RunError};
use makadam_frames::output::WriteError;
use makadam_frames::plan::Scene;
use std::path::PathBuf;

/// A study under way.
pub(super) trait Part: Sync {
    /// Returns its jobs, each of which stores a result.
    fn jobs(&self) -> Vec<Job<'_>>;

    /// Returns the result of the study from the stored results.
    fn section(&self) -> Result<StudySection, RunError>;
}

/// Settings and stored runs of the qualification.
#[derive(Clone, Copy)]
pub(super) struct Place<'a> {
    pub(super) settings: &'a Settings<'a>,
    /// Runs shared with the scenes of the qualification.
    pub(super) cache: &'a RunCache,
}

impl Place<'_> {
    fn folder(&self, study: &str) -> PathBuf {
        self.settings.folder.join(study)
    }

    /// Opens the stored results of a study.
    fn open(&self, study: &str) -> Result<RunCache, WriteError> {
        RunCache::open(&self.folder(study).join("kept"), self.settings.again)
    }
}

/// A scene by its name in the table of tiers, with its file.
#[derive(Clone)]
struct Named {
    name: &'static str,
    file: PathBuf,
    scene: Scene,
}

impl Named {
    fn open(name: &'static str, place: Place<'_>) -> Result<Named, QualifyError> {
        let file = scenes::find(name, &place.settings.roots)?;
        Ok(Named { name, scene: scenes::load(&file)?, file })
    }
}

/// Opens a study of the table of tiers.
pub(super) fn open<'a>(study: &Study, place: Place<'a>) -> Result<Box<dyn Part + 'a>, QualifyError> {
    Ok(match study {
        Study::HardCases(filters) => Box::new(physics::StressTests::open(filters, place)?),
        Study::Laws(laws) => Box::new(physics::Laws::open(laws, place)?),
        Study::Ablation(scenes) => Box::new(physics::Ablations::open(scenes, place)?),
        Study::Convergence(scenes) => Box::new(numerics::Convergence::open(scenes, place)?),
        Study::ContactProblems => Box::new(numerics::ContactProblems::open(place)?),
        Study::Tradeoff(scenes) => Box::new(numerics::Tradeoff::open(scenes, place)?),
    })
}

/// Lets a job fail only if no other may follow: a run that fails by itself shows in the tests.
fn unless_fatal<T>(result: Result<T, RunError>) -> Result<(), RunError> {
    match result {
        Err(error) if error.ends_all() => Err(error),
        _ => Ok(()),
    }
}

/// Returns the CSV files of a study on a scene under names that are unique in the folder of the report.
fn named(study: &str, scene: &str, files: Vec<File>) -> Vec<File> {
    let tables = files.into_iter().filter(|(name, _)| name.ends_with(".csv"));
    tables.map(|(name, bytes)| (format!("{study}-{scene}-{name}"), bytes)).collect()
}
