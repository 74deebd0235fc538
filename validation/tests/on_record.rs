//! Tests on record: one that is not made, or made with less, is no pass, and the verdict names it.

use crate::support::sample;
use makadam_validation::compare::Row;
use makadam_validation::plan::physics_hash;
use makadam_validation::report::{Qualification, Standing, StudyOutcome, StudyTestOnRecord, TestOnRecord, write};
use makadam_validation::statistics::Outcome;
use std::fs;

/// A drum in which every test agrees, and one of its tests as a record of it.
fn sound() -> (Qualification, TestOnRecord) {
    let mut drum = sample::drum(false);
    for row in &mut drum.rows {
        row.outcome = row.margin.and(Some(Outcome::Agree));
    }
    let row = drum.rows.iter().find(|row| row.reference_code.is_some() && row.margin.is_some()).expect("a test");
    let test = TestOnRecord {
        scene: row.scene.clone(),
        observable: row.observable.clone(),
        reference_code: row.reference_code.clone().expect("a reference"),
        margin: row.margin,
        seeds: row.seeds,
        judged_seeds: 0,
        scene_hash: Some(physics_hash(&drum.scene)),
    };
    let qualification = Qualification { on_record: vec![test.clone()], ..sample::qualification(vec![drum]) };
    assert_eq!(qualification.verdict().standing, Standing::Agree);
    (qualification, test)
}

/// The verdict is no pass, and says so of the test in these words.
fn is_lost(qualification: &Qualification, test: &TestOnRecord, words: &str) {
    let verdict = qualification.verdict();
    assert_eq!((verdict.standing, verdict.not_measured), (Standing::NotMeasured, 1));
    // It counts once, made or not.
    let comparison = &qualification.comparisons[0];
    let is_test = |row: &&Row| row.code == comparison.judged && row.reference_code.is_some() && row.outcome.is_some();
    let made = comparison.rows.iter().filter(is_test).count();
    let wanting = qualification.on_record.iter().filter(|test| test.observable == "packing_factor").count();
    assert_eq!(verdict.tests(), made + wanting);
    let said = format!(" A test on record {words}: {test}.");
    assert!(verdict.sentence.ends_with(&said), "{}", verdict.sentence);
    let folder = tempfile::tempdir().expect("a temporary folder");
    write(qualification, folder.path()).expect("a report");
    let junit = fs::read_to_string(folder.path().join("junit.xml")).expect("the tests");
    assert!(junit.contains(&format!("tests=\"{}\" failures=\"0\" errors=\"1\"", verdict.tests())), "{junit}");
    assert!(junit.contains(&format!("it {words}")), "{junit}");
}

#[test]
fn a_test_that_was_not_made_is_no_pass() {
    let (mut qualification, test) = sound();
    let misspelt = TestOnRecord { observable: "packing_factor".into(), ..test.clone() };
    qualification.on_record.push(misspelt.clone());
    is_lost(&qualification, &misspelt, "was not made");
    // Of two to which the same happened one sentence tells.
    let other = TestOnRecord { observable: "packing_ratio".into(), ..test.clone() };
    qualification.on_record.push(other.clone());
    let said = format!(" Each of 2 tests on record was not made: {misspelt}, {other}.");
    assert!(qualification.verdict().sentence.ends_with(&said), "{}", qualification.verdict().sentence);
    qualification.on_record.pop();
    // A margin that is gone is a test that is gone.
    qualification.on_record.pop();
    qualification.comparisons[0].rows.iter_mut().for_each(|row| row.margin = None);
    assert_eq!(qualification.lost().len(), 1);
    assert_ne!(qualification.verdict().standing, Standing::Agree);
}

#[test]
fn another_scene_is_no_pass() {
    let (mut qualification, test) = sound();
    qualification.comparisons[0].scene.duration += 1.0;
    let hash = physics_hash(&qualification.comparisons[0].scene);
    is_lost(&qualification, &test, &format!("was made on another scene than the one on record (its hash is {hash})"));
}

