//! Tests that a qualification must make whatever the scenes say, and how little of each may be left.

use super::qualification::Qualification;
use super::studies::StudyTestOnRecord;
use crate::compare::{Comparison, Row, physics_hash};
use crate::draw::numbers::plural;
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

/// A test on record that was not made, or with less than is on record.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Lost {
    /// The test.
    pub test: String,
    /// What became of it, in words that follow its name.
    pub what: String,
}

impl fmt::Display for TestOnRecord {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        out.write_str(&name(&self.observable, &self.scene, &self.reference_code))
    }
}

impl Lost {
    /// Whether a row is what was made of the test.
    pub(super) fn is_of(&self, row: &Row) -> bool {
        row.reference_code.as_ref().is_some_and(|reference| self.test == name(&row.observable, &row.scene, reference))
    }
}

/// A test of equivalence in words.
fn name(observable: &str, scene: &str, reference_code: &str) -> String {
    format!("{observable} of {scene} against {reference_code}")
}

impl Qualification {
    /// Tests on record that were not made as they stand there.
    pub fn lost(&self) -> Vec<Lost> {
        let lost = |test: &TestOnRecord| Some(Lost { test: test.to_string(), what: self.lacks(test)? });
        let of_study = |on_record: &StudyTestOnRecord| {
            let study = self.studies.iter().find(|study| study.name == on_record.study);
            let what = study.map_or(Some("was not made".into()), |study| study.lacks(on_record))?;
            Some(Lost { test: format!("{} ({})", on_record.test, on_record.study), what })
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
            let is = |row: &&Row| {
                row.code == comparison.judged
                    && (&row.scene, &row.observable, row.reference_code.as_ref())
                        == (&test.scene, &test.observable, Some(&test.reference_code))
            };
            let row = comparison.rows.iter().find(is)?;
            Some((comparison, row, row.margin?))
        })
    }
}
