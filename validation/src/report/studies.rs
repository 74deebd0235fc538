//! Studies that were a part of a qualification: their tests, what each came to, and where the study itself is written.

use crate::draw::numbers::plural;
use crate::study::{Cell, Table, cells};
use minijinja::{Value, context};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// A study and its tests.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct StudySection {
    /// Its name: that of the command that makes such a study alone.
    pub name: String,
    /// Its title.
    pub title: String,
    /// What was run, in a sentence.
    pub scope: String,
    /// Runs behind it.
    pub runs: usize,
    /// Their wall times, s.
    pub wall_seconds: f64,
    /// Its own pages, by their paths below the folder of the report.
    pub pages: Vec<String>,
    /// Its tests; each counts in the verdict.
    pub tests: Vec<StudyTest>,
    /// What no test says, in sentences.
    pub notes: Vec<String>,
}

/// A test of a study.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
pub struct StudyTest {
    /// Its name, unique in the study.
    pub name: String,
    /// What was measured.
    pub measured: String,
    /// What is right.
    pub right: String,
    /// What it came to.
    pub outcome: StudyOutcome,
    /// Why it is excused, or why there is nothing measured.
    pub remark: Option<String>,
}

/// What a test of a study came to.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum StudyOutcome {
    /// What is right was measured.
    Passed,
    /// It was not.
    Failed,
    /// It was not, which is known, documented and on record.
    KnownException,
    /// There is nothing to tell it from.
    NotMeasured,
}

/// The tests of a study, counted.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
pub struct StudyCount {
    /// Name of the study.
    pub name: String,
    /// Its tests.
    pub tests: usize,
    /// Those that passed.
    pub passed: usize,
    /// Names of those that are known not to pass.
    pub known_exceptions: Vec<String>,
    /// Names of those that failed.
    pub failed: Vec<String>,
    /// Names of those that could not be made.
    pub not_measured: Vec<String>,
}

/// A test of a study that a qualification must make.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
pub struct StudyTestOnRecord {
    /// Name of the study.
    pub study: String,
    /// Name of the test.
    pub test: String,
    /// Whether it is known not to pass.
    pub known_exception: bool,
}

impl StudyOutcome {
    /// In words.
    pub fn words(self) -> &'static str {
        match self {
            StudyOutcome::Passed => "passed",
            StudyOutcome::Failed => "failed",
            StudyOutcome::KnownException => "known exception",
            StudyOutcome::NotMeasured => "not measured",
        }
    }

    fn class(self) -> &'static str {
        match self {
            StudyOutcome::Passed => "agree",
            StudyOutcome::Failed => "disagree",
            StudyOutcome::KnownException | StudyOutcome::NotMeasured => "undecided",
        }
    }
}

impl StudySection {
    /// Its tests, counted.
    pub fn count(&self) -> StudyCount {
        let of = |outcome: StudyOutcome| {
            let tests = self.tests.iter().filter(move |test| test.outcome == outcome);
            tests.map(|test| test.name.clone()).collect::<Vec<_>>()
        };
        StudyCount {
            name: self.name.clone(),
            tests: self.tests.len(),
            passed: of(StudyOutcome::Passed).len(),
            known_exceptions: of(StudyOutcome::KnownException),
            failed: of(StudyOutcome::Failed),
            not_measured: of(StudyOutcome::NotMeasured),
        }
    }

    /// What became of a test on record, in words that follow its name; absent where it was made as it stands there.
    pub(super) fn lacks(&self, on_record: &StudyTestOnRecord) -> Option<String> {
        let Some(test) = self.tests.iter().find(|test| test.name == on_record.test) else {
            return Some("was not made".into());
        };
        let excused = test.outcome == StudyOutcome::KnownException;
        (excused && !on_record.known_exception).then(|| "is excused, and not on record as a known exception".into())
    }
}

impl StudyCount {
    /// The study came to this, in a sentence.
    pub fn sentence(&self, title: &str) -> String {
        let mut text = format!("{title}: {} of {} passed", self.passed, plural(self.tests, "test"));
        for (words, names) in [
            ("failed", &self.failed),
            ("not measured", &self.not_measured),
            (
                if self.known_exceptions.len() == 1 { "known exception" } else { "known exceptions" },
                &self.known_exceptions,
            ),
        ] {
            if !names.is_empty() {
                text += &format!(", {} {words} ({})", names.len(), names.join("; "));
            }
        }
        text + "."
    }
}

/// The tests of a study, one a row.
fn table(study: &StudySection) -> Table {
    let table = Table::new(&["test", "right", "measured"], &[]).styled("results").with_words("");
    table.of(&study.tests, |test| {
        let outcome = Cell::from("").outcome(Some((test.outcome.class(), test.outcome.words())));
        cells![&test.name, &test.right, &test.measured, outcome.above(test.remark.clone())]
    })
}

/// What the template shows of a study.
pub(super) fn shown(study: &StudySection) -> Value {
    let count = study.count();
    let (word, class) = match (count.failed.len(), count.not_measured.len()) {
        (0, 0) => ("Passed", "agree"),
        (0, _) => ("Not measured", "undecided"),
        _ => ("Failed", "disagree"),
    };
    context! {
        study => study,
        anchor => format!("study-{}", study.name),
        word => word,
        class => class,
        sentence => count.sentence(&study.title),
        wall_time => crate::draw::numbers::duration(study.wall_seconds),
        table => table(study).html(),
    }
}
