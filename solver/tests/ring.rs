//! A disc with a hole: its geometry, and grains that fall through it and slide over its rim, against closed forms.

use approx::assert_relative_eq;
use makadam::Simulation;
use makadam::scene::{Domain, Scene, Shape, Wall};
use makadam::wall::PlacedWalls;
use nalgebra::Vector3;

const HOLE: f64 = 0.05;
const RADIUS: f64 = 0.01;
const GRAVITY: f64 = 9.81;

/// A domain that does not repeat itself.
fn everywhere() -> Domain {
    Domain { min: [-10.0; 3], max: [10.0; 3], periodic: Vec::new() }
}

/// A ring in the plane z = 0, its hole of radius 0.05 m and its outline of 0.2 m.
fn ring() -> PlacedWalls {
    let shape = Shape::Disc { centre: [0.0; 3], normal: [0.0, 0.0, 2.0], radius: 0.2, hole: HOLE };
    let wall = Wall::new("ring", "wall", shape);
    PlacedWalls::at(&[wall], &everywhere(), 0.0, &[], &[])
}

fn nearest(at: [f64; 3]) -> (f64, Vector3<f64>) {
    let ring = ring();
    let (_, face) = ring.faces().next().unwrap();
    face.nearest(&Vector3::from(at), Vector3::zeros)
}

#[test]
fn the_nearest_point_lies_on_the_face_or_on_a_rim() {
    // Above and below the face: both sides are sides.
    for side in [1.0, -1.0] {
        let (gap, normal) = nearest([0.0, 0.1, side * 0.008]);
        assert_relative_eq!(gap, 0.008, max_relative = 1e-12);
        assert_relative_eq!(normal, Vector3::new(0.0, 0.0, -side), epsilon = 1e-12);
    }
    // Over the hole and beyond the outline: 3, 4, 5 from the rim.
    let (gap, normal) = nearest([HOLE - 0.003, 0.0, 0.004]);
    assert_relative_eq!(gap, 0.005, max_relative = 1e-12);
    assert_relative_eq!(normal, Vector3::new(0.6, 0.0, -0.8), epsilon = 1e-12);
    let (gap, normal) = nearest([0.0, -0.203, -0.004]);
    assert_relative_eq!(gap, 0.005, max_relative = 1e-12);
    assert_relative_eq!(normal, Vector3::new(0.0, 0.6, 0.8), epsilon = 1e-12);
    // On the axis every point of the rim is as near.
    let (gap, normal) = nearest([0.0, 0.0, 0.12]);
    assert_relative_eq!(gap, 0.13, max_relative = 1e-12);
    assert_relative_eq!(normal.norm(), 1.0, max_relative = 1e-12);
}

#[test]
fn nothing_jumps_where_face_and_rim_meet() {
    let along = |across: f64| nearest([across, 0.0, RADIUS]);
    for edge in [HOLE, 0.2] {
        let ((a, one), (b, other)) = (along(edge - 1e-9), along(edge + 1e-9));
        assert!((a - b).abs() < 1e-9 && (one - other).norm() < 1e-6, "{a} {b} {one} {other}");
    }
}

/// A frictionless, rigid grain at a distance from the axis and a height over the ring, with a velocity along x.
fn simulation(across: f64, height: f64, velocity: f64) -> Simulation {
    let text = format!(
        r#"
        name = "ring"
        description = "one grain and a ring"
        duration = 1.0
        domain = {{ min = [-0.3, -0.3, -1.0], max = [0.3, 0.3, 0.5] }}
        [solver]
        step = 1e-4
        normal_law = {{ kind = "rigid" }}
        [material.glass]
        density = 2500.0
        youngs_modulus = 1e7
        poisson_ratio = 0.3
        friction = 0.0
        restitution = 0.0
        [[wall]]
        name = "ring"
        material = "glass"
        shape = {{ kind = "disc", centre = [0.0, 0.0, 0.0], normal = [0.0, 0.0, 1.0], radius = 0.2, hole = {HOLE} }}
        [[grain]]
        material = "glass"
        radius = {RADIUS}
        position = [{across}, 0.0, {height}]
        velocity = [{velocity}, 0.0, 0.0]
        "#
    );
    Simulation::new(&Scene::parse(&text).unwrap(), 1).unwrap()
}

#[test]
fn a_grain_falls_through_the_hole() {
    let mut simulation = simulation(0.02, 0.1, 0.0);
    while simulation.time() < 0.3 - 1e-9 {
        simulation.step();
    }
    let grain = simulation.snapshot().particles[0];
    // The first-order step falls by g h t / 2 more than the parabola.
    assert_relative_eq!(grain.position[2], 0.1 - 0.5 * GRAVITY * 0.3 * (0.3 + 1e-4), max_relative = 1e-9);
    assert_eq!(grain.position[0], 0.02);
}

#[test]
fn a_grain_slides_over_the_rim_and_leaves_it_where_it_must() {
    // Pushed inwards at 1% of sqrt(g r); it slides over the rim as a point slides off a fixed sphere of its own radius, and
    // leaves where its centre is two thirds of the radius high (energy, and weight against the centripetal force).
    let start = 0.01 * (GRAVITY * RADIUS).sqrt();
    let mut simulation = simulation(HOLE + 1e-4, RADIUS, -start);
    let (mut left, mut steps) = (None, 0);
    while simulation.snapshot().particles[0].position[2] > -0.05 {
        simulation.step();
        steps += 1;
        assert!(steps < 20_000, "the grain hangs on the rim");
        let frame = simulation.snapshot();
        if left.is_none() && frame.contacts.is_empty() && frame.particles[0].position[2] < 0.99 * RADIUS {
            left = Some(frame.particles[0]);
        }
    }
    let left = left.expect("it leaves the rim");
    assert_relative_eq!(left.position[2], 2.0 / 3.0 * RADIUS, max_relative = 0.02);
    let speed = (2.0 * GRAVITY * RADIUS / 3.0).sqrt();
    assert_relative_eq!(-left.velocity[0], speed * 2.0 / 3.0, max_relative = 0.02);
    // No energy comes from the way over the rim.
    let grain = simulation.snapshot().particles[0];
    let square: f64 = grain.velocity.iter().map(|v| v * v).sum();
    assert_relative_eq!(square, 2.0 * GRAVITY * (RADIUS - grain.position[2]), max_relative = 0.01);
}

#[test]
fn a_hole_wider_than_its_disc_is_refused() {
    let text = r#"
        name = "ring"
        description = "a hole that is too wide"
        duration = 1.0
        domain = { min = [-1.0, -1.0, -1.0], max = [1.0, 1.0, 1.0] }
        [material.glass]
        density = 2500.0
        youngs_modulus = 1e7
        poisson_ratio = 0.3
        friction = 0.5
        restitution = 0.5
        [[wall]]
        name = "floor"
        material = "glass"
        shape = { kind = "disc", centre = [0.0, 0.0, 0.0], normal = [0.0, 0.0, 1.0], radius = 0.2, hole = 0.3 }
    "#;
    let error = Scene::parse(text).unwrap_err().to_string();
    assert!(error.contains("hole") && error.contains("0.3"), "{error}");
}
