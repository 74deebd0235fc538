//! Unit tests of `src/statistics/distributions.rs`.

use super::ranked;
use std::convert::Infallible;

#[test]
fn a_rank_is_found_as_by_sorting() {
    let mut random = 1_u64;
    let mut numbers: Vec<f64> = (0..2000)
        .map(|n| {
            random = random.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            // Equal ones, tiny ones, zeros, and neighbours that differ in their last bits alone.
            match n % 5 {
                0 => 0.0,
                1 => 0.25,
                2 => f64::from_bits(0x3fe0_0000_0000_0000 + (random >> 60)),
                _ => (random >> 11) as f64 * 1e-18_f64.powi(n % 3),
            }
        })
        .collect();
    let find = |rank: u64| {
        let Ok(found) = ranked::<Infallible>(rank, |look| {
            numbers.iter().for_each(|number| look(*number));
            Ok(())
        });
        found
    };
    let found: Vec<f64> = (0..2000).map(find).collect();
    numbers.sort_by(f64::total_cmp);
    assert_eq!(found, numbers);
}
