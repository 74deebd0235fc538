//! Resistance to rolling and twisting against closed forms on one grain and on two, and that its absence leaves no trace.

use crate::common::bits::{hash_after, leaves_no_trace, reference_scene, same_bits_everywhere, start};
use crate::common::{CONVERGED_HERTZ, CONVERGED_RIGID, DENSITY, FLOOR, Setup, grain, run_until};
use approx::assert_relative_eq;
use makadam::Simulation;
use makadam::scene::Scene;
use std::f64::consts::PI;

const RADIUS: f64 = 0.005;
const MASS: f64 = DENSITY * 4.0 / 3.0 * PI * RADIUS * RADIUS * RADIUS;
const INERTIA: f64 = 0.4 * MASS * RADIUS * RADIUS;
const G: f64 = 9.81;

/// A scene whose contacts, with walls and between grains, resist rolling and twisting.
fn resisting(setup: &Setup, rolling: f64, twisting: f64) -> Scene {
    let mut scene = setup.scene();
    for material in scene.material.values_mut() {
        (material.rolling_friction, material.twisting_friction) = (rolling, twisting);
    }
    scene
}

/// A grain on the floor with a velocity along x and a spin.
fn on_the_floor(velocity: f64, spin: [f64; 3]) -> Setup {
    let grain = grain(RADIUS, [0.0, 0.0, RADIUS * (1.0 - 1e-9)], [velocity, 0.0, 0.0]);
    Setup { wall_friction: 1.0, body: format!("{FLOOR}{grain}spin = {spin:?}\n"), ..Setup::default() }
}

#[test]
fn a_rolling_ball_slows_down_by_five_sevenths_of_the_coefficient_times_g_and_stops() {
    // The torque mu_r r m g slows the spin, friction keeps the surface from slipping: 7/5 m dv/dt = -mu_r m g.
    let (speed, coefficient) = (0.1, 0.05);
    let setup = on_the_floor(speed, [0.0, speed / RADIUS, 0.0]);
    let mut simulation = start(&resisting(&setup, coefficient, 0.0));
    let slowing = 5.0 / 7.0 * coefficient * G;
    for share in [0.25, 0.5, 0.75] {
        let time = share * speed / slowing;
        run_until(&mut simulation, time);
        let ball = simulation.snapshot().particles[0];
        assert_relative_eq!(ball.velocity[0], speed - slowing * simulation.time(), max_relative = 1e-6);
        assert_relative_eq!(ball.spin[1] * RADIUS, ball.velocity[0], max_relative = 1e-6);
    }
    run_until(&mut simulation, 1.2 * speed / slowing);
    let ball = simulation.snapshot().particles[0];
    assert!(ball.velocity[0].abs() < 1e-9 && ball.spin[1].abs() * RADIUS < 1e-9, "{ball:?}");
    // It has gone v^2 / (2 a), but for the last step.
    assert_relative_eq!(ball.position[0], speed * speed / (2.0 * slowing), max_relative = 1e-2);
}

#[test]
fn a_ball_stays_on_a_slope_up_to_the_coefficient_and_rolls_down_beyond() {
    let coefficient = 0.1;
    for (slope, stays) in [(0.09, true), (0.11, false), (0.3, false)] {
        let angle = f64::atan(slope);
        let setup = Setup { gravity: [G * angle.sin(), 0.0, -G * angle.cos()], ..on_the_floor(0.0, [0.0; 3]) };
        let mut simulation = start(&resisting(&setup, coefficient, 0.0));
        run_until(&mut simulation, 0.05);
        let velocity = simulation.snapshot().particles[0].velocity[0];
        if stays {
            assert!(velocity.abs() < 1e-9, "slope {slope}: {velocity}");
        } else {
            let acceleration = 5.0 / 7.0 * G * (angle.sin() - coefficient * angle.cos());
            assert_relative_eq!(velocity, acceleration * simulation.time(), max_relative = 1e-6);
        }
    }
}

