//! Gravity that changes in time, against closed forms on one grain.

use crate::common::{DENSITY, FLOOR, Setup, grain, run_until};
use approx::assert_relative_eq;
use makadam::Simulation;
use makadam::scene::{GravityChange, Scene, Watch};
use makadam::solve::StopReason;
use makadam::watch::Watchdog;
use std::f64::consts::PI;

const RADIUS: f64 = 0.005;
const MASS: f64 = DENSITY * 4.0 / 3.0 * PI * RADIUS * RADIUS * RADIUS;
const G: f64 = 9.81;
const STEP: f64 = 1e-4;

fn changing(setup: &Setup, changes: &[(f64, [f64; 3])]) -> Scene {
    let mut scene = setup.scene();
    scene.gravity_changes = changes.iter().map(|&(time, gravity)| GravityChange { time, gravity }).collect();
    scene
}

fn start(scene: &Scene) -> Simulation {
    Simulation::new(scene, 1).unwrap_or_else(|error| panic!("{error}"))
}

fn on_the_floor() -> Setup {
    let body = format!("{FLOOR}{}", grain(RADIUS, [0.0, 0.0, RADIUS * (1.0 - 1e-9)], [0.0; 3]));
    Setup { body, restitution: 0.0, ..Setup::default() }
}

#[test]
fn a_grain_falls_as_gravity_ramps_and_then_as_it_stays() {
    let (ramp, gain) = (0.1, [3.0, 0.0, -10.0]);
    let last = std::array::from_fn(|axis| [0.0, 0.0, -G][axis] + gain[axis]);
    let setup = Setup { body: grain(RADIUS, [0.0, 0.0, 5.0], [0.0; 3]), ..Setup::default() };
    let mut simulation = start(&changing(&setup, &[(ramp, last)]));
    for until in [0.05, 0.1, 0.3] {
        run_until(&mut simulation, until);
        let time = simulation.time();
        let (rising, level) = (time.min(ramp), (time - ramp).max(0.0));
        for axis in 0..3 {
            let (first, gain) = ([0.0, 0.0, -G][axis], gain[axis]);
            let speed = |t: f64| first * t + gain * t * t / (2.0 * ramp);
            let way = |t: f64| first * t * t / 2.0 + gain * t * t * t / (6.0 * ramp);
            let velocity = speed(rising) + (first + gain) * level;
            let place =
                [0.0, 0.0, 5.0][axis] + way(rising) + speed(rising) * level + (first + gain) * level * level / 2.0;
            let ball = simulation.snapshot().particles[0];
            assert_relative_eq!(ball.velocity[axis], velocity, epsilon = 2.0 * G * STEP);
            assert_relative_eq!(ball.position[axis], place, epsilon = 2.0 * G * STEP * time);
        }
    }
}

#[test]
fn a_grain_slides_once_gravity_has_turned_by_the_angle_of_friction() {
    // Along the plane gravity grows from 0 to g, across it stays: its slope passes mu = 1/2 half way.
    let (ramp, friction) = (0.2, 0.5);
    let setup = Setup { wall_friction: friction, ..on_the_floor() };
    let mut scene = changing(&setup, &[(ramp, [G, 0.0, -G])]);
    // So that it cannot roll.
    scene.material.values_mut().for_each(|material| material.rolling_friction = 100.0);
    let mut simulation = start(&scene);
    let speed = |simulation: &Simulation| simulation.snapshot().particles[0].velocity[0];
    while speed(&simulation) < 1e-9 {
        simulation.step();
    }
    // Gravity was that of the start of the step.
    let slides_at = simulation.time() - STEP;
    assert!((slides_at - friction * ramp).abs() <= 1.5 * STEP, "slides at {slides_at} s");
    run_until(&mut simulation, ramp);
    let (from, to) = (friction * ramp, simulation.time());
    let expected = G * (to * to - from * from) / (2.0 * ramp) - friction * G * (to - from);
    assert_relative_eq!(speed(&simulation), expected, epsilon = 2.0 * G * STEP);
}

#[test]
fn a_contact_bears_the_weight_of_the_moment_and_lets_go_as_it_turns_round() {
    let ramp = 0.2;
    let mut simulation = start(&changing(&on_the_floor(), &[(0.1, [0.0, 0.0, -G]), (0.1 + ramp, [0.0, 0.0, G])]));
    let mut left = None;
    while simulation.time() < 0.3 {
        let (time, report) = (simulation.time(), simulation.step());
        // The measure of residuals does not vanish with gravity.
        assert!(matches!(report.solve.reason, StopReason::NoContacts | StopReason::Residual), "{report:?} at {time} s");
        let weight = MASS * G * (1.0 - 2.0 * ((time - 0.1) / ramp).max(0.0));
        let force = simulation.snapshot().contacts.first().map_or(0.0, |contact| contact.normal_force);
        // At first the slight overlap that it starts with pushes too.
        if time > 0.01 {
            assert_relative_eq!(force, weight.max(0.0), epsilon = 1e-6 * MASS * G);
        }
        if left.is_none() && time > 0.01 && simulation.snapshot().particles[0].velocity[2] > 1e-9 {
            left = Some(time);
        }
    }
    let left = left.expect("gravity has turned round");
    assert!((left - 0.2).abs() <= 1.5 * STEP, "leaves at {left} s");
}

