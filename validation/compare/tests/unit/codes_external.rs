//! Unit tests of `src/codes/external.rs`.

use super::*;
use crate::scenes::{find, load};

#[test]
fn frames_are_asked_for_when_makadam_is_measured() {
    let asked_of = |duration: f64, interval: f64, from: Option<f64>| {
        let mut scene = load(&find("packing-100", &[]).unwrap()).unwrap();
        scene.duration = duration;
        scene.measure = Measure { interval, from, ..scene.measure };
        asked(&scene)
    };
    assert_eq!(asked_of(0.6, 0.25, None), [0.6]);
    assert_eq!(asked_of(0.02, 0.25, None), [0.02]);
    assert_eq!(asked_of(0.6, 0.25, Some(0.0)), [0.0, 0.25, 0.5, 0.6]);
    assert_eq!(asked_of(0.5, 0.25, Some(0.2)), [0.25, 0.5]);
    assert_eq!(asked_of(0.6, 0.25, Some(0.55)), [0.6]);
    // What is just before the first time is measured, and asked for.
    assert_eq!(asked_of(0.5, 0.25, Some(0.251)), [0.25, 0.5]);
    // 3 x 0.1 is just above 0.3.
    assert_eq!(asked_of(0.3, 0.1, Some(0.1)), [0.1, 0.2, 0.3]);
}
