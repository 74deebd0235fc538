//! Unit tests of `src/laws/beverloo.rs`.

use super::*;
use approx::assert_relative_eq;

/// Flows of a law with this C, k and exponent.
fn means(c: f64, k: f64, exponent: f64) -> Vec<Mean> {
    let mean = |hole: f64| Mean {
        case: format!("beverloo-{hole}"),
        seeds: 1,
        values: values([("hole", hole), ("flow_scaled", c * (hole - k).powf(exponent))]),
        deviations: Values::new(),
    };
    [6.0, 8.0, 10.0, 12.0].map(mean).into()
}

#[test]
fn exponent_and_coefficients_are_found() {
    let fit = Fit::of(&means(0.6, 1.4, 2.3));
    assert_relative_eq!(fit.exponent, 2.3, max_relative = 1e-9);
    let fit = Fit::of(&means(0.6, 1.7, 2.5));
    assert_relative_eq!(fit.free[0], 0.6, max_relative = 1e-9);
    assert_relative_eq!(fit.free[1], 1.7, max_relative = 1e-9);
}

#[test]
fn the_exponent_is_judged() {
    assert!(judge(&means(0.5, 1.4, 2.59))[0].holds());
    assert!(!judge(&means(0.5, 1.4, 2.61))[0].holds());
    assert!(!judge(&means(0.0, 1.4, 2.5))[0].holds());
}
