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
    let hash = |more: &str| {
        scene_hash(
            &MeasuredScene::parse(&SCENE.replace("[material.glass]", &format!("{more}\n[material.glass]"))).unwrap(),
        )
    };
    assert_eq!(format!("{:016x}", hash("")), "5a631b7a1c620ec7");
    let prepared = "prepare = { duration = 0.01, step = 1e-3 }\noutput = { contacts = false }";
    assert_eq!(format!("{:016x}", hash(prepared)), "b60b48bd5237d136");
    assert_ne!(hash("accuracy = { relative = 0.1 }"), hash(""));
    assert_eq!(hash("watch = { on_escape = \"ignore\" }"), hash(""));
}
