//! Loads and wear of walls: sums over the steps, against the ledger and closed forms.

use crate::common::{DENSITY, FLOOR, Setup, grain};
use approx::assert_relative_eq;
use makadam::scene::{Scene, Shape, TriangleMesh};
use makadam::{FaceWear, Simulation};
use std::f64::consts::PI;

const RADIUS: f64 = 0.005;
const G: f64 = 9.81;
const STEP: f64 = 1e-4;

fn mass() -> f64 {
    DENSITY * 4.0 / 3.0 * PI * RADIUS.powi(3)
}

/// A drum half full of grains, which turns.
fn drum() -> Scene {
    let body = "[[wall]]\nname = 'shell'\nmaterial = 'wall'\n\
                shape = { kind = 'cylinder', base = [0, -0.02, 0], axis = [0, 1, 0], radius = 0.04, length = 0.04 }\n\
                motion = { kind = 'rotating', point = [0, 0, 0], axis = [0, 1, 0], rate = 6.0 }\n\
                [[wall]]\nname = 'ends'\nmaterial = 'wall'\n\
                shape = { kind = 'box', min = [-0.05, -0.02, -0.05], max = [0.05, 0.02, 0.05], open = ['-x', '+x', '-z', '+z'] }\n\
                [[population]]\ncount = 150\nmaterial = 'grain'\nradius = { kind = 'uniform', mean = 0.003, spread = 0.2 }\n\
                region = { kind = 'cylinder', base = [0, -0.02, 0], axis = [0, 1, 0], radius = 0.039, length = 0.04 }\n\
                agitation = 0.5\n"
        .to_string();
    let solver = "step = 5e-4\nnormal_law = { kind = 'hertz' }\nstop = { kind = 'sweeps', sweeps = 20 }".into();
    Setup { restitution: 0.3, solver, body, ..Setup::default() }.scene()
}

/// A frictionless floor of triangles, wider than its grain's path.
fn floor_of(triangles: &[[[f64; 3]; 3]], velocity: [f64; 3]) -> Scene {
    let body = format!("{FLOOR}{}", grain(RADIUS, [-0.013, 0.004, RADIUS], velocity));
    let mut scene = Setup { wall_friction: 0.0, restitution: 0.0, body, ..Setup::default() }.scene();
    if !triangles.is_empty() {
        scene.wall[0].shape = Shape::mesh("floor", TriangleMesh::new(triangles).unwrap());
    }
    scene
}

/// Triangles of a square of side 0.1 m in `n` by `n` cells, cut along one diagonal.
fn square(n: usize) -> Vec<[[f64; 3]; 3]> {
    let at = |i: usize, j: usize| [0.1 * i as f64 / n as f64 - 0.05, 0.1 * j as f64 / n as f64 - 0.05, 0.0];
    let cells = (0..n).flat_map(|i| (0..n).map(move |j| (i, j)));
    let halves = cells.flat_map(|(i, j)| {
        let [a, b, c, d] = [at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)];
        [[a, b, c], [a, c, d]]
    });
    halves.collect()
}

fn recorded(scene: &Scene, steps: usize) -> Simulation {
    let mut simulation = Simulation::new(scene, 1).unwrap();
    simulation.record_walls(true);
    (0..steps).for_each(|_| _ = simulation.step());
    simulation
}

fn sums(wear: &[FaceWear]) -> [f64; 2] {
    [wear.iter().map(|face| face.archard).sum(), wear.iter().map(|face| face.finnie).sum()]
}

#[test]
fn loads_are_the_walls_of_the_ledger() {
    let mut simulation = Simulation::new(&drum(), 1).unwrap();
    simulation.record_walls(false);
    simulation.open_ledger();
    (0..800).for_each(|_| _ = simulation.step());
    let (loads, balance, time) = (simulation.wall_loads(), simulation.balance().unwrap(), simulation.time());
    assert_eq!(loads.len(), 2);
    let sum =
        |of: fn(&makadam::WallLoad) -> [f64; 3], axis: usize| loads.iter().map(|load| of(load)[axis]).sum::<f64>();
    for axis in 0..3 {
        let scale = 1e-12 * balance.gravity_impulse[2].abs();
        assert_relative_eq!(-time * sum(|load| load.force, axis), balance.wall_impulse[axis], epsilon = scale);
        let turned = -time * sum(|load| load.torque, axis);
        assert_relative_eq!(turned, balance.wall_angular_impulse[axis], epsilon = scale);
    }
    assert_relative_eq!(time * (loads[0].power + loads[1].power), balance.walls, max_relative = 1e-12);
    // The shell lifts the grains: torque on it against its rotation.
    assert!(loads[0].power > 0.0 && loads[0].torque[1] < 0.0 && loads[1].power == 0.0, "{loads:?}");
    assert_relative_eq!(loads[0].power, -6.0 * loads[0].torque[1], max_relative = 1e-3);
    assert!(simulation.wear().is_empty());
}

