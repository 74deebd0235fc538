//! Unit tests of `src/laws/collapse/deposit.rs`.

use super::*;
use approx::assert_relative_eq;

#[test]
fn a_layer_ends_where_half_of_the_plane_is_covered() {
    let profile = [3.0, 2.0, 1.0, 0.75, 0.25, 0.1];
    assert_relative_eq!(edge(&profile, 0.5), 4.0 * DIAMETER, max_relative = 1e-12);
    assert!(edge(&[0.1, 0.2], 0.5).is_nan());
}

#[test]
fn the_area_of_a_quarter_leaves_its_margins_out() {
    assert_relative_eq!(area(0.3, Part::Whole), PI * 0.09);
    assert_eq!(area(1.4 * MARGIN, Part::Quarter), 0.0);
    // Counted on a grid.
    let (radius, cells) = (0.1, 2000);
    let cell = radius / f64::from(cells);
    let inside = |i: i32, j: i32| {
        let [x, y] = [i, j].map(|place| (f64::from(place) + 0.5) * cell);
        x > MARGIN && y > MARGIN && x.hypot(y) < radius
    };
    let counted = (0..cells).flat_map(|i| (0..cells).map(move |j| (i, j))).filter(|&(i, j)| inside(i, j)).count();
    assert_relative_eq!(area(radius, Part::Quarter), counted as f64 * cell * cell, max_relative = 1e-3);
}
