//! Drums and heaps whose walls do not fit the definitions, or fit them for some of the time.

use crate::support::beds::{
    Random, drum_scene, frame, particles, random_crystal, recording, scene, tilted_drum, value,
};
use approx::assert_abs_diff_eq;
use makadam::scene::Motion;
use makadam::snapshot::{Contact, DrivenWall, Partner, Snapshot};
use makadam_frames::plan::MeasuredScene;
use makadam_measure::observables::{Measured, impossible, measured_in, series, unmeasured};
use nalgebra::Vector3;

/// Frames of grains that turn about the axis of a drum at `rate` (rad/s), and drag the shell's lowest point along with 0.3 N against it.
fn turning(rate: f64, degrees: f64) -> Vec<Snapshot> {
    let mut frames = tilted_drum(10, degrees, 0.0, 0.005);
    for frame in &mut frames {
        for grain in &mut frame.particles {
            grain.velocity = Vector3::new(0.0, rate, 0.0).cross(&Vector3::from(grain.position)).into();
        }
        frame.contacts.push(Contact {
            first: 0,
            second: Partner::Wall(0),
            point: [0.0, 0.0, -0.1],
            normal: [0.0, 0.0, -1.0],
            normal_force: 1.0,
            tangential_force: [0.3 * rate.signum(), 0.0, 0.0],
        });
    }
    frames
}

/// Measures frames a twentieth of a second apart that begin at a time (s).
fn measured(scene: &MeasuredScene, mut frames: Vec<Snapshot>, from: f64) -> Measured {
    frames.iter_mut().enumerate().for_each(|(number, frame)| frame.time = from + 0.05 * number as f64);
    measured_in(scene, &recording(frames))
}

fn has(found: &Measured, name: &str) -> bool {
    found.measurements.iter().any(|one| one.observable == name)
}

fn reason(scene: &MeasuredScene, found: &Measured, name: &str) -> String {
    unmeasured(scene, &[], found).into_iter().find(|one| one.observable == name).expect("it has no value").reason
}

const FLOW: &str = r#"["drum-flow", "dynamic-angle-of-repose"]"#;

fn moved(start: f64, stop: Option<f64>, reverse: Option<f64>) -> MeasuredScene {
    let mut scene = drum_scene(2.0, FLOW);
    let (point, axis, rate) = ([0.0; 3], [0.0, 1.0, 0.0], 2.0);
    scene.wall[0].motion = Motion::Rotating { point, axis, rate, start, stop, reverse };
    scene
}

#[test]
fn a_reversed_drum_is_measured_in_its_present_sense() {
    let scene = moved(0.0, None, Some(1.0));
    for (from, rate, degrees) in [(0.0, 2.0, -20.0), (1.0, -2.0, 20.0)] {
        let found = measured(&scene, turning(rate, degrees), from);
        assert_abs_diff_eq!(value(&found.measurements, "shell_layer_speed_ratio"), 1.0, epsilon = 1e-12);
        assert_abs_diff_eq!(value(&found.measurements, "wall_torque"), 0.03, epsilon = 1e-12);
        assert_abs_diff_eq!(value(&found.measurements, "dynamic_angle_of_repose"), 20.0, epsilon = 2.0);
    }
    // Half of the frames turn one way, and half the other way.
    let both = [turning(2.0, -20.0), turning(-2.0, 20.0)].concat();
    let found = measured(&scene, both, 0.5);
    assert_abs_diff_eq!(value(&found.measurements, "shell_layer_speed_ratio"), 1.0, epsilon = 1e-12);
    assert_abs_diff_eq!(value(&found.measurements, "wall_torque"), 0.03, epsilon = 1e-12);
    for name in ["dynamic_angle_of_repose", "flowing_layer_thickness"] {
        assert!(reason(&scene, &found, name).contains("does not turn in one sense"), "{found:?}");
    }
}

#[test]
fn a_drum_at_rest_has_no_dynamic_values() {
    let found = measured(&moved(1.0, Some(2.0), None), turning(2.0, -20.0), 0.0);
    assert_eq!(
        found.measurements.iter().map(|one| one.observable.as_str()).collect::<Vec<_>>(),
        ["lacey_mixing_index"]
    );
    // It stops in the middle of the measured frames.
    let scene = moved(0.0, Some(0.25), None);
    let found = measured(&scene, turning(2.0, -20.0), 0.0);
    let ratio = found.measurements.iter().find(|one| one.observable == "shell_layer_speed_ratio").unwrap();
    assert_eq!(ratio.frames, 5);
    assert!(reason(&scene, &found, "surface_line_angle").contains("does not turn in one sense"));
    // Angles over time end two frames before it stops.
    let run = recording(turning(2.0, -20.0));
    assert_eq!(series(&scene, &run)[0].time, [0.0, 0.05, 0.1]);
}

