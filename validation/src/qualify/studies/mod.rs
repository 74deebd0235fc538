//! Studies as parts of a qualification: a study states its jobs, and returns checks, figures and tables; the report writes them.

mod numerics;
mod physics;

use super::scenes::{Job, weight};
use super::tier::Study;
use super::{QualifyError, Settings};
use crate::compare::KeptRuns;
use crate::peers::{Code, Makadam};
use crate::plan::Scene;
use crate::report::{StudyOutcome, StudySection, StudyTest};
use crate::scenes;
use crate::stability::{Campaign, Case, CaseResult, Verdict, catalogue, known_exception, telling};
use crate::study::File;
use std::collections::BTreeMap;
use std::path::PathBuf;
use std::sync::Mutex;

/// A study under way.
pub(super) trait Part: Sync {
    /// Returns its jobs.
    fn jobs(&self) -> Vec<Job<'_>>;

    /// Returns the result of the study from the finished jobs.
    ///
    /// # Errors
    /// [`QualifyError`] if a result is missing.
    fn section(&self) -> Result<StudySection, QualifyError>;
}

/// Settings and stored runs of the qualification.
#[derive(Clone, Copy)]
pub(super) struct Place<'a> {
    pub(super) settings: &'a Settings<'a>,
    /// Runs shared with the scenes of the qualification.
    pub(super) kept: &'a KeptRuns,
}

impl Place<'_> {
    /// Returns the folder of a study's stored runs.
    fn folder(&self, study: &str) -> PathBuf {
        self.settings.folder.join(study)
    }
}

/// Results of jobs by name, in an order that does not depend on which job ends first.
struct Results<T>(Mutex<BTreeMap<String, T>>);

impl<T: Clone> Results<T> {
    fn new() -> Results<T> {
        Results(Mutex::default())
    }

    fn add(&self, name: &str, result: T) {
        self.0.lock().expect("nothing panics while it holds the lock").insert(name.into(), result);
    }

    fn get(&self, name: &str) -> Option<T> {
        self.0.lock().expect("nothing panics while it holds the lock").get(name).cloned()
    }

    fn all(&self) -> Vec<T> {
        self.0.lock().expect("nothing panics while it holds the lock").values().cloned().collect()
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
///
/// # Errors
/// [`QualifyError`] if one of its scenes cannot be read.
pub(super) fn open<'a>(study: &Study, place: Place<'a>) -> Result<Box<dyn Part + 'a>, QualifyError> {
    Ok(match study {
        Study::HardCases(filters) => Box::new(HardCases::new(filters, place)),
        Study::Laws(laws) => Box::new(physics::Laws::open(laws, place)?),
        Study::Ablation(scenes) => Box::new(physics::Ablations::open(scenes, place)?),
        Study::Convergence(scenes) => Box::new(numerics::Convergence::open(scenes, place)?),
        Study::ContactProblems => Box::new(numerics::ContactProblems::open(place)?),
        Study::Tradeoff(scenes) => Box::new(numerics::Tradeoff::open(scenes, place)?),
    })
}

/// Returns the CSV files of a study on a scene under names that are unique in the folder of the report.
fn named(study: &str, scene: &str, files: Vec<File>) -> Vec<File> {
    let tables = files.into_iter().filter(|(name, _)| name.ends_with(".csv"));
    tables.map(|(name, bytes)| (format!("{study}-{scene}-{name}"), bytes)).collect()
}

/// Wall time after which a stress test is stopped, s: that of the whole catalogue.
const TIME_LIMIT: f64 = 600.0;

/// The stress tests of `makadam stability`, in Makadam.
struct HardCases<'a> {
    place: Place<'a>,
    folder: PathBuf,
    cases: Vec<Case>,
    codes: [Box<dyn Code>; 1],
}

impl<'a> HardCases<'a> {
    fn new(filters: &[&str], place: Place<'a>) -> HardCases<'a> {
        let is_wanted = |case: &Case| {
            filters.is_empty() || filters.iter().any(|filter| case.name.contains(filter) || case.group.contains(filter))
        };
        let cases = catalogue().into_iter().filter(is_wanted).collect();
        HardCases { place, folder: place.folder("stability"), cases, codes: [Box::new(Makadam)] }
    }

    fn job<'s>(&'s self, case: &'s Case) -> Job<'s> {
        Job {
            identity: format!("stability {}", case.name),
            weight: weight(&case.scene),
            alone: false,
            work: Box::new(move || {
                let _display = (self.place.settings.announce)(&case.name);
                self.take(case, self.place.settings.again).map(|_| ())
            }),
        }
    }

    fn take(&self, case: &Case, again: bool) -> Result<CaseResult, QualifyError> {
        let campaign = Campaign {
            cases: &self.cases,
            codes: &self.codes,
            time_limit: TIME_LIMIT,
            folder: &self.folder,
            again: false,
            begins: &|_, _| {},
            ended: &|_, _, _| {},
        };
        Ok(CaseResult::new(case, vec![campaign.take(case, &Makadam, again)?]))
    }
}

impl Part for HardCases<'_> {
    fn jobs(&self) -> Vec<Job<'_>> {
        self.cases.iter().map(|case| self.job(case)).collect()
    }

    fn section(&self) -> Result<StudySection, QualifyError> {
        let cases = self.cases.iter().map(|case| self.take(case, false)).collect::<Result<Vec<_>, QualifyError>>()?;
        Ok(StudySection {
            name: "stability".into(),
            title: "Hard cases".into(),
            scope: "Scenes that break simulators, each with what is right by a closed form or a law of conservation."
                .into(),
            runs: cases.len(),
            wall_seconds: cases.iter().flat_map(|case| &case.outcomes).map(|outcome| outcome.wall_seconds).sum(),
            tests: cases.iter().map(case_test).collect(),
            ..StudySection::default()
        })
    }
}

fn case_test(case: &CaseResult) -> StudyTest {
    let outcome = case.outcomes.first().expect("a case is run in Makadam");
    let measured = format!("{}: {}", outcome.verdict.words(), telling(outcome));
    let measured = measured.trim_end_matches(": ").to_string();
    let test = StudyTest::of(case.name.clone(), measured, case.right.clone(), outcome.verdict == Verdict::AsStated);
    let remark = outcome.reason.clone().filter(|_| test.outcome == StudyOutcome::Failed);
    StudyTest { remark, ..test }.with_exception(known_exception(&case.name))
}
