//! Unit tests of `src/plan/hashes.rs`.

use super::*;

const SCENE: &str = r#"
        name = "hashed"
        description = "one grain above a floor"
        duration = 0.01
        gravity = [0.0, 0.0, -9.81]
        domain = { min = [0.0, 0.0, 0.0], max = [0.1, 0.1, 0.1] }
        measure = { interval = 0.005, observables = ["balances"] }
        [material.glass]
        density = 2500.0
        youngs_modulus = 1e7
        poisson_ratio = 0.3
        friction = 0.5
        restitution = 0.5
        [[grain]]
        material = "glass"
        radius = 0.005
        position = [0.05, 0.05, 0.05]
        [solver]
        step = 1e-3
        [[compare]]
        observable = "kinetic_energy"
        margin = 1e-3
    "#;

#[test]
fn hashes_are_those_of_recorded_results() {
    let hash = |place: &str, text: &str| scene_hash(&MeasuredScene::parse(&SCENE.replace(place, text)).unwrap());
    let plain = scene_hash(&MeasuredScene::parse(SCENE).unwrap());
    assert_eq!(format!("{plain:016x}"), "5a631b7a1c620ec7");
    let prepared = "prepare = { duration = 0.01, step = 1e-3 }\noutput = { contacts = false }\n[material.glass]";
    assert_eq!(format!("{:016x}", hash("[material.glass]", prepared)), "b60b48bd5237d136");
    let accurate = hash("[solver]\n        step = 1e-3", "[accuracy]\n        relative = 0.1");
    assert_ne!(accurate, hash("[solver]\n        step = 1e-3", ""));
    assert_eq!(hash("[material.glass]", "watch = { on_escape = \"ignore\" }\n[material.glass]"), plain);
}