#[test]
fn a_torque_turns_a_drum_as_fast_as_frames_tell() {
    let mut scene = drum_scene(1.0, FLOW);
    scene.wall[0].motion = Motion::TorqueDriven {
        point: [0.0; 3],
        axis: [0.0, -1.0, 0.0],
        torque: 1.0,
        moment_of_inertia: 1.0,
        largest_speed: None,
        start: 0.0,
    };
    let mut frames = turning(2.0, -20.0);
    frames
        .iter_mut()
        .for_each(|frame| frame.driven_walls = vec![DrivenWall { wall: 0, displacement: 0.3, rate: -2.0 }]);
    let found = measured(&scene, frames, 0.0);
    assert_abs_diff_eq!(value(&found.measurements, "shell_layer_speed_ratio"), 1.0, epsilon = 1e-12);
    assert_abs_diff_eq!(value(&found.measurements, "dynamic_angle_of_repose"), 20.0, epsilon = 2.0);
}

#[test]
fn a_cylinder_that_turns_about_another_axis_is_no_drum() {
    let about = |point: [f64; 3], axis: [f64; 3]| {
        let mut scene = drum_scene(2.0, FLOW);
        scene.wall[0].motion = Motion::Rotating { point, axis, rate: 2.0, start: 0.0, stop: None, reverse: None };
        let found = measured(&scene, turning(2.0, -20.0), 0.0);
        (impossible(&scene, None).len(), has(&found, "wall_torque"))
    };
    assert_eq!(about([0.0, 0.3, 0.0], [0.0, -2.0, 0.0]), (0, true));
    assert_eq!(about([0.1, 0.0, 0.0], [0.0, 1.0, 0.0]), (2, false), "beside its own axis");
    assert_eq!(about([0.0; 3], [0.0, 0.0, 1.0]), (2, false), "about the vertical");
    assert_eq!(about([0.0; 3], [0.0, 1.0, 0.01]), (2, false), "aslant");
}

/// A plate, and a tube of 0.2 m about (0.01, 0.02) m that moves at `velocity` from the start, before or after other walls.
fn heap(velocity: [f64; 3], others: &str, tube_first: bool) -> MeasuredScene {
    let tube = format!(
        "[[wall]]\nname = \"tube\"\nmaterial = \"grain\"\nshape = {{ kind = \"cylinder\", base = [0.01, 0.02, 0.0], axis = [0, 0, 1], radius = \
         0.2, length = 0.28 }}\nmotion = {{ kind = \"translating\", velocity = {velocity:?}, start = 0.0 }}\n"
    );
    let plate = "[[wall]]\nname = \"plate\"\nmaterial = \"grain\"\nshape = { kind = \"plane\", point = [0, 0, 0], normal = [0, 0, 1] }\n";
    let walls = if tube_first { format!("{plate}{tube}{others}") } else { format!("{others}{tube}{plate}") };
    scene(&walls, r#"["static-angle-of-repose"]"#, "from = 0.0")
}

fn upright(name: &str, x: f64) -> String {
    format!(
        "[[wall]]\nname = \"{name}\"\nmaterial = \"grain\"\nshape = {{ kind = \"cylinder\", base = [{x}, 0.02, 0.0], axis = [0, 0, -1], radius \
         = 0.01, length = 0.1 }}\n"
    )
}

#[test]
fn a_heap_has_one_axis_or_none_in_any_order_of_walls() {
    let slope = 25_f64.to_radians().tan();
    let cone = random_crystal(&mut Random(3), 0.2)
        .into_iter()
        .filter(|p| p.z > 0.003 && p.z < slope * (0.15 - p.x.hypot(p.y)));
    let grains = particles(cone.map(|p| p + Vector3::new(0.01, 0.02, 0.0)), 0.003);
    let found = |scene: &MeasuredScene| measured(scene, vec![frame(0.0, grains.clone())], 5.0);
    let lift = [0.0, 0.0, 0.5];
    let expected = value(&found(&heap(lift, "", true)).measurements, "static_angle_of_repose");
    assert_abs_diff_eq!(expected, 25.0, epsilon = 1.0);
    for tube_first in [true, false] {
        let coaxial = found(&heap(lift, &upright("rim", 0.01), tube_first));
        assert_eq!(value(&coaxial.measurements, "static_angle_of_repose"), expected);
        let scene = heap(lift, &upright("post", 0.2), tube_first);
        let why = reason(&scene, &found(&scene), "static_angle_of_repose");
        assert!(why.contains("'tube'") && why.contains("'post'") && why.contains("different axes"), "{why}");
    }
    let scene = heap([0.01, 0.0, 0.5], "", true);
    let why = reason(&scene, &found(&scene), "static_angle_of_repose");
    assert!(why.contains("'tube' has moved sideways"), "{why}");
}