#[test]
fn a_wider_margin_is_no_pass() {
    let (mut qualification, test) = sound();
    let widest = test.margin.expect("a margin");
    for row in &mut qualification.comparisons[0].rows {
        row.margin = row.margin.map(|margin| if row.observable == test.observable { 2.0 * widest } else { margin });
    }
    is_lost(
        &qualification,
        &test,
        &format!("was made against a margin of {}, not of the {widest} on record", 2.0 * widest),
    );
}

#[test]
fn fewer_seeds_of_either_code_are_no_pass() {
    let (qualification, test) = sound();
    let judged = qualification.comparisons[0].judged.clone();
    for code in [&judged, &test.reference_code] {
        let mut fewer = qualification.clone();
        let rows = fewer.comparisons[0].rows.iter_mut();
        rows.filter(|row| row.code == *code && row.observable == test.observable).for_each(|row| row.seeds -= 1);
        let words = format!("was made with {} seeds of {code}, not with the {} on record", test.seeds - 1, test.seeds);
        is_lost(&fewer, &test, &words);
    }
}

#[test]
fn fewer_seeds_of_the_judged_code_are_no_pass() {
    let (mut qualification, test) = sound();
    qualification.on_record[0].judged_seeds = test.seeds + 1;
    let judged = qualification.comparisons[0].judged.clone();
    let words = format!("was made with {} seeds of {judged}, not with the {} on record", test.seeds, test.seeds + 1);
    is_lost(&qualification, &test, &words);
}

/// A sound qualification with a study of one test, which is on record.
fn with_study(outcome: StudyOutcome) -> Qualification {
    let (mut qualification, _) = sound();
    qualification.studies.push(sample::study(outcome));
    let test = &qualification.studies[0].tests[0];
    qualification.studies_on_record =
        vec![StudyTestOnRecord { study: "stability".into(), test: test.name.clone(), known_exception: false }];
    qualification
}

#[test]
fn each_test_of_a_study_counts() {
    let of = |outcome| with_study(outcome).verdict();
    assert_eq!(of(StudyOutcome::Passed).standing, Standing::Agree);
    let failed = of(StudyOutcome::Failed);
    assert_eq!(failed.standing, Standing::Disagree);
    assert!(failed.sentence.ends_with("Hard cases: 0 of 1 test passed, 1 failed (stack-10)."), "{}", failed.sentence);
    assert_eq!(of(StudyOutcome::NotMeasured).standing, Standing::NotMeasured);
}

#[test]
fn an_exception_has_to_be_on_record() {
    let mut excused = with_study(StudyOutcome::KnownException);
    let verdict = excused.verdict();
    assert_eq!(verdict.standing, Standing::NotMeasured);
    let said = "A test on record is excused, and not on record as a known exception: stack-10 (stability).";
    assert!(verdict.sentence.ends_with(said), "{}", verdict.sentence);
    excused.studies_on_record[0].known_exception = true;
    let verdict = excused.verdict();
    assert_eq!(verdict.standing, Standing::Agree);
    assert!(verdict.sentence.contains("0 of 1 test passed, 1 known exception (stack-10)"), "{}", verdict.sentence);
}

#[test]
fn a_test_of_a_study_that_was_not_made_is_no_pass() {
    let mut lost = with_study(StudyOutcome::Passed);
    lost.studies[0].tests[0].name = "stack-11".into();
    assert_eq!(lost.verdict().standing, Standing::NotMeasured);
    lost.studies.clear();
    let verdict = lost.verdict();
    assert_eq!(verdict.standing, Standing::NotMeasured);
    assert!(verdict.sentence.ends_with("A test on record was not made: stack-10 (stability)."), "{}", verdict.sentence);
}

#[test]
fn a_record_of_names_alone_is_read() {
    let text = r#"{"scene": "drum", "observable": "gini", "reference_code": "YADE"}"#;
    let test: TestOnRecord = serde_json::from_str(text).expect("a record of an earlier version");
    assert_eq!((test.margin, test.seeds), (None, 0));
}
