//! Same bits, checkpoints, ledger, driven and turning meshes, effects.

use super::{Corners, G, RADIUS, cylinder, mesh, moving, open_box, rectangle, scene, start};
use crate::common::bits::same_bits_everywhere;
use crate::common::{CONVERGED_HERTZ, FLOOR, Setup, grain, run_until};
use makadam::scene::{Motion, Scene, Shape, Wall};
use makadam::{Partner, Simulation};

const STEPS: &str = "step = 2e-4\nnormal_law = { kind = 'hertz' }\nstop = { kind = 'sweeps', sweeps = 12 }";

/// Rotation about the y axis.
fn turning(rate: f64) -> Motion {
    Motion::Rotating { point: [0.0; 3], axis: [0.0, 1.0, 0.0], rate, start: 0.0, stop: None, reverse: None }
}

fn population(count: usize, min: [f64; 3], max: [f64; 3]) -> String {
    format!(
        "[[population]]\ncount = {count}\nmaterial = 'grain'\nradius = {{ kind = 'uniform', mean = {RADIUS}, spread = 0.2 }}\n\
         agitation = 0.4\nregion = {{ kind = 'box', min = {min:?}, max = {max:?} }}\n"
    )
}

/// Caps of a drum about the y axis.
fn caps(radius: f64, length: f64, sides: usize) -> Vec<Corners> {
    let point = |y: f64, i: usize| {
        let angle = (i as f64 + 0.5) / sides as f64 * std::f64::consts::TAU;
        [radius * angle.sin(), y, -radius * angle.cos()]
    };
    [0.0, length]
        .into_iter()
        .flat_map(|y| (0..sides).map(move |i| [[0.0, y, 0.0], point(y, i), point(y, i + 1)]))
        .collect()
}

/// A turning drum of triangles with lifters, half full of grains.
fn drum(solver: &str, more: &str) -> Scene {
    let (radius, length, sides) = (0.06, 0.05, 24);
    let mut shell = cylinder(radius, length, sides, 4);
    shell.extend(caps(radius, length, sides));
    for k in 0..4 {
        let (sine, cosine) = (k as f64 * 1.57).sin_cos();
        let [inner, outer] = [0.8 * radius, radius].map(|r| [r * sine, 0.0, r * cosine]);
        let out = [0, 1, 2].map(|axis| outer[axis] - inner[axis]);
        shell.extend(rectangle(inner, out, [0.0, length, 0.0], [1, 2]));
    }
    let body = population(60, [-0.035, 0.0, -0.035], [0.035, length, 0.04]);
    let setup = Setup { youngs_modulus: 1e6, solver: solver.into(), body, ..Setup::default() };
    let mut scene = setup.scene_with(more);
    scene.wall.push(moving("drum", &shell, turning(6.0)));
    scene
}

#[test]
fn the_same_bits_on_threads_instruction_sets_and_after_stops() {
    same_bits_everywhere(&drum(STEPS, ""), 400);
    let spring = STEPS.to_string() + "\ntangential_law = { kind = 'spring' }";
    same_bits_everywhere(&drum(&spring, "rolling_friction = 0.1\ntwisting_friction = 0.05\n"), 300);
    same_bits_everywhere(&drum(STEPS, "cohesion = { kind = 'constant', force = 0.01 }\n"), 300);
}

#[test]
fn no_grain_leaves_a_turning_drum_of_triangles() {
    for rate in [1.0, 30.0] {
        let mut scene = drum(STEPS, "");
        scene.wall[0].motion = turning(rate);
        let mut simulation = Simulation::new(&scene, 1).unwrap();
        for _ in 0..3000 {
            simulation.step();
        }
        assert_eq!(simulation.crossing(), None);
        for grain in simulation.snapshot().particles {
            let [x, y, z] = grain.position;
            assert!(x.hypot(z) < 0.06 && (0.0..0.05).contains(&y), "{rate} rad/s: {grain:?}");
        }
    }
}

#[test]
fn the_ledger_closes() {
    for more in ["", "rolling_friction = 0.1\n", "cohesion = { kind = 'constant', force = 0.01 }\n"] {
        let mut simulation = Simulation::new(&drum(STEPS, more), 1).unwrap();
        simulation.open_ledger();
        for step in 0..800 {
            simulation.step();
            let balance = simulation.balance().unwrap();
            let scale = balance.exchanged() + balance.start.kinetic + balance.start.potential.abs();
            assert!(balance.closure.abs() < 1e-9 * scale, "step {step}: {balance:#?}");
        }
    }
}

