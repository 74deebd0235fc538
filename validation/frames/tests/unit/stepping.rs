//! Unit tests of `src/stepping.rs`.

use super::*;

#[test]
fn frames_fall_on_multiples_of_the_interval() {
    let due: Vec<u64> = (0..=300).filter(|&step| frame_is_due(step, 5e-4, 0.05)).collect();
    assert_eq!(due, [100, 200, 300]);
    let due: Vec<u64> = (0..=10).filter(|&step| frame_is_due(step, 1.0, 2.5)).collect();
    assert_eq!(due, [3, 5, 8, 10]);
}
