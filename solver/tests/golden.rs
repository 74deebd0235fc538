//! The bits of a few scenes, written down: a change that alters them says why. They hold in every build, whatever effects are left
//! out of it, as long as the scene does not call for them:
//!
//! ```text
//! cargo test --package makadam --no-default-features --test golden
//! cargo test --package makadam --no-default-features --features friction --test golden
//! ```

mod common;
use common::bits::{hash_after, reference_scene};
use makadam::scene::Scene;
use std::path::Path;

const STEPS: usize = 500;

fn assert_bits(scene: &Scene, expected: u64) {
    let found = hash_after(scene, STEPS, |_| ());
    assert_eq!(found, expected, "{}: {found:#018x} after {STEPS} steps, not {expected:#018x}", scene.name);
}

#[test]
#[cfg_attr(not(feature = "friction"), ignore = "these scenes have friction")]
fn drum_packing_and_heap_have_the_bits_that_they_had() {
    assert_bits(&reference_scene("drum"), 0x4ff8_4a40_189d_ae94);
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
    assert_bits(&Scene::parse(&text, &file).unwrap(), 0xbb31_549f_5aae_5809);
}

/// Every effect that a build can be without, and a line that calls for it.
const EFFECTS: [(bool, &str, &str); 10] = [
    (cfg!(feature = "friction"), "friction", "friction = 0.5"),
    (cfg!(feature = "rolling-resistance"), "rolling-resistance", "rolling_friction = 0.1"),
    (cfg!(feature = "twisting-resistance"), "twisting-resistance", "twisting_friction = 0.1"),
    (cfg!(feature = "cohesion"), "cohesion", "cohesion = { kind = 'surface-energy', work = 0.1 }"),
    (cfg!(feature = "kinetic-friction"), "kinetic-friction", "kinetic_friction = 0.0"),
    (cfg!(feature = "falling-restitution"), "falling-restitution", "restitution_speed = 0.5"),
    (
        cfg!(feature = "vibration"),
        "vibration",
        "motion = { kind = 'vibrating', amplitude = [0, 0, 0.001], frequency = 10 }",
    ),
    (
        cfg!(feature = "driven-walls"),
        "driven-walls",
        "motion = { kind = 'force-driven', axis = [0, 0, 1], force = 1, mass = 1 }",
    ),
    (cfg!(feature = "changing-gravity"), "changing-gravity", "gravity_changes = [{ time = 1, gravity = [0, 0, 0] }]"),
    (cfg!(feature = "periodic-axes"), "periodic-axes", "periodic = ['x']"),
];

#[test]
fn a_build_without_an_effect_refuses_scenes_that_call_for_it() {
    for (built, feature, line) in EFFECTS {
        let place = |key: &str| if line.starts_with(key) { line } else { "" };
        let (root, domain, wall) = (place("gravity_changes"), place("periodic"), place("motion"));
        let friction = if feature == "friction" { "" } else { "friction = 0.0" };
        let grain = if root.len() + domain.len() + wall.len() == 0 { line } else { "" };
        let text = format!(
            "name = 'effect'\ndescription = ''\nduration = 1\ngravity = [0, 0, -9.81]\n{root}\n[domain]\nmin = [0, 0, 0]\nmax = [1, 1, 1]\n{domain}\n\
             [material.grain]\ndensity = 2500\nyoungs_modulus = 1e7\npoisson_ratio = 0.3\nrestitution = 0.5\n{friction}\n{grain}\n\
             [[wall]]\nname = 'floor'\nmaterial = 'grain'\nshape = {{ kind = 'plane', point = [0, 0, 0], normal = [0, 0, 1] }}\n{wall}\n\
             [[grain]]\nmaterial = 'grain'\nradius = 0.01\nposition = [0.5, 0.5, 0.5]\n"
        );
        match (built, Scene::parse(&text, Path::new("effect.toml"))) {
            (true, Ok(_)) => {}
            (false, Err(error)) => {
                let error = error.to_string();
                assert!(error.contains(&format!("--features {feature}")) && error.contains("effect.toml:"), "{error}");
            }
            (_, outcome) => panic!("{feature}, built in: {built}: {outcome:?}"),
        }
    }
}