#[test]
fn a_bed_in_a_box_of_triangles_settles_as_in_a_box() {
    let side = 0.06;
    let grains = population(80, [0.0; 3], [side, side, 0.16]);
    let shape = Shape::Box { min: [0.0; 3], max: [side, side, 0.2], open: vec!["+z".into()] };
    let solver = CONVERGED_HERTZ.replace("1e-4", "2e-4");
    let settled = |wall: Wall| {
        let setup = Setup {
            restitution: 0.2,
            youngs_modulus: 1e6,
            solver: solver.clone(),
            body: grains.clone(),
            ..Setup::default()
        };
        let mut simulation = start(&setup, &[wall]);
        run_until(&mut simulation, 0.05);
        let early = simulation.snapshot();
        run_until(&mut simulation, 0.4);
        let frame = simulation.snapshot();
        let force: f64 =
            frame.contacts.iter().filter(|one| !one.second.is_grain()).map(|one| one.force_on_partner().z).sum();
        let weight: f64 =
            frame.particles.iter().map(|one| 2500.0 * 4.0 / 3.0 * std::f64::consts::PI * one.radius.powi(3) * G).sum();
        assert!((force / weight + 1.0).abs() < 2e-2, "{force} of {weight}");
        early
    };
    let expected = settled(Wall::new("box", "wall", shape));
    for n in [1, 6, 30] {
        let found = settled(mesh("box", &open_box([0.0; 3], [side, side, 0.2], n)));
        for (one, other) in expected.particles.iter().zip(&found.particles) {
            for axis in 0..3 {
                assert!((one.position[axis] - other.position[axis]).abs() < 1e-8, "{n} cells: {one:?}\n{other:?}");
            }
        }
    }
}

#[test]
fn a_driven_lid_presses_and_a_turntable_carries_as_planes_do() {
    let lid = rectangle([-0.03, -0.03, 0.012], [0.06, 0.0, 0.0], [0.0, 0.06, 0.0], [5, 5]);
    let motion =
        Motion::ForceDriven { axis: [0.0, 0.0, 1.0], force: -2.0, mass: 0.05, largest_speed: None, start: 0.0 };
    let body = FLOOR.to_string() + &grain(RADIUS, [0.001, 0.0021, RADIUS], [0.0; 3]);
    let plane = Wall::new("lid", "wall", Shape::plane([0.0, 0.0, 0.012], [0.0, 0.0, -1.0])).moving(motion.clone());
    let pressed = |wall: Wall| {
        let setup = Setup { restitution: 0.0, solver: CONVERGED_HERTZ.into(), body: body.clone(), ..Setup::default() };
        let mut simulation = start(&setup, &[wall]);
        run_until(&mut simulation, 0.1);
        let contacts = simulation.snapshot().contacts;
        contacts.iter().find(|contact| contact.second == Partner::Wall(1)).unwrap().normal_force
    };
    let (expected, found) = (pressed(plane), pressed(moving("lid", &lid, motion)));
    assert!((expected - found).abs() < 1e-9 * expected, "{expected} and {found}");

    let rotation = Motion::Rotating {
        point: [0.01, 0.0, 0.0],
        axis: [0.0, 0.0, 1.0],
        rate: 3.0,
        start: 0.0,
        stop: None,
        reverse: None,
    };
    let table = rectangle([-0.3, -0.3, 0.0], [0.6, 0.0, 0.0], [0.0, 0.6, 0.0], [50, 50]);
    let carried = |wall: Wall| {
        let body = grain(RADIUS, [0.1, 0.0, RADIUS], [0.0; 3]);
        let mut simulation = start(&Setup { restitution: 0.0, body, ..Setup::default() }, &[wall]);
        run_until(&mut simulation, 0.3);
        simulation.snapshot().particles[0]
    };
    let plane = Wall::new("table", "wall", Shape::plane([0.0; 3], [0.0, 0.0, 1.0])).moving(rotation.clone());
    let (one, other) = (carried(plane), carried(moving("table", &table, rotation)));
    for axis in 0..3 {
        assert!((one.position[axis] - other.position[axis]).abs() < 1e-9, "{one:?}\n{other:?}");
        assert!((one.velocity[axis] - other.velocity[axis]).abs() < 1e-8, "{one:?}\n{other:?}");
    }
}

#[test]
fn grains_come_and_go_beside_a_mesh() {
    let setup = Setup { solver: STEPS.into(), body: population(30, [0.0; 3], [0.06, 0.06, 0.1]), ..Setup::default() };
    let scene = scene(&setup, &[mesh("box", &open_box([0.0; 3], [0.06, 0.06, 0.2], 4))]);
    let mut simulation = Simulation::new(&scene, 1).unwrap();
    simulation.open_ledger();
    run_until(&mut simulation, 0.2);
    simulation.remove(&[3, 17]).unwrap();
    let entry = makadam::GrainEntry {
        material: "grain".into(),
        radius: RADIUS,
        position: [0.03, 0.03, 0.15],
        velocity: [0.0; 3],
        spin: [0.0; 3],
    };
    simulation.insert(&scene, &[entry]).unwrap();
    run_until(&mut simulation, 0.5);
    let balance = simulation.balance().unwrap();
    assert!(balance.closure.abs() < 1e-9 * balance.exchanged(), "{balance:#?}");
    for grain in simulation.snapshot().particles {
        assert!(grain.position[2] > 0.0, "{grain:?}");
    }
}
