//! One document, two readers: what a scene says of measuring is checked, and hashes of scenes are those of recorded results.

use makadam_validation::compare::physics_hash;
use makadam_validation::plan::Scene;
use makadam_validation::scenes;

/// Reference scenes with the hash of what other codes are given of them, by which recorded results are known.
const HASHES: [(&str, &str); 12] = [
    ("cohesive-heap", "97bf81c8022fea88"),
    ("drum", "6b1ce0781e5c37d5"),
    ("drum-caps", "f370629e4d422826"),
    ("drum-rolling", "097b1b6c0377fe23"),
    ("frictionless-packing", "1da13efe8358f726"),
    ("heap", "4ac7ca2cead7bcd6"),
    ("heap-rolling", "fcf081bd58b7642d"),
    ("oedometer", "6ea3a3f15c6b76c9"),
    ("packing", "d4a0ed254a056927"),
    ("packing-high-friction", "7dae9461a7456f11"),
    ("packing-low-friction", "8653e7e5915dbbe7"),
    ("vibrated-bed", "8856ff0207b596e6"),
];

#[test]
fn hashes_of_reference_scenes_are_those_of_recorded_results() {
    for (name, hash) in HASHES {
        let scene = scenes::load(&scenes::find(name, &[]).unwrap()).unwrap();
        assert_eq!(physics_hash(&scene), hash, "{name}");
    }
}

fn refusal(from: &str, to: &str) -> String {
    let text = scenes::text(&scenes::find("packing", &[]).unwrap()).unwrap();
    assert!(text.contains(from), "the scene no longer holds {from:?}");
    Scene::parse(&text.replacen(from, to, 1)).expect_err("accepted").to_string()
}

#[test]
fn what_a_scene_says_of_measuring_is_checked() {
    let message = refusal("interval = 0.05", "interval = 1e-6");
    assert!(message.contains("measure.interval") && message.contains("too many frames"), "{message}");
    let message = refusal("interval = 0.05", "intervall = 0.05");
    assert!(message.contains("unknown field `intervall`"), "{message}");
    let message = refusal("[measure]", "[prepare]\nduration = 1.0\nstep = 1.0\n[measure]");
    assert!(message.contains("prepare.step: 1 is out of range"), "{message}");
}

#[test]
fn a_scene_is_written_as_it_was_read() {
    for name in scenes::names() {
        let scene = scenes::load(&scenes::find(name, &[]).unwrap()).unwrap();
        let mut read = scene.clone();
        // An accuracy chooses the step, and a written scene holds both.
        read.accuracy = None;
        let again = Scene::parse(&toml::to_string(&read).unwrap()).unwrap();
        assert_eq!(again, read, "{name}");
    }
}

#[test]
fn reference_scenes_have_no_findings() {
    assert!(scenes::names().count() >= 18);
    for name in scenes::names() {
        let scene = scenes::load(&scenes::find(name, &[]).unwrap()).unwrap();
        let findings = scene.findings(None);
        assert!(findings.is_empty(), "{name}: {findings:?}");
    }
}