#[test]
fn a_top_slows_down_by_its_twisting_torque_and_stops() {
    let (spin, coefficient) = (100.0, 0.2);
    let mut simulation = start(&resisting(&on_the_floor(0.0, [0.0, 0.0, spin]), 0.0, coefficient));
    let slowing = coefficient * RADIUS * MASS * G / INERTIA;
    run_until(&mut simulation, 0.5 * spin / slowing);
    let top = simulation.snapshot().particles[0];
    assert_relative_eq!(top.spin[2], spin - slowing * simulation.time(), max_relative = 1e-6);
    run_until(&mut simulation, 1.1 * spin / slowing);
    let top = simulation.snapshot().particles[0];
    assert!(top.spin[2].abs() < 1e-9, "{top:?}");
    assert!(top.velocity.iter().all(|v| v.abs() < 1e-12), "{top:?}");
}

/// Two touching grains that approach along x with a speed of 2 each and have these spins.
fn collision(spins: [[f64; 3]; 2], rolling: f64, twisting: f64) -> Simulation {
    let [first, second] = [
        grain(RADIUS, [-RADIUS * (1.0 - 1e-9), 0.0, 1.0], [2.0, 0.0, 0.0]),
        grain(RADIUS, [RADIUS * (1.0 - 1e-9), 0.0, 1.0], [-2.0, 0.0, 0.0]),
    ];
    let body = format!("{first}spin = {:?}\n{second}spin = {:?}\n", spins[0], spins[1]);
    let setup = Setup { gravity: [0.0; 3], restitution: 0.5, body, ..Setup::default() };
    let mut simulation = start(&resisting(&setup, rolling, twisting));
    run_until(&mut simulation, 3e-4);
    simulation
}

#[test]
fn two_grains_that_collide_lose_spin_by_their_cap_over_the_effective_radius() {
    // The normal impulse is m/2 (1 + e) 4; the effective radius of two equal grains is half of one.
    let impulse = 0.5 * MASS * 1.5 * 4.0;
    for coefficient in [0.001, 0.01] {
        let change = coefficient * 0.5 * RADIUS * impulse / INERTIA;
        // About the line of centres: twisting alone.
        let tops = collision([[50.0, 0.0, 0.0], [-50.0, 0.0, 0.0]], 0.0, coefficient).snapshot().particles;
        assert_relative_eq!(tops[0].spin[0], 50.0 - change, max_relative = 1e-9);
        assert_relative_eq!(tops[1].spin[0], -50.0 + change, max_relative = 1e-9);
        // Like two cogs: the surfaces do not slip, so rolling resistance alone slows them.
        let cogs = collision([[0.0, 0.0, 50.0], [0.0, 0.0, -50.0]], coefficient, 0.0).snapshot().particles;
        assert_relative_eq!(cogs[0].spin[2], 50.0 - change, max_relative = 1e-9);
        assert_relative_eq!(cogs[1].spin[2], -50.0 + change, max_relative = 1e-9);
        assert!(cogs.iter().all(|cog| cog.velocity[1].abs() < 1e-9), "no friction: {cogs:?}");
    }
    // A large coefficient stops the turning and does not turn it round.
    for (spins, axis) in [([[50.0, 0.0, 0.0], [-30.0, 0.0, 0.0]], 0), ([[0.0, 0.0, 50.0], [0.0, 0.0, -50.0]], 2)] {
        let grains = collision(spins, 10.0, 10.0).snapshot().particles;
        assert_relative_eq!(grains[0].spin[axis], grains[1].spin[axis], epsilon = 1e-9);
        let mean = 0.5 * (spins[0][axis] + spins[1][axis]);
        assert_relative_eq!(grains[0].spin[axis], mean, epsilon = 1e-9);
    }
}

