//! Periodic axes against closed forms, brute force over images, and scenes without them.

use crate::common::bits::{same_bits_everywhere, start};
use crate::common::{CONVERGED_HERTZ, FLOOR, Setup, grain, run_until};
use approx::assert_relative_eq;
use makadam::scene::{Axis, Domain, Scene, populate};
use makadam::snapshot::{Particle, Partner};
use nalgebra::Vector3;
use std::f64::consts::PI;

const RADIUS: f64 = 0.005;
const ALL: [Axis; 3] = [Axis::X, Axis::Y, Axis::Z];

/// A scene whose domain repeats itself along some axes.
fn periodic(setup: &Setup, min: [f64; 3], max: [f64; 3], axes: &[Axis]) -> Scene {
    let mut scene = setup.scene();
    scene.domain = Domain { min, max, periodic: axes.to_vec() };
    scene
}

/// A gas of grains of two sizes in a cube of so many diameters, with friction, periodic along all axes.
pub fn gas(diameters: f64, count: usize) -> Scene {
    let side = diameters * 2.0 * RADIUS;
    let population = format!(
        "[[population]]\ncount = {count}\nmaterial = 'grain'\nradius = {{ kind = 'uniform', mean = 0.004, spread = 0.2 }}\n\
         spacing = 1.02\nagitation = 1.0\nregion = {{ kind = 'box', min = [0, 0, 0], max = [{side:?}, {side:?}, {side:?}] }}\n"
    );
    let solver = "step = 1e-4\nstop = { kind = 'sweeps', sweeps = 30 }".into();
    let setup = Setup { gravity: [0.0; 3], restitution: 0.9, solver, body: population, ..Setup::default() };
    periodic(&setup, [0.0; 3], [side; 3], &ALL)
}

#[test]
fn grains_collide_across_the_end_of_an_axis() {
    for axis in 0..3 {
        // From both ends towards the boundary between them, and on into the next image.
        let (mut left, mut right, mut velocity) = ([0.05; 3], [0.05; 3], [0.0; 3]);
        (left[axis], right[axis], velocity[axis]) = (0.006, 0.094, 1.0);
        let body = grain(RADIUS, left, velocity.map(|v| -v)) + &grain(RADIUS, right, velocity);
        let setup = Setup { gravity: [0.0; 3], restitution: 0.6, body, ..Setup::default() };
        let mut simulation = start(&periodic(&setup, [0.0; 3], [0.1; 3], &[ALL[axis]]));
        run_until(&mut simulation, 0.02);
        let after = simulation.snapshot().particles;
        assert_relative_eq!(after[0].velocity[axis], 0.6, max_relative = 1e-9);
        assert_relative_eq!(after[1].velocity[axis], -0.6, max_relative = 1e-9);
    }
}

#[test]
fn a_grain_that_leaves_comes_in_at_the_other_end() {
    let body = grain(RADIUS, [0.09, 0.05, 0.05], [10.0, -3.0, 0.0]);
    let setup = Setup { gravity: [0.0; 3], body, ..Setup::default() };
    let mut simulation = start(&periodic(&setup, [0.0; 3], [0.1; 3], &[Axis::X, Axis::Y]));
    run_until(&mut simulation, 0.1);
    let [x, y, z] = simulation.snapshot().particles[0].position;
    assert_relative_eq!(x, 0.09, epsilon = 1e-9);
    assert_relative_eq!(y, 0.05, epsilon = 1e-9);
    assert_eq!(z, 0.05);
}

#[test]
fn a_ring_of_grains_bears_what_its_overlap_says() {
    // Ten grains fill a period that is ten overlaps too short: every contact has the same force, k_H d^1.5.
    let (count, overlap) = (10, 1e-5);
    let spacing = 2.0 * RADIUS - overlap;
    let place = |number: usize| grain(RADIUS, [(number as f64 + 0.3) * spacing, 0.05, 0.05], [0.0; 3]);
    let setup = Setup {
        gravity: [0.0; 3],
        solver: CONVERGED_HERTZ.into(),
        body: (0..count).map(place).collect(),
        ..Setup::default()
    };
    let length = count as f64 * spacing;
    let mut simulation = start(&periodic(&setup, [0.0; 3], [length, 0.1, 0.1], &[Axis::X]));
    for _ in 0..20 {
        simulation.step();
    }
    let effective_modulus = 1e7 / (2.0 * (1.0 - 0.09));
    let force = 4.0 / 3.0 * effective_modulus * (0.5 * RADIUS).sqrt() * overlap.powf(1.5);
    let snapshot = simulation.snapshot();
    assert_eq!(snapshot.contacts.len(), count);
    for contact in &snapshot.contacts {
        assert_relative_eq!(contact.normal_force, force, max_relative = 1e-6);
        assert!((0.0..length).contains(&contact.point[0]), "{contact:?}");
    }
}

