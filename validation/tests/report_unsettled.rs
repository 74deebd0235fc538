//! What a report says of an earlier one, and of tests that are not settled, in each of its forms.

use crate::support::sample;
use makadam_validation::compare::Row;
use makadam_validation::report::{Changes, Qualification, Standing, comparison_table, write};
use makadam_validation::statistics::Outcome;
use std::fs;

/// A drum in which every test agrees.
fn sound() -> Qualification {
    let mut drum = sample::drum(false);
    for row in &mut drum.rows {
        row.outcome = row.margin.and(Some(Outcome::Agree));
    }
    sample::qualification(vec![drum])
}

/// The same with references that differ by more than the margin in one observable.
fn at_odds() -> Qualification {
    let mut qualification = sound();
    let floor = |row: &&mut Row| row.code == "LIGGGHTS" && row.observable == "gini" && row.reference_code.is_some();
    let row = qualification.comparisons[0].rows.iter_mut().find(floor).expect("a floor");
    row.difference = Some(0.05);
    qualification
}

#[test]
fn what_is_different_from_an_earlier_report_is_told() {
    let earlier = sound();
    assert_eq!(Changes::between(&earlier, &earlier), Changes::default());
    let mut now = earlier.clone();
    let rows = &mut now.comparisons[0].rows;
    let gone = rows.iter().position(|row| row.reference_code.is_some()).expect("a pair");
    rows.remove(gone);
    let moved = rows.iter_mut().find(|row| row.standard_deviation.is_some() && row.seeds > 1).expect("a mean");
    moved.mean = moved.mean.zip(moved.standard_deviation).map(|(mean, deviation)| mean + 10.0 * deviation);
    let changes = Changes::between(&earlier, &now);
    assert!(changes.has_lost() && changes.lost.len() == 1, "{changes:?}");
    assert!(changes.moved.len() == 1 && changes.gained.is_empty(), "{changes:?}");
    let back = Changes::between(&now, &earlier);
    assert!(!back.has_lost() && back.gained.len() == 1, "{back:?}");
}

#[test]
fn other_conditions_than_those_of_an_earlier_report_are_told() {
    let earlier = sound();
    let mut now = earlier.clone();
    now.comparisons[0].scene.duration += 1.0;
    now.comparisons[0].rows[0].margin = Some(9.0);
    let changes = Changes::between(&earlier, &now);
    assert_eq!(changes.conditions.len(), 2, "{changes:?}");
    assert!(changes.conditions[0].contains("before, 9 now"), "{changes:?}");
    assert!(changes.text().contains("other conditions: drum: another scene than before"), "{}", changes.text());
}

/// The rows are those of an earlier version, which called it agreement.
#[test]
fn where_references_are_at_odds_each_form_says_why() {
    let qualification = at_odds();
    let verdict = qualification.verdict();
    assert_eq!((verdict.standing, verdict.undecided, verdict.floor_above_margin), (Standing::Undecided, 2, 2));
    let folder = tempfile::tempdir().unwrap();
    write(&qualification, folder.path()).unwrap();
    let file = |name: &str| fs::read_to_string(folder.path().join(name)).unwrap();
    assert_eq!(file("junit.xml").matches("the means of the references differ by more than the margin").count(), 2);
    assert!(file("badge.svg").contains("6 of 8 tests agree, others undecided"));
    // Rows of today say themselves that they are undecided.
    let mut qualification = qualification;
    let tests = |row: &&mut Row| row.code == "Makadam" && row.observable == "gini" && row.reference_code.is_some();
    let rows = qualification.comparisons[0].rows.iter_mut().filter(tests);
    rows.for_each(|row| row.outcome = Some(Outcome::Undecided));
    let table = comparison_table(&qualification.comparisons[0], false);
    assert_eq!(table.matches("undecided (references differ)").count(), 2, "{table}");
}

#[test]
fn a_badge_tells_live_runs_that_failed_from_tests_that_were_not_made() {
    let folder = tempfile::tempdir().unwrap();
    let badge = |qualification: &Qualification| {
        write(qualification, folder.path()).unwrap();
        fs::read_to_string(folder.path().join("badge.svg")).unwrap()
    };
    let failed = Qualification { failed_runs: vec!["drum: the live run of YADE failed".into()], ..sound() };
    assert!(badge(&failed).contains("8 of 8 tests agree, live runs failed or unchecked"));
    let mut lacking = sound();
    lacking.comparisons[0].rows[0].outcome = Some(Outcome::NotMeasured);
    assert!(badge(&lacking).contains("agree, others not measured"));
}

#[test]
fn a_difference_without_a_margin_that_was_not_made_is_told_and_no_test() {
    let mut lacking = sound();
    let row = &mut lacking.comparisons[0].rows[0];
    (row.margin, row.outcome, row.missing) = (None, Some(Outcome::NotMeasured), Some("Makadam has no value".into()));
    let verdict = lacking.verdict();
    assert_eq!((verdict.standing, verdict.agree, verdict.tests()), (Standing::NotMeasured, 7, 7));
    assert_eq!((verdict.not_measured, verdict.differences_not_measured), (0, 1));
    assert!(verdict.sentence.starts_with("Makadam agrees with "), "{}", verdict.sentence);
    let said = " 1 difference without a margin could not be made for want of values.";
    assert!(verdict.sentence.ends_with(said), "{}", verdict.sentence);
    // With nothing else, no test was made.
    lacking.comparisons[0].rows.truncate(1);
    let verdict = lacking.verdict();
    assert_eq!((verdict.standing, verdict.tests()), (Standing::NotMeasured, 0));
    assert!(verdict.sentence.starts_with("No observable was tested against a margin"), "{}", verdict.sentence);
}

#[test]
fn a_report_without_a_test_has_a_case_that_says_so() {
    let mut nothing = sound();
    nothing.comparisons[0].rows.clear();
    let folder = tempfile::tempdir().unwrap();
    write(&nothing, folder.path()).unwrap();
    let junit = fs::read_to_string(folder.path().join("junit.xml")).unwrap();
    assert!(junit.contains("tests=\"1\"") && junit.contains("<skipped message=\"no observable was tested"), "{junit}");
}
