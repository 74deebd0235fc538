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
    assert_bits(&reference_scene("drum"), 0xec50_8b98_0aa6_1556);
    assert_bits(&reference_scene("packing"), 0x445c_517c_fb3d_e91e);
    assert_bits(&reference_scene("heap"), 0xacc9_1bcd_6b70_205b);
}

#[test]
fn a_smooth_packing_has_the_bits_that_it_had() {
    let file = Path::new(env!("CARGO_MANIFEST_DIR")).join("../reference-scenes/packing/scene.toml");
    let text = std::fs::read_to_string(&file)
        .unwrap()
        .replace("friction = 0.5", "friction = 0.0")
        .replace("\"packing\"", "\"smooth\"");
    assert_bits(&Scene::parse(&text).unwrap(), 0x6c98_18c4_da10_b86d);
}
