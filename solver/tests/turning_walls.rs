//! Grains that stick to walls that turn go with them, on their circle.

use crate::common::{Setup, grain};
use approx::assert_relative_eq;
use makadam::Simulation;
use nalgebra::Vector3;

const RADIUS: f64 = 0.005;
const RATE: f64 = 10.0;
const STEP: &str = "step = 5e-4";

/// A motion about the z axis.
const TURNING: &str = "motion = { kind = 'rotating', point = [0, 0, 0], axis = [0, 0, 1], rate = 10.0 }";

fn weightless(body: String, friction: f64, restitution: f64) -> Simulation {
    let solver = STEP.into();
    Setup { gravity: [0.0; 3], friction, wall_friction: friction, restitution, solver, body, ..Setup::default() }
        .start()
}

/// A grain that turns with the walls from the start.
fn carried(position: [f64; 3]) -> String {
    let velocity = [-RATE * position[1], RATE * position[0], 0.0];
    format!("{}spin = [0.0, 0.0, {RATE:?}]\n", grain(RADIUS, position, velocity))
}

/// Distance of the grain from the axis, m.
fn distance(simulation: &Simulation) -> f64 {
    let [x, y, _] = simulation.snapshot().particles[0].position;
    x.hypot(y)
}

fn box_that(motion: &str) -> String {
    format!(
        "[[wall]]\nname = 'box'\nmaterial = 'wall'\n{motion}\n\
         shape = {{ kind = 'box', min = [-0.05, -0.05, -0.05], max = [0.05, 0.05, 0.05], open = [] }}\n"
    )
}

#[test]
fn grain_in_turning_corner_stays() {
    let corner = [0.045, 0.045, 0.0];
    let mut simulation = weightless(box_that(TURNING) + &carried(corner), 1.0, 0.0);
    // Hertz's overlap under half of the centrifugal force on each wall is 1.01e-3 radii.
    for _ in 0..4000 {
        simulation.step();
        let overlap = simulation.largest_overlap();
        assert!(overlap < 1.3e-3, "{overlap} radii after {} s", simulation.time());
    }
    assert!((distance(&simulation) - 0.045 * 2.0_f64.sqrt()).abs() < 2e-3 * RADIUS, "{}", distance(&simulation));
    let spin = simulation.snapshot().particles[0].spin;
    // Friction acts at the grain's radius, and the wall is nearer by the overlap.
    assert_relative_eq!(spin[2], RATE, max_relative = 1e-3);
}

#[test]
fn grain_in_driven_box_keeps_circle() {
    // Pressed 1e-5 m into floor and lid. So heavy a box that the grain does not change its rate.
    let motion = "motion = { kind = 'torque-driven', point = [0, 0, 0], axis = [0, 0, 1], torque = 1e7, moment_of_inertia = 1e6 }";
    let half = RADIUS - 1e-5;
    let flat = format!(
        "[[wall]]\nname = 'box'\nmaterial = 'wall'\n{motion}\n\
         shape = {{ kind = 'box', min = [-1, -1, {:?}], max = [1, 1, {half:?}], open = ['-x', '+x', '-y', '+y'] }}\n",
        -half
    );
    let mut simulation = weightless(flat + &grain(RADIUS, [0.06, 0.0, 0.0], [0.0; 3]), 3.0, 0.0);
    for _ in 0..3000 {
        simulation.step();
    }
    assert_relative_eq!(simulation.snapshot().driven_walls[0].rate, 15.0, max_relative = 1e-6);
    assert_relative_eq!(distance(&simulation), 0.06, max_relative = 1e-4);
}

#[test]
fn grain_between_turning_plates_keeps_circle() {
    // Two plates that their own rotation maps onto themselves hold it by friction alone: it presses 1e-5 m into each.
    let plate = |name: &str, height: f64, up: f64| {
        format!(
            "[[wall]]\nname = '{name}'\nmaterial = 'wall'\n{TURNING}\n\
             shape = {{ kind = 'plane', point = [0, 0, {height:?}], normal = [0, 0, {up:?}] }}\n"
        )
    };
    let body = plate("below", 1e-5 - RADIUS, 1.0) + &plate("above", RADIUS - 1e-5, -1.0) + &carried([0.06, 0.0, 0.0]);
    let mut simulation = weightless(body, 1.0, 0.0);
    for _ in 0..4000 {
        simulation.step();
    }
    assert_relative_eq!(distance(&simulation), 0.06, max_relative = 1e-5);
}

#[test]
fn smooth_turning_drum_moves_no_grain() {
    // What maps itself onto itself has no velocity along its normal.
    let drum = format!(
        "[[wall]]\nname = 'drum'\nmaterial = 'wall'\n{}\n\
         shape = {{ kind = 'cylinder', base = [0, 0, -0.1], axis = [0, 0, 1], radius = 0.1, length = 0.2 }}\n",
        TURNING.replace("10.0", "100.0")
    );
    let mut simulation = weightless(drum + &grain(RADIUS, [0.1 - RADIUS * (1.0 - 1e-9), 0.0, 0.0], [0.0; 3]), 0.0, 0.5);
    for _ in 0..1000 {
        simulation.step();
    }
    let velocity = Vector3::from(simulation.snapshot().particles[0].velocity);
    assert!(velocity.norm() < 1e-7, "{velocity}");
}

#[test]
fn carried_grain_takes_no_work() {
    let mut simulation = weightless(box_that(TURNING) + &carried([0.045, 0.045, 0.0]), 1.0, 0.0);
    simulation.open_ledger();
    let kinetic = simulation.energy().kinetic;
    for _ in 0..2000 {
        simulation.step();
    }
    let balance = simulation.balance().unwrap();
    assert!(balance.walls.abs() < 1e-3 * kinetic, "{balance:#?}");
    assert!(balance.closure.abs() < 1e-9 * balance.exchanged().max(kinetic), "{balance:#?}");
    assert!(balance.angular_momentum_closure.iter().all(|open| open.abs() < 1e-12), "{balance:#?}");
}