#[test]
fn each_resistance_leaves_the_other_motion_alone() {
    let tops = collision([[50.0, 0.0, 0.0], [-50.0, 0.0, 0.0]], 0.5, 0.0).snapshot().particles;
    assert_eq!((tops[0].spin[0], tops[1].spin[0]), (50.0, -50.0), "rolling resistance does not slow a top");
    let cogs = collision([[0.0, 0.0, 50.0], [0.0, 0.0, -50.0]], 0.0, 0.5).snapshot().particles;
    assert_relative_eq!(cogs[0].spin[2], 50.0, max_relative = 1e-12);
}

#[test]
fn the_ledger_closes_with_what_resistance_took() {
    let speed = 0.1;
    let setup =
        Setup { solver: CONVERGED_RIGID.replace("1e-4", "1e-3"), ..on_the_floor(speed, [0.0, speed / RADIUS, 40.0]) };
    let mut simulation = start(&resisting(&setup, 0.05, 0.1));
    simulation.open_ledger();
    run_until(&mut simulation, 0.5);
    let balance = simulation.balance().unwrap();
    let kinetic = 0.5 * MASS * speed * speed * 1.4 + 0.5 * INERTIA * 40.0 * 40.0;
    assert_relative_eq!(balance.start.kinetic, kinetic, max_relative = 1e-9);
    // It has come to rest without slipping: resistance took all.
    assert_relative_eq!(balance.resistance, kinetic, max_relative = 1e-6);
    assert!(balance.friction.abs() < 1e-6 * kinetic && balance.closure.abs() < 1e-9 * kinetic, "{balance:?}");
}

#[test]
fn a_kernel_with_resistance_that_no_contact_has_gives_the_bits_of_one_without() {
    for name in ["drum", "packing", "heap"] {
        for (rolling, twisting) in [(0.3, 0.0), (0.0, 0.3), (0.3, 0.3)] {
            leaves_no_trace(&reference_scene(name), 400, |bystander| {
                (bystander.rolling_friction, bystander.twisting_friction) = (rolling, twisting);
            });
        }
    }
}

#[test]
fn a_bed_that_resists_turning_has_the_same_bits_everywhere() {
    let mut scene = reference_scene("drum");
    for material in scene.material.values_mut() {
        (material.rolling_friction, material.twisting_friction) = (0.1, 0.05);
    }
    let without = hash_after(&reference_scene("drum"), 500, |_| ());
    assert_ne!(same_bits_everywhere(&scene, 500), without, "resistance changes the result");
}

#[test]
fn what_torques_do_not_go_with_is_refused_with_a_remedy() {
    let setup = |solver: &str| {
        let scene = resisting(&on_the_floor(0.0, [0.0; 3]), 0.1, 0.0);
        let text = toml::to_string(&scene).unwrap();
        let table: toml::Table = toml::from_str(&text).unwrap();
        let mut table = table;
        let solver: toml::Table = toml::from_str(solver).unwrap();
        table["solver"].as_table_mut().unwrap().extend(solver);
        Scene::parse(&toml::to_string(&table).unwrap()).unwrap_err().to_string()
    };
    let message = setup("method = { kind = 'anderson' }");
    assert!(message.contains("anderson") && message.contains("rolling_friction"), "{message}");
    assert!(message.contains("gauss-seidel in double precision"), "{message}");
    let message = setup("precision = 'single'");
    assert!(message.contains("single") && message.contains("leave one out"), "{message}");
}

#[test]
fn compliant_contacts_resist_alike() {
    let (speed, coefficient) = (0.1, 0.05);
    let setup = Setup { solver: CONVERGED_HERTZ.into(), ..on_the_floor(speed, [0.0, speed / RADIUS, 0.0]) };
    let mut simulation = start(&resisting(&setup, coefficient, 0.0));
    // After the grain has settled onto its overlap.
    run_until(&mut simulation, 0.02);
    let before = (simulation.time(), simulation.snapshot().particles[0].velocity[0]);
    run_until(&mut simulation, 0.1);
    let after = (simulation.time(), simulation.snapshot().particles[0].velocity[0]);
    let slowing = (before.1 - after.1) / (after.0 - before.0);
    assert_relative_eq!(slowing, 5.0 / 7.0 * coefficient * G, max_relative = 1e-3);
}
