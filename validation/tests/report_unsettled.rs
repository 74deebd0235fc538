//! Tests that are not settled, in each form of a report.

use crate::support::sample;
use makadam_compare::compare::Row;
use makadam_measure::statistics::Outcome;
use makadam_qualification::report::{Qualification, Standing, comparison_table};

/// A drum in which every test agrees.
fn sound() -> Qualification {
    let mut drum = sample::drum(false);
    for row in &mut drum.rows {
        row.outcome = row.margin.and(Some(Outcome::Agree));
    }
    sample::qualification(vec![drum])
}

/// Returns a comparison with references that differ by more than the margin in one observable.
fn at_odds() -> Qualification {
    let mut qualification = sound();
    let floor = |row: &&mut Row| row.code == "LIGGGHTS" && row.observable == "gini" && row.reference_code.is_some();
    let row = qualification.comparisons[0].rows.iter_mut().find(floor).expect("a floor");
    row.difference = Some(0.05);
    qualification
}

/// The rows are those of an earlier version, which called it agreement.
#[test]
fn where_references_are_at_odds_each_form_says_why() {
    let qualification = at_odds();
    let verdict = qualification.verdict();
    assert_eq!((verdict.standing, verdict.undecided, verdict.floor_above_margin), (Standing::Undecided, 2, 2));
    // Rows of today say themselves that they are undecided.
    let mut qualification = qualification;
    let tests = |row: &&mut Row| row.code == "Makadam" && row.observable == "gini" && row.reference_code.is_some();
    let rows = qualification.comparisons[0].rows.iter_mut().filter(tests);
    rows.for_each(|row| row.outcome = Some(Outcome::Undecided));
    let table = comparison_table(&qualification.comparisons[0], false);
    assert_eq!(table.matches("undecided (references differ)").count(), 2, "{table}");
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
    let said = " 1 difference without a margin not measured.";
    assert!(verdict.sentence.ends_with(said), "{}", verdict.sentence);
    // With nothing else, no test was made.
    lacking.comparisons[0].rows.truncate(1);
    let verdict = lacking.verdict();
    assert_eq!((verdict.standing, verdict.tests()), (Standing::NotMeasured, 0));
    assert!(
        verdict.sentence.starts_with("No verdict: no observable was tested against a margin"),
        "{}",
        verdict.sentence
    );
}
