//! Unit tests of `src/observables/regions.rs`.

use super::*;
use crate::observables::{measured_in, series};
use makadam::scene::SceneError;
use makadam_frames::plan::MeasuredScene;
use makadam_frames::recording::Recording;

const SCENE: &str = r#"
    name = "regions"
    description = "grains in two halves"
    duration = 1.0
    domain = { min = [-1.0, -1.0, -1.0], max = [1.0, 1.0, 1.0] }
    [material]
    a = { density = 2500.0, youngs_modulus = 1e7, poisson_ratio = 0.3, friction = 0.5, restitution = 0.3 }
    b = { density = 2000.0, youngs_modulus = 1e7, poisson_ratio = 0.3, friction = 0.5, restitution = 0.3 }
    [[population]]
    count = 3
    material = "a"
    radius = { kind = "fixed", value = 0.01 }
    region = { kind = "box", min = [-0.5, -0.5, -0.5], max = [0.5, 0.5, 0.5] }
    [[population]]
    count = 2
    material = "b"
    radius = { kind = "fixed", value = 0.01 }
    region = { kind = "box", min = [-0.5, -0.5, 0.5], max = [0.5, 0.5, 0.9] }
    [measure]
    from = 0.25
    interval = 0.25
    observables = ["regions"]
    [[measure.region]]
    name = "lower half"
    within = { kind = "box", min = [-1.0, -1.0, -1.0], max = [1.0, 1.0, 0.0] }
    [[measure.region]]
    name = "b in the tube"
    within = { kind = "cylinder", base = [0.0, 0.0, -1.0], axis = [0.0, 0.0, 2.0], radius = 0.1, length = 2.0 }
    material = "b"
    [[compare]]
    observable = "grain_count(lower half)"
    at = [0.0, 0.5]
"#;

/// Three grains of `a` at heights that fall by 0.25 per frame, two of `b`, one of them in the tube.
fn recording() -> Recording {
    let grain =
        |id: u32, position: [f64; 3]| Particle { id, position, radius: 0.01, velocity: [0.0; 3], spin: [0.0; 3] };
    let frame = |number: u32| {
        let fallen = 0.25 * f64::from(number);
        let of_a = (0..3).map(|id| grain(id, [0.0, 0.0, 0.3 + 0.25 * f64::from(id) - fallen]));
        let of_b = (3..5).map(|id| grain(id, [f64::from(id - 3) * 0.5, 0.0, 0.9]));
        Snapshot { time: fallen, particles: of_a.chain(of_b).collect(), ..Snapshot::default() }
    };
    Recording {
        scene: "regions".into(),
        code: "Makadam".into(),
        version: String::new(),
        seed: 1,
        time_step: 1e-3,
        rayleigh_fraction: None,
        stiffness_factor: 1.0,
        threads: 1,
        wall_seconds: 1.0,
        core_seconds: None,
        simulated_seconds: 1.0,
        frames: (0..5).map(frame).collect(),
        lacks: Vec::new(),
        alarms: Vec::new(),
        notes: Vec::new(),
    }
}

#[test]
fn grains_are_counted_by_place_and_material() {
    let (scene, recording) = (MeasuredScene::parse(SCENE).unwrap(), recording());
    let measured = measured_in(&scene, &recording).measurements;
    let value = |name: &str| measured.iter().find(|one| one.observable == name).map(|one| one.value);
    // Below zero are 0, 0, 1, 2, 3 grains; the means are over the frames from 0.25 s on.
    assert_eq!(value("grain_count(lower half)"), Some(1.5));
    assert_eq!(value("grain_count(b in the tube)"), Some(1.0));
    assert_eq!(value("grain_count(lower half) at 0 s"), Some(0.0));
    assert_eq!(value("grain_count(lower half) at 0.5 s"), Some(2.0));
    let curve = &series(&scene, &recording)[0];
    assert_eq!(
        (curve.observable.as_str(), &curve.value[..]),
        ("grain_count(lower half)", &[0.0, 0.0, 1.0, 2.0, 3.0][..])
    );
}

#[test]
fn times_without_a_frame_and_unknown_names_are_refused() {
    let message = |text: String| match MeasuredScene::parse(&text) {
        Err(error @ SceneError::Invalid { .. }) => error.to_string(),
        other => panic!("{other:?}"),
    };
    let replaced = |from: &str, to: &str| message(SCENE.replace(from, to));
    let off = replaced("at = [0.0, 0.5]", "at = [0.0, 0.6]");
    assert!(off.contains("compare[0].at[1]") && off.contains("a multiple of measure.interval"), "{off}");
    assert!(replaced("at = [0.0, 0.5]", "at = [0.0, 1.0]").contains("compare[0].at[1]"));
    assert!(replaced("from = 0.25", "").contains("give measure.from"));
    let unknown = replaced(
        "radius = 0.1, length = 2.0 }\n    material = \"b\"",
        "radius = 0.1, length = 2.0 }\n    material = \"c\"",
    );
    assert!(unknown.contains("measure.region[1].material") && unknown.contains("a, b"), "{unknown}");
    assert!(replaced("b in the tube", "lower half").contains("measure.region[1].name"));
}
