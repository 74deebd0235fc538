//! Static and kinetic friction against closed forms on one grain, and that their difference leaves no trace where there is none.

use crate::common::bits::{hash_after, leaves_no_trace, reference_scene, same_bits_everywhere, start};
use crate::common::{CONVERGED_HERTZ, CONVERGED_RIGID, FLOOR, Setup, grain, run_until};
use approx::assert_relative_eq;
use makadam::Simulation;
use makadam::scene::Scene;

const RADIUS: f64 = 0.005;
const G: f64 = 9.81;
const STATIC: f64 = 0.5;
const KINETIC: f64 = 0.3;

/// A grain that cannot roll on a slope, with a velocity down it (m/s).
fn on_a_slope(slope: f64, velocity: f64, solver: &str) -> Simulation {
    let angle = f64::atan(slope);
    let setup = Setup {
        gravity: [G * angle.sin(), 0.0, -G * angle.cos()],
        wall_friction: STATIC,
        solver: solver.into(),
        body: format!("{FLOOR}{}", grain(RADIUS, [0.0, 0.0, RADIUS * (1.0 - 1e-9)], [velocity, 0.0, 0.0])),
        ..Setup::default()
    };
    let mut scene = setup.scene();
    for material in scene.material.values_mut() {
        (material.rolling_friction, material.kinetic_friction) = (100.0, Some(KINETIC));
    }
    start(&scene)
}

fn speed(simulation: &Simulation) -> f64 {
    simulation.snapshot().particles[0].velocity[0]
}

/// Acceleration down a slope with a coefficient of friction.
fn acceleration(slope: f64, friction: f64) -> f64 {
    let angle = f64::atan(slope);
    G * (angle.sin() - friction * angle.cos())
}

#[test]
fn a_grain_at_rest_stays_up_to_the_static_coefficient_and_slides_with_the_kinetic_one_beyond() {
    for (slope, stays) in [(0.2, true), (0.4, true), (0.49, true), (0.55, false), (0.8, false)] {
        let mut simulation = on_a_slope(slope, 0.0, CONVERGED_RIGID);
        run_until(&mut simulation, 0.1);
        if stays {
            assert!(speed(&simulation).abs() < 1e-9, "slope {slope}: {}", speed(&simulation));
            continue;
        }
        // Static friction acts until the speed is g h.
        let (before, step) = (G * 1e-4, 1e-4);
        let breaking_loose = before / acceleration(slope, STATIC);
        let expected = before + acceleration(slope, KINETIC) * (simulation.time() - breaking_loose);
        assert_relative_eq!(speed(&simulation), expected, epsilon = 2.0 * G * step);
    }
}

#[test]
fn what_breaking_loose_takes_shrinks_with_the_step() {
    // 0.1 above the static coefficient: the first law of motion is the kinetic one in the limit.
    let (slope, time) = (0.6, 0.05);
    let errors = [4e-4, 2e-4, 1e-4].map(|step: f64| {
        let mut simulation = on_a_slope(slope, 0.0, &CONVERGED_RIGID.replace("1e-4", &format!("{step:e}")));
        run_until(&mut simulation, time);
        acceleration(slope, KINETIC) * simulation.time() - speed(&simulation)
    });
    for two in errors.windows(2) {
        assert!(two[1] > 0.0 && (1.7..2.4).contains(&(two[0] / two[1])), "{errors:?}");
    }
}

#[test]
fn between_the_two_angles_a_grain_that_slides_goes_on_and_one_launched_uphill_stops_and_stays() {
    for slope in [0.35, 0.4, 0.45] {
        let launched = 0.2;
        let mut down = on_a_slope(slope, launched, CONVERGED_RIGID);
        run_until(&mut down, 0.2);
        let expected = launched + acceleration(slope, KINETIC) * down.time();
        assert_relative_eq!(speed(&down), expected, max_relative = 1e-6);

        let mut up = on_a_slope(slope, -launched, CONVERGED_RIGID);
        let angle = f64::atan(slope);
        let slowing = G * (angle.sin() + KINETIC * angle.cos());
        run_until(&mut up, 0.5 * launched / slowing);
        assert_relative_eq!(speed(&up), -launched + slowing * up.time(), max_relative = 1e-6);
        run_until(&mut up, 2.0 * launched / slowing);
        assert!(speed(&up).abs() < 1e-9, "slope {slope}: {}", speed(&up));
        let way = -up.snapshot().particles[0].position[0];
        assert_relative_eq!(way, launched * launched / (2.0 * slowing), max_relative = 1e-2);
    }
}

