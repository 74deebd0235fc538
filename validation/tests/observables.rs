//! Packing, contacts and forces, measured of beds whose numbers are known beforehand.

use crate::support::beds::{
    Random, drum_scene, fcc, frame, particles, random_crystal, recording, scene, tilted_drum, value,
};
use approx::assert_abs_diff_eq;
use makadam::scene::{Axis, Domain, GravityChange, Shape};
use makadam::snapshot::{Contact, Particle, Partner, Snapshot};
use makadam_frames::neighbours::{Pair, close_pairs, close_pairs_in};
use makadam_frames::plan::{MeasuredScene, Observable};
use makadam_frames::recording::{Content, Recording};
use makadam_measure::observables::packing_fraction::fraction_in_box;
use makadam_measure::observables::{Measurement, force_distribution, measure, measured_in, unmeasured};
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
fn a_box_ends_with_the_domain_along_a_periodic_axis() {
    let fraction = |half: f64| {
        let walls = format!(
            "[[wall]]\nname = \"box\"\nmaterial = \"grain\"\n\
             shape = {{ kind = \"box\", min = [-{half}, -0.1, -0.1], max = [{half}, 0.1, 0.1], open = [\"-x\", \"+x\"] }}\n"
        );
        let mut scene = scene(&walls, r#"["packing-fraction"]"#, "");
        scene.gravity = [0.0; 3];
        scene.domain = Domain { min: [-0.1, -1.0, -1.0], max: [0.1, 1.0, 1.0], periodic: vec![Axis::X] };
        let grains = particles(fcc(0.01, 0.0999, Rotation3::identity(), Vector3::zeros()), 0.005);
        value(&measure(&scene, &recording(vec![frame(0.0, grains)])), "packing_fraction")
    };
    assert_abs_diff_eq!(fraction(0.1), PI / (3.0 * SQRT_2), epsilon = 0.01);
    assert_eq!([0.05, 0.15, 0.4].map(fraction), [fraction(0.1); 3]);
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
shape = { kind = "box", min = [-0.09, -0.09, -0.09], max = [0.09, 0.09, 0.09] }
"#;
    // A crystal that fills a box, with two grains in a cavity that hang from its side one behind the other: both are rattlers.
    let mut scene = scene(walls, r#"["coordination-number"]"#, "");
    let mut places = fcc(0.01, 0.085, Rotation3::identity(), Vector3::zeros());
    places.retain(|place| place.norm() > 0.015);
    let side = Vector3::new(1.0, 0.5, 0.5) * 0.01 * SQRT_2;
    assert!(places.iter().any(|place| (place - side).norm() < 1e-9), "a grain at the side of the cavity");
    places.extend((1..=2).map(|n| side - side.normalize() * 0.00999 * f64::from(n)));
    scene.gravity = [0.0; 3];
    let measurements = measure(&scene, &recording(vec![frame(0.0, particles(places, 0.005))]));
    let bulk = value(&measurements, "bulk_grains");
    assert_abs_diff_eq!(value(&measurements, "rattler_share"), 2.0 / bulk, epsilon = 1e-12);
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

/// A crystal without gravity in a box, whose bulk contacts have forces of an exponential distribution, and no others are listed.
fn exponential_forces() -> (MeasuredScene, Recording) {
    let walls = "[[wall]]\nname = \"box\"\nmaterial = \"grain\"\n\
        shape = { kind = \"box\", min = [-0.1, -0.1, -0.1], max = [0.1, 0.1, 0.1] }\n";
    let mut scene = scene(walls, r#"["contact-forces", "balances"]"#, "");
    scene.gravity = [0.0; 3];
    let grains = particles(fcc(0.01, 0.085, Rotation3::identity(), Vector3::zeros()), 0.005);
    // The bulk begins 0.02 m inside the walls.
    let is_in_bulk = |pair: &Pair| {
        let [a, b] = [pair.first, pair.second].map(|place| Vector3::from(grains[place].position));
        (0.5 * (a + b)).amax() <= 0.08
    };
    let pairs: Vec<Pair> = close_pairs(&grains, 1e-4).into_iter().filter(is_in_bulk).collect();
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
    scene.domain = Domain { min: [-0.1, -1.0, -1.0], max: [0.1, 1.0, 1.0], periodic: vec![Axis::X] };
    if let Shape::Box { open, .. } = &mut scene.wall[0].shape {
        *open = vec!["-x".into(), "+x".into()];
    }
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
    // The ends are at -0.1 m and 0.1 m, the bulk begins 0.02 m from them. Halfway between these places is the middle of the box.
    left_out([(0.096, 0.005), (-0.096, 0.005)]);
    left_out([(-0.099, 0.005), (0.092, 0.005)]);
    // Giants in the bulk that touch at its end, and a giant that reaches through the end into the bulk.
    left_out([(0.07, 0.0301), (-0.07, 0.0301)]);
    counted([(-0.04, 0.085), (0.0701, 0.005)]);
    counted([(0.02, 0.005), (0.029, 0.005)]);
}

#[test]
fn contacts_at_the_kinetic_limit_slide() {
    // A quarter of the contacts is at the static limit of 0.5, the others at 0.1.
    let (mut scene, run) = exponential_forces();
    for (kinetic, sliding) in [(0.3, 0.25), (0.1, 1.0), (0.1005, 1.0), (0.102, 0.25), (0.498, 0.25)] {
        scene.material.values_mut().for_each(|material| material.kinetic_friction = Some(kinetic));
        let measured = measure(&scene, &run);
        assert_abs_diff_eq!(value(&measured, "sliding_share"), sliding, epsilon = 5e-3);
        assert_abs_diff_eq!(value(&measured, "friction_mobilisation"), 0.4, epsilon = 5e-3);
    }
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

/// Measures one frame of a bed of 0.01 m grains in a box-shaped heap, with some of the grains changed.
fn measure_odd(scene: &MeasuredScene, change: impl Fn(&mut Vec<Particle>)) -> Vec<Measurement> {
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
    // Its cubes alone would be 1e32: the frame has no value, and the other one has.
    let alone = measure(&drum, &recording(vec![frame(0.0, particles(places.clone(), 0.005))]));
    assert_eq!(with_giant(1e8), alone);
}

/// A block of 12 x 12 x 12 grains that touch, standing free on a floor, in a container.
fn free_block(walls: &str) -> Vec<Measurement> {
    let scene = scene(walls, r#"["packing-fraction", "coordination-number"]"#, "");
    let place = |index: usize| 0.005 * (index as f64 - 5.5);
    let places = (0..1728).map(|n| Vector3::new(place(n % 12), place(n / 12 % 12), 0.0025 + 0.005 * (n / 144) as f64));
    measure(&scene, &recording(vec![frame(0.0, particles(places, 0.0025))]))
}

#[test]
fn free_sides_of_a_block_are_surfaces() {
    let container = "[[wall]]\nname = \"box\"\nmaterial = \"grain\"\n\
        shape = { kind = \"box\", min = [-0.15, -0.15, 0.0], max = [0.15, 0.15, 0.3], open = [\"+z\"] }\n";
    let floor = "[[wall]]\nname = \"floor\"\nmaterial = \"grain\"\n\
        shape = { kind = \"plane\", point = [0.0, 0.0, 0.0], normal = [0.0, 0.0, 1.0] }\n";
    for walls in [container, floor] {
        let measured = free_block(walls);
        assert_abs_diff_eq!(value(&measured, "packing_fraction"), PI / 6.0, epsilon = 1e-9);
        assert_abs_diff_eq!(value(&measured, "coordination_number"), 6.0, epsilon = 1e-12);
    }
}

#[test]
fn a_slope_in_a_box_has_no_bulk() {
    let walls = "[[wall]]\nname = \"box\"\nmaterial = \"grain\"\n\
        shape = { kind = \"box\", min = [-0.1, -0.1, -0.1], max = [0.1, 0.1, 0.3], open = [\"+z\"] }\n";
    let scene = scene(walls, r#"["packing-fraction", "coordination-number"]"#, "");
    let mut random = Random(4);
    let places = random_crystal(&mut random, 0.095).into_iter().filter(|place| place.z < 0.8 * place.x);
    let run = recording(vec![frame(0.0, particles(places, 0.005))]);
    let measured = measured_in(&scene, &run);
    assert_eq!(measured.measurements, []);
    let left = unmeasured(&scene, &[], &measured);
    assert!(left.iter().all(|one| one.reason.contains("neither level between walls")), "{left:?}");
}

#[test]
fn overlaps_across_a_periodic_end_count() {
    let mut scene = scene("", r#"["balances"]"#, "");
    scene.domain.periodic = vec![Axis::X];
    let pair = particles([Vector3::new(-0.9955, 0.05, 0.05), Vector3::new(0.9955, 0.05, 0.05)], 0.005);
    let measured = measure(&scene, &recording(vec![frame(0.0, pair)]));
    assert_abs_diff_eq!(value(&measured, "largest_overlap"), 0.2, epsilon = 1e-12);
    assert_abs_diff_eq!(value(&measured, "mean_overlap"), 0.2, epsilon = 1e-12);
}

#[test]
fn close_pairs_are_found_across_ends() {
    let mut random = Random(6);
    let grains: Vec<Particle> = (0..300)
        .flat_map(|_| particles([Vector3::from_fn(|_, _| random.uniform() * 0.1)], 0.002 + 0.003 * random.uniform()))
        .collect();
    let domain = Domain { min: [0.0; 3], max: [0.1; 3], periodic: vec![Axis::X, Axis::Z] };
    let mut found: Vec<(usize, usize)> =
        close_pairs_in(&domain, &grains, 5e-4).iter().map(|pair| (pair.first, pair.second)).collect();
    found.sort_unstable();
    let mut expected = Vec::new();
    for second in 0..grains.len() {
        for first in 0..second {
            let arm = domain.period().arm(&grains[first].position.into(), &grains[second].position.into());
            if arm.norm() < grains[first].radius + grains[second].radius + 5e-4 {
                expected.push((first, second));
            }
        }
    }
    expected.sort_unstable();
    assert_eq!(found, expected);
}

#[test]
fn weight_is_that_of_the_frame_while_gravity_changes() {
    let walls = "[[wall]]\nname = \"floor\"\nmaterial = \"grain\"\n\
        shape = { kind = \"plane\", point = [0.0, 0.0, 0.0], normal = [0.0, 0.0, 1.0] }\n";
    let mut scene = scene(walls, r#"["balances"]"#, "from = 0.0");
    scene.gravity_changes = vec![GravityChange { time: 1.0, gravity: [0.0, 0.0, -19.62] }];
    let mass = 2500.0 * 4.0 / 3.0 * PI * 0.005_f64.powi(3);
    let at = |time: f64| {
        let force = mass * 9.81 * (1.0 + time.min(1.0));
        let (first, second, normal) = (0, Partner::Wall(0), [0.0, 0.0, -1.0]);
        let contact =
            Contact { first, second, point: [0.0; 3], normal, normal_force: force, tangential_force: [0.0; 3] };
        Snapshot { contacts: vec![contact], ..frame(time, particles([Vector3::z() * 0.005], 0.005)) }
    };
    let measured = measure(&scene, &recording([0.0, 0.25, 0.5, 2.0].map(at).to_vec()));
    assert_abs_diff_eq!(value(&measured, "wall_force_over_weight"), 1.0, epsilon = 1e-12);
}

#[test]
fn walls_of_unknown_place_are_not_measured_by() {
    let walls = "[[wall]]\nname = \"box\"\nmaterial = \"grain\"\n\
        shape = { kind = \"box\", min = [-0.05, -0.05, -0.05], max = [0.05, 0.05, 0.3], open = [\"+z\"] }\n\
        [[wall]]\nname = \"lid\"\nmaterial = \"grain\"\nshape = { kind = \"plane\", point = [0, 0, 0.2], normal = [0, 0, -1] }\n\
        motion = { kind = \"force-driven\", axis = [0, 0, -1], force = 5.0, mass = 0.05 }\n";
    let scene = scene(walls, r#"["packing-fraction", "balances"]"#, "");
    let places = fcc(0.0106, 0.045, Rotation3::identity(), Vector3::zeros());
    let mut run = recording(vec![frame(0.0, particles(places, 0.005))]);
    assert!(measure(&scene, &run).iter().any(|one| one.observable == "packing_fraction"));
    run.lacks = vec![Content::DrivenWalls];
    let measured = measured_in(&scene, &run);
    assert!(measured.measurements.iter().all(|one| one.observable != "packing_fraction"));
    assert!(measured.measurements.iter().any(|one| one.observable == "kinetic_energy"));
    let left = unmeasured(&scene, &run.lacks, &measured);
    let reason = &left.iter().find(|one| one.observable == "packing_fraction").unwrap().reason;
    assert!(reason.contains("poses of driven walls"), "{reason}");
}

#[test]
fn grains_of_a_source_have_the_friction_of_their_material() {
    let text = include_str!("../../tests/scenes/smoke.toml");
    let text =
        text.replace("[[population]]\ncount", "[[insert]]\ntotal").replace("spacing = 1.1\nagitation = 0.1\n", "");
    let scene = MeasuredScene::parse(&text).unwrap();
    let mut simulation = makadam::Simulation::builder(&scene).time_step(1e-3).build().unwrap();
    (0..1500).for_each(|_| {
        simulation.step();
    });
    assert!(simulation.grains() > 150);
    // Two supports hold a grain with friction; without, four do, and a loose bed unravels.
    let rattlers = value(&measure(&scene, &recording(vec![simulation.snapshot()])), "rattler_share");
    assert!(rattlers < 0.3, "{rattlers}");
}

#[test]
fn what_went_into_a_sink_counts_after_the_last_grain() {
    let text = include_str!("../../tests/scenes/smoke.toml")
        .replace("open = [\"+z\"]", "open = [\"-z\", \"+z\"]")
        .replace("observables = [\"balances\"", "from = 0.1\nobservables = [\"discharge\", \"balances\"")
        + "\n[[remove]]\nregion = { kind = \"box\", min = [-0.03, -0.03, -0.01], max = [0.03, 0.03, 0.0] }\n";
    let scene = MeasuredScene::parse(&text).unwrap();
    let mut simulation = makadam::Simulation::builder(&scene).time_step(1e-3).build().unwrap();
    let frames: Vec<Snapshot> = (0..9)
        .map(|_| {
            let frame = simulation.snapshot();
            (0..50).for_each(|_| {
                simulation.step();
            });
            frame
        })
        .collect();
    let (first, last) = (frames[2].passed[1], frames[8].passed[1]);
    assert!(frames[8].particles.is_empty() && last.grains == 200 && first.grains < 200);
    let measured = measure(&scene, &recording(frames));
    assert_abs_diff_eq!(value(&measured, "discharged_mass"), last.mass, epsilon = 1e-15);
    assert_abs_diff_eq!(value(&measured, "mass_flow_rate"), (last.mass - first.mass) / 0.3, epsilon = 1e-9);
    assert!(measured.iter().all(|one| one.value.is_finite()), "{measured:?}");
}