#[test]
fn means_restart_and_wear_goes_on() {
    let mut simulation = recorded(&drum(), 100);
    let before = sums(&simulation.wear());
    simulation.restart_wall_means();
    assert!(simulation.wall_loads().is_empty() && sums(&simulation.wear()) == before);
    simulation.step();
    // The mean over one step is the load of the frame's contacts.
    let (frame, load) = (simulation.snapshot(), simulation.wall_loads()[0]);
    let forces = frame.contacts.iter().filter(|contact| contact.second == makadam::Partner::Wall(0));
    let force = forces.fold([0.0; 3], |sum, contact| {
        let force = contact.force_on_partner();
        [0, 1, 2].map(|axis| sum[axis] + force[axis])
    });
    for (recorded, expected) in load.force.iter().zip(force) {
        assert_relative_eq!(*recorded, expected, epsilon = 1e-9);
    }
    assert!(sums(&simulation.wear())[0] > before[0] && frame.wall_loads[0] == load);
}

#[test]
fn a_record_changes_no_bits_and_has_the_same_on_any_threads_and_after_a_checkpoint() {
    let scene = drum();
    let mut plain = Simulation::new(&scene, 1).unwrap();
    (0..200).for_each(|_| _ = plain.step());
    let simulation = recorded(&scene, 200);
    assert_eq!(plain.state_hash(), simulation.state_hash());
    let mut halves = recorded(&scene, 90);
    halves = Simulation::resume(&scene, &halves.checkpoint()).unwrap();
    (0..110).for_each(|_| _ = halves.step());
    for threads in [2, 3] {
        let mut other = Simulation::builder(&scene).threads(threads).build().unwrap();
        other.record_walls(true);
        (0..200).for_each(|_| _ = other.step());
        assert_eq!((other.wall_loads(), other.wear()), (simulation.wall_loads(), simulation.wear()));
    }
    assert_eq!((halves.wall_loads(), halves.wear()), (simulation.wall_loads(), simulation.wear()));
}

#[test]
fn sliding_wears_by_force_times_path_on_any_triangles() {
    let (speed, steps) = (0.3, 900);
    let path = speed * STEP * steps as f64;
    for triangles in [Vec::new(), square(1), square(7), square(40)] {
        let simulation = recorded(&floor_of(&triangles, [speed, 0.0, 0.0]), steps);
        let wear = simulation.wear();
        assert_relative_eq!(sums(&wear)[0], mass() * G * path, max_relative = 1e-9);
        // Each worn triangle lies on the path, and those of one row share it.
        for face in wear.iter().filter(|face| face.archard > 0.0 && !triangles.is_empty()) {
            let corners = triangles[face.face as usize];
            let [low, high] =
                [f64::min, f64::max].map(|pick| corners.map(|corner| corner[1]).into_iter().reduce(pick).unwrap());
            assert!((low..=high).contains(&0.004), "{face:?} of {corners:?}");
        }
        let load = simulation.wall_loads()[0];
        assert_relative_eq!(load.force[2], -mass() * G, max_relative = 1e-9);
    }
}

#[test]
fn impacts_wear_by_finnie_once_each() {
    for (velocity, factor) in [
        ([0.0, 0.0, -1.0], 0.0),
        ([1.0, 0.0, -1.0], 1.0 / 6.0),
        // tan a = 1/3, at which both branches are 0.3.
        ([3.0, 0.0, -1.0], 0.3),
        ([10.0, 0.0, -1.0], (20.0 - 3.0) / 101.0),
    ] {
        let mut scene = floor_of(&[], velocity);
        scene.gravity = [0.0; 3];
        scene.grain[0].position[2] += 3.3e-4;
        let simulation = recorded(&scene, 30);
        let square: f64 = velocity.iter().map(|component| component * component).sum();
        let finnie = sums(&simulation.wear())[1];
        assert_relative_eq!(finnie, mass() * square * factor, max_relative = 1e-9, epsilon = 1e-18);
    }
}