#[test]
fn below_the_kinetic_angle_a_sliding_grain_stops() {
    let (slope, launched) = (0.1, 0.2);
    let mut simulation = on_a_slope(slope, launched, CONVERGED_HERTZ);
    run_until(&mut simulation, 0.5);
    assert!(speed(&simulation).abs() < 1e-9, "{}", speed(&simulation));
}

#[test]
fn spin_counts_as_sliding() {
    // A grain that spins on the spot slides, whatever the velocity of its centre: friction speeds it up with mu_k g.
    let body =
        format!("{FLOOR}{}spin = [0.0, 100.0, 0.0]\n", grain(RADIUS, [0.0, 0.0, RADIUS * (1.0 - 1e-9)], [0.0; 3]));
    let mut scene = Setup { wall_friction: STATIC, body, ..Setup::default() }.scene();
    scene.material.values_mut().for_each(|material| material.kinetic_friction = Some(KINETIC));
    let mut simulation = start(&scene);
    run_until(&mut simulation, 0.01);
    // The slight overlap that it starts with adds to its weight at first.
    assert_relative_eq!(speed(&simulation), KINETIC * G * simulation.time(), max_relative = 1e-4);
    // And two cogs: unlike two wheels in gear their surfaces slide on each other.
    for (second, slides) in [(300.0, true), (-300.0, false)] {
        let cog = |side: f64, spin: f64| {
            grain(RADIUS, [side * RADIUS * (1.0 - 1e-9), 0.0, 1.0], [-side, 0.0, 0.0])
                + &format!("spin = [0.0, 0.0, {spin:?}]\n")
        };
        let setup = Setup {
            gravity: [0.0; 3],
            friction: STATIC,
            restitution: 0.0,
            body: cog(-1.0, 300.0) + &cog(1.0, second),
            ..Setup::default()
        };
        let mut scene = setup.scene();
        scene.material.values_mut().for_each(|material| material.kinetic_friction = Some(KINETIC));
        let mut simulation = start(&scene);
        simulation.step();
        // Each grain stops along the normal; across it friction gives mu_k of that.
        let across = simulation.snapshot().particles[0].velocity[1];
        let expected = if slides { KINETIC } else { 0.0 };
        assert_relative_eq!(across.abs(), expected, epsilon = 1e-6);
    }
}

/// A bed of 100 grains under a lid that presses with 5 N, at a gravity (m/s2): the share of contacts, of those that bear more than a
/// thousandth of the mean, whose friction is above the kinetic coefficient, over the last tenth of a second.
fn share_above_kinetic(gravity: f64, sweeps: u32) -> f64 {
    let (sticking, kinetic) = (0.8, 0.2);
    let lid = "[[wall]]\nname = 'lid'\nmaterial = 'wall'\nshape = { kind = 'plane', point = [0, 0, 0.1], normal = [0, 0, -1] }\n\
               motion = { kind = 'force-driven', axis = [0, 0, -1], force = 5.0, mass = 0.05 }\n";
    let bin = "[[wall]]\nname = 'box'\nmaterial = 'wall'\n\
               shape = { kind = 'box', min = [-0.02, -0.02, 0], max = [0.02, 0.02, 0.28], open = ['+z'] }\n";
    let grains = "[[population]]\ncount = 100\nmaterial = 'grain'\nradius = { kind = 'uniform', mean = 0.004, spread = 0.2 }\n\
                  spacing = 1.02\nregion = { kind = 'box', min = [-0.02, -0.02, 0], max = [0.02, 0.02, 0.1] }\n";
    let mut scene = Setup {
        gravity: [0.0, 0.0, -gravity],
        friction: sticking,
        wall_friction: sticking,
        restitution: 0.3,
        solver: format!("step = 5e-4\nstop = {{ kind = 'sweeps', sweeps = {sweeps} }}"),
        body: format!("{bin}{lid}{grains}"),
        ..Setup::default()
    }
    .scene();
    scene.material.values_mut().for_each(|material| material.kinetic_friction = Some(kinetic));
    let mut simulation = start(&scene);
    run_until(&mut simulation, 0.7);
    let mut shares = Vec::new();
    for _ in 0..10 {
        let next = simulation.time() + 0.01;
        run_until(&mut simulation, next);
        let contacts = simulation.snapshot().contacts;
        let mean = contacts.iter().map(|one| one.normal_force).sum::<f64>() / contacts.len() as f64;
        let bearing: Vec<_> = contacts.iter().filter(|one| one.normal_force > 1e-3 * mean).collect();
        let size = |vector: [f64; 3]| vector.iter().map(|v| v * v).sum::<f64>().sqrt();
        let above =
            bearing.iter().filter(|one| size(one.tangential_force) > 1.001 * kinetic * one.normal_force).count();
        shares.push(above as f64 / bearing.len() as f64);
    }
    shares.iter().sum::<f64>() / shares.len() as f64
}

