//! Finite shapes with two sides: frusta and rectangles.

use crate::common::{CONVERGED_RIGID, DENSITY, Setup, grain, run_until};
use crate::mesh::{Corners, G, RADIUS, mesh, start, wall_contacts};
use makadam::Simulation;
use makadam::scene::{Domain, Motion, Shape, Wall};
use makadam::wall::PlacedWalls;
use nalgebra::Vector3;
use proptest::prelude::*;
use std::f64::consts::PI;

type Vector = Vector3<f64>;

const MASS: f64 = DENSITY * 4.0 / 3.0 * PI * RADIUS * RADIUS * RADIUS;
const UP: [f64; 3] = [0.0, 0.0, 1.0];

fn wall(shape: Shape) -> Wall {
    Wall::new("shape", "wall", shape)
}

fn frustum(radii: [f64; 2], length: f64) -> Shape {
    Shape::Frustum { base: [0.0; 3], axis: UP, radii, length }
}

/// Square of 40 mm about the origin.
fn sheet() -> Shape {
    Shape::Rectangle { corner: [-0.02, -0.02, 0.0], edges: [[0.04, 0.0, 0.0], [0.0, 0.04, 0.0]] }
}

/// Contacts of a grain after 20 ms from rest at a place under gravity in a direction.
fn rests(shape: Shape, down: [f64; 3], place: [f64; 3]) -> usize {
    let gravity = down.map(|x| x * G / down.iter().map(|x| x * x).sum::<f64>().sqrt());
    let body = grain(RADIUS, place, [0.0; 3]);
    let setup = Setup { gravity, restitution: 0.0, body, solver: CONVERGED_RIGID.into(), ..Setup::default() };
    let mut simulation = start(&setup, &[wall(shape.clone())]);
    run_until(&mut simulation, 0.02);
    let frame = simulation.snapshot();
    let moved: f64 = (0..3).map(|axis| (frame.particles[0].position[axis] - place[axis]).powi(2)).sum();
    assert!(moved.sqrt() < 1e-6, "{:?} from {place:?} on {shape:?}", frame.particles[0]);
    for (axis, pull) in gravity.iter().enumerate() {
        let of_walls: f64 = frame.contacts.iter().map(|contact| contact.force_on_partner()[axis]).sum();
        assert!((of_walls - MASS * pull).abs() < 1e-9 * MASS * G, "{shape:?}: {:?}", frame.contacts);
    }
    wall_contacts(&simulation).len()
}

#[test]
fn one_contact_on_both_sides_edges_and_corners_of_a_rectangle() {
    let half = RADIUS / 2.0_f64.sqrt();
    for (down, place) in [
        ([0.0, 0.0, -1.0], [0.0, 0.0, RADIUS]),
        ([0.0, 0.0, -1.0], [0.013, 0.002, RADIUS]),
        ([0.0, 0.0, 1.0], [0.013, 0.002, -RADIUS]),
        ([-1.0, 0.0, 0.0], [0.02 + RADIUS, 0.004, 0.0]),
        ([-1.0, -1.0, 0.0], [0.02 + half, 0.02 + half, 0.0]),
    ] {
        assert_eq!(rests(sheet(), down, place), 1, "{place:?}");
    }
}

#[test]
fn one_contact_on_both_sides_and_rims_of_a_cone() {
    // Flank of 45 degrees.
    let half = RADIUS / 2.0_f64.sqrt();
    for (down, place) in [
        ([-1.0, 0.0, -1.0], [0.03 + half, 0.0, 0.02 + half]),
        ([0.0, -1.0, -1.0], [0.0, 0.03 + half, 0.02 + half]),
        ([1.0, 0.0, 1.0], [0.03 - half, 0.0, 0.02 - half]),
        ([-1.0, 0.0, 0.0], [0.05 + RADIUS, 0.0, 0.0]),
        ([0.0, 0.0, -1.0], [0.01, 0.0, 0.04 + RADIUS]),
    ] {
        assert_eq!(rests(frustum([0.05, 0.01], 0.04), down, place), 1, "{place:?}");
    }
}

