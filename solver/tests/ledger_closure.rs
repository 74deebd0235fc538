//! Closure of the ledger with all effects: to a millionth of what was exchanged, and with each entry where it belongs.

use crate::common::{DENSITY, FLOOR, Setup, grain};
use makadam::scene::{Axis, Cohesion, GravityChange, Scene};
use makadam::{Balance, Simulation};
use std::f64::consts::PI;

const RADIUS: f64 = 0.005;
const MASS: f64 = DENSITY * 4.0 / 3.0 * PI * RADIUS * RADIUS * RADIUS;
const HERTZ: &str = "step = 2e-4\nnormal_law = { kind = 'hertz' }\nstop = { kind = 'sweeps', sweeps = 20 }";
const LINEAR: &str =
    "step = 2e-4\nnormal_law = { kind = 'linear', stiffness = 1e4 }\nstop = { kind = 'sweeps', sweeps = 20 }";

const RIGID: &str = "step = 1e-4\nnormal_law = { kind = 'rigid' }\nstop = { kind = 'sweeps', sweeps = 100 }";

/// A box of 0.06 m, open at the top, with grains that fall into it.
fn bed(count: usize) -> String {
    format!(
        "[[wall]]\nname = 'box'\nmaterial = 'wall'\nshape = {{ kind = 'box', min = [0, 0, 0], max = [0.06, 0.06, 0.2], \
         open = ['+z'] }}\n[[population]]\ncount = {count}\nmaterial = 'grain'\nradius = {{ kind = 'fixed', value = {RADIUS} }}\n\
         spacing = 1.05\nagitation = 0.5\nregion = {{ kind = 'box', min = [0, 0, 0], max = [0.06, 0.06, 0.2] }}\n"
    )
}

fn wall(name: &str, shape: &str, motion: &str) -> String {
    format!("[[wall]]\nname = '{name}'\nmaterial = 'wall'\nshape = {{ {shape} }}\nmotion = {{ {motion} }}\n")
}

/// Returns the ledger of a scene after so many steps, read at each.
fn balance(scene: &Scene, steps: usize) -> Balance {
    let mut simulation = Simulation::new(scene, 1).unwrap();
    simulation.open_ledger();
    let mut last = simulation.balance().unwrap();
    for step in 0..steps {
        simulation.step();
        last = simulation.balance().unwrap();
        let scale = last.exchanged() + last.start.kinetic + last.start.potential.abs();
        assert!(last.closure.abs() < 1e-6 * scale, "step {step}: {last:#?}");
    }
    println!(
        "closure {:e} of {:e} J: walls {:e}, first touch {:e}, turning {:e}, let go {:e}, wall paths {:e}, lost {:e}",
        last.closure,
        last.exchanged(),
        last.walls,
        last.first_touch,
        last.turning,
        last.let_go,
        last.wall_paths,
        last.lost()
    );
    assert!(last.momentum_closure.iter().all(|open| open.abs() < 1e-9 * MASS * steps as f64), "{last:#?}");
    // Levers are below a metre.
    assert!(last.angular_momentum_closure.iter().all(|open| open.abs() < 1e-9 * MASS * steps as f64), "{last:#?}");
    last
}

#[test]
fn overlaps_account_for_lost_angular_momentum() {
    // Two grains that spin the same way pass each other on a slanting course: friction turns them by their full radii.
    let spinning =
        |position: [f64; 3], velocity: [f64; 3]| grain(RADIUS, position, velocity) + "spin = [0.0, 0.0, 200.0]\n";
    let body = spinning([-0.0052, 0.001, 0.0], [1.0, 0.0, 0.0]) + &spinning([0.0052, -0.001, 0.0], [-1.0, 0.0, 0.0]);
    let of_step = |step: f64| {
        let solver = HERTZ.replace("2e-4", &format!("{step:e}"));
        let (gravity, body) = ([0.0; 3], body.clone());
        let balance = balance(&Setup { gravity, solver, body, ..Setup::default() }.scene(), (2e-3 / step) as usize);
        let [_, _, open] = balance.overlap_angular_impulse;
        let [start, end] = [balance.angular_momentum_start[2], balance.angular_momentum_end[2]];
        assert!((end - start - open).abs() < 1e-12 * start.abs(), "{balance:#?}");
        open.abs() / start.abs()
    };
    let lost = [2e-4, 2e-5].map(of_step);
    // They meet at 2 m/s and overlap by a tenth of a radius.
    assert!(lost.iter().all(|share| (0.01..0.1).contains(share)), "{lost:?}");
}

