//! The measurement code against beds whose numbers are known beforehand.

use approx::assert_abs_diff_eq;
use makadam::scene::Scene;
use makadam::snapshot::{Contact, Particle, Partner, Snapshot};
use makadam_validation::observables::literature::LiteratureCurve;
use makadam_validation::observables::neighbours::close_pairs;
use makadam_validation::observables::packing_fraction::fraction_in_box;
use makadam_validation::observables::{ForcePool, Measurement, force_distribution, measure, series};
use makadam_validation::recording::Recording;
use nalgebra::{Rotation3, Vector3};
use std::f64::consts::{PI, SQRT_2};
use std::path::Path;

/// A small generator, so that synthetic beds are the same in every run.
struct Random(u64);

impl Random {
    fn uniform(&mut self) -> f64 {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 11) as f64 / (1_u64 << 53) as f64
    }
}

fn scene(walls: &str, observables: &str, from: &str) -> Scene {
    let text = format!(
        r#"
name = "synthetic"
description = "a synthetic bed"
duration = 10.0
domain = {{ min = [-1.0, -1.0, -1.0], max = [1.0, 1.0, 1.0] }}
[material.grain]
density = 2500.0
youngs_modulus = 1e7
poisson_ratio = 0.3
friction = 0.5
restitution = 0.3
{walls}
[[population]]
count = 1
material = "grain"
radius = {{ kind = "fixed", value = 0.005 }}
region = {{ kind = "box", min = [-0.1, -0.1, -0.1], max = [0.1, 0.1, 0.1] }}
[measure]
observables = {observables}
{from}
"#
    );
    Scene::parse(&text, Path::new("synthetic.toml")).expect("a valid scene")
}

fn drum_scene(rate: f64, observables: &str) -> Scene {
    let walls = format!(
        r#"
[[wall]]
name = "shell"
material = "grain"
shape = {{ kind = "cylinder", base = [0.0, -0.06, 0.0], axis = [0.0, 1.0, 0.0], radius = 0.1, length = 0.12 }}
motion = {{ kind = "rotating", point = [0.0, 0.0, 0.0], axis = [0.0, 1.0, 0.0], rate = {rate:?} }}
[[wall]]
name = "front"
material = "grain"
shape = {{ kind = "disc", centre = [0.0, -0.06, 0.0], normal = [0.0, 1.0, 0.0], radius = 0.1 }}
[[wall]]
name = "back"
material = "grain"
shape = {{ kind = "disc", centre = [0.0, 0.06, 0.0], normal = [0.0, -1.0, 0.0], radius = 0.1 }}
"#
    );
    scene(&walls, observables, "from = 0.0")
}

fn recording(frames: Vec<Snapshot>) -> Recording {
    Recording {
        scene: "synthetic".into(),
        code: "Makadam".into(),
        version: "0".into(),
        seed: 1,
        time_step: 1e-3,
        rayleigh_fraction: None,
        stiffness_factor: 1.0,
        threads: 1,
        wall_seconds: 1.0,
        simulated_seconds: 1.0,
        frames,
    }
}

fn particles(places: impl IntoIterator<Item = Vector3<f64>>, radius: f64) -> Vec<Particle> {
    (places.into_iter().enumerate())
        .map(|(id, place)| Particle {
            id: id as u32,
            position: place.into(),
            radius,
            velocity: [0.0; 3],
            spin: [0.0; 3],
        })
        .collect()
}

fn frame(time: f64, particles: Vec<Particle>) -> Snapshot {
    Snapshot { time, particles, contacts: Vec::new() }
}

fn value(measurements: &[Measurement], name: &str) -> f64 {
    measurements.iter().find(|m| m.observable == name).unwrap_or_else(|| panic!("{name} is missing")).value
}

/// Sites of a face-centred cubic lattice of touching spheres, turned, in a cube about the origin.
fn fcc(diameter: f64, half: f64, turn: Rotation3<f64>, shift: Vector3<f64>) -> Vec<Vector3<f64>> {
    let edge = diameter * SQRT_2;
    // The cube's corner lies sqrt(3) of its half width away, the lattice is shifted by up to an edge.
    let count = (1.75 * half / edge).ceil() as i64 + 2;
    let mut sites = Vec::new();
    for i in -count..=count {
        for j in -count..=count {
            for k in -count..=count {
                for basis in [[0.0, 0.0, 0.0], [0.5, 0.5, 0.0], [0.5, 0.0, 0.5], [0.0, 0.5, 0.5]] {
                    let site = Vector3::new(i as f64, j as f64, k as f64) + Vector3::from(basis);
                    let place = turn * (site * edge) + shift;
                    if place.amax() <= half {
                        sites.push(place);
                    }
                }
            }
        }
    }
    sites
}

