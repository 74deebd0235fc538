//! Studies in a report: the page, the data.

use crate::support::sample;
use makadam_qualification::report::{Qualification, StudyOutcome, write};
use roxmltree::{Document, ParsingOptions};
use std::fs;

fn with(outcome: StudyOutcome) -> Qualification {
    let mut qualification = sample::qualification(vec![sample::drum(false)]);
    qualification.studies.push(sample::study(outcome));
    qualification
}

#[test]
fn a_study_stands_in_every_file() {
    let qualification = Qualification { comparisons: vec![sample::drum(true)], ..with(StudyOutcome::Failed) };
    let folder = tempfile::tempdir().unwrap();
    let page_file = write(&qualification, folder.path()).unwrap();
    let page = fs::read_to_string(&page_file).unwrap();
    for words in [
        "<section id=\"study-stability\">",
        "<a href=\"#study-stability\">Hard cases</a>",
        "<strong>Failed.</strong> Hard cases: 0 of 1 test passed, 1 failed (stack-10).",
        "10 grains stay where they are",
    ] {
        assert!(page.contains(words), "{words}");
    }
    let options = ParsingOptions { allow_dtd: true, ..Default::default() };
    let document = Document::parse_with_options(&page, options).unwrap();
    assert!(document.descendants().any(|node| node.attribute("href") == Some("stability.csv")));
    assert!(folder.path().join("stability.csv").is_file());
}

#[test]
fn a_known_exception_is_said_and_is_no_success() {
    let folder = tempfile::tempdir().unwrap();
    let page_file = write(&with(StudyOutcome::KnownException), folder.path()).unwrap();
    let page = fs::read_to_string(page_file).unwrap();
    assert!(page.contains("0 of 1 test passed, 1 known exception (stack-10)."));
}
