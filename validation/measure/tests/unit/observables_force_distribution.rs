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

/// Distribution after it was written to a file: six digits.
fn recorded(mut distribution: ForceDistribution) -> ForceDistribution {
    for density in &mut distribution.density {
        *density = format!("{density:.5e}").parse().unwrap();
    }
    distribution
}

#[test]
fn pooling_two_distributions_is_counting_their_forces_together() {
    let (a, b) = (pool(700, 0), pool(13, 700));
    let mut both = a.clone();
    both.merge(&b);
    let parts = recorded(a.distribution(32, 0.25)).pooled(&recorded(b.distribution(32, 0.25))).unwrap();
    assert_eq!(parts.samples, 713 * 997);
    assert_eq!(parts, both.distribution(32, 0.25));
}

#[test]
fn many_small_additions_lose_nothing() {
    let mut sum = recorded(pool(1, 0).distribution(32, 0.25));
    for frame in 1..40 {
        sum = recorded(sum.pooled(&pool(1, frame).distribution(32, 0.25)).unwrap());
    }
    assert_eq!(sum, recorded(pool(40, 0).distribution(32, 0.25)));
}

#[test]
fn other_bins_cannot_be_pooled() {
    let pool = pool(1, 0);
    assert_eq!(pool.distribution(32, 0.25).pooled(&pool.distribution(16, 0.5)), None);
}
