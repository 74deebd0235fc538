//! Baseline: tests of a qualification as plain data, and changes from it.
//!
//! A qualification writes its tests as `tests.json`. `validation/baseline.json` has the same form with one list for each tier. A list is
//! replaced by that of a run whose verdicts are accepted.

use super::qualification::{Qualification, StudyOutcome};
use makadam_compare::compare::{Comparison, Row};
use makadam_frames::plan::physics_hash;
use makadam_measure::statistics::Outcome;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use std::path::Path;

/// Version of the layout.
const VERSION: u32 = 2;

/// Content of `tests.json`.
#[derive(Serialize, Deserialize)]
struct Document {
    version: u32,
    tiers: BTreeMap<String, Vec<Test>>,
}

/// Test: its conditions, its verdict and its values.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Test {
    /// Scene or study.
    pub group: String,
    /// Name in the group.
    pub name: String,
    /// Verdict; absent where none has been recorded yet.
    pub verdict: Option<TestVerdict>,
    /// Difference of the means, or the measured value of a study.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub value: Option<String>,
    /// Margin of equivalence, in the unit of the observable.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub margin: Option<f64>,
    /// Runs of the code under test and of the reference code, including those excluded because they are not at rest.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub runs: Option<[usize; 2]>,
    /// Hash of the scene as given to every code, 16 hexadecimal digits.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub scene_hash: Option<String>,
}

/// Verdict of a test.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(untagged)]
pub enum TestVerdict {
    /// Verdict of a test of a scene.
    Scene(Outcome),
    /// Verdict of a test of a study.
    Study(StudyOutcome),
}

impl TestVerdict {
    fn words(self) -> &'static str {
        match self {
            TestVerdict::Scene(outcome) => outcome.words(),
            TestVerdict::Study(outcome) => outcome.words(),
        }
    }

    /// Rank of the verdict; a larger one is worse.
    fn rank(self) -> u8 {
        match self {
            TestVerdict::Scene(Outcome::Agree) | TestVerdict::Study(StudyOutcome::Passed) => 0,
            TestVerdict::Study(StudyOutcome::KnownException) => 1,
            TestVerdict::Scene(Outcome::Undecided | Outcome::Exploratory) => 2,
            TestVerdict::Scene(Outcome::NotMeasured) | TestVerdict::Study(StudyOutcome::NotMeasured) => 3,
            TestVerdict::Scene(Outcome::Disagree) | TestVerdict::Study(StudyOutcome::Failed) => 4,
        }
    }
}

/// Differences between the tests of a baseline and those of a qualification.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize)]
pub struct Changes {
    /// Tests of the baseline that were not made, or with a wider margin, fewer runs or another scene.
    pub missing: Vec<String>,
    /// Tests with a worse verdict.
    pub worse: Vec<String>,
    /// Tests with a better verdict.
    pub better: Vec<String>,
    /// Tests missing in the baseline.
    pub new: Vec<String>,
}

/// Returns the tests of a qualification.
pub fn tests(qualification: &Qualification) -> Vec<Test> {
    let of_scenes = qualification.comparisons.iter().flat_map(|comparison| {
        let is_judged = |row: &&Row| row.code == comparison.judged && row.margin.is_some();
        comparison.rows.iter().filter(is_judged).filter_map(|row| test_of(comparison, row))
    });
    let of_studies = qualification.studies.iter().flat_map(|study| {
        study.tests.iter().map(|test| Test {
            group: study.name.clone(),
            name: test.name.clone(),
            verdict: Some(TestVerdict::Study(test.outcome)),
            value: Some(test.measured.clone()),
            margin: None,
            runs: None,
            scene_hash: None,
        })
    });
    of_scenes.chain(of_studies).collect()
}

fn test_of(comparison: &Comparison, row: &Row) -> Option<Test> {
    let runs = |name: &str| comparison.codes.iter().find(|code| code.code == name).map_or(0, |code| code.seeds.len());
    let reference = row.reference_code.as_ref()?;
    Some(Test {
        group: row.scene.clone(),
        name: format!("{} against {reference}", row.observable),
        verdict: Some(TestVerdict::Scene(row.outcome?)),
        value: row.difference.map(|difference| format!("{difference:.4e}")),
        margin: row.margin,
        runs: Some([runs(&row.code), runs(reference)]),
        scene_hash: Some(physics_hash(&comparison.scene)),
    })
}

