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
