//! The tests of a qualification as JUnit XML, for programs that collect the results of tests.

use super::qualification::{Qualification, StudyOutcome, StudyTest};
use makadam_compare::compare::{Comparison, Row};
use makadam_measure::statistics::Outcome;
use quick_junit::{NonSuccessKind, Report, TestCase, TestCaseStatus, TestSuite};

/// Returns the tests as JUnit XML: one suite per scene and study. Known exceptions are skipped; undecided tests and those that were not made
/// are errors.
pub(super) fn document(qualification: &Qualification) -> Result<String, quick_junit::SerializeError> {
    let mut report = Report::new(qualification.title.as_str());
    let case = |suite: &mut TestSuite, group: &str, name: String, status: TestCaseStatus| {
        let mut case = TestCase::new(name, status);
        case.set_classname(format!("{}.{group}", qualification.tier));
        suite.add_test_case(case);
    };
    for comparison in &qualification.comparisons {
        let scene = comparison.scene.name.as_str();
        let mut suite = TestSuite::new(scene);
        for row in comparison.rows.iter().filter(|row| row.code == comparison.judged) {
            let (Some(reference), Some(outcome)) = (&row.reference_code, row.outcome) else { continue };
            let name = format!("{} against {reference}", row.observable);
            case(&mut suite, scene, name, of_row(comparison, row, outcome));
        }
        report.add_test_suite(suite);
    }
    for study in &qualification.studies {
        let mut suite = TestSuite::new(study.title.as_str());
        study.tests.iter().for_each(|test| case(&mut suite, &study.name, test.name.clone(), of_study(test)));
        report.add_test_suite(suite);
    }
    let unchecked = qualification.unchecked.iter().chain(&qualification.failed_runs);
    let sentences = qualification.outside_spread.iter().map(|words| (words, NonSuccessKind::Failure));
    let sentences: Vec<_> = sentences.chain(unchecked.map(|words| (words, NonSuccessKind::Error))).collect();
    if !sentences.is_empty() {
        let mut suite = TestSuite::new("live runs");
        for (place, (words, kind)) in sentences.into_iter().enumerate() {
            case(&mut suite, "live", format!("live run {}", place + 1), failed(kind, words));
        }
        report.add_test_suite(suite);
    }
    if report.test_suites.iter().all(|suite| suite.test_cases.is_empty()) {
        let mut suite = TestSuite::new("no test");
        let status = skipped("no observable was tested against a margin and another code");
        suite.add_test_case(TestCase::new("no test", status));
        report.add_test_suite(suite);
    }
    report.to_string()
}

fn failed(kind: NonSuccessKind, message: &str) -> TestCaseStatus {
    let mut status = TestCaseStatus::non_success(kind);
    status.set_message(message);
    status
}

fn skipped(message: &str) -> TestCaseStatus {
    let mut status = TestCaseStatus::skipped();
    status.set_message(message);
    status
}

fn of_row(comparison: &Comparison, row: &Row, outcome: Outcome) -> TestCaseStatus {
    let number = |value: Option<f64>| value.map_or("none".into(), |value| format!("{value:.6}"));
    let said = format!("{}: difference {}, margin {}", outcome.words(), number(row.difference), number(row.margin));
    match outcome {
        Outcome::Disagree => failed(NonSuccessKind::Failure, &said),
        Outcome::NotMeasured => failed(NonSuccessKind::Error, row.missing.as_deref().unwrap_or(&said)),
        _ if comparison.references_at_odds(row) => {
            let why = "the means of the references differ by more than the margin";
            failed(NonSuccessKind::Error, &format!("{said}; {why}"))
        }
        Outcome::Agree => TestCaseStatus::success(),
        Outcome::Undecided | Outcome::Exploratory => failed(NonSuccessKind::Error, &said),
    }
}

fn of_study(test: &StudyTest) -> TestCaseStatus {
    let said = format!("{}: {}; right: {}", test.outcome.words(), test.measured, test.right);
    let said = test.remark.as_deref().unwrap_or(&said);
    match test.outcome {
        StudyOutcome::Passed => TestCaseStatus::success(),
        StudyOutcome::Failed => failed(NonSuccessKind::Failure, said),
        StudyOutcome::NotMeasured => failed(NonSuccessKind::Error, said),
        StudyOutcome::KnownException => skipped(&format!("known exception: {said}")),
    }
}
