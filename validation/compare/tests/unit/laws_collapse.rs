//! Unit tests of `src/laws/collapse/mod.rs`.

use super::*;
use approx::assert_relative_eq;

#[test]
fn the_law_has_its_two_branches() {
    assert_relative_eq!(law(1.0), 1.24);
    assert_relative_eq!(law(4.0), 3.2);
}

#[test]
fn a_single_column_is_judged_itself() {
    let judged = |run_out: f64| judge(&[mean(20.0, run_out)])[0].holds();
    assert!(judged(1.24 * 1.09) && judged(1.24 * 0.91));
    assert!(!judged(1.24 * 1.11) && !judged(1.24 * 0.89));
}

#[test]
fn the_limit_of_endless_columns_is_judged_and_nothing_else() {
    // 1 - 4 d/r0 of the law; the narrowest one is off that line and must not count.
    let missing = |radius: f64| mean(radius, 1.24 * (1.0 - 4.0 / radius));
    let findings = judge(&[mean(8.0, 0.1), missing(12.0), missing(20.0), missing(40.0)]);
    let judged: Vec<&Finding> = findings.iter().filter(|finding| finding.low.is_some()).collect();
    assert_eq!(judged.len(), 1);
    assert_relative_eq!(judged[0].value, 1.0, max_relative = 1e-12);
    let value = |words: &str| findings.iter().find(|finding| finding.what.contains(words)).unwrap().value;
    assert!(value("standard error") < 1e-9);
    assert_relative_eq!(value("r0 = 40 d"), 0.9, max_relative = 1e-12);
}

fn mean(radius_in_diameters: f64, run_out: f64) -> Mean {
    let radius = radius_in_diameters * DIAMETER;
    let given = [("aspect", 1.0), ("nominal_aspect", 1.0), ("radius", radius), ("run_out", run_out), ("share", 1.0)];
    let alternatives = ALTERNATIVES.map(|(name, _)| (name, run_out));
    let mut all = values(given);
    all.extend(values(alternatives));
    Mean { case: format!("collapse-{radius}"), seeds: 1, values: all, deviations: Values::new() }
}
