//! Unit tests of `src/qualify/studies/numerics.rs`.

use super::*;

#[test]
fn whole_interval_lies_within_the_bound() {
    let of = |values: &[f64]| verdict(Ensemble::of(values), 0.5);
    assert_eq!(of(&[0.1, 0.2, 0.3]), ("0.20 (0.03 to 0.37), 3 seeds".into(), StudyOutcome::Passed));
    assert_eq!(of(&[-0.8, 0.2, 1.0]).1, StudyOutcome::Failed, "too wide");
    assert_eq!(of(&[0.41, 0.45, 0.55]).1, StudyOutcome::Failed, "too near");
    assert_eq!(of(&[-0.61, -0.6, -0.62]).1, StudyOutcome::Failed, "beyond");
    assert_eq!(of(&[0.1]).1, StudyOutcome::NotMeasured, "one seed tells no interval");
    assert_eq!(verdict(None, 0.5).1, StudyOutcome::NotMeasured);
}