#[test]
fn a_grain_rests_in_a_funnel_narrower_than_itself() {
    // In the flank, on the rim of the mouth, and in the tip.
    let lean = 0.02 / 0.04_f64.hypot(0.02);
    for radii in [[0.001, 0.021], [0.0, 0.02]] {
        let height = (RADIUS / (1.0_f64 - lean * lean).sqrt() - radii[0]) * 2.0;
        assert_eq!(rests(frustum(radii, 0.04), [0.0, 0.0, -1.0], [0.0, 0.0, height]), 3, "{radii:?}");
    }
    let mouth = (RADIUS * RADIUS - 0.0048_f64.powi(2)).sqrt();
    assert_eq!(rests(frustum([0.0048, 0.03], 0.005), [0.0, 0.0, -1.0], [0.0, 0.0, mouth]), 3);
}

/// Lateral surface of a frustum about z, with `sides` corners on the circles.
fn facets(radii: [f64; 2], length: f64, sides: usize) -> Vec<Corners> {
    let point = |i: usize, end: usize| {
        let angle = (i as f64 + 0.5) / sides as f64 * std::f64::consts::TAU;
        [radii[end] * angle.cos(), radii[end] * angle.sin(), length * end as f64]
    };
    let quad = |i: usize| {
        let [a, b, c, d] = [point(i, 0), point(i + 1, 0), point(i + 1, 1), point(i, 1)];
        [[a, b, c], [a, c, d]]
    };
    (0..sides).flat_map(quad).collect()
}

/// Distance of a point from the nearest of some walls, m.
fn distance(walls: &[Wall], point: &Vector) -> f64 {
    let domain = Domain { min: [-1.0; 3], max: [1.0; 3], periodic: Vec::new() };
    PlacedWalls::at(walls, &domain, 0.0, &[], &[]).distance(point)
}

#[test]
fn the_error_of_a_meshed_frustum_falls_as_one_minus_a_cosine() {
    let (radii, length) = ([0.06, 0.03], 0.05);
    let shell = [wall(frustum(radii, length))];
    for sides in [12, 48, 192] {
        let facets = [mesh("facets", &facets(radii, length, sides))];
        // Over the middle of a facet, half way up, outside.
        let point = Vector::new(0.08, 0.0, 0.025);
        let lean = length / length.hypot(radii[0] - radii[1]);
        let (exact, meshed) = (distance(&shell, &point), distance(&facets, &point));
        assert!((exact - (0.08 - 0.045) * lean).abs() < 1e-15, "{exact}");
        let foot = 0.08 - exact * lean;
        let expected = foot * (1.0 - (PI / sides as f64).cos()) * lean;
        // The facet leans less than the cone: a correction of the second order.
        assert!(((meshed - exact) / expected - 1.0).abs() < 8.0 / (sides * sides) as f64 + 1e-9, "{sides} sides");
    }
}

proptest! {
    #[test]
    fn distances_agree_with_triangles(
        radii in prop::array::uniform2(0.0..0.1_f64),
        length in 0.01..0.2_f64,
        point in prop::array::uniform3(-0.2..0.2_f64),
    ) {
        prop_assume!(radii[0].max(radii[1]) > 0.01);
        let (sides, point) = (256, Vector::from(point));
        let mut triangles = facets(radii, length, sides);
        triangles.retain(|corners| {
            let [a, b, c] = corners.map(Vector::from);
            (b - a).cross(&(c - a)).norm() > 1e-9
        });
        prop_assume!(!triangles.is_empty());
        let exact = distance(&[wall(frustum(radii, length))], &point);
        let meshed = distance(&[mesh("facets", &triangles)], &point);
        let sagitta = radii[0].max(radii[1]) * (1.0 - (PI / sides as f64).cos());
        prop_assert!((exact - meshed).abs() < sagitta + 1e-6, "{exact} and {meshed}");
    }
}

