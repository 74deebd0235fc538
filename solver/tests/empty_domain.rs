//! A domain that is mostly empty changes neither what touches nor what it costs to find it; nor do grains that leave their domain.

use crate::common::bits::{same_bits_everywhere, start, steps};
use crate::common::lattice::{CLOSED, CONTACTS, lattice};
use makadam::Simulation;
use makadam::scene::{Precision, Scene};

/// A cube around the origin, m.
fn cube(half: f64) -> [[f64; 3]; 2] {
    [[-half; 3], [half; 3]]
}

fn contacts(scene: &Scene) -> usize {
    let mut simulation = start(scene);
    steps(&mut simulation, CLOSED);
    simulation.layout().contacts
}

/// Grains far from the rest, in all directions and at all distances.
fn lone(count: usize) -> Vec<[f64; 3]> {
    (0..count)
        .map(|number| {
            let (angle, far) = (number as f64, 10.0 * 1.3_f64.powi(number as i32 % 40));
            [far * angle.cos(), far * angle.sin(), far * (2.3 * angle).sin()]
        })
        .collect()
}

#[test]
fn the_same_grains_touch_however_large_the_domain_is() {
    let middle = [[0.0; 3]];
    assert_eq!(contacts(&lattice(cube(0.1), "", &middle, &[])), CONTACTS, "as tight as can be");
    assert_eq!(contacts(&lattice(cube(3.0), "", &middle, &[])), CONTACTS);
    assert_eq!(contacts(&lattice(cube(900_000.0), "", &middle, &[])), CONTACTS);
    assert_eq!(contacts(&lattice(cube(900_000.0), "", &middle, &lone(40))), CONTACTS);
    assert_eq!(contacts(&lattice(cube(3.0), "periodic = ['x', 'y']", &middle, &[])), CONTACTS);
    let edge = [[3.0, -3.0, 0.0]];
    assert_eq!(contacts(&lattice(cube(3.0), "periodic = ['x', 'y']", &edge, &[])), CONTACTS, "across two ends");
    let edge = [[1000.0, -1000.0, 1000.0]];
    let all = "periodic = ['x', 'y', 'z']";
    assert_eq!(contacts(&lattice(cube(1000.0), all, &edge, &lone(25)[..16])), CONTACTS, "across a corner");
    let apart = [[0.0; 3], [700.0, -300.0, 20.0]];
    assert_eq!(contacts(&lattice(cube(1000.0), "", &apart, &[])), 2 * CONTACTS, "two blocks");
}

#[test]
fn bits_are_the_same_everywhere_and_after_stops() {
    same_bits_everywhere(&lattice(cube(900_000.0), "", &[[0.0; 3]], &lone(40)), 45);
    let edge = [[1000.0, -1000.0, 1000.0]];
    same_bits_everywhere(&lattice(cube(1000.0), "periodic = ['x', 'y', 'z']", &edge, &lone(16)), 45);
}

#[test]
fn an_empty_domain_takes_no_memory() {
    let bytes = |scene: &Scene| {
        let mut simulation = start(scene);
        steps(&mut simulation, CLOSED);
        simulation.memory_bytes() as f64
    };
    let small = bytes(&lattice(cube(0.1), "", &[[0.0; 3]], &[]));
    let large = bytes(&lattice(cube(900_000.0), "", &[[0.0; 3]], &[]));
    assert!(large < 1.3 * small, "{large} bytes, {small} in a tight domain");
    // A lone grain costs its own box.
    let scattered = bytes(&lattice(cube(900_000.0), "", &[[0.0; 3]], &lone(100)));
    assert!(scattered < 2.0 * small, "{scattered} bytes, {small} in a tight domain");
}

/// Grains of a stream.
const STREAM: usize = 400;

/// A block at rest, and a stream below it that gathers in a plane after so many seconds and flies apart from there: each grain is faster
/// than the one before, down where `sign` is -1.
fn stream(half: f64, sign: f64, after: f64) -> Scene {
    let at = |number: usize| [number % 20, number / 20].map(|place| 0.012 * (place as f64 - 9.5));
    let speed = |number: usize| sign * (5.0 + 0.1 * number as f64);
    let places = (0..STREAM).map(|number| (at(number), speed(number)));
    let places: Vec<[f64; 3]> = places.map(|([x, y], speed)| [x, y, -0.1 - after * speed]).collect();
    let mut scene = lattice(cube(half), "", &[[0.0; 3]], &places);
    let block = scene.grain.len() - STREAM;
    scene.grain[..block].iter_mut().for_each(|grain| grain.velocity = [0.0; 3]);
    for (number, grain) in scene.grain[block..].iter_mut().enumerate() {
        grain.velocity = [0.0, 0.0, speed(number)];
    }
    scene
}

#[test]
fn escaping_grains_cost_their_own_boxes() {
    for half in [0.13, 30.0] {
        let mut simulation = start(&stream(half, -1.0, 0.0));
        simulation.step();
        let before = simulation.memory_bytes();
        steps(&mut simulation, 200);
        let each = simulation.memory_bytes().saturating_sub(before) / STREAM;
        assert!(each < 6_000, "{each} bytes per grain that left the block, domain of {half} m");
        let tasks = simulation.layout().plan.tasks().len();
        assert!(tasks < 200, "{tasks} tasks: lone grains have none");
    }
}

#[test]
fn escaped_grains_resume_to_the_same_bits() {
    same_bits_everywhere(&stream(0.13, -1.0, 0.0), 45);
}

#[test]
fn single_precision_follows_fewer_boxes() {
    // The stream comes from afar, so that there are ever fewer boxes, and strikes the block.
    let mut scene = stream(30.0, 1.0, 0.05);
    scene.solver.precision = Precision::Single;
    let mut simulation = start(&scene);
    steps(&mut simulation, 100);
    let mut resumed = Simulation::resume(&scene, &simulation.checkpoint()).unwrap();
    steps(&mut simulation, 20);
    steps(&mut resumed, 20);
    assert!(simulation.layout().contacts > 100, "the stream strikes the block");
    assert_eq!(resumed.state_hash(), simulation.state_hash());
}

#[test]
fn empty_space_and_lone_grains_make_no_tasks() {
    let tasks = |scene: &Scene| {
        let mut simulation = start(scene);
        steps(&mut simulation, CLOSED);
        simulation.layout().plan.tasks().len()
    };
    let middle = [[0.0; 3]];
    let tight = tasks(&lattice(cube(0.1), "", &middle, &[]));
    // As finely divided as in a tight domain, and no more tasks where there is nothing.
    for half in [0.5, 3.0, 1e3, 9e5] {
        let found = tasks(&lattice(cube(half), "", &middle, &[]));
        assert!((tight / 8..=8 * tight).contains(&found), "{half} m: {found} tasks for {tight}");
    }
    for count in [1, 100] {
        let found = tasks(&lattice(cube(9e5), "", &middle, &lone(count)));
        assert!((tight / 8..=8 * tight).contains(&found), "{count} escaped: {found} tasks for {tight}");
    }
    let two = tasks(&lattice(cube(9e5), "", &[[0.0; 3], [7e5, -3e5, 20.0]], &[]));
    assert!((tight / 8..=16 * tight).contains(&two), "two blocks: {two} tasks for {tight}");
}
