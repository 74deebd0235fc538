//! Tests that a qualification must make whatever the scenes say, and how little of each may be left.

use super::qualification::Qualification;
use super::studies::{StudyTest, StudyTestOnRecord};
use crate::compare::{Comparison, Row};
use crate::draw::numbers::plural;
use crate::plan::physics_hash;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::fmt;

/// A test of equivalence on record.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct TestOnRecord {
    /// Name of the scene.
    pub scene: String,
    /// Name of the observable.
    pub observable: String,
    /// The code that the judged one is held against.
    pub reference_code: String,
    /// Widest margin, in the unit of the observable; absent in reports of earlier versions.
    #[serde(default)]
    pub margin: Option<f64>,
    /// Fewest seeds of each of the two codes.
    #[serde(default)]
    pub seeds: usize,
    /// Fewest seeds of the judged code, where that is more.
    #[serde(default)]
    pub judged_seeds: usize,
    /// Hash of what every code is given of the scene, 16 hexadecimal digits; absent in reports of earlier versions.
    #[serde(default)]
    pub scene_hash: Option<String>,
}

/// A test on record of either kind.
#[derive(Clone, Debug, PartialEq)]
pub enum AnyTestOnRecord {
    /// Of equivalence.
    Equivalence(TestOnRecord),
    /// Of a study.
    Study(StudyTestOnRecord),
}

/// A test on record that was not made, or with less than is on record.
#[derive(Clone, Debug, PartialEq)]
pub struct Lost {
    /// The test.
    pub test: AnyTestOnRecord,
    /// What became of it, in words that follow its name.
    pub what: String,
}

impl TestOnRecord {
    /// Whether a row is what was made of it.
    fn is_made_in(&self, row: &Row) -> bool {
        (&row.scene, &row.observable, row.reference_code.as_ref())
            == (&self.scene, &self.observable, Some(&self.reference_code))
    }
}

impl fmt::Display for TestOnRecord {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(out, "{} of {} against {}", self.observable, self.scene, self.reference_code)
    }
}

impl fmt::Display for AnyTestOnRecord {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            AnyTestOnRecord::Equivalence(test) => test.fmt(out),
            AnyTestOnRecord::Study(test) => write!(out, "{} ({})", test.test, test.study),
        }
    }
}

impl Lost {
    /// Whether a row is what was made of the test.
    pub(super) fn is_of(&self, row: &Row) -> bool {
        matches!(&self.test, AnyTestOnRecord::Equivalence(test) if test.is_made_in(row))
    }

    /// Whether a test of a study is what was made of the test.
    pub(super) fn is_of_study(&self, study: &str, made: &StudyTest) -> bool {
        matches!(&self.test, AnyTestOnRecord::Study(test) if test.study == study && test.test == made.name)
    }
}

impl Qualification {
    /// Tests on record that were not made as they stand there.
    pub fn lost(&self) -> Vec<Lost> {
        let lost = |test: &TestOnRecord| {
            let what = self.lacks(test)?;
            Some(Lost { test: AnyTestOnRecord::Equivalence(test.clone()), what })
        };
        let of_study = |on_record: &StudyTestOnRecord| {
            let study = self.studies.iter().find(|study| study.name == on_record.study);
            let what = study.map_or(Some("was not made".into()), |study| study.lacks(on_record))?;
            Some(Lost { test: AnyTestOnRecord::Study(on_record.clone()), what })
        };
        let of_studies = self.studies_on_record.iter().filter_map(of_study);
        self.on_record.iter().filter_map(lost).chain(of_studies).collect()
    }

    /// What a test lacks; absent where it was made as it stands on record.
    fn lacks(&self, test: &TestOnRecord) -> Option<String> {
        let Some((comparison, row, margin)) = self.made(test) else { return Some("was not made".into()) };
        if let Some(widest) = test.margin.filter(|widest| margin > *widest) {
            return Some(format!("was made against a margin of {margin}, not of the {widest} on record"));
        }
        let made_on = physics_hash(&comparison.scene);
        if test.scene_hash.as_ref().is_some_and(|recorded| *recorded != made_on) {
            return Some(format!("was made on another scene than the one on record (its hash is {made_on})"));
        }
        let of_reference = comparison.rows.iter().filter(|other| other.observable == row.observable);
        let of_reference =
            of_reference.filter(|other| other.code == test.reference_code).map(|other| other.seeds).max();
        let (judged, reference) = (row.seeds, of_reference.unwrap_or(0));
        if judged < test.judged_seeds {
            let (code, least) = (&comparison.judged, test.judged_seeds);
            let made = plural(judged, "seed");
            return Some(format!("was made with {made} of {code}, not with the {least} on record"));
        }
        let fewest = judged.min(reference);
        (fewest < test.seeds).then(|| {
            let code = if judged == fewest { &comparison.judged } else { &test.reference_code };
            format!("was made with {} of {code}, not with the {} on record", plural(fewest, "seed"), test.seeds)
        })
    }

    /// The row of a test with its comparison and its margin.
    fn made(&self, test: &TestOnRecord) -> Option<(&Comparison, &Row, f64)> {
        self.comparisons.iter().find_map(|comparison| {
            let is = |row: &&Row| row.code == comparison.judged && test.is_made_in(row);
            let row = comparison.rows.iter().find(is)?;
            Some((comparison, row, row.margin?))
        })
    }
}
