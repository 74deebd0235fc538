//! A grain on a plane of triangles moves as on the analytic plane.

use super::{Corners, G, RADIUS, bent, mesh, rectangle, start};
use crate::common::{CONVERGED_HERTZ, CONVERGED_RIGID, FLOOR, Setup, grain, run_until};
use makadam::scene::Wall;
use makadam::snapshot::Particle;

/// Numbers from 0 to 1 by a linear congruence.
fn numbers(seed: u64) -> impl FnMut() -> f64 {
    let mut state = seed;
    move || {
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (state >> 11) as f64 / (1_u64 << 53) as f64
    }
}

/// Square of 0.2 m about the origin.
fn square(cells: usize) -> Vec<Corners> {
    rectangle([-0.1, -0.1, 0.0], [0.2, 0.0, 0.0], [0.0, 0.2, 0.0], [cells, cells])
}

fn random_square(cells: usize) -> Vec<Corners> {
    let mut number = numbers(7);
    let shifts: Vec<[f64; 2]> = (0..(cells + 1) * (cells + 1)).map(|_| [number() - 0.5, number() - 0.5]).collect();
    let width = 0.2 / cells as f64;
    let bend = |i: usize, j: usize| {
        let [x, y] = shifts[i * cells + j];
        [0.8 * x * width, 0.8 * y * width, 0.0]
    };
    bent([-0.1, -0.1, 0.0], [0.2, 0.0, 0.0], [0.0, 0.2, 0.0], [cells, cells], bend)
}

fn floors() -> Vec<(&'static str, Vec<Corners>)> {
    let twice = square(8).into_iter().flat_map(|corners| {
        let [a, b, c] = corners;
        [corners, [b, a, c], [a, b, c]]
    });
    // The left half is coarse, the right half is fine, so that corners of fine triangles lie on the sides of coarse ones.
    let mut seam = rectangle([-0.1, -0.1, 0.0], [0.1, 0.0, 0.0], [0.0, 0.2, 0.0], [1, 2]);
    seam.extend(rectangle([0.0, -0.1, 0.0], [0.1, 0.0, 0.0], [0.0, 0.2, 0.0], [20, 33]));
    // Corners that differ in the last bits of single precision.
    let mut number = numbers(3);
    let loose = square(10)
        .into_iter()
        .map(|corners| corners.map(|[x, y, z]| [x * (1.0 + 1e-7 * number()), y * (1.0 - 1e-7 * number()), z]));
    // Needles of 1:1000.
    let needles = rectangle([-0.1, -0.1, 0.0], [0.2, 0.0, 0.0], [0.0, 0.2, 0.0], [1, 1000]);
    vec![
        ("coarse", rectangle([-9.0, -9.0, 0.0], [18.0, 0.0, 0.0], [0.0, 18.0, 0.0], [1, 1])),
        ("regular", square(8)),
        ("fine", square(200)),
        ("random", random_square(30)),
        ("two layers", twice.collect()),
        ("T-junctions", seam),
        ("loose corners", loose.collect()),
        ("needles", needles),
    ]
}

fn end(solver: &str, restitution: f64, wall: Option<Wall>, grain: &str, time: f64) -> Particle {
    let body = if wall.is_some() { grain.to_string() } else { FLOOR.to_string() + grain };
    let setup = Setup { restitution, solver: solver.into(), body, ..Setup::default() };
    let mut simulation = start(&setup, wall.as_slice());
    run_until(&mut simulation, time);
    simulation.snapshot().particles[0]
}

fn same(name: &str, one: &Particle, other: &Particle, tolerance: f64) {
    let all = [(one.position, other.position), (one.velocity, other.velocity)];
    for (axis, (a, b)) in (0..3).flat_map(|axis| all.map(|(a, b)| (axis, (a[axis], b[axis])))) {
        assert!((a - b).abs() < tolerance, "{name}, axis {axis}: {a:e} and {b:e}\n{one:?}\n{other:?}");
    }
    for (a, b) in one.spin.iter().zip(other.spin) {
        assert!((a - b).abs() * RADIUS < tolerance, "{name}: {one:?}\n{other:?}");
    }
}

