//! Vibrating walls against closed forms on one grain.

use crate::common::{CONVERGED_HERTZ, CONVERGED_RIGID, DENSITY, Setup, grain, run_until};
use approx::assert_relative_eq;
use makadam::Simulation;
use std::f64::consts::{PI, TAU};

const RADIUS: f64 = 0.005;
const MASS: f64 = DENSITY * 4.0 / 3.0 * PI * RADIUS * RADIUS * RADIUS;
const G: f64 = 9.81;
const STEP: f64 = 1e-4;

/// A plate at z = 0 that vibrates, with more about its motion, and a grain that rests on it.
fn on_a_plate(amplitude: [f64; 3], frequency: f64, more: &str) -> Setup {
    let plate = format!(
        "[[wall]]\nname = 'plate'\nmaterial = 'wall'\nshape = {{ kind = 'plane', point = [0, 0, 0], normal = [0, 0, 1] }}\n\
         motion = {{ kind = 'vibrating', amplitude = {amplitude:?}, frequency = {frequency:?}{more} }}\n"
    );
    let body = plate + &grain(RADIUS, [0.0, 0.0, RADIUS * (1.0 - 1e-9)], [0.0; 3]);
    Setup { restitution: 0.0, body, ..Setup::default() }
}

/// Normal force of the one contact in the last step, N; zero where there is none.
fn force(simulation: &Simulation) -> f64 {
    simulation.snapshot().contacts.first().map_or(0.0, |contact| contact.normal_force)
}

#[test]
fn below_g_a_grain_stays_on_the_plate_and_bears_its_acceleration() {
    let rate = TAU * 50.0;
    let peak = 0.8 * G;
    let amplitude = peak / (rate * rate);
    let mut simulation = on_a_plate([0.0, 0.0, amplitude], 50.0, "").start();
    // The start is a jump of the plate's velocity; after it the contact goes with the plate.
    run_until(&mut simulation, 0.01);
    while simulation.time() < 0.07 {
        let acceleration = -peak * (rate * simulation.time()).sin();
        simulation.step();
        // The second difference of a sine is (w h)^2 / 12 below its second derivative.
        assert_relative_eq!(force(&simulation), MASS * (G + acceleration), epsilon = 1e-4 * MASS * peak);
        let height = simulation.snapshot().particles[0].position[2];
        let plate = amplitude * (rate * simulation.time()).sin();
        assert_relative_eq!(height, plate + RADIUS, epsilon = 1e-12);
    }
}

#[test]
fn a_compliant_contact_bears_the_same() {
    // Far below the frequency at which the grain swings on its contact, 200 Hz.
    let rate = TAU * 5.0;
    let peak = 0.8 * G;
    let mut simulation =
        Setup { solver: CONVERGED_HERTZ.into(), ..on_a_plate([0.0, 0.0, peak / (rate * rate)], 5.0, "") }.start();
    run_until(&mut simulation, 0.2);
    while simulation.time() < 0.6 {
        let acceleration = -peak * (rate * simulation.time()).sin();
        simulation.step();
        assert_relative_eq!(force(&simulation), MASS * (G + acceleration), epsilon = 1e-2 * MASS * G);
    }
}

#[test]
fn above_g_a_grain_takes_off_where_the_plate_falls_with_g_and_flies_freely() {
    let rate = TAU * 10.0;
    let ratio = 2.0;
    let amplitude = ratio * G / (rate * rate);
    for step in [STEP, 0.25 * STEP] {
        let solver = CONVERGED_RIGID.replace("1e-4", &format!("{step:e}"));
        let mut simulation = Setup { solver, ..on_a_plate([0.0, 0.0, amplitude], 10.0, "") }.start();
        simulation.step();
        while force(&simulation) > 0.0 {
            simulation.step();
        }
        let left = simulation.time() - step;
        let take_off = (1.0 / ratio).asin() / rate;
        assert!((left - take_off).abs() <= step, "step {step}: leaves at {left} s, not {take_off}");
        run_until(&mut simulation, take_off + 0.02);
        let flight = simulation.time() - take_off;
        let speed = amplitude * rate * (rate * take_off).cos();
        let ball = simulation.snapshot().particles[0];
        assert_relative_eq!(ball.velocity[2], speed - G * flight, epsilon = 2.0 * G * step);
        let height = RADIUS + amplitude / ratio + speed * flight - 0.5 * G * flight * flight;
        assert_relative_eq!(ball.position[2], height, epsilon = 2.0 * G * step * flight);
    }
}

