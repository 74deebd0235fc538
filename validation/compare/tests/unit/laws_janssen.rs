//! Unit tests of `src/laws/janssen.rs`.

use super::*;
use approx::assert_relative_eq;

/// Fillings whose apparent masses follow the law with M_s = 2 kg, one of them changed by so many kg.
fn means(change: f64) -> Vec<Mean> {
    let mean = |(number, mass): (usize, f64)| Mean {
        case: format!("janssen-{number}"),
        seeds: 1,
        values: values([
            ("mass", mass),
            ("apparent_mass", 2.0 * law(mass / 2.0) + if number == 2 { change } else { 0.0 }),
            ("speed_share", 1.0),
            ("bulk_density", 1500.0),
            ("radius", 0.075),
        ]),
        deviations: Values::new(),
    };
    [0.5, 1.0, 2.0, 4.0, 8.0].into_iter().enumerate().map(mean).collect()
}

#[test]
fn the_saturated_mass_is_fitted() {
    assert_relative_eq!(saturated(&means(0.0)), 2.0, max_relative = 1e-6);
}

#[test]
fn a_mass_off_the_curve_is_outside() {
    assert!(judge(&means(0.05))[0].holds());
    assert!(!judge(&means(0.4))[0].holds());
    assert!(!judge(&means(f64::NAN))[0].holds());
}

#[test]
fn rankines_limits_of_thirty_degrees() {
    let [active, passive] = rankine((PI / 6.0).tan());
    assert_relative_eq!(active, 1.0 / 3.0, max_relative = 1e-12);
    assert_relative_eq!(passive, 3.0, max_relative = 1e-12);
}
