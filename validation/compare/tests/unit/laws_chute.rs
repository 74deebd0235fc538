//! Unit tests of `src/laws/chute/mod.rs`.

use super::*;
use approx::assert_relative_eq;

#[test]
fn the_law_has_its_limits() {
    assert_relative_eq!(friction(1e-12), 0.382, max_relative = 1e-9);
    assert_relative_eq!(friction(1e12), 0.752, max_relative = 1e-9);
    assert_relative_eq!(friction_of_beads(1e-12), 20.9_f64.to_radians().tan(), max_relative = 1e-9);
    assert_relative_eq!(friction_of_beads(0.279), 0.5 * (0.38186 + 0.64353), max_relative = 1e-3);
}

#[test]
fn the_bed_has_no_gap_that_a_grain_falls_through() {
    let centres = bed();
    assert_eq!(centres.len(), ROWS[0] * ROWS[1]);
    // Where the smallest grain comes to rest above each place.
    let (reach, [length, width]) = ((1.0 - 0.5 * SPREAD) * DIAMETER, PERIOD.map(|diameters| diameters * DIAMETER));
    let lap = |distance: f64, period: f64| distance - period * (distance / period).round();
    let rest = |x: f64, y: f64| {
        let heights = centres.iter().map(|centre| {
            let square = lap(x - centre[0], length).powi(2) + lap(y - centre[1], width).powi(2);
            centre[2] + (reach * reach - square).sqrt()
        });
        heights.fold(f64::NEG_INFINITY, f64::max)
    };
    let places =
        (0..200).flat_map(|i| (0..200).map(move |j| (f64::from(i) * length / 200.0, f64::from(j) * width / 200.0)));
    let lowest = places.map(|(x, y)| rest(x, y)).fold(f64::INFINITY, f64::min);
    assert!(lowest > -0.5 * DIAMETER, "a grain sinks to {lowest} m");
}
