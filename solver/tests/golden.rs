//! The bits of a few scenes, written down: a change that alters them says why.

use crate::common::bits::{hash_after, reference_scene};
use makadam::scene::Scene;
use std::path::Path;

const STEPS: usize = 500;

fn assert_bits(scene: &Scene, expected: u64) {
    let found = hash_after(scene, STEPS, |_| ());
    assert_eq!(found, expected, "{}: {found:#018x} after {STEPS} steps, not {expected:#018x}", scene.name);
}

#[test]
fn drum_packing_and_heap_have_the_bits_that_they_had() {
    assert_bits(&reference_scene("drum"), 0xe6b0_8ca5_7e8b_9694);
    assert_bits(&reference_scene("packing"), 0x8da0_20fc_c277_1554);
    assert_bits(&reference_scene("heap"), 0x6eff_ce15_c737_43c9);
}

#[test]
fn a_smooth_packing_has_the_bits_that_it_had() {
    let file = Path::new(env!("CARGO_MANIFEST_DIR")).join("../reference-scenes/packing/scene.toml");
    let text = std::fs::read_to_string(&file)
        .unwrap()
        .replace("friction = 0.5", "friction = 0.0")
        .replace("\"packing\"", "\"smooth\"");
    assert_bits(&Scene::parse(&text).unwrap(), 0xbb31_549f_5aae_5809);
}
