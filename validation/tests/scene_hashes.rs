//! One document, two readers: what a scene says of measuring is checked, and hashes of scenes are those of recorded results.

use makadam_validation::compare::physics_hash;
use makadam_validation::plan::Scene;
use makadam_validation::provenance::scene_hash;
use makadam_validation::scenes;

/// Hashes of the reference scenes, by which recorded results are known: of all that they say, and of what other codes are given.
const HASHES: [(&str, u64, &str); 0] = [];

#[test]
fn hashes_of_reference_scenes_are_those_of_recorded_results() {
    let found = scenes::names().map(|name| {
        let scene = scenes::load(&scenes::find(name, &[]).unwrap()).unwrap();
        (name, scene_hash(&scene), physics_hash(&scene))
    });
    let known = HASHES.iter().map(|&(name, scene, physics)| (name, scene, physics.to_string()));
    assert_eq!(found.collect::<Vec<_>>(), known.collect::<Vec<_>>());
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
