//! Unit tests of `src/qualify/studies/physics.rs`.

use super::*;

#[test]
fn failed_variation_proves_a_need_only_where_known() {
    let outcome = |unmeasurable: &'static str, changed_mean: Option<f64>, need: Need| {
        let ablated = Ablated { scene: "tiny", seeds: 2, needed: "Coulomb friction", unmeasurable };
        let row = Row {
            effect: "Coulomb friction",
            change: "off".into(),
            observable: "packing_fraction".into(),
            mean: Some(0.6),
            changed_mean,
            interval90: None,
            margin: 0.006,
            need,
        };
        let tests =
            ablation_tests(&ablated, &Ablation { seeds: vec![1, 2], rows: vec![row], runs: 4, wall_seconds: 1.0 });
        assert_eq!(tests.len(), 2);
        tests[1].outcome
    };
    assert_eq!(outcome("", Some(0.65), Need::Needed), StudyOutcome::Passed);
    assert_eq!(outcome("", Some(0.6), Need::NotNeeded), StudyOutcome::Failed);
    assert_eq!(outcome("", None, Need::NotMeasurable), StudyOutcome::NotMeasured);
    assert_eq!(outcome("Coulomb friction", None, Need::NotMeasurable), StudyOutcome::Passed);
}