#[test]
fn every_pair_that_overlaps_is_stopped_and_momentum_stays() {
    // One, two and several boxes along each axis, and a step so long that its list would like to reach further than the period lets it.
    let mut found = 0;
    let mut falling = gas(5.0, 50);
    (falling.gravity, falling.solver.step) = ([0.0, 0.0, -9.81], 2e-3);
    for scene in [gas(5.0, 50), gas(12.0, 700), gas(30.0, 8000), falling] {
        let diameters = scene.domain.max[0] / (2.0 * RADIUS);
        let mut simulation = start(&scene);
        let (period, before) = (scene.domain.period(), simulation.momentum());
        let scale: f64 = simulation.momentum().iter().map(|p| p.abs()).sum::<f64>() + 1e-3;
        for _ in 0..8 {
            for _ in 0..50 {
                simulation.step();
            }
            // Contacts are those of the positions at the start of a step.
            let particles = simulation.snapshot().particles;
            simulation.step();
            let after = simulation.snapshot().particles;
            let mut contacts: Vec<(u32, u32)> = simulation
                .snapshot()
                .contacts
                .iter()
                .map(|contact| match contact.second {
                    Partner::Grain(second) => (contact.first.min(second), contact.first.max(second)),
                    Partner::Wall(_) => panic!("there are no walls"),
                })
                .collect();
            contacts.sort_unstable();
            for (place, a) in particles.iter().enumerate() {
                for b in &particles[place + 1..] {
                    let arm = period.arm(&Vector3::from(a.position), &Vector3::from(b.position));
                    let nearing = |of: &[Particle]| {
                        let [v, w] = [a, b].map(|one| Vector3::from(of[one.id as usize].velocity));
                        arm.normalize().dot(&(v - w))
                    };
                    if arm.norm() < a.radius + b.radius - 1e-9 && nearing(&particles) > 0.0 {
                        found += 1;
                        let pair = (a.id.min(b.id), a.id.max(b.id));
                        // It bears a force, or others have parted the two.
                        let stopped = contacts.binary_search(&pair).is_ok() || nearing(&after) < 1e-3;
                        assert!(stopped, "{diameters} diameters: {pair:?} near each other by {} m/s", nearing(&after));
                    }
                }
            }
        }
        let weighs = scene.gravity[2] != 0.0;
        for (now, then) in simulation.momentum().iter().zip(before).take(if weighs { 2 } else { 3 }) {
            assert!((now - then).abs() < 1e-11 * scale, "{diameters} diameters: {now} {then}");
        }
    }
    assert!(found > 100, "{found} overlaps seen");
}

#[test]
fn where_the_boundary_lies_does_not_matter() {
    // The same gas, its contents shifted by a part of a period: other boxes, other order, the same motion.
    let scene = gas(6.0, 80);
    let grains = populate(&scene, 1).unwrap();
    let shifted = |shift: [f64; 3]| {
        let mut moved = scene.clone();
        moved.population.clear();
        moved.solver.stop = makadam::scene::Stop::Residual { tolerance: 1e-13, max_sweeps: 20_000 };
        moved.grain = grains
            .iter()
            .map(|grain| makadam::scene::GrainEntry {
                material: grain.material.clone(),
                radius: grain.radius,
                position: std::array::from_fn(|axis| {
                    (grain.position[axis] + shift[axis]).rem_euclid(scene.domain.max[axis])
                }),
                velocity: grain.velocity,
                spin: grain.spin,
            })
            .collect();
        let mut simulation = start(&moved);
        for _ in 0..150 {
            simulation.step();
        }
        simulation.snapshot().particles
    };
    let (here, there) = (shifted([0.0; 3]), shifted([0.031, 0.017, 0.044]));
    let moved =
        here.iter().zip(&grains).filter(|(now, then)| Vector3::from(now.velocity) != Vector3::from(then.velocity));
    assert!(moved.count() > 40, "hardly anything collided");
    for (a, b) in here.iter().zip(&there) {
        let difference = (Vector3::from(a.velocity) - Vector3::from(b.velocity)).norm();
        assert!(difference < 1e-6, "grain {}: {difference:e} m/s", a.id);
    }
}

#[test]
fn periodic_scenes_have_the_same_bits_everywhere_and_after_a_restart() {
    same_bits_everywhere(&gas(20.0, 3000), 150);
}

/// Gravity of a chute that is inclined by `angle` (rad) along x.
fn inclined(angle: f64) -> [f64; 3] {
    [9.81 * angle.sin(), 0.0, -9.81 * angle.cos()]
}

