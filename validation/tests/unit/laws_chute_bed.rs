//! Unit tests of `src/laws/chute/bed.rs`.

use super::super::SPREAD;
use super::*;

#[test]
fn the_bed_has_no_gap_that_a_grain_falls_through() {
    let centres = centres();
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