#[test]
fn the_ledger_closes_while_a_hertzian_packing_collapses() {
    for solver in [HERTZ, LINEAR] {
        let setup = Setup { solver: solver.into(), youngs_modulus: 1e6, body: bed(60), ..Setup::default() };
        let balance = balance(&setup.scene(), 800);
        assert!(balance.first_touch > 0.0 && balance.turning != 0.0 && balance.end.elastic > 0.0, "{balance:#?}");
        // Nothing but the grains moves, and no contact ends before it opens.
        assert_eq!((balance.wall_paths, balance.let_go, balance.walls), (0.0, 0.0, 0.0));
    }
}

#[test]
fn the_ledger_closes_in_a_cohesive_heap() {
    for cohesion in [
        Cohesion::Constant { force: 4.0 * MASS * 9.81, range: 2e-4 },
        Cohesion::SurfaceEnergy { work: 0.2, range: None },
    ] {
        for solver in [HERTZ, crate::common::CONVERGED_RIGID] {
            let setup = Setup { solver: solver.into(), body: bed(40), youngs_modulus: 1e6, ..Setup::default() };
            let mut scene = setup.scene();
            scene.material.values_mut().for_each(|material| material.cohesion = Some(cohesion));
            let balance = balance(&scene, 500);
            assert!(balance.end.cohesive < 0.0 && balance.first_touch != 0.0, "{balance:#?}");
        }
    }
}

#[test]
fn the_ledger_closes_under_fast_walls() {
    let plane = "kind = 'plane', point = [0.03, 0.03, 0.035], normal = [0, 0, -1]";
    let plate = "kind = 'disc', centre = [0.03, 0.03, 0.035], normal = [0, 0, -1], radius = 0.04";
    let side = "kind = 'plane', point = [0, 0, 0], normal = [1, 0, 0]";
    let ball = "kind = 'spheres', centres = [[0.03, 0.03, 0.035]], radius = 0.01";
    let presses = format!("kind = 'force-driven', axis = [0, 0, 1], force = {}, mass = {}", -800.0 * MASS, 10.0 * MASS);
    // Whether each goes on straight, or does otherwise within a step: it turns, or starts and stops between two steps.
    let walls = [
        (plane, "kind = 'translating', velocity = [0, 0, -20], start = 0.0101, stop = 0.0113", false),
        (plate, "kind = 'translating', velocity = [0, 0, -5], start = 0.01, stop = 0.015", true),
        (side, "kind = 'vibrating', amplitude = [0.012, 0, 0], frequency = 60", true),
        (plate, "kind = 'rotating', point = [0.03, 0.03, 0.035], axis = [0, 1, 0], rate = 10", false),
        (plane, &presses, true),
        (ball, "kind = 'translating', velocity = [0, 0.2, -0.5], start = 0.0, stop = 0.06", false),
    ];
    for (shape, motion, straight) in walls {
        for (solver, stores) in [(HERTZ, true), (LINEAR, true), (RIGID, false)] {
            let body = bed(40) + &wall("moving", shape, motion);
            let setup = Setup { solver: solver.into(), youngs_modulus: 1e6, body, ..Setup::default() };
            let balance = balance(&setup.scene(), 400);
            assert!(balance.walls.abs() > 0.01 * balance.exchanged(), "{motion} {balance:#?}");
            let share = balance.wall_paths.abs() / balance.exchanged();
            assert_eq!(share > 1e-12, stores && !straight, "{motion}: {share:e}");
        }
    }
}

