//! The tests of a qualification as JUnit XML, for whatever collects the results of tests.

use super::on_record::Lost;
use super::qualification::Qualification;
use super::studies::StudyOutcome;
use super::words;
use crate::compare::{Comparison, Row};
use crate::statistics::Outcome;
use quick_junit::{NonSuccessKind, Report, TestCase, TestCaseStatus, TestSuite};

/// One suite a scene and a study, one case a test; known exceptions are skipped, undecided tests and those that were not made, or with less
/// than is on record, are errors, not skipped.
pub(super) fn document(qualification: &Qualification) -> Result<String, quick_junit::SerializeError> {
    let mut report = Report::new(qualification.title.as_str());
    let mut lost = qualification.lost();
    for comparison in &qualification.comparisons {
        let mut suite = TestSuite::new(comparison.scene.name.as_str());
        for row in comparison.rows.iter().filter(|row| row.code == comparison.judged) {
            let (Some(reference), Some(outcome)) = (&row.reference_code, row.outcome) else { continue };
            let name = format!("{} against {reference}", row.observable);
            let made = match take(&mut lost, |lost| lost.is_of(row)) {
                // A disagreement goes before what the test lacks.
                Some(what) if outcome != Outcome::Disagree => failed(NonSuccessKind::Error, &format!("it {what}")),
                _ => status(comparison, row, outcome),
            };
            let mut case = TestCase::new(name, made);
            case.set_classname(format!("{}.{}", qualification.tier, comparison.scene.name));
            suite.add_test_case(case);
        }
        report.add_test_suite(suite);
    }
    for study in &qualification.studies {
        let mut suite = TestSuite::new(study.title.as_str());
        for test in &study.tests {
            let said = format!("{}: {}; right: {}", test.outcome.words(), test.measured, test.right);
            let said = test.remark.as_deref().unwrap_or(&said);
            let made = match (test.outcome, take(&mut lost, |lost| lost.is_of_study(&study.name, test))) {
                (StudyOutcome::Failed, _) => failed(NonSuccessKind::Failure, said),
                (_, Some(what)) => failed(NonSuccessKind::Error, &format!("it {what}")),
                (StudyOutcome::Passed, None) => TestCaseStatus::success(),
                (StudyOutcome::NotMeasured, None) => failed(NonSuccessKind::Error, said),
                (StudyOutcome::KnownException, None) => {
                    let mut status = TestCaseStatus::skipped();
                    status.set_message(format!("known exception: {said}"));
                    status
                }
            };
            let mut case = TestCase::new(test.name.as_str(), made);
            case.set_classname(format!("{}.{}", qualification.tier, study.name));
            suite.add_test_case(case);
        }
        report.add_test_suite(suite);
    }
    if !lost.is_empty() {
        let mut suite = TestSuite::new("tests on record");
        for Lost { test, what } in lost {
            let message = format!("it {what}");
            suite.add_test_case(TestCase::new(test.to_string(), failed(NonSuccessKind::Error, &message)));
        }
        report.add_test_suite(suite);
    }
    let unchecked = qualification.unchecked.iter().chain(&qualification.failed_runs);
    let sentences = qualification.outside_spread.iter().map(|words| (words, NonSuccessKind::Failure));
    let sentences: Vec<_> = sentences.chain(unchecked.map(|words| (words, NonSuccessKind::Error))).collect();
    if !sentences.is_empty() {
        let mut suite = TestSuite::new("live runs");
        for (place, (words, kind)) in sentences.into_iter().enumerate() {
            suite.add_test_case(TestCase::new(format!("live run {}", place + 1), failed(kind, words)));
        }
        report.add_test_suite(suite);
    }
    if report.test_suites.iter().all(|suite| suite.test_cases.is_empty()) {
        let mut suite = TestSuite::new("no test");
        let words = "no observable was tested against a margin and another code";
        let mut status = TestCaseStatus::skipped();
        status.set_message(words);
        suite.add_test_case(TestCase::new("nothing to judge by", status));
        report.add_test_suite(suite);
    }
    report.to_string()
}

/// Takes out what a test lacks that was made; what is left in the list was not made.
fn take(lost: &mut Vec<Lost>, is_of: impl Fn(&Lost) -> bool) -> Option<String> {
    lost.extract_if(.., |lost| is_of(lost)).last().map(|Lost { what, .. }| what)
}

fn failed(kind: NonSuccessKind, message: &str) -> TestCaseStatus {
    let mut status = TestCaseStatus::non_success(kind);
    status.set_message(message);
    status
}

fn status(comparison: &Comparison, row: &Row, outcome: Outcome) -> TestCaseStatus {
    let number = |value: Option<f64>| value.map_or("none".into(), |value| format!("{value:.6}"));
    let said =
        format!("{}: difference {}, margin {}", words::outcome(outcome), number(row.difference), number(row.margin));
    let at_odds = outcome != Outcome::Disagree && comparison.references_at_odds(row);
    match outcome {
        Outcome::Agree | Outcome::Exploratory | Outcome::Undecided if at_odds => {
            let why = "the means of the references differ by more than the margin, so that agreement with one of them proves nothing";
            failed(NonSuccessKind::Error, &format!("{said}; {why}"))
        }
        Outcome::Agree => TestCaseStatus::success(),
        Outcome::Disagree => failed(NonSuccessKind::Failure, &said),
        Outcome::Undecided | Outcome::Exploratory | Outcome::NotMeasured => {
            failed(NonSuccessKind::Error, row.missing.as_deref().unwrap_or(&said))
        }
    }
}
