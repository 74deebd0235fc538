//! The ledger of energy and momentum against closed forms, and how it closes.

use crate::common::{CONVERGED_HERTZ, CONVERGED_RIGID, DENSITY, FLOOR, Setup, grain, run_until};
use approx::assert_relative_eq;
use makadam::scene::Scene;
use makadam::{Balance, Simulation};
use std::f64::consts::PI;
use std::path::Path;

const RADIUS: f64 = 0.005;
const MASS: f64 = DENSITY * 4.0 / 3.0 * PI * RADIUS * RADIUS * RADIUS;

fn run(setup: &Setup, time: f64) -> Balance {
    let mut simulation = setup.start();
    simulation.open_ledger();
    run_until(&mut simulation, time);
    simulation.balance().unwrap()
}

fn throughput(balance: &Balance) -> f64 {
    balance.start.kinetic + balance.friction.abs() + balance.restitution.abs() + balance.walls.abs()
}

#[test]
fn an_impact_loses_what_newtons_law_says() {
    for restitution in [0.0, 0.5, 0.9] {
        let setup = Setup {
            gravity: [0.0; 3],
            wall_friction: 0.0,
            friction: 0.0,
            restitution,
            body: format!("{FLOOR}{}", grain(RADIUS, [0.0, 0.0, 0.006], [0.0, 0.0, -1.0])),
            ..Setup::default()
        };
        let balance = run(&setup, 0.01);
        let kinetic = 0.5 * MASS;
        assert_relative_eq!(balance.start.kinetic, kinetic, max_relative = 1e-12);
        assert_relative_eq!(balance.restitution, kinetic * (1.0 - restitution * restitution), max_relative = 1e-9);
        assert_eq!((balance.friction, balance.walls), (0.0, 0.0));
        assert!(balance.closure.abs() < 1e-12 * kinetic, "{balance:?}");
        assert_relative_eq!(balance.wall_impulse[2], MASS * (1.0 + restitution), max_relative = 1e-9);
        assert!(balance.momentum_closure.iter().all(|open| open.abs() < 1e-12 * MASS), "{balance:?}");
    }
}

#[test]
fn a_sliding_grain_loses_to_friction_until_it_rolls() {
    // Set down sliding at 1 m/s it rolls at 5/7 m/s in the end: 2/7 of its energy went to friction.
    let setup = Setup {
        wall_friction: 0.3,
        body: format!("{FLOOR}{}", grain(RADIUS, [0.0, 0.0, RADIUS], [1.0, 0.0, 0.0])),
        ..Setup::default()
    };
    let balance = run(&setup, 0.2);
    assert_relative_eq!(balance.friction, 0.5 * MASS * 2.0 / 7.0, max_relative = 1e-6);
    assert_relative_eq!(balance.gravity_impulse[2], -MASS * 9.81 * 0.2, max_relative = 1e-9);
    assert!(balance.closure.abs() < 1e-9 * MASS, "{balance:?}");
}

#[test]
fn a_belt_does_work_on_what_it_carries_along() {
    // Carried from rest to the belt's speed V: friction loses as much as the grain gains, and the belt pays both (sliding), where
    // a sphere that ends rolling at rest on the belt moves at 2/7 V.
    let floor = FLOOR.replace(
        "normal = [0, 0, 1] }",
        "normal = [0, 0, 1] }\nmotion = { kind = 'translating', velocity = [1.0, 0.0, 0.0] }",
    );
    let setup = Setup {
        wall_friction: 0.3,
        // Rounding keeps many of these solves above 1e-13.
        solver: CONVERGED_RIGID.replace("1e-13", "1e-11"),
        body: format!("{floor}{}", grain(RADIUS, [0.0, 0.0, RADIUS], [0.0; 3])),
        ..Setup::default()
    };
    let balance = run(&setup, 0.3);
    let impulse = MASS * 2.0 / 7.0;
    assert_relative_eq!(balance.walls, impulse, max_relative = 1e-5);
    assert_relative_eq!(balance.wall_impulse[0], impulse, max_relative = 1e-5);
    assert_relative_eq!(balance.friction, 0.5 * impulse, max_relative = 1e-5);
    assert!(balance.closure.abs() < 1e-8 * MASS, "{balance:?}");
}

