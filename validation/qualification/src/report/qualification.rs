//! Qualification: the comparisons and studies of one command, and the verdict on their tests.

use makadam_compare::compare::Comparison;
use makadam_compare::study::File;
use makadam_measure::statistics::Outcome;
use makadam_view::draw::figure::Figure;
use makadam_view::draw::numbers::plural;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;

/// One qualification: every scene that was compared, and where the numbers came from.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Qualification {
    /// Title of the report.
    pub title: String,
    /// Tier that was run: "quick", "full", "release", or "compare" for a single scene.
    pub tier: String,
    /// Wall time of the whole qualification, s.
    pub wall_seconds: f64,
    /// Comparisons, a scene after the other.
    pub comparisons: Vec<Comparison>,
    /// Origin of the numbers, by name: version, commit, compiler, instruction set, threads, processor, date.
    pub provenance: BTreeMap<String, String>,
    /// Notes on the whole run: scenes that were left out, codes that are missing.
    pub notes: Vec<String>,
    /// Values of live runs of reference codes outside the spread of their recorded runs, one in a sentence.
    pub outside_spread: Vec<String>,
    /// Values of live runs of reference codes that could not be compared with their recorded runs, one in a sentence.
    pub unchecked: Vec<String>,
    /// Live runs of reference codes that failed, one in a sentence.
    pub failed_runs: Vec<String>,
    /// Studies of the qualification.
    pub studies: Vec<StudySection>,
}

/// Verdict of a qualification as a whole.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Standing {
    /// Every test of equivalence and of a study passed, and every live run lies inside the recorded spread.
    Agree,
    /// At least one failed, or a live run lies outside the recorded spread.
    Disagree,
    /// None failed, at least one is undecided.
    Undecided,
    /// None failed, and the runs are not those that the scene has registered, so that none counts as agreement.
    Exploratory,
    /// None failed, and a requested value was not measured.
    NotMeasured,
    /// No observable was tested against a margin.
    #[default]
    NothingCompared,
}

/// The verdict of a qualification, counted over the tests of the code under test against the others.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Verdict {
    /// The verdict.
    pub standing: Standing,
    /// Tests of equivalence that passed.
    pub agree: usize,
    /// Tests that failed.
    pub disagree: usize,
    /// Tests that too few seeds, or references at odds with each other, leave open.
    pub undecided: usize,
    /// Tests inside the margin of runs that the scene has not registered: they do not count as agreement.
    pub exploratory: usize,
    /// Tests that could not be made: a code lacks a value of the observable in some or all of its seeds.
    pub not_measured: usize,
    /// Differences without a margin, which are no tests, that could not be made for want of values.
    pub differences_not_measured: usize,
    /// Undecided tests in whose observable the references differ from each other by more than the margin: more seeds would not decide.
    pub floor_above_margin: usize,
    /// Live runs of reference codes outside the spread of their recorded runs.
    pub outside_spread: usize,
    /// Live values of reference codes that could not be compared with their recorded runs.
    pub unchecked: usize,
    /// Live runs of reference codes that failed.
    pub failed_runs: usize,
    /// Tests of the studies.
    pub study_tests: usize,
    /// The verdict in words; the first sentence is that of the tests of equivalence.
    pub sentence: String,
}

/// A study and its tests.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct StudySection {
    /// Its name: that of the command that makes such a study alone.
    pub name: String,
    /// Its title.
    pub title: String,
    /// Extent of the study, in a sentence.
    pub scope: String,
    /// Number of runs.
    pub runs: usize,
    /// Their wall times, s.
    pub wall_seconds: f64,
    /// Its tests; each counts in the verdict.
    pub tests: Vec<StudyTest>,
    /// Results without a test, in sentences.
    pub notes: Vec<String>,
    /// Figures of the page.
    #[serde(skip)]
    pub figures: Vec<Figure>,
    /// Data files next to the page.
    #[serde(skip)]
    pub files: Vec<File>,
}

/// A test of a study.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
pub struct StudyTest {
    /// Its name, unique in the study.
    pub name: String,
    /// Measured value.
    pub measured: String,
    /// Required value.
    pub right: String,
    /// Outcome.
    pub outcome: StudyOutcome,
    /// Reason for an exception, a failure or a missing value.
    pub remark: Option<String>,
}

/// Outcome of a test of a study.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum StudyOutcome {
    /// The measured value is the required one.
    Passed,
    /// It is not.
    Failed,
    /// It is not, which is known and documented.
    KnownException,
    /// There is no value.
    NotMeasured,
}