#[test]
fn the_ledger_closes_on_a_chute_without_end() {
    let angle = 0.5;
    let population = "[[population]]\ncount = 300\nmaterial = 'grain'\nradius = { kind = 'fixed', value = 0.005 }\n\
                      spacing = 1.05\nregion = { kind = 'box', min = [0, 0, 0], max = [0.1, 0.06, 0.2] }\n";
    let setup = Setup {
        gravity: inclined(angle),
        solver: "step = 5e-4\nstop = { kind = 'sweeps', sweeps = 30 }".into(),
        body: format!("{FLOOR}{population}"),
        ..Setup::default()
    };
    let mut simulation = start(&periodic(&setup, [0.0, 0.0, -0.1], [0.1, 0.06, 1.0], &[Axis::X, Axis::Y]));
    simulation.open_ledger();
    run_until(&mut simulation, 1.5);
    let balance = simulation.balance().unwrap();
    let lost = balance.friction + balance.restitution + balance.stabilisation;
    let fallen = balance.start.potential - balance.end.potential;
    // Grains went round several times, and potential energy knows it.
    assert!(fallen > 20.0 * balance.start.kinetic.max(1e-3) && lost > 0.0, "{balance:?}");
    // A lap of all grains is 3% of it.
    assert!(balance.closure.abs() < 0.01 * fallen, "{balance:?}");
    let weight = balance.gravity_impulse[2].abs();
    assert!(balance.momentum_closure.iter().all(|open| open.abs() < 1e-9 * weight), "{balance:?}");
    let speed = simulation.snapshot().particles.iter().map(|one| one.velocity[0]).sum::<f64>() / 300.0;
    assert!(speed > 0.5, "the bed slides on a flat floor: {speed} m/s");
}

#[test]
fn a_drum_without_ends_carries_its_grains() {
    // The shell goes on through the ends of its axis: a grain that drifts along it stays inside.
    let shell = "[[wall]]\nname = 'shell'\nmaterial = 'wall'\n\
                 shape = { kind = 'cylinder', base = [0, 0, 0], axis = [0, 1, 0], radius = 0.05, length = 0.06 }\n";
    let body = format!("{shell}{}", grain(RADIUS, [0.0, 0.03, -0.045], [0.0, 1.0, 0.0]));
    let setup = Setup { friction: 0.0, wall_friction: 0.0, body, ..Setup::default() };
    let mut simulation = start(&periodic(&setup, [-0.1, 0.0, -0.1], [0.1, 0.06, 0.1], &[Axis::Y]));
    run_until(&mut simulation, 0.5);
    let snapshot = simulation.snapshot();
    assert_relative_eq!(snapshot.particles[0].velocity[1], 1.0, max_relative = 1e-12);
    assert_relative_eq!(snapshot.particles[0].position[2], -0.045, epsilon = 1e-6);
    assert_eq!(snapshot.contacts.len(), 1);
}

/// Walls of spheres at some places.
fn spheres(radius: f64, centres: &[[f64; 3]]) -> String {
    format!(
        "[[wall]]\nname = 'bed'\nmaterial = 'wall'\nshape = {{ kind = 'spheres', radius = {radius:?}, centres = {centres:?} }}\n"
    )
}

#[test]
fn three_fixed_spheres_bear_a_grain_as_a_pyramid_does() {
    // Equal spheres that touch: the arms to the top are sqrt(2/3) steep, so each smooth contact bears W / (3 sqrt(2/3)).
    let ring = [0.0, 1.0, 2.0].map(|third: f64| {
        let (sine, cosine) = (third * 2.0 * PI / 3.0).sin_cos();
        [2.0 * RADIUS / 3.0_f64.sqrt() * cosine, 2.0 * RADIUS / 3.0_f64.sqrt() * sine, 0.0]
    });
    let height = 2.0 * RADIUS * (2.0_f64 / 3.0).sqrt();
    // The same across the ends of two axes: two of the three lie one period further.
    let far = [ring[0], [ring[1][0] + 0.1, ring[1][1] - 0.2, 0.0], [ring[2][0] - 0.1, ring[2][1], 0.0]];
    for centres in [ring, far] {
        let setup = Setup {
            friction: 0.0,
            wall_friction: 0.0,
            body: spheres(RADIUS, &centres) + &grain(RADIUS, [0.0, 0.0, height], [0.0; 3]),
            ..Setup::default()
        };
        let mut simulation = start(&periodic(&setup, [-0.05, -0.05, -0.1], [0.05, 0.05, 0.1], &[Axis::X, Axis::Y]));
        run_until(&mut simulation, 0.05);
        let snapshot = simulation.snapshot();
        let weight = crate::common::DENSITY * 4.0 / 3.0 * PI * RADIUS.powi(3) * 9.81;
        assert_eq!(snapshot.contacts.len(), 3);
        for contact in &snapshot.contacts {
            assert_relative_eq!(contact.normal_force, weight / (3.0 * (2.0_f64 / 3.0).sqrt()), max_relative = 1e-6);
        }
    }
}

