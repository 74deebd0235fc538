//! Unit tests of `src/draw/axis.rs`.

use super::*;

#[test]
fn zero_has_no_place_on_a_logarithmic_axis() {
    for make in [Axis::logarithmic, Axis::fine, Axis::doublings] {
        for (low, high) in [(0.0, 2.0), (-1.0, 3e-3), (0.0, 0.0), (f64::NAN, f64::INFINITY)] {
            let axis = make("time", low, high);
            assert!(axis.low > 0.0 && axis.high > axis.low, "{low} {high}");
            assert!((1..100).contains(&axis.ticks(5).len()), "{low} {high}");
        }
    }
}
