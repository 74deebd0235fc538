//! Slopes, flow and mixing, measured of beds whose numbers are known beforehand.

use crate::support::beds::{
    Random, drum_scene, frame, particles, random_crystal, recording, scene, tilted_drum, value,
};
use approx::assert_abs_diff_eq;
use makadam::scene::{Grain, populate};
use makadam::snapshot::{Contact, Particle, Partner};
use makadam_frames::plan::MeasuredScene;
use makadam_measure::observables::{measure, series};
use makadam_studies::effects::variations;
use nalgebra::Vector3;
use std::collections::BTreeMap;
use std::path::Path;

#[test]
fn tilt_of_a_drum_is_recovered_for_either_sense_of_rotation() {
    // About +y the lowest point of the shell moves towards -x: the bed rises towards -x, so a slope along x is negative.
    for (rate, sign) in [(1.0, -1.0), (-1.0, 1.0)] {
        let scene = drum_scene(rate, r#"["dynamic-angle-of-repose"]"#);
        for angle in [0.0, 12.0, 30.0, 41.0] {
            for offset in [0.0, -0.02] {
                let run = recording(tilted_drum(40, sign * angle, offset, 0.005));
                let measurements = measure(&scene, &run);
                let line = value(&measurements, "surface_line_angle");
                let circle = value(&measurements, "dynamic_angle_of_repose");
                assert_abs_diff_eq!(line, angle, epsilon = 0.3);
                assert_abs_diff_eq!(circle, angle, epsilon = 0.7);
            }
        }
    }
}

#[test]
fn angle_over_time_has_a_point_a_frame() {
    let scene = drum_scene(-1.0, r#"["dynamic-angle-of-repose"]"#);
    let series = series(&scene, &recording(tilted_drum(12, 25.0, 0.0, 0.005)));
    assert_eq!(series.len(), 1);
    assert_eq!(series[0].observable, "dynamic_angle_of_repose");
    assert_eq!(series[0].time.len(), 12);
    for value in &series[0].value {
        assert_abs_diff_eq!(*value, 25.0, epsilon = 6.0);
    }
}

#[test]
fn rigid_rotation_has_no_slip_and_no_flowing_layer() {
    let scene = drum_scene(2.0, r#"["drum-flow"]"#);
    let mut frames = tilted_drum(10, -20.0, 0.0, 0.005);
    for grain in frames.iter_mut().flat_map(|frame| &mut frame.particles) {
        grain.velocity = Vector3::new(0.0, 2.0, 0.0).cross(&Vector3::from(grain.position)).into();
    }
    // One grain pushes the shell at its lowest point, and is pulled along by 0.3 N in the shell's direction.
    for frame in &mut frames {
        frame.contacts.push(Contact {
            first: 0,
            second: Partner::Wall(0),
            point: [0.0, 0.0, -0.1],
            normal: [0.0, 0.0, -1.0],
            normal_force: 1.0,
            tangential_force: [0.3, 0.0, 0.0],
        });
    }
    let measurements = measure(&scene, &recording(frames));
    assert_abs_diff_eq!(value(&measurements, "shell_layer_speed_ratio"), 1.0, epsilon = 1e-12);
    assert_abs_diff_eq!(value(&measurements, "wall_torque"), 0.03, epsilon = 1e-12);
    assert!(!measurements.iter().any(|m| m.observable == "flowing_layer_thickness"));
}

#[test]
fn flowing_layer_ends_where_the_velocity_turns() {
    let scene = drum_scene(1.0, r#"["drum-flow"]"#);
    let mut frames = tilted_drum(20, -25.0, 0.0, 0.005);
    let (sine, cosine) = 25_f64.to_radians().sin_cos();
    for grain in frames.iter_mut().flat_map(|frame| &mut frame.particles) {
        // Down the slope, towards +x, at the surface; it turns 25 mm below it.
        let [x, _, z] = grain.position;
        let depth = -(z * cosine + x * sine);
        let speed = 0.2 * (1.0 - depth / 0.025);
        grain.velocity = [speed * cosine, 0.0, -speed * sine];
    }
    let measurements = measure(&scene, &recording(frames));
    // The contour lies where half of the space is filled: at the highest centres, a radius below the highest points.
    assert_abs_diff_eq!(value(&measurements, "flowing_layer_thickness"), 2.0, epsilon = 0.1);
    assert_abs_diff_eq!(value(&measurements, "surface_speed"), 0.14, epsilon = 0.01);
}

/// A plate, and a tube that leaves it.
const HEAP: &str = r#"
[[wall]]
name = "plate"
material = "grain"
shape = { kind = "plane", point = [0.0, 0.0, 0.0], normal = [0.0, 0.0, 1.0] }
[[wall]]
name = "tube"
material = "grain"
shape = { kind = "cylinder", base = [0.01, 0.02, 0.0], axis = [0.0, 0.0, 1.0], radius = 0.2, length = 0.28 }
motion = { kind = "translating", velocity = [0.0, 0.0, 0.5], start = 0.0 }
"#;

#[test]
fn slope_of_a_cone_is_recovered_despite_stray_grains() {
    let scene = scene(HEAP, r#"["static-angle-of-repose"]"#, "from = 0.0");
    let mut random = Random(3);
    for angle in [15.0_f64, 22.0, 30.0] {
        let slope = angle.to_radians().tan();
        let frames = (0..10).map(|index| {
            let mut places: Vec<_> = (random_crystal(&mut random, 0.2).into_iter())
                .filter(|p| p.z > 0.003 && p.z < slope * (0.15 - p.x.hypot(p.y)) - 0.003)
                .collect();
            places.extend((0..20).map(|n| Vector3::new(0.3 + 0.02 * f64::from(n), 0.1, 0.003)));
            let offset = Vector3::new(0.01, 0.02, 0.0);
            frame(index as f64 + 5.0, particles(places.into_iter().map(|p| p + offset), 0.003))
        });
        let measurements = measure(&scene, &recording(frames.collect()));
        assert_abs_diff_eq!(value(&measurements, "static_angle_of_repose"), angle, epsilon = 0.5);
    }
}

/// A cone of a crystal on a plate, with some grains that lie below it or far off.
fn cone(random: &mut Random, height: f64) -> Vec<Vector3<f64>> {
    let slope = 25_f64.to_radians().tan();
    let cone =
        random_crystal(random, 0.16).into_iter().filter(|p| p.z > 0.003 && p.z < slope * (0.14 - p.x.hypot(p.y)));
    let mut places: Vec<_> = cone.map(|place| place + Vector3::z() * height).collect();
    places.extend((0..30).map(|n| Vector3::new(0.3 + 0.02 * f64::from(n), 0.1, 0.003)));
    places
}

#[test]
fn a_heap_on_a_raised_plate_has_its_slope() {
    let plate = |height: f64| {
        format!(
            "[[wall]]\nname = \"ground\"\nmaterial = \"grain\"\nshape = {{ kind = \"plane\", point = [0, 0, 0], normal = [0, 0, 1] }}\n\
             [[wall]]\nname = \"table\"\nmaterial = \"grain\"\n\
             shape = {{ kind = \"disc\", centre = [0, 0, {height:?}], normal = [0, 0, 1], radius = 0.15 }}\n"
        )
    };
    let measured = |height: f64| {
        let scene = scene(&plate(height), r#"["static-angle-of-repose"]"#, "");
        let run = recording(vec![frame(0.0, particles(cone(&mut Random(8), height), 0.005))]);
        let measurements = measure(&scene, &run);
        (value(&measurements, "static_angle_of_repose"), value(&measurements, "heap_height"))
    };
    let (angle, height) = measured(0.0);
    assert_abs_diff_eq!(angle, 25.0, epsilon = 1.0);
    for raised in [0.05, 0.1, 0.3] {
        let (raised_angle, raised_height) = measured(raised);
        assert_abs_diff_eq!(raised_angle, angle, epsilon = 1e-6);
        assert_abs_diff_eq!(raised_height, height, epsilon = 1e-9);
    }
}

#[test]
fn last_bits_of_the_radii_leave_the_slope_alone() {
    let scene = scene(HEAP, r#"["static-angle-of-repose", "contact-forces", "packing-fraction"]"#, "");
    for seed in 0..6 {
        let mut random = Random(seed);
        let places = cone(&mut random, 0.0);
        let mut grains = particles(places, 0.005);
        grains.iter_mut().for_each(|grain| grain.radius *= 0.95 + 0.1 * random.uniform());
        let angle = |change: f64| {
            let mut grains = grains.clone();
            grains.iter_mut().for_each(|grain| grain.radius *= 1.0 + change);
            measure(&scene, &recording(vec![frame(5.0, grains)]))
        };
        let expected = angle(0.0);
        for change in (1..7).map(|n| f64::from(n) * 1.1e-16) {
            for (one, other) in angle(change).iter().zip(&expected) {
                assert_abs_diff_eq!(one.value, other.value, epsilon = 1e-9 * other.value.abs());
            }
        }
    }
}

#[test]
fn grains_that_a_tube_still_holds_have_no_slope() {
    let scene = scene(HEAP, r#"["static-angle-of-repose"]"#, "from = 0.0");
    let mut random = Random(5);
    let frames = (0..3).map(|index| {
        let held = random_crystal(&mut random, 0.2).into_iter().filter(|p| p.x.hypot(p.y) < 0.06 && p.z.abs() < 0.1);
        let upright = held.map(|p| p + Vector3::new(0.01, 0.02, 0.1));
        frame(index as f64 + 5.0, particles(upright, 0.003))
    });
    let measurements = measure(&scene, &recording(frames.collect()));
    assert!(measurements.iter().all(|one| one.observable != "static_angle_of_repose"), "{measurements:?}");
}

/// The scene that tests size spread; measured where its grains start, before anything has moved.
fn segregation() -> MeasuredScene {
    let file = Path::new(env!("CARGO_MANIFEST_DIR")).join("../reference-scenes/drum-segregation/scene.toml");
    let mut scene = MeasuredScene::load(&file).unwrap();
    scene.measure.from = Some(0.0);
    scene
}

/// Measures the grains at their start, by name.
fn at_start(scene: &MeasuredScene) -> (Vec<f64>, BTreeMap<String, f64>) {
    let grains = populate(scene, 1).unwrap();
    let radii = grains.iter().map(|grain| grain.radius).collect();
    let particle = |(id, grain): (usize, Grain)| Particle {
        id: id as u32,
        position: grain.position,
        radius: grain.radius,
        velocity: [0.0; 3],
        spin: [0.0; 3],
    };
    let particles = grains.into_iter().enumerate().map(particle).collect();
    let measured = measure(scene, &recording(vec![frame(0.0, particles)]));
    (radii, measured.into_iter().map(|one| (one.observable, one.value)).collect())
}

#[test]
fn two_populations_that_differ_in_size_are_as_mixed_by_population_as_by_size() {
    let (radii, measured) = at_start(&segregation());
    assert!(radii.iter().any(|&radius| radius < 0.0031) && radii.iter().any(|&radius| radius > 0.0058));
    assert_eq!(measured["size_mixing_index"], measured["population_mixing_index"]);
    assert_eq!(measured["small_over_large_distance"], measured["first_over_other_distance"]);
    // Large grains lie above small ones.
    assert!(measured["population_mixing_index"] < 0.3, "{measured:?}");
}

#[test]
fn without_size_spread_all_grains_have_the_mean_radius_and_populations_are_still_told_apart() {
    let scene = segregation();
    let all = variations(&scene);
    let alike = all.iter().find(|variation| variation.effect == "size spread").unwrap();
    let (radii, measured) = at_start(&alike.scene);
    let mean = (1850.0 * 0.003 + 200.0 * 0.006) / 2050.0;
    assert!(radii.iter().all(|radius| (radius / mean - 1.0).abs() < 1e-12));
    assert!(!measured.contains_key("size_mixing_index"), "no size to be mixed by");
    assert!(measured["population_mixing_index"] < 0.3, "{measured:?}");
}