#[test]
fn a_grain_rolls_over_triangles_as_over_a_plane() {
    // Across everything; along a line of the grid; over its corners on the diagonal.
    for (velocity, place) in [([0.7, 0.31], [-0.07, -0.033]), ([0.8, 0.0], [-0.08, 0.0]), ([0.5, 0.5], [-0.05, -0.05])]
    {
        for solver in [CONVERGED_RIGID, CONVERGED_HERTZ] {
            let body = grain(RADIUS, [place[0], place[1], RADIUS], [velocity[0], velocity[1], 0.0]);
            let expected = end(solver, 0.0, None, &body, 0.15);
            for (name, triangles) in floors() {
                let found = end(solver, 0.0, Some(mesh("floor", &triangles)), &body, 0.15);
                same(name, &found, &expected, 1e-10);
            }
        }
    }
}

#[test]
fn a_grain_bounces_from_faces_sides_and_corners_alike() {
    // In a face of the coarse grid, on a side, on a diagonal and on a corner of it.
    for place in [[0.0107, 0.0043], [0.0, 0.0107], [0.0125, 0.0125], [0.0, 0.0]] {
        for solver in [CONVERGED_RIGID, CONVERGED_HERTZ] {
            let body = grain(RADIUS, [place[0], place[1], 2.0 * RADIUS], [0.0; 3]);
            let expected = end(solver, 0.8, None, &body, 0.045);
            assert!(expected.velocity[2] > 0.0, "it bounces");
            for (name, triangles) in floors() {
                let found = end(solver, 0.8, Some(mesh("floor", &triangles)), &body, 0.045);
                same(name, &found, &expected, 1e-10);
                assert!(found.spin.iter().all(|spin| spin.abs() < 1e-9), "{name}: {found:?}");
            }
        }
    }
}

#[test]
fn friction_continues_from_triangle_to_triangle() {
    // A grain sticks to a tilted plane by a spring, and is dragged over triangles much smaller than its path.
    let solver = CONVERGED_HERTZ.to_string() + "\ntangential_law = { kind = 'spring' }";
    let gravity = [0.3 * G, 0.0, -G];
    let body = grain(RADIUS, [0.0, 0.0, RADIUS], [0.2, 0.0, 0.0]);
    let of = |wall: Option<Wall>| {
        let body = if wall.is_some() { body.clone() } else { FLOOR.to_string() + &body };
        let setup = Setup { gravity, solver: solver.clone(), body, restitution: 0.0, ..Setup::default() };
        let mut simulation = start(&setup, wall.as_slice());
        run_until(&mut simulation, 0.1);
        let frame = simulation.snapshot();
        (frame.particles[0], frame.contacts[0].tangential_force)
    };
    let (expected, force) = of(None);
    for (name, triangles) in floors() {
        let (found, other) = of(Some(mesh("floor", &triangles)));
        same(name, &found, &expected, 1e-10);
        for axis in 0..3 {
            assert!((force[axis] - other[axis]).abs() < 1e-9, "{name}: {force:?} and {other:?}");
        }
    }
}

#[test]
fn fast_grains_bounce_from_triangles_as_from_a_plane() {
    // The grain moves by eight radii in a step.
    for solver in [CONVERGED_RIGID, CONVERGED_HERTZ] {
        let body = grain(RADIUS, [-0.043, 0.012, 1.0], [30.0, -7.0, -400.0]);
        let expected = end(solver, 0.5, None, &body, 0.004);
        assert!(expected.velocity[2] > 0.0, "it bounces");
        for (name, triangles) in floors().into_iter().filter(|(name, _)| *name != "coarse") {
            let found = end(solver, 0.5, Some(mesh("floor", &triangles)), &body, 0.004);
            same(name, &found, &expected, 1e-9);
        }
    }
}
