//! Packing, contacts and forces, measured of beds whose numbers are known beforehand.

use crate::support::beds::{Random, drum_scene, fcc, frame, particles, recording, scene, tilted_drum, value};
use approx::assert_abs_diff_eq;
use makadam::scene::Axis;
use makadam::snapshot::{Contact, Particle, Partner, Snapshot};
use makadam_validation::observables::literature::LiteratureCurve;
use makadam_validation::observables::neighbours::close_pairs;
use makadam_validation::observables::packing_fraction::fraction_in_box;
use makadam_validation::observables::{ForcePool, Measurement, force_distribution, measure};
use makadam_validation::plan::{Observable, Scene};
use makadam_validation::recording::Recording;
use nalgebra::{Rotation3, Vector3};
use std::f64::consts::{PI, SQRT_2};

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
    let mut scene = scene;
    scene.gravity = [0.0; 3];
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
    let mut scene = scene("", r#"["contact-forces", "balances"]"#, "");
    scene.gravity = [0.0; 3];
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
    (scene, recording(vec![Snapshot { particles: grains, contacts, ..Snapshot::default() }]))
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
fn a_contact_across_a_periodic_end_lies_there() {
    let (mut scene, run) = exponential_forces();
    scene.domain.periodic = vec![Axis::X];
    scene.measure.observables = vec![Observable::ContactForces];
    let forces: Vec<f64> = run.frames[0].contacts.iter().map(|contact| contact.normal_force).collect();
    let (sum, count, load) = (forces.iter().sum::<f64>(), forces.len() as f64, 1e6);
    // The mean force with two more grains, each at a place along x (m) and of a radius (m), and a contact of theirs.
    let mean_with = |grains: [(f64, f64); 2]| {
        let mut run = run.clone();
        let frame = &mut run.frames[0];
        let first = frame.particles.len() as u32;
        for (id, (x, radius)) in (first..).zip(grains) {
            let position = [x, 0.0, 0.0];
            frame.particles.push(Particle { id, position, radius, velocity: [0.0; 3], spin: [0.0; 3] });
        }
        frame.contacts.push(Contact {
            first,
            second: Partner::Grain(first + 1),
            point: [0.0; 3],
            normal: [1.0, 0.0, 0.0],
            normal_force: load,
            tangential_force: [0.0; 3],
        });
        value(&measure(&scene, &run), "mean_normal_force")
    };
    let left_out = |grains| assert_abs_diff_eq!(mean_with(grains), sum / count, epsilon = 1e-9);
    let counted = |grains| assert_abs_diff_eq!(mean_with(grains), (sum + load) / (count + 1.0), epsilon = 1e-6);
    // The ends are at -1 m and 1 m, the bulk begins 0.02 m from them. Halfway between these places is the middle of the box.
    left_out([(0.996, 0.005), (-0.996, 0.005)]);
    left_out([(-0.999, 0.005), (0.992, 0.005)]);
    // Giants in the bulk that touch at its end, and a giant that reaches through the end into the bulk.
    left_out([(0.7, 0.301), (-0.7, 0.301)]);
    counted([(-0.6, 0.5), (0.896, 0.005)]);
    counted([(0.2, 0.005), (0.209, 0.005)]);
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
    let run = recording(vec![Snapshot { particles: grains, contacts, ..Snapshot::default() }]);
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