/// Returns the text of `tests.json`: one test per line.
pub(super) fn tests_json(qualification: &Qualification) -> Result<String, serde_json::Error> {
    let lines: Result<Vec<String>, _> = tests(qualification).iter().map(serde_json::to_string).collect();
    let tier = serde_json::to_string(&qualification.tier)?;
    Ok(format!("{{\"version\": {VERSION}, \"tiers\": {{{tier}: [\n{}\n]}}}}\n", lines?.join(",\n")))
}

impl Test {
    /// Reads the tests of a tier from a baseline.
    ///
    /// # Errors
    /// A message with the file, the fault and the remedy.
    pub fn read(file: &Path, tier: &str) -> Result<Vec<Test>, String> {
        let fault = |problem: String| {
            format!("{}: {problem}; give validation/baseline.json, or tests.json of a qualification", file.display())
        };
        let bytes = std::fs::read(file).map_err(|error| fault(error.to_string()))?;
        let Document { version, mut tiers } =
            serde_json::from_slice(&bytes).map_err(|error| fault(error.to_string()))?;
        if version != VERSION {
            return Err(fault(format!("its version is {version}, not {VERSION}")));
        }
        let known: Vec<String> = tiers.keys().cloned().collect();
        tiers
            .remove(tier)
            .ok_or_else(|| fault(format!("it has no tests of the tier {tier}, only of {}", known.join(", "))))
    }

    fn is(&self, other: &Test) -> bool {
        (&self.group, &self.name) == (&other.group, &other.name)
    }

    fn title(&self) -> String {
        format!("{}: {}", self.group, self.name)
    }

    /// Reason why a test counts as missing although a test of its name was made.
    fn lacks(&self, made: &Test) -> Option<String> {
        match (self.margin.zip(made.margin), self.runs.zip(made.runs)) {
            (Some((was, is)), _) if is > was => Some(format!("margin {is}, baseline {was}")),
            (_, Some((was, is))) if is[0] < was[0] || is[1] < was[1] => {
                Some(format!("{} and {} runs, baseline {} and {}", is[0], is[1], was[0], was[1]))
            }
            _ if self.scene_hash != made.scene_hash => Some("another scene than that of the baseline".into()),
            _ => None,
        }
    }
}

impl Changes {
    /// Compares the tests of a qualification with a baseline.
    pub fn between(baseline: &[Test], now: &[Test]) -> Changes {
        let mut changes = Changes::default();
        for test in baseline {
            let Some(made) = now.iter().find(|made| made.is(test)) else {
                changes.missing.push(test.title());
                continue;
            };
            if let Some(reason) = test.lacks(made) {
                changes.missing.push(format!("{} ({reason})", test.title()));
            }
            let words = |test: &Test| test.verdict.map_or("", TestVerdict::words);
            let line = format!("{}: {}, baseline {}", test.title(), words(made), words(test));
            match test.verdict.zip(made.verdict).map(|(was, is)| (was.rank(), is.rank())) {
                Some((was, is)) if is > was => changes.worse.push(line),
                Some((was, is)) if is < was => changes.better.push(line),
                _ => {}
            }
        }
        let new = now.iter().filter(|made| !baseline.iter().any(|test| test.is(made)));
        changes.new.extend(new.map(Test::title));
        changes
    }

    /// Returns true if no test is missing and no verdict is worse.
    pub fn pass(&self) -> bool {
        self.missing.is_empty() && self.worse.is_empty()
    }

    /// Lists all changes, one per line.
    pub fn text(&self) -> String {
        let parts = [("missing", &self.missing), ("worse", &self.worse), ("better", &self.better), ("new", &self.new)];
        let lines: Vec<String> =
            parts.iter().flat_map(|(word, list)| list.iter().map(move |text| format!("\n  {word}: {text}"))).collect();
        match lines.is_empty() {
            true => "against the baseline: the same tests with the same verdicts".into(),
            false => format!("against the baseline:{}", lines.concat()),
        }
    }
}