#[test]
fn the_ledger_closes_with_torques_periods_and_a_field_that_changes() {
    let setup = Setup { solver: HERTZ.into(), youngs_modulus: 1e6, body: bed(50), ..Setup::default() };
    let mut scene = setup.scene();
    for material in scene.material.values_mut() {
        (material.rolling_friction, material.twisting_friction) = (0.2, 0.1);
    }
    let balance_of_torques = balance(&scene, 500);
    assert!(balance_of_torques.resistance > 0.0, "{balance_of_torques:#?}");

    let population = "[[population]]\ncount = 60\nmaterial = 'grain'\nradius = { kind = 'fixed', value = 0.005 }\n\
                      spacing = 1.05\nregion = { kind = 'box', min = [0, 0, 0], max = [0.06, 0.06, 0.2] }\n";
    let body = format!("{FLOOR}{population}");
    let setup = Setup { gravity: [4.0, 0.0, -9.0], body, ..Setup { solver: HERTZ.into(), ..Setup::default() } };
    let mut scene = setup.scene();
    (scene.domain.min, scene.domain.max) = ([0.0, 0.0, -0.1], [0.06, 0.06, 1.0]);
    scene.domain.periodic = vec![Axis::X, Axis::Y];
    balance(&scene, 800);

    let mut scene = Setup { solver: HERTZ.into(), youngs_modulus: 1e6, body: bed(50), ..Setup::default() }.scene();
    let change = |time: f64, gravity: [f64; 3]| GravityChange { time, gravity };
    scene.gravity_changes = vec![change(0.03, [12.0, 0.0, -5.0]), change(0.06, [-9.0, 3.0, -20.0])];
    let balance = balance(&scene, 500);
    assert!(balance.changing_gravity != 0.0, "{balance:#?}");
}

#[test]
fn a_ledger_that_opens_before_the_first_step_knows_of_overlaps_at_the_start() {
    // Two grains that overlap from the start: what they store is theirs, and no first touch.
    let body = grain(RADIUS, [0.0; 3], [0.0; 3]) + &grain(RADIUS, [1.995 * RADIUS, 0.0, 0.0], [0.0; 3]);
    let setup = Setup { gravity: [0.0; 3], solver: HERTZ.into(), body, ..Setup::default() };
    let balance = balance(&setup.scene(), 50);
    assert!(balance.start.elastic > 0.0 && balance.first_touch == 0.0, "{balance:#?}");
}

#[test]
fn a_wall_that_leaves_sideways_takes_what_its_contact_stores() {
    // The disc below a grain is gone within a step: its path, which is not that along the normal, has changed what is stored.
    let disc = wall(
        "disc",
        "kind = 'disc', centre = [0, 0, 0], normal = [0, 0, 1], radius = 0.02",
        "kind = 'translating', velocity = [1000.0, 0, 0]",
    );
    let body = disc + &grain(RADIUS, [0.0, 0.0, 0.998 * RADIUS], [0.0; 3]);
    let smooth = Setup { gravity: [0.0; 3], friction: 0.0, wall_friction: 0.0, ..Setup::default() };
    let setup = Setup { solver: HERTZ.into(), youngs_modulus: 1e6, body, ..smooth };
    let balance = balance(&setup.scene(), 3);
    assert!(balance.start.elastic > 0.0 && balance.end.elastic == 0.0, "{balance:#?}");
    // The grain moves by a hundredth of the overlap meanwhile.
    assert!((balance.wall_paths / balance.start.elastic + 1.0).abs() < 0.05, "{balance:#?}");
    assert!(balance.turning.abs() < 1e-9 * balance.start.elastic, "{balance:#?}");
    assert_eq!((balance.first_touch, balance.let_go), (0.0, 0.0));
}
