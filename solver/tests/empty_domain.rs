//! A domain that is mostly empty changes neither what touches nor what it costs to find it.

use crate::common::bits::{same_bits_everywhere, start, steps};
use crate::common::lattice::{CLOSED, CONTACTS, lattice};
use makadam::scene::Scene;

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
