//! Studies as parts of a qualification: items state their jobs, and return tests, figures and tables; the report writes them.

mod numerics;
mod physics;

use super::scenes::{Job, weight};
use super::tier::Study;
use super::{QualifyError, Settings};
use crate::report::{StudySection, StudyTest};
use makadam_compare::scenes;
use makadam_compare::study::{File, RunCache, RunError};
use makadam_frames::output::WriteError;
use makadam_frames::plan::MeasuredScene;
use makadam_view::draw::figure::Figure;
use serde::{Deserialize, Serialize};
use std::path::PathBuf;
use std::sync::{Arc, OnceLock};

/// Study in progress: its section, still without results, and its items.
pub(super) struct Part<'a> {
    section: StudySection,
    items: Vec<Item<'a>>,
}

/// Case, scene or problem of a study.
struct Item<'a> {
    /// Jobs; each stores a result.
    jobs: Vec<Job<'a>>,
    /// Combines the stored results.
    solved: Box<dyn FnOnce() -> Result<Solved, RunError> + 'a>,
}

/// Result of an item.
#[derive(Clone, Default, Serialize, Deserialize)]
struct Solved {
    runs: usize,
    wall_seconds: f64,
    tests: Vec<StudyTest>,
    notes: Vec<String>,
    figures: Vec<Figure>,
    files: Vec<File>,
}

impl<'a> Item<'a> {
    /// Returns an item of one job, whose result is that of the item.
    fn of(
        identity: String,
        weight: f64,
        alone: bool,
        solve: impl Fn() -> Result<Solved, RunError> + Send + Sync + 'a,
    ) -> Item<'a> {
        let result = Arc::new(OnceLock::new());
        let stored = result.clone();
        let work = Box::new(move || {
            let solved = solve()?;
            result.get_or_init(|| solved);
            Ok(())
        });
        let solved = move || Ok(stored.get().expect("its job has ended well").clone());
        Item { jobs: vec![Job { identity, weight, alone, work }], solved: Box::new(solved) }
    }
}

impl<'a> Part<'a> {
    fn new(name: &str, title: &str, scope: impl Into<String>, items: Vec<Item<'a>>) -> Part<'a> {
        let [name, title] = [name, title].map(String::from);
        Part { section: StudySection { name, title, scope: scope.into(), ..StudySection::default() }, items }
    }

    /// Takes the jobs out of the study.
    pub(super) fn jobs(&mut self) -> Vec<Job<'a>> {
        self.items.iter_mut().flat_map(|item| std::mem::take(&mut item.jobs)).collect()
    }

    /// Returns the section of the study once all jobs have ended.
    pub(super) fn section(self) -> Result<StudySection, RunError> {
        let Part { mut section, items } = self;
        for item in items {
            let solved = (item.solved)()?;
            section.runs += solved.runs;
            section.wall_seconds += solved.wall_seconds;
            section.tests.extend(solved.tests);
            section.notes.extend(solved.notes);
            section.figures.extend(solved.figures);
            section.files.extend(solved.files);
        }
        Ok(section)
    }
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

/// Scene by its name in the table of tiers, with its file.
#[derive(Clone)]
struct Named {
    name: &'static str,
    file: PathBuf,
    scene: MeasuredScene,
}

impl Named {
    fn open(name: &'static str, place: Place<'_>) -> Result<Named, QualifyError> {
        let file = scenes::find(name, &place.settings.roots)?;
        Ok(Named { name, scene: scenes::load(&file)?, file })
    }
}

/// Opens a study of the table of tiers.
pub(super) fn open<'a>(study: &Study, place: Place<'a>) -> Result<Part<'a>, QualifyError> {
    match study {
        Study::HardCases(filters) => physics::stress_tests(filters, place),
        Study::Laws(laws) => physics::laws(laws, place),
        Study::Ablation(scenes) => physics::ablations(scenes, place),
        Study::Convergence(scenes) => numerics::convergence(scenes, place),
        Study::ContactProblems => numerics::contact_problems(place),
        Study::Tradeoff(scenes) => numerics::tradeoff(scenes, place),
    }
}

/// Lets a job fail only if no other may follow: a run that fails by itself appears in the tests.
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
