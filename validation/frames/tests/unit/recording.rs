//! Unit tests of `src/recording.rs`.

use super::*;
use makadam::snapshot::Particle;
use std::path::PathBuf;

#[test]
fn frames_of_another_scene_are_told_apart() {
    let scene = |name: &str| {
        let root = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../../reference-scenes");
        MeasuredScene::load(&root.join(name).join("scene.toml")).unwrap()
    };
    let (drum, packing) = (scene("drum"), scene("packing"));
    let simulation = makadam::Simulation::new(&drum, 1).unwrap();
    let frame = simulation.snapshot();
    assert_eq!(frame_belongs_to(&frame, &drum), Ok(()));
    assert!(frame_belongs_to(&frame, &packing).unwrap_err().contains("1600 grains, and the scene has"));
    let mut larger = frame.clone();
    larger.particles[7].radius *= 3.0;
    assert!(frame_belongs_to(&larger, &drum).unwrap_err().contains("grain 7 has a radius"));
}

#[test]
fn every_changed_bit_of_a_recording_is_seen_and_one_without_a_seal_is_refused() {
    let grain = Particle { id: 0, position: [0.1; 3], radius: 0.005, velocity: [0.0; 3], spin: [0.0; 3] };
    let recording = Recording {
        scene: "small".into(),
        code: "YADE".into(),
        version: "1".into(),
        seed: 1,
        time_step: 1e-5,
        rayleigh_fraction: Some(0.1),
        stiffness_factor: 1.0,
        threads: 1,
        wall_seconds: 2.0,
        core_seconds: None,
        simulated_seconds: 0.2,
        frames: vec![Snapshot { particles: vec![grain], ..Snapshot::default() }],
        lacks: vec![Content::Spins],
        alarms: vec![Noticed { what: "deep".into(), fatal: true }],
        notes: Vec::new(),
    };
    let sealed = recording.to_bytes();
    assert_eq!(Recording::parse(&sealed).unwrap(), recording);
    for place in 0..sealed.len() {
        for bit in 0..8 {
            let mut changed = sealed.clone();
            changed[place] ^= 1 << bit;
            assert!(Recording::parse(&changed).is_err(), "bit {bit} of byte {place}");
        }
    }
    let bare = postcard::to_stdvec(&recording).unwrap();
    assert!(Recording::parse(&bare).is_err());
}
