//! Unit tests of `src/observables/force_distribution.rs`.

use super::*;

/// A pool of forces whose sizes are spread like those of a packing.
fn pool(frames: usize, from: usize) -> ForcePool {
    let mut pool = ForcePool::new("YADE");
    for frame in from..from + frames {
        let share = |index: usize| (index * 7919 + frame * 104_729) % 10_007;
        let forces: Vec<f64> = (0..997).map(|index| -(share(index) as f64 / 10_007.0).max(1e-4).ln()).collect();
        pool.add(&forces);
    }
    pool
}

#[test]
fn merging_two_pools_is_counting_their_forces_together() {
    let mut parts = pool(700, 0);
    parts.merge(&pool(13, 700));
    assert_eq!(parts.samples(), 713 * 997);
    assert_eq!(parts, pool(713, 0));
}