#[test]
fn a_resolved_bounce_stores_and_gives_back() {
    let setup = Setup {
        gravity: [0.0; 3],
        restitution: 0.8,
        youngs_modulus: 1e6,
        solver: CONVERGED_HERTZ.replace("1e-4", "1e-6"),
        body: format!("{FLOOR}{}", grain(RADIUS, [0.0, 0.0, 0.0051], [0.0, 0.0, -0.2])),
        ..Setup::default()
    };
    let balance = run(&setup, 0.01);
    let kinetic = 0.5 * MASS * 0.04;
    assert_relative_eq!(balance.restitution, kinetic * (1.0 - 0.64), max_relative = 0.01);
    assert_eq!(balance.end.elastic, 0.0);
    assert!(balance.closure.abs() < 1e-4 * kinetic, "{balance:?}");
}

#[test]
fn the_ledger_of_a_packing_and_of_a_drum_closes() {
    for (name, time) in [("packing", 0.5), ("drum", 0.8)] {
        let file = Path::new(env!("CARGO_MANIFEST_DIR")).join(format!("../reference-scenes/{name}/scene.toml"));
        let scene = Scene::load(&file).unwrap();
        let mut simulation = Simulation::new(&scene, 1).unwrap();
        let mut without = simulation.clone();
        simulation.open_ledger();
        run_until(&mut simulation, time);
        run_until(&mut without, time);
        assert_eq!(simulation.state_hash(), without.state_hash(), "{name}: the ledger only looks");
        let balance = simulation.balance().unwrap();
        println!("{name}: {balance:#?}");
        let scale = throughput(&balance) + (balance.end.potential - balance.start.potential).abs();
        assert!(balance.friction > 0.0 && balance.restitution > 0.0, "{name}: {balance:?}");
        assert!(balance.closure.abs() < 0.01 * scale, "{name}: {balance:?}");
        let weight = balance.gravity_impulse[2].abs();
        assert!(balance.momentum_closure.iter().all(|open| open.abs() < 1e-9 * weight), "{name}: {balance:?}");
    }
}

#[test]
fn rigid_grains_lose_nothing_to_stabilisation_at_rest() {
    let setup = Setup {
        solver: CONVERGED_RIGID.into(),
        body: format!("{FLOOR}{}", grain(RADIUS, [0.0, 0.0, RADIUS], [0.0; 3])),
        ..Setup::default()
    };
    let balance = run(&setup, 0.1);
    assert!(balance.stabilisation.abs() < 1e-12 * MASS && balance.closure.abs() < 1e-12 * MASS, "{balance:?}");
}

#[test]
fn an_impulse_outside_of_the_solve_is_accounted_for() {
    // A grain that moves along x throws the one that it touches down onto a wall that comes up at 2 m/s, all within a step: the solve
    // knows of the pair alone.
    let floor = FLOOR.replace(
        "normal = [0, 0, 1] }",
        "normal = [0, 0, 1] }\nmotion = { kind = 'translating', velocity = [0.0, 0.3, 2.0] }",
    );
    let struck = grain(RADIUS, [0.0, 0.0, 0.02], [0.0; 3]) + "spin = [3.0, 2.0, 1.0]\n";
    let arm = 2.0 * RADIUS * (1.0 - 1e-9) * 0.5_f64.sqrt();
    let flying = grain(RADIUS, [-arm, 0.0, 0.02 + arm], [1000.0, 0.0, 0.0]);
    let setup = Setup { gravity: [1.0, 0.0, -9.0], body: format!("{floor}{struck}{flying}"), ..Setup::default() };
    let mut simulation = setup.start();
    simulation.open_ledger();
    simulation.step();
    assert_eq!(simulation.layout().tasks().map(|(_, task)| task.walls.len()).sum::<usize>(), 0);
    let balance = simulation.balance().unwrap();
    let [impulse_y, impulse_z] = [balance.wall_impulse[1], balance.wall_impulse[2]];
    assert!(impulse_y > 0.0 && impulse_z > 100.0 * MASS, "the wall turns the grain up: {balance:#?}");
    assert_relative_eq!(balance.walls, 0.3 * impulse_y + 2.0 * impulse_z, max_relative = 1e-12);
    assert!(balance.restitution > 0.0 && balance.friction > 0.0, "{balance:#?}");
    for _ in 0..2 {
        let now = simulation.balance().unwrap();
        assert!(now.closure.abs() < 1e-12 * now.exchanged(), "{now:#?}");
        assert!(now.momentum_closure.iter().all(|open| open.abs() < 1e-15), "{now:#?}");
        assert!(now.angular_momentum_closure.iter().all(|open| open.abs() < 1e-15), "{now:#?}");
        assert_eq!(now.walls, balance.walls, "nothing more happens");
        simulation.step();
    }
}