#[test]
fn a_grain_too_fast_for_its_step_does_not_pass_through_a_fixed_sphere() {
    // A hundred diameters a step, head on and past the rim.
    for (offset, hits) in [(0.0, true), (0.009, true), (0.0101, false)] {
        let setup = Setup {
            gravity: [0.0; 3],
            friction: 0.0,
            wall_friction: 0.0,
            restitution: 1.0,
            body: spheres(RADIUS, &[[0.0; 3]]) + &grain(RADIUS, [-0.5, offset, 0.0], [1e4, 0.0, 0.0]),
            ..Setup::default()
        };
        let mut simulation = start(&setup.scene());
        simulation.step();
        simulation.step();
        let [u, v, _] = simulation.snapshot().particles[0].velocity;
        // Mirrored at the normal where they touch, whose sine is the offset over the sum of the radii.
        let sine = if hits { offset / (2.0 * RADIUS) } else { 1.0 };
        assert_relative_eq!(u, 1e4 * (2.0 * sine * sine - 1.0), max_relative = 1e-9, epsilon = 1e-6);
        assert_relative_eq!(v, 1e4 * 2.0 * sine * (1.0 - sine * sine).sqrt(), max_relative = 1e-9, epsilon = 1e-6);
    }
}

#[test]
fn what_cannot_repeat_itself_is_refused() {
    let refusal = |length: f64, wall: &str| {
        let text = format!(
            "name = 'x'\ndescription = 'x'\nduration = 1.0\n\
             domain = {{ min = [0, 0, 0], max = [{length:?}, 1, 1], periodic = ['x'] }}\n\
             [material.m]\ndensity = 2500\nyoungs_modulus = 1e7\npoisson_ratio = 0.3\nfriction = 0.5\nrestitution = 0.5\n\
             [[grain]]\nmaterial = 'm'\nradius = 0.01\nposition = [0.02, 0.5, 0.5]\n{wall}"
        );
        Scene::parse(&text).map(drop).map_err(|error| error.to_string())
    };
    let wall = |shape: &str| format!("[[wall]]\nname = 'w'\nmaterial = 'm'\nshape = {shape}\n");
    assert!(refusal(1.0, "").is_ok());
    assert!(refusal(0.06, "").unwrap_err().contains("too short a period"), "{:?}", refusal(0.06, ""));
    let fine = [
        "{ kind = 'plane', point = [0, 0, 0], normal = [0, 0.1, 1] }",
        "{ kind = 'box', min = [0, 0, 0], max = [1, 1, 1], open = ['-x', '+x'] }",
        "{ kind = 'cylinder', base = [1, 0.5, 0.5], axis = [-1, 0, 0], radius = 0.4, length = 1.0 }",
        "{ kind = 'spheres', centres = [[0, 0, 0]], radius = 0.1 }",
    ];
    for shape in fine {
        assert_eq!(refusal(1.0, &wall(shape)), Ok(()));
    }
    let wrong = [
        ("{ kind = 'plane', point = [0, 0, 0], normal = [0.1, 0, 1] }", "not parallel"),
        ("{ kind = 'box', min = [0, 0, 0], max = [1, 1, 1], open = ['-x'] }", "as open"),
        ("{ kind = 'cylinder', base = [0, 0.5, 0.5], axis = [1, 0, 0], radius = 0.4, length = 0.9 }", "does not reach"),
        ("{ kind = 'cylinder', base = [0.5, 0.5, 0], axis = [0, 0, 1], radius = 0.4, length = 1.0 }", "not parallel"),
        ("{ kind = 'disc', centre = [0.5, 0.5, 0], normal = [0, 0, 1], radius = 0.2 }", "has edges"),
    ];
    for (shape, why) in wrong {
        let message = refusal(1.0, &wall(shape)).unwrap_err();
        assert!(
            message.contains("wall 'w'") && message.contains(why) && message.contains("domain.periodic"),
            "{message}"
        );
    }
    let turning = "[[wall]]\nname = 'w'\nmaterial = 'm'\nshape = { kind = 'plane', point = [0, 0, 0], normal = [0, 0, 1] }\n\
                   motion = { kind = 'rotating', point = [0, 0, 0], axis = [0, 1, 0], rate = 1.0 }\n";
    assert!(refusal(1.0, turning).unwrap_err().contains("another axis"));
}