#[test]
fn friction_carries_a_grain_along_with_a_plate_that_vibrates_in_its_plane() {
    let rate = TAU * 20.0;
    let peak = 0.3 * G;
    let amplitude = peak / (rate * rate);
    let mut scene = on_a_plate([amplitude, 0.0, 0.0], 20.0, "").scene();
    // So that it cannot roll.
    scene.material.values_mut().for_each(|material| material.rolling_friction = 100.0);
    let mut simulation = Simulation::new(&scene, 1).unwrap();
    // It slips at the start, where the plate jumps to its speed, and then no more.
    run_until(&mut simulation, 0.05);
    while simulation.time() < 0.1 {
        let (acceleration, speed) = (
            -peak * (rate * simulation.time()).sin(),
            amplitude * rate * (rate * (simulation.time() + 0.5 * STEP)).cos(),
        );
        simulation.step();
        let frame = simulation.snapshot();
        assert_relative_eq!(frame.particles[0].velocity[0], speed, epsilon = 1e-4 * amplitude * rate);
        // The force on the plate is the opposite of what carries the grain.
        assert_relative_eq!(-frame.contacts[0].tangential_force[0], MASS * acceleration, epsilon = 1e-3 * MASS * peak);
    }
}

#[test]
fn a_plate_reaches_grains_far_away_and_hits_them_with_its_speed() {
    // Without gravity, 20 radii above the plate: the candidate list must notice that the plate comes.
    let (amplitude, rate, height) = (0.2, TAU, 0.1);
    let mut setup = on_a_plate([0.0, 0.0, amplitude], 1.0, "");
    setup.body = setup.body.replace(&format!("{:?}", RADIUS * (1.0 - 1e-9)), &format!("{:?}", RADIUS + height));
    let mut simulation = Setup { gravity: [0.0; 3], restitution: 1.0, ..setup }.start();
    run_until(&mut simulation, 0.2);
    let cosine = (1.0 - (height / amplitude) * (height / amplitude)).sqrt();
    let velocity = simulation.snapshot().particles[0].velocity[2];
    assert_relative_eq!(velocity, 2.0 * amplitude * rate * cosine, epsilon = 5.0 * amplitude * rate * rate * STEP);
}

#[test]
fn a_plate_waits_for_its_start_and_stays_where_it_stops() {
    let amplitude = 1e-3;
    // Half a period and a sixth of one, downwards from the middle: a displacement of minus sin(60 degrees).
    let setup = on_a_plate([0.0, 0.0, amplitude], 10.0, ", start = 0.05, stop = 0.11666666666666667");
    let mut simulation = setup.start();
    run_until(&mut simulation, 0.05);
    assert_relative_eq!(simulation.snapshot().particles[0].position[2], RADIUS, epsilon = 1e-9);
    run_until(&mut simulation, 0.4);
    let height = simulation.snapshot().particles[0].position[2];
    assert_relative_eq!(height, RADIUS - amplitude * (PI / 3.0).sin(), epsilon = 1e-9);
    assert_relative_eq!(force(&simulation), MASS * G, max_relative = 1e-9);
}

#[test]
fn the_ledger_closes_with_the_work_of_the_plate() {
    for (solver, share) in [(CONVERGED_RIGID, 1e-6), (CONVERGED_HERTZ, 1e-2)] {
        // Thrown and caught over and over.
        let rate = TAU * 20.0;
        let amplitude = 3.0 * G / (rate * rate);
        let setup = Setup { solver: solver.into(), restitution: 0.5, ..on_a_plate([0.0, 0.0, amplitude], 20.0, "") };
        let mut simulation = setup.start();
        // The ledger opens once the list knows the two.
        simulation.step();
        simulation.open_ledger();
        run_until(&mut simulation, 0.5);
        let balance = simulation.balance().unwrap();
        let throughput = balance.walls.abs() + balance.restitution.abs();
        assert!(balance.walls > 0.0 && balance.restitution > 0.0, "{balance:?}");
        assert!(balance.closure.abs() < share * throughput, "{balance:?}");
        assert!(balance.momentum_closure.iter().all(|open| open.abs() < 1e-12), "{balance:?}");
    }
}

#[test]
fn what_makes_no_vibration_is_refused_with_a_remedy() {
    let text = toml::to_string(&on_a_plate([0.0, 0.0, 1e-3], 10.0, "").scene()).unwrap();
    for (sound, wrong, word) in [
        ("frequency = 10.0", "frequency = -1.0", "frequency"),
        ("amplitude = [0.0, 0.0, 0.001]", "amplitude = [0.0, 0.0, inf]", "amplitude"),
        ("start = 0.0", "start = 2.0\nstop = 1.0", "stop"),
    ] {
        assert!(text.contains(sound), "{text}");
        let message = crate::common::parse(&text.replace(sound, wrong)).unwrap_err();
        assert!(message.contains(word) && message.contains("test.toml:"), "{message}");
    }
}