/// A crystal that is turned and shifted anew for each frame: dense, and with no direction of its own over time.
fn random_crystal(random: &mut Random, half: f64) -> Vec<Vector3<f64>> {
    let turn = Rotation3::from_euler_angles(6.3 * random.uniform(), 6.3 * random.uniform(), 6.3 * random.uniform());
    let shift = Vector3::from_fn(|_, _| 0.01 * random.uniform());
    fcc(0.0106, half, turn, shift)
}

/// Frames of a drum whose bed is cut by a plane `offset` (m) above the axis and inclined by `degrees` about y.
fn tilted_drum(frames: usize, degrees: f64, offset: f64, radius: f64) -> Vec<Snapshot> {
    let mut random = Random(7);
    let (sine, cosine) = degrees.to_radians().sin_cos();
    (0..frames)
        .map(|index| {
            let places = random_crystal(&mut random, 0.12).into_iter().filter(|p| {
                p.x.hypot(p.z) < 0.1 - radius
                    && p.y.abs() < 0.06 - radius
                    && p.z * cosine - p.x * sine < offset - radius
            });
            frame(index as f64 * 0.05, particles(places, radius))
        })
        .collect()
}

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

#[test]
fn slope_of_a_cone_is_recovered_despite_stray_grains() {
    let walls = r#"
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
    let scene = scene(walls, r#"["static-angle-of-repose"]"#, "from = 0.0");
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

#[test]
fn crystal_fills_its_share_of_space() {
    let diameter = 0.01;
    let grains = particles(fcc(diameter, 0.06, Rotation3::identity(), Vector3::zeros()), 0.5 * diameter);
    // Two unit cells wide, from an arbitrary corner: every cell holds four spheres, cut or whole.
    let edge = diameter * SQRT_2;
    let low = [-1.3 * edge, -0.77 * edge, -1.11 * edge];
    let fraction = fraction_in_box(&grains, low, low.map(|x| x + 2.0 * edge)).expect("a box that is not empty");
    assert_abs_diff_eq!(fraction, PI / (3.0 * SQRT_2), epsilon = 1e-12);
}

#[test]
fn crystal_in_a_box_has_twelve_neighbours() {
    let walls = r#"
[[wall]]
name = "box"
material = "grain"
shape = { kind = "box", min = [-0.1, -0.1, -0.1], max = [0.1, 0.1, 0.3], open = ["+z"] }
"#;
    let scene = scene(walls, r#"["packing-fraction", "coordination-number"]"#, "");
    let grains = particles(fcc(0.01, 0.095, Rotation3::identity(), Vector3::zeros()), 0.005);
    let measurements = measure(&scene, &recording(vec![frame(0.0, grains)]));
    assert_abs_diff_eq!(value(&measurements, "coordination_number"), 12.0, epsilon = 1e-12);
    assert_abs_diff_eq!(value(&measurements, "coordination_number_without_rattlers"), 12.0, epsilon = 1e-12);
    assert_abs_diff_eq!(value(&measurements, "rattler_share"), 0.0, epsilon = 1e-12);
    assert_abs_diff_eq!(value(&measurements, "packing_fraction"), PI / (3.0 * SQRT_2), epsilon = 0.005);
}

#[test]
fn packing_fraction_by_cubes_matches_the_crystal() {
    // A drum full to the brim: no box, so the bulk is made of cubes.
    let scene = drum_scene(1.0, r#"["packing-fraction"]"#);
    let frames = tilted_drum(8, 0.0, 0.2, 0.0053);
    let expected = PI / (3.0 * SQRT_2);
    assert_abs_diff_eq!(value(&measure(&scene, &recording(frames)), "packing_fraction"), expected, epsilon = 5e-3);
}

#[test]
fn rattlers_are_removed_one_after_the_other() {
    let walls = r#"
[[wall]]
name = "floor"
material = "grain"
shape = { kind = "plane", point = [0.0, 0.0, -0.5], normal = [0.0, 0.0, 1.0] }
"#;
    // A crystal with a chain of three grains that dangles from its side: all three are rattlers.
    let scene = scene(walls, r#"["coordination-number"]"#, "");
    let mut places = fcc(0.01, 0.06, Rotation3::identity(), Vector3::zeros());
    let far = places.iter().copied().max_by(|a, b| a.x.total_cmp(&b.x)).expect("grains");
    places.extend((1..=3).map(|n| far + Vector3::x() * 0.01 * f64::from(n)));
    let all = places.len();
    let scene = Scene { gravity: [0.0; 3], ..scene };
    let measurements = measure(&scene, &recording(vec![frame(0.0, particles(places, 0.005))]));
    assert_abs_diff_eq!(value(&measurements, "rattler_share"), 3.0 / all as f64, epsilon = 1e-12);
}

#[test]
fn close_pairs_match_all_pairs() {
    let mut random = Random(5);
    let mut grains: Vec<Particle> = (0..400)
        .flat_map(|_| particles([Vector3::from_fn(|_, _| random.uniform() * 0.1)], 0.002 + 0.003 * random.uniform()))
        .collect();
    grains.extend(particles([Vector3::new(50.0, -3.0, 2.0)], 0.004));
    let mut pairs: Vec<(usize, usize)> = close_pairs(&grains, 5e-4).iter().map(|p| (p.first, p.second)).collect();
    pairs.sort_unstable();
    let mut expected = Vec::new();
    for second in 0..grains.len() {
        for first in 0..second {
            let distance = (Vector3::from(grains[first].position) - Vector3::from(grains[second].position)).norm();
            if distance < grains[first].radius + grains[second].radius + 5e-4 {
                expected.push((first, second));
            }
        }
    }
    expected.sort_unstable();
    assert_eq!(pairs, expected);
}

/// A crystal without gravity whose contacts bear forces of an exponential distribution.
fn exponential_forces() -> (Scene, Recording) {
    let scene = Scene { gravity: [0.0; 3], ..scene("", r#"["contact-forces", "balances"]"#, "") };
    let grains = particles(fcc(0.01, 0.08, Rotation3::identity(), Vector3::zeros()), 0.005);
    let pairs = close_pairs(&grains, 1e-4);
    let count = pairs.len() as f64;
    let contacts = (pairs.iter().enumerate())
        .map(|(index, pair)| {
            let (a, b) = (Vector3::from(grains[pair.first].position), Vector3::from(grains[pair.second].position));
            let normal = (b - a).normalize();
            let force = -2.0 * (1.0 - (index as f64 + 0.5) / count).ln();
            let across = normal.cross(&Vector3::new(0.3, 0.5, 0.8)).normalize();
            Contact {
                first: pair.first as u32,
                second: Partner::Grain(pair.second as u32),
                point: (0.5 * (a + b)).into(),
                normal: normal.into(),
                normal_force: force,
                tangential_force: (across * force * 0.5 * if index % 4 == 0 { 1.0 } else { 0.2 }).into(),
            }
        })
        .collect();
    (scene, recording(vec![Snapshot { time: 0.0, particles: grains, contacts }]))
}

#[test]
fn exponential_forces_give_the_numbers_of_an_exponential() {
    let (scene, run) = exponential_forces();
    let measurements = measure(&scene, &run);
    for (name, expected) in [
        ("share_below_mean", 0.632),
        ("gini", 0.5),
        ("force_second_moment", 2.0),
        ("weak_load_share", 0.264),
        ("friction_mobilisation", 0.4),
        ("sliding_share", 0.25),
    ] {
        assert_abs_diff_eq!(value(&measurements, name), expected, epsilon = 5e-3);
    }
    assert_abs_diff_eq!(value(&measurements, "coulomb_excess"), 0.0, epsilon = 1e-12);
    // A cubic lattice has no preferred direction to second order, but its surface favours none either way.
    assert!(value(&measurements, "fabric_anisotropy") < 0.02);

    let distribution = force_distribution(&scene, std::slice::from_ref(&run));
    let area: f64 = distribution.density.iter().sum::<f64>() * 0.25;
    assert_abs_diff_eq!(area, 1.0, epsilon = 2e-3);
    for (force, density) in distribution.force.iter().zip(&distribution.density) {
        assert_abs_diff_eq!(*density, (-force).exp(), epsilon = 5e-3);
    }
}

#[test]
fn pooled_forces_know_their_distance() {
    let quantile = |n: usize| (n as f64 + 0.5) / 10_000.0;
    let exponential: Vec<f64> = (0..10_000).map(|n| -(1.0 - quantile(n)).ln()).collect();
    let uniform: Vec<f64> = (0..10_000).map(|n| 2.0 * quantile(n)).collect();
    let (mut a, mut b) = (ForcePool::new("YADE"), ForcePool::new("LIGGGHTS"));
    a.add(&exponential);
    b.add(&uniform);
    assert_eq!(a.samples(), 10_000);
    // Largest |1 - exp(-f) - f/2| is at f = 2: exp(-2).
    let at_ln2 = 0.5 - 0.5 * 2_f64.ln();
    assert_abs_diff_eq!(a.kolmogorov_smirnov(&b), at_ln2.max((-2_f64).exp()), epsilon = 0.01);
    let exact = makadam_validation::statistics::wasserstein(&exponential, &uniform);
    assert_abs_diff_eq!(a.wasserstein(&b), exact, epsilon = 0.01);
    assert_abs_diff_eq!(a.kolmogorov_smirnov(&a), 0.0, epsilon = 1e-15);
}

#[test]
fn weight_is_carried_and_energy_counted() {
    let walls = r#"
[[wall]]
name = "floor"
material = "grain"
shape = { kind = "plane", point = [0.0, 0.0, 0.0], normal = [0.0, 0.0, 1.0] }
"#;
    let scene = scene(walls, r#"["balances"]"#, "");
    let mut grains = particles([Vector3::new(0.0, 0.0, 0.0049), Vector3::new(0.0, 0.0, 0.0148)], 0.005);
    let mass = 2500.0 * 4.0 / 3.0 * PI * 0.005_f64.powi(3);
    grains[1].velocity = [3.0, 0.0, 0.0];
    grains[1].spin = [0.0, 100.0, 0.0];
    let contact = |second, normal: f64, force: f64| Contact {
        first: 0,
        second,
        point: [0.0; 3],
        normal: [0.0, 0.0, normal],
        normal_force: force,
        tangential_force: [0.0; 3],
    };
    let contacts =
        vec![contact(Partner::Wall(0), -1.0, 2.0 * mass * 9.81), contact(Partner::Grain(1), 1.0, mass * 9.81)];
    let run = recording(vec![Snapshot { time: 0.0, particles: grains, contacts }]);
    let measurements = measure(&scene, &run);
    assert_abs_diff_eq!(value(&measurements, "wall_force_over_weight"), 1.0, epsilon = 1e-12);
    assert_abs_diff_eq!(value(&measurements, "largest_overlap"), 0.02, epsilon = 1e-9);
    assert_abs_diff_eq!(value(&measurements, "mean_overlap"), 0.02, epsilon = 1e-9);
    let energy = 0.5 * mass * (9.0 + 0.4 * 0.005_f64.powi(2) * 1e4);
    assert_abs_diff_eq!(value(&measurements, "kinetic_energy"), energy, epsilon = 1e-12);
}

#[test]
fn literature_curves_have_the_numbers_derived_from_the_fits() {
    for (curve, share, gini, weak, second) in [
        (LiteratureCurve::Mueth, 0.585, 0.425, 0.278, 1.64),
        (LiteratureCurve::Radjai, 0.593, 0.479, 0.244, 1.85),
        (LiteratureCurve::Exponential, 0.632, 0.500, 0.264, 2.0),
    ] {
        // Midpoint rule; the power law's pole at zero costs a little.
        let step = 1e-3;
        let force: Vec<f64> = (0..30_000).map(|n| (n as f64 + 0.5) * step).collect();
        let mut mass: Vec<f64> = force.iter().map(|f| curve.density(*f) * step).collect();
        let total: f64 = mass.iter().sum();
        assert_abs_diff_eq!(total, 1.0, epsilon = 5e-3);
        mass.iter_mut().for_each(|m| *m /= total);
        let sum = |weight: &dyn Fn(f64) -> f64| force.iter().zip(&mass).map(|(f, m)| weight(*f) * m).sum::<f64>();
        assert_abs_diff_eq!(sum(&|f| f), 1.0, epsilon = 4e-3);
        assert_abs_diff_eq!(sum(&|f| f64::from(u8::from(f < 1.0))), share, epsilon = 4e-3);
        assert_abs_diff_eq!(sum(&|f| if f < 1.0 { f } else { 0.0 }), weak, epsilon = 1e-3);
        assert_abs_diff_eq!(sum(&|f| f * f), second, epsilon = 1e-2);
        // Gini: the integral of F (1 - F) over the mean.
        let mut below = 0.0;
        let area: f64 = mass
            .iter()
            .map(|m| {
                below += m;
                below * (1.0 - below) * step
            })
            .sum();
        assert_abs_diff_eq!(area, gini, epsilon = 4e-3);
    }
}

#[test]
fn only_the_last_frame_counts_where_the_scene_names_no_time() {
    let scene = scene("", r#"["balances"]"#, "");
    let mut moving = particles([Vector3::zeros()], 0.005);
    moving[0].velocity = [1.0, 0.0, 0.0];
    let run = recording(vec![frame(0.0, moving), frame(1.0, particles([Vector3::zeros()], 0.005))]);
    let measurements = measure(&scene, &run);
    let energy = measurements.iter().find(|m| m.observable == "kinetic_energy").expect("energy");
    assert_eq!((energy.value, energy.frames), (0.0, 1));
    assert!(measure(&scene, &recording(Vec::new())).is_empty());
}

/// What a scene measures of one frame of a bed of 0.01 m grains in a box-shaped heap, with some of the grains changed.
fn measure_odd(scene: &Scene, change: impl Fn(&mut Vec<Particle>)) -> Vec<Measurement> {
    let places = fcc(0.01, 0.04, Rotation3::identity(), Vector3::zeros());
    let mut grains = particles(places, 0.005);
    change(&mut grains);
    let start = std::time::Instant::now();
    let measured = measure(scene, &recording(vec![frame(0.0, grains)]));
    assert!(start.elapsed().as_secs() < 20, "{:?} for {} numbers", start.elapsed(), measured.len());
    assert!(measured.iter().all(|m| m.value.is_finite()), "{measured:?}");
    measured
}

#[test]
fn odd_sizes_and_places_cost_no_more_than_the_number_of_grains() {
    let has = |measured: &[Measurement], name: &str| measured.iter().any(|m| m.observable == name);
    let drum = drum_scene(
        1.0,
        r#"["dynamic-angle-of-repose", "packing-fraction", "coordination-number", "contact-forces", "balances", "drum-flow"]"#,
    );
    let floor = "[[wall]]\nname = \"floor\"\nmaterial = \"grain\"\n\
                 shape = { kind = \"plane\", point = [0.0, 0.0, -0.045], normal = [0.0, 0.0, 1.0] }\n";
    let heap = scene(floor, r#"["static-angle-of-repose", "packing-fraction", "coordination-number", "balances"]"#, "");
    let walls = floor.replace(
        "plane\", point = [0.0, 0.0, -0.045], normal = [0.0, 0.0, 1.0]",
        "box\", min = [-0.05, -0.05, \
                              -0.05], max = [0.05, 0.05, 0.05], open = [\"+z\"]",
    );
    let bed = scene(&walls, r#"["packing-fraction", "coordination-number", "balances"]"#, "");
    for scene in [&drum, &heap, &bed] {
        // All there is to be measured is, as long as grains are as they should be.
        let sane = measure_odd(scene, |_| ());
        assert!(has(&sane, "packing_fraction") && has(&sane, "kinetic_energy"), "{sane:?}");
        // Dust has no bed in a drum, a box or a heap of this size.
        let dust = measure_odd(scene, |grains| grains.iter_mut().for_each(|grain| grain.radius = 1e-11));
        assert!(!has(&dust, "packing_fraction") && has(&dust, "kinetic_energy"), "{dust:?}");
        // One grain that reaches over everything, in what the mean diameter of the others makes small cells.
        measure_odd(scene, |grains| {
            grains.extend(grains.clone().iter().map(|grain| Particle { radius: 1e3, ..*grain }).take(1))
        });
        measure_odd(scene, |grains| {
            grains.iter_mut().for_each(|grain| grain.radius = 1e-9);
            grains[0].radius = 1e-3;
        });
        // Grains that flew off, in each direction.
        for axis in 0..3 {
            for far in [-1e11, -1e5, 1e5, 1e11] {
                let measured = measure_odd(scene, |grains| grains[7].position[axis] = far);
                assert!(has(&measured, "kinetic_energy"), "{measured:?}");
            }
        }
    }
    // Above a bed they hide its surface: there is no bulk, and nothing is said of it.
    let hidden = measure_odd(&bed, |grains| grains[7].position[2] = 1e9);
    assert!(!has(&hidden, "packing_fraction") && !has(&hidden, "coordination_number"), "{hidden:?}");
}

#[test]
fn a_giant_among_grains_takes_the_space_that_it_has_or_is_refused() {
    let mut drum = drum_scene(1.0, r#"["packing-fraction"]"#);
    drum.measure.from = Some(0.0);
    let places = fcc(0.01, 0.04, Rotation3::identity(), Vector3::zeros());
    let with_giant = |radius: f64| {
        // In a later frame than the one that sets the diameter.
        let (first, mut giant) = (particles(places.clone(), 0.005), particles(places.clone(), 0.005));
        giant[0].radius = radius;
        measure(&drum, &recording(vec![frame(0.0, first), frame(0.1, giant)]))
    };
    // It fills every cube, beside the other grains: half a solid fraction more over the two frames.
    let fraction = value(&with_giant(2.0), "packing_fraction");
    assert!(fraction > 0.5 + 0.4 && fraction < 0.5 + 0.75, "{fraction}");
    // Its cubes alone would be 1e32.
    assert_eq!(with_giant(1e8), []);
}