#[test]
fn static_friction_holds_without_gravity() {
    for sweeps in [10, 100] {
        let shares = [9.81, 0.1, 1e-3, 0.0].map(|gravity| share_above_kinetic(gravity, sweeps));
        println!("{sweeps} sweeps: {shares:?}");
        assert!(shares.iter().all(|&share| share > 0.2), "{sweeps} sweeps: {shares:?}");
    }
}

#[test]
fn every_method_tells_sliding_from_sticking() {
    use makadam::scene::SolverMethod;
    // Pressed against a wall by a lid without gravity: one pushed with less than mu_s stays, one with more slides with mu_k.
    for method in SolverMethod::ALL {
        for (slope, stays) in [(0.4, true), (0.6, false)] {
            let angle = f64::atan(slope);
            let setup = Setup {
                gravity: [G * angle.sin(), 0.0, -G * angle.cos()],
                wall_friction: STATIC,
                body: format!(
                    "{FLOOR}{}",
                    [-1.0, 1.0].map(|side| grain(RADIUS, [0.0, side * 0.02, RADIUS * (1.0 - 1e-9)], [0.0; 3])).concat()
                ),
                ..Setup::default()
            };
            let mut scene = setup.scene();
            scene.solver.method = method;
            scene.solver.stop = makadam::scene::Stop::Sweeps { sweeps: 100 };
            // Grains that cannot roll need torques, which most methods lack; so the two are made to slide by their spin.
            scene.material.values_mut().for_each(|material| material.kinetic_friction = Some(KINETIC));
            for grain in &mut scene.grain {
                grain.spin = [0.0, if stays { 0.0 } else { -400.0 }, 0.0];
            }
            let mut simulation = start(&scene);
            run_until(&mut simulation, 0.01);
            let contacts = simulation.snapshot().contacts;
            let coefficient = contacts[0].tangential_force[0].abs() / contacts[0].normal_force;
            let rolling = 2.0 / 7.0 * slope;
            let expected = if stays { rolling } else { KINETIC };
            assert_relative_eq!(coefficient, expected, max_relative = 1e-3);
        }
    }
}

#[test]
fn two_coefficients_that_no_contact_has_leave_no_trace() {
    for name in ["drum", "packing", "heap"] {
        let plain = reference_scene(name);
        leaves_no_trace(&plain, 300, |bystander| bystander.kinetic_friction = Some(0.0));
        assert!(!toml::to_string(&plain).unwrap().contains("kinetic_friction"), "{name}");
    }
}

#[test]
fn a_bed_has_the_same_bits_everywhere() {
    let mut scene = reference_scene("drum");
    for material in scene.material.values_mut() {
        material.kinetic_friction = Some(0.6 * material.friction);
    }
    let without = hash_after(&reference_scene("drum"), 500, |_| ());
    assert_ne!(same_bits_everywhere(&scene, 500), without, "the effect changes the result");
}

#[test]
fn a_rule_for_friction_alone_holds_for_both_and_more_than_static_friction_is_refused() {
    let body = format!("{FLOOR}{}", grain(RADIUS, [0.0, 0.0, RADIUS], [0.0; 3]));
    let text = toml::to_string(&Setup { wall_friction: STATIC, body, ..Setup::default() }.scene()).unwrap();
    let text = text.replace("pair = []\n", "");
    let parse = |rule: &str| {
        let rule = format!("{text}\n[[pair]]\nbetween = ['wall', 'grain']\n{rule}\n");
        Scene::parse(&rule).map_err(|error| error.to_string())
    };
    let coefficients = |rule: &str| {
        let pair = parse(rule).unwrap().contact_coefficients("grain", "wall", true);
        (pair.friction, pair.kinetic_friction)
    };
    assert_eq!(coefficients("friction = 0.7"), (0.7, 0.7));
    assert_eq!(coefficients("kinetic_friction = 0.2"), (STATIC, 0.2));
    assert_eq!(coefficients("friction = 0.7\nkinetic_friction = 0.6"), (0.7, 0.6));
    let message = parse("kinetic_friction = 0.6").unwrap_err();
    assert!(message.contains("pair[0].kinetic_friction") && message.contains("from 0 to 0.5"), "{message}");
    let text = text.replace("[material.grain]", "[material.grain]\nkinetic_friction = 0.9");
    let message = Scene::parse(&text).unwrap_err().to_string();
    assert!(message.contains("material.grain.kinetic_friction"), "{message}");
}