#[test]
fn a_grain_floats_until_gravity_is_switched_on() {
    let setup = Setup { gravity: [0.0; 3], ..on_the_floor() };
    let above = setup.body.replace(&format!("{:?}", RADIUS * (1.0 - 1e-9)), "0.015");
    let mut simulation =
        start(&changing(&Setup { body: above, ..setup }, &[(0.1, [0.0; 3]), (0.1001, [0.0, 0.0, -G])]));
    run_until(&mut simulation, 0.1);
    assert_eq!(simulation.snapshot().particles[0].position[2], 0.015);
    run_until(&mut simulation, 0.4);
    let frame = simulation.snapshot();
    assert_relative_eq!(frame.particles[0].position[2], RADIUS, epsilon = 1e-6);
    assert_relative_eq!(frame.contacts[0].normal_force, MASS * G, max_relative = 1e-6);
}

#[test]
fn the_ledger_closes_with_what_the_changing_field_gave() {
    // A ball that bounces while gravity grows and turns.
    let body = format!("{FLOOR}{}", grain(RADIUS, [0.0, 0.0, 0.05], [0.1, 0.0, 0.0]));
    let setup = Setup { restitution: 0.7, body, ..Setup::default() };
    let mut simulation = start(&changing(&setup, &[(0.2, [2.0, 0.0, -15.0]), (0.4, [-1.0, 1.0, -5.0])]));
    simulation.open_ledger();
    run_until(&mut simulation, 0.5);
    let balance = simulation.balance().unwrap();
    let throughput = balance.restitution + balance.friction;
    assert!(balance.changing_gravity.abs() > 0.1 * throughput, "{balance:?}");
    assert!(balance.closure.abs() < 1e-9 * throughput, "{balance:?}");
    assert!(balance.momentum_closure.iter().all(|open| open.abs() < 1e-12), "{balance:?}");
}

#[test]
fn changing_gravity_is_no_energy_from_nowhere() {
    // On a floor one metre up, where a field that grows gives a grain at rest potential energy.
    let body = format!("{FLOOR}{}", grain(RADIUS, [0.0, 0.0, 1.0 + RADIUS], [0.0; 3]))
        .replace("point = [0, 0, 0]", "point = [0, 0, 1]");
    let scene = changing(&Setup { body, ..on_the_floor() }, &[(0.1, [0.0, 0.0, -2.0 * G])]);
    let mut simulation = start(&scene);
    let mut watchdog = Watchdog::new(&Watch { every: 4, ..Watch::default() }, &simulation);
    while simulation.time() < 0.2 {
        let report = simulation.step();
        let alarms = watchdog.observe(&simulation, &report);
        assert!(alarms.is_empty(), "{alarms:?}");
    }
}

#[test]
fn a_run_that_was_stopped_goes_on_with_the_gravity_of_its_time() {
    let scene = changing(&on_the_floor(), &[(0.05, [1.0, 2.0, -15.0]), (0.1, [-8.0, 0.0, -5.0])]);
    let mut simulation = start(&scene);
    run_until(&mut simulation, 0.07);
    let mut continued = Simulation::resume(&scene, &simulation.checkpoint()).unwrap();
    run_until(&mut simulation, 0.12);
    run_until(&mut continued, 0.12);
    assert_eq!(continued.state_hash(), simulation.state_hash());
}

#[test]
fn a_field_is_linear_between_its_changes() {
    let changes = [(1.0, [0.0, 0.0, -G]), (2.0, [G, 0.0, 0.0]), (3.0, [0.0, 0.0, -G]), (4.0, [0.0, 0.0, -2.0 * G])];
    let field = changing(&on_the_floor(), &changes).gravity_field();
    assert_eq!(field.largest(), 2.0 * G);
    assert_relative_eq!(field.at(1.25).x, 0.25 * G, max_relative = 1e-12);
}

#[test]
fn a_scene_without_changes_does_not_mention_them_and_wrong_ones_are_refused() {
    let plain = toml::to_string(&on_the_floor().scene()).unwrap();
    assert!(!plain.contains("gravity_changes"), "{plain}");
    let parse = |changes: &str| {
        let text = format!("gravity_changes = [{changes}]\n{plain}");
        crate::common::parse(&text)
    };
    assert!(parse("{ time = 1.0, gravity = [0, 0, -1] }, { time = 2.0, gravity = [0, 0, 1] }").is_ok());
    for wrong in [
        "{ time = 0.0, gravity = [0, 0, -1] }",
        "{ time = 2.0, gravity = [0, 0, -1] }, { time = 1.0, gravity = [0, 0, 1] }",
        "{ time = 1.0, gravity = [0, 0, nan] }",
        "{ time = -1.0, gravity = [0, 0, 1] }",
    ] {
        let message = parse(wrong).unwrap_err();
        assert!(message.starts_with("test.toml:1:") && message.contains("gravity_changes["), "{message}");
    }
}