impl Standing {
    /// Returns the verdict in a word or two.
    pub fn words(self) -> &'static str {
        match self {
            Standing::Agree => "Agree",
            Standing::Disagree => "Disagree",
            Standing::Undecided => "Undecided",
            Standing::Exploratory => "Exploratory",
            Standing::NotMeasured => "Not measured",
            Standing::NothingCompared => "No verdict",
        }
    }

    /// Returns the style class of its mark.
    pub(crate) fn class(self) -> &'static str {
        match self {
            Standing::Agree => "agree",
            Standing::Disagree => "disagree",
            Standing::Undecided | Standing::Exploratory | Standing::NotMeasured | Standing::NothingCompared => {
                "undecided"
            }
        }
    }
}

impl StudyOutcome {
    /// Returns the name of the outcome.
    pub fn words(self) -> &'static str {
        match self {
            StudyOutcome::Passed => "passed",
            StudyOutcome::Failed => "failed",
            StudyOutcome::KnownException => "known exception",
            StudyOutcome::NotMeasured => "not measured",
        }
    }

    /// Returns the style class of its mark.
    pub(super) fn class(self) -> &'static str {
        match self {
            StudyOutcome::Passed => "agree",
            StudyOutcome::Failed => "disagree",
            StudyOutcome::KnownException | StudyOutcome::NotMeasured => "undecided",
        }
    }
}

impl StudyTest {
    /// Returns a test that passes if a condition holds.
    pub(crate) fn of(name: String, measured: String, right: String, passes: bool) -> StudyTest {
        let outcome = if passes { StudyOutcome::Passed } else { StudyOutcome::Failed };
        StudyTest { name, measured, right, outcome, remark: None }
    }

    /// Marks a test that is known to fail, with the reason; an unexpected pass is a failure.
    pub(crate) fn with_exception(self, reason: Option<&str>) -> StudyTest {
        let (outcome, remark) = match (reason, self.outcome) {
            (None, _) => return self,
            (Some(_), StudyOutcome::Passed) => {
                (StudyOutcome::Failed, "it is listed as a known exception and passes: take it off the list")
            }
            (Some(reason), _) => (StudyOutcome::KnownException, reason),
        };
        StudyTest { outcome, remark: Some(remark.into()), ..self }
    }
}

impl StudySection {
    /// Returns the names of its tests of an outcome.
    pub fn named(&self, outcome: StudyOutcome) -> Vec<&str> {
        self.tests.iter().filter(|test| test.outcome == outcome).map(|test| test.name.as_str()).collect()
    }

    /// Returns its result as a sentence.
    pub fn sentence(&self) -> String {
        let passed = self.named(StudyOutcome::Passed).len();
        let mut text = format!("{}: {passed} of {} passed", self.title, plural(self.tests.len(), "test"));
        for outcome in [StudyOutcome::Failed, StudyOutcome::NotMeasured, StudyOutcome::KnownException] {
            let names = self.named(outcome);
            let counted = match outcome {
                StudyOutcome::KnownException => plural(names.len(), outcome.words()),
                _ => format!("{} {}", names.len(), outcome.words()),
            };
            if !names.is_empty() {
                text += &format!(", {counted} ({})", names.join("; "));
            }
        }
        text + "."
    }
}

impl Verdict {
    /// Returns the number of tests of equivalence and of studies.
    pub fn tests(&self) -> usize {
        self.tests_of_scenes() + self.study_tests
    }

    fn tests_of_scenes(&self) -> usize {
        self.agree + self.disagree + self.undecided + self.exploratory + self.not_measured
    }
}

