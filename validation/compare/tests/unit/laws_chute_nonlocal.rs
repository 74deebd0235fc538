//! Unit tests of `src/laws/chute/nonlocal.rs`.

use super::*;

#[test]
fn a_layer_of_any_depth_has_bagnolds_profile_far_from_the_slope_at_which_it_stops() {
    assert!((exponent(25.0, 300.0) - 1.5).abs() < 1e-3);
    assert!((exponent(31.0, 40.0) - 1.5).abs() < 2e-3, "{}", exponent(31.0, 40.0));
    // A layer turns to a straight profile as it gets shallower or the slope gets flatter.
    let by_depth = [300.0, 40.0, 20.0, 10.0].map(|depth| exponent(22.0, depth));
    assert!(by_depth.is_sorted_by(|a, b| a > b) && by_depth[3] < 1.0, "{by_depth:?}");
    let by_slope = [25.0, 24.0, 23.0, 22.0, 21.5].map(|angle| exponent(angle, 40.0));
    assert!(by_slope.is_sorted_by(|a, b| a > b), "{by_slope:?}");
}

#[test]
fn layers_of_the_study_have_the_exponents_of_an_independent_solution() {
    // Newton's method on a grid of another program, 800 points.
    for (angle, wanted) in [(22.0, 1.396), (23.0, 1.464), (24.0, 1.486), (25.0, 1.494)] {
        assert!((exponent(angle, 40.0) - wanted).abs() < 3e-3, "{angle}: {}", exponent(angle, 40.0));
    }
}

#[test]
fn a_layer_shallower_than_the_stopping_depth_does_not_flow() {
    // Kamrin & Henann: h_stop = pi/2 A sqrt((mu_2 - mu)/((mu_2 - mu_s) (mu - mu_s))) diameters.
    let [start, end] = BEADS.map(|angle| angle.to_radians().tan());
    let friction = 22f64.to_radians().tan();
    let stop =
        0.5 * std::f64::consts::PI * AMPLITUDE * ((end - friction) / ((end - start) * (friction - start))).sqrt();
    assert!((4.8..4.9).contains(&stop), "{stop}");
    assert!(exponent(22.0, 0.99 * stop).is_nan() && exponent(20.0, 40.0).is_nan());
}