#[test]
fn a_grain_rolls_over_a_rectangle_as_over_a_plane() {
    let end = |walls: &[Wall]| {
        let setup = Setup { body: grain(RADIUS, [-0.03, -0.025, RADIUS], [0.5, 0.4, 0.0]), ..Setup::default() };
        let mut simulation = start(&setup, walls);
        run_until(&mut simulation, 0.1);
        simulation.snapshot().particles[0]
    };
    let plane = end(&[wall(Shape::plane([0.0; 3], UP))]);
    let rectangle =
        end(&[wall(Shape::Rectangle { corner: [-0.05, -0.05, 0.0], edges: [[0.1, 0.0, 0.0], [0.0, 0.1, 0.0]] })]);
    for axis in 0..3 {
        assert!((plane.position[axis] - rectangle.position[axis]).abs() < 1e-12, "{plane:?} {rectangle:?}");
        assert!((plane.spin[axis] - rectangle.spin[axis]).abs() < 1e-8, "{plane:?} {rectangle:?}");
    }
}

#[test]
fn fast_grains_bounce_from_both_sides() {
    let rebound = |shape: &Shape, normal: [f64; 3], foot: [f64; 3], speed: f64| {
        let unit = Vector::from(normal).normalize();
        let (place, velocity) = (Vector::from(foot) + unit * 0.012, unit * -speed);
        let body = grain(RADIUS, place.into(), velocity.into());
        let solver = CONVERGED_RIGID.replace("1e-4", "5e-4");
        let mut simulation =
            start(&Setup { gravity: [0.0; 3], solver, body, ..Setup::default() }, &[wall(shape.clone())]);
        for _ in 0..100 {
            simulation.step();
        }
        Vector::from(simulation.snapshot().particles[0].velocity).dot(&unit) / speed
    };
    let shell = frustum([0.08, 0.04], 0.04);
    for speed in [0.5, 5.0, 50.0, 500.0] {
        for (shape, normal, foot) in [
            (&shell, [1.0, 0.0, 1.0], [0.06, 0.0, 0.02]),
            (&shell, [-1.0, 0.0, -1.0], [0.06, 0.0, 0.02]),
            (&shell, [0.0, 1.0, 1.0], [0.0, 0.06, 0.02]),
            (&sheet(), UP, [0.01, 0.01, 0.0]),
            (&sheet(), [0.0, 0.0, -1.0], [0.0, 0.0, 0.0]),
        ] {
            let back = rebound(shape, normal, foot, speed);
            assert!((back - 0.5).abs() < 1e-9, "{shape:?} at {speed} m/s along {normal:?}: {back}");
        }
    }
}

#[test]
fn a_turning_rectangle_moves_grains_as_its_triangles_do() {
    let motion = || {
        let (point, axis) = ([0.0; 3], [0.0, 1.0, 0.3]);
        Motion::Rotating { point, axis, rate: 7.0, start: 0.0, stop: None, reverse: None }
    };
    let end = |wall: Wall| {
        let setup = Setup { body: grain(RADIUS, [0.01, 0.0, 0.01], [0.0; 3]), friction: 0.3, ..Setup::default() };
        let mut simulation: Simulation = start(&setup, &[wall.moving(motion())]);
        run_until(&mut simulation, 0.05);
        simulation.snapshot().particles[0]
    };
    let (one, other) = (end(wall(sheet())), end(mesh("shape", &sheet().triangles().unwrap())));
    assert_eq!(one.position, other.position);
    assert!(one.spin != [0.0; 3], "the rectangle strikes the grain: {one:?}");
}

#[test]
fn errors_name_key_and_remedy() {
    let mut scene = Setup::default().scene();
    for (shape, key, remedy) in [
        (frustum([0.0, 0.0], 1.0), "shape.radii", "from 0.000000001"),
        (frustum([-1.0, 1.0], 1.0), "shape.radii", "from 0"),
        (frustum([f64::NAN, 1.0], 1.0), "shape.radii", "from 0"),
        (Shape::Rectangle { corner: [0.0; 3], edges: [UP, UP] }, "shape.edges", "different directions"),
    ] {
        scene.wall = vec![wall(shape)];
        let error = scene.check().unwrap_err().to_string();
        assert!(error.contains(key) && error.contains(remedy), "{error}");
    }
}
