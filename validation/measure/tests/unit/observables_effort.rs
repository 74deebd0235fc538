//! Unit tests of `src/observables/effort.rs`.

use super::*;

#[test]
fn the_bound_grows_with_the_grains_and_never_overflows() {
    assert_eq!(most(0), 1_000_000);
    assert_eq!(most(2_000), 3_000_000);
    assert_eq!(most(usize::MAX), usize::MAX);
}