impl Qualification {
    /// Returns the verdict on the rows. Differences between two references set the lower limit and do not count.
    pub fn verdict(&self) -> Verdict {
        let mut verdict = Verdict {
            outside_spread: self.outside_spread.len(),
            unchecked: self.unchecked.len(),
            failed_runs: self.failed_runs.len(),
            study_tests: self.studies.iter().map(|study| study.tests.len()).sum(),
            ..Verdict::default()
        };
        let (mut references, mut scenes): (Vec<&str>, usize) = (Vec::new(), 0);
        for comparison in &self.comparisons {
            let before = verdict.tests_of_scenes();
            // Without the code under test, a missing value of another code is still not a success.
            let is_judged = comparison.rows.iter().any(|row| row.code == comparison.judged);
            for row in comparison.rows.iter().filter(|row| row.code == comparison.judged || !is_judged) {
                let Some(outcome) = row.outcome else { continue };
                if outcome == Outcome::NotMeasured {
                    match row.margin {
                        Some(_) => verdict.not_measured += 1,
                        None => verdict.differences_not_measured += 1,
                    }
                    continue;
                }
                let Some(reference) = row.reference_code.as_deref().filter(|_| is_judged) else { continue };
                match outcome {
                    Outcome::Disagree => verdict.disagree += 1,
                    _ if comparison.references_at_odds(row) => {
                        verdict.undecided += 1;
                        verdict.floor_above_margin += 1;
                    }
                    Outcome::Agree => verdict.agree += 1,
                    Outcome::Exploratory => verdict.exploratory += 1,
                    Outcome::Undecided | Outcome::NotMeasured => verdict.undecided += 1,
                }
                if !references.contains(&reference) {
                    references.push(reference);
                }
            }
            scenes += usize::from(verdict.tests_of_scenes() > before);
        }
        verdict.standing = standing(&verdict, &self.studies);
        let judged = self.comparisons.first().map_or("", |comparison| &comparison.judged);
        verdict.sentence = sentence(&verdict, judged, &references, scenes);
        if verdict.exploratory > 0 {
            let unregistered = self.comparisons.iter().find_map(|comparison| comparison.unregistered());
            verdict.sentence += &unregistered.map_or(String::new(), |words| format!(" Exploratory: {words}."));
        }
        for study in &self.studies {
            verdict.sentence += &format!(" {}", study.sentence());
        }
        verdict
    }
}

fn standing(verdict: &Verdict, studies: &[StudySection]) -> Standing {
    let any_study = |outcome: StudyOutcome| studies.iter().any(|study| !study.named(outcome).is_empty());
    let is_lacking =
        verdict.not_measured + verdict.differences_not_measured + verdict.unchecked + verdict.failed_runs > 0;
    let is_tested = verdict.tests_of_scenes() > verdict.not_measured;
    match () {
        () if verdict.disagree > 0 || any_study(StudyOutcome::Failed) => Standing::Disagree,
        () if is_tested && verdict.outside_spread > 0 => Standing::Disagree,
        () if is_lacking || any_study(StudyOutcome::NotMeasured) => Standing::NotMeasured,
        () if !is_tested => Standing::NothingCompared,
        () if verdict.exploratory > 0 => Standing::Exploratory,
        () if verdict.undecided > 0 => Standing::Undecided,
        () => Standing::Agree,
    }
}

fn sentence(verdict: &Verdict, judged: &str, references: &[&str], scenes: usize) -> String {
    let tests = verdict.tests_of_scenes();
    let against = if references.is_empty() { String::new() } else { format!(" against {}", join(references)) };
    let over = format!("{} of {}", plural(tests, "test"), plural(scenes, "scene"));
    let mut text = if tests == 0 {
        "No verdict: no observable was tested against a margin and a reference code.".to_string()
    } else if verdict.agree == tests {
        let all = if tests > 1 { "all " } else { "" };
        format!("{judged} agrees with {} within the margins in {all}{over}.", join(references))
    } else {
        let word = match (verdict.disagree, verdict.not_measured, verdict.exploratory) {
            (1.., ..) => "Disagree",
            (0, 1.., _) => "Not measured",
            (0, 0, 1..) => "No verdict",
            (0, 0, 0) => "Undecided",
        };
        let disagree = match verdict.disagree {
            0 => "none disagrees".into(),
            1 => "1 disagrees".into(),
            count => format!("{count} disagree"),
        };
        let others = [
            (verdict.undecided, "undecided"),
            (verdict.exploratory, "within the margins (exploratory)"),
            (verdict.not_measured, "not measured"),
        ];
        let others = others.iter().filter(|(count, _)| *count > 0);
        let others: String = others.map(|(count, words)| format!(", {count} {words}")).collect();
        format!("{word}: of {over}{against}, {} agree, {disagree}{others}.", verdict.agree)
    };
    for (count, noun, clause) in [
        (verdict.floor_above_margin, "test", "undecided because the references differ by more than the margin"),
        (verdict.differences_not_measured, "difference", "without a margin not measured"),
        (verdict.outside_spread, "live value", "of a reference code outside the spread of its recorded runs"),
        (verdict.unchecked, "live value", "of a reference code without a recorded spread"),
        (verdict.failed_runs, "live run", "of a reference code failed"),
    ] {
        if count > 0 {
            text += &format!(" {} {clause}.", plural(count, noun));
        }
    }
    text
}

/// Joins names: "a", "a and b", "a, b and c".
pub(super) fn join<T: AsRef<str>>(names: &[T]) -> String {
    match names {
        [] => "no code".into(),
        [only] => only.as_ref().into(),
        [first @ .., last] => {
            let first: Vec<&str> = first.iter().map(AsRef::as_ref).collect();
            format!("{} and {}", first.join(", "), last.as_ref())
        }
    }
}
