//! Convex and concave edges and corners, thin and small features.

use super::{Corners, G, RADIUS, mesh, open_box, rectangle, start, wall_contacts};
use crate::common::{CONVERGED_RIGID, DENSITY, Setup, grain, run_until};
use std::f64::consts::PI;

const MASS: f64 = DENSITY * 4.0 / 3.0 * PI * RADIUS * RADIUS * RADIUS;

/// Cube outside of which grains are, between 0 and its side.
fn cube(side: f64, n: usize) -> Vec<Corners> {
    let mut all = open_box([0.0; 3], [side; 3], n);
    all.extend(rectangle([0.0, 0.0, side], [side, 0.0, 0.0], [0.0, side, 0.0], [n, n]));
    all
}

/// Contacts of a grain after 20 ms from rest at a place under gravity in a direction.
fn rests(triangles: &[Corners], down: [f64; 3], place: [f64; 3]) -> Vec<([f64; 3], f64)> {
    let gravity = down.map(|x| x * G / down.iter().map(|x| x * x).sum::<f64>().sqrt());
    let setup = Setup {
        gravity,
        restitution: 0.0,
        body: grain(RADIUS, place, [0.0; 3]),
        solver: CONVERGED_RIGID.into(),
        ..Setup::default()
    };
    let mut simulation = start(&setup, &[mesh("mesh", triangles)]);
    run_until(&mut simulation, 0.02);
    let frame = simulation.snapshot();
    let moved: f64 = (0..3).map(|axis| (frame.particles[0].position[axis] - place[axis]).powi(2)).sum();
    assert!(moved.sqrt() < 1e-6, "{:?} from {place:?}", frame.particles[0]);
    let contacts = wall_contacts(&simulation);
    assert!(frame.particles[0].spin.iter().all(|spin| spin.abs() < 1e-6), "{:?} {contacts:?}", frame.particles[0]);
    for (axis, pull) in gravity.iter().enumerate() {
        let of_walls: f64 = frame.contacts.iter().map(|contact| contact.force_on_partner()[axis]).sum();
        assert!((of_walls - MASS * pull).abs() < 1e-9 * MASS * G, "{contacts:?}");
    }
    contacts
}

#[test]
fn one_contact_on_faces_edges_and_corners_of_a_cube() {
    let side = 0.04;
    let (half, third) = (RADIUS / 2.0_f64.sqrt(), RADIUS / 3.0_f64.sqrt());
    for n in [1, 2, 7, 50] {
        let cube = cube(side, n);
        for (down, place) in [
            ([0.0, 0.0, -1.0], [0.013, 0.017, side + RADIUS]),
            ([0.0, 0.0, -1.0], [0.02, 0.02, side + RADIUS]),
            ([0.0, 0.0, -1.0], [0.02, 0.011, side + RADIUS]),
            ([0.0, -1.0, -1.0], [0.013, side + half, side + half]),
            ([0.0, -1.0, -1.0], [0.02, side + half, side + half]),
            ([-1.0, -1.0, -1.0], [side + third; 3]),
        ] {
            let contacts = rests(&cube, down, place);
            assert_eq!(contacts.len(), 1, "{n} cells, {place:?}: {contacts:?}");
        }
    }
}

#[test]
fn one_contact_for_each_side_of_a_concave_corner() {
    for n in [1, 3, 20] {
        let walls = open_box([0.0; 3], [0.05, 0.05, 0.05], n);
        let contacts = rests(&walls, [-1.0, -1.0, -1.0], [RADIUS; 3]);
        assert_eq!(contacts.len(), 3, "{contacts:?}");
        let contacts = rests(&walls, [-1.0, 0.0, -1.0], [RADIUS, 0.0211, RADIUS]);
        assert_eq!(contacts.len(), 2, "{contacts:?}");
        // A trough of an obtuse angle, far from its ends.
        let slope = |sign: f64| rectangle([0.0, -0.05, 0.0], [0.0, 0.1, 0.0], [sign * 0.05, 0.0, 0.01], [n, n]);
        let trough = [slope(1.0), slope(-1.0)].concat();
        let height = RADIUS * (1.0_f64 + 0.04).sqrt();
        let contacts = rests(&trough, [0.0, 0.0, -1.0], [0.0, 0.0013, height]);
        assert_eq!(contacts.len(), 2, "{contacts:?}");
    }
}

#[test]
fn a_grain_rests_on_a_knife_edge_and_on_a_needle() {
    for (m, n) in [(1, 1), (9, 4)] {
        let sheet = rectangle([-0.05, 0.0, -0.05], [0.1, 0.0, 0.0], [0.0, 0.0, 0.05], [m, n]);
        assert_eq!(rests(&sheet, [0.0, 0.0, -1.0], [0.0031, 0.0, RADIUS]).len(), 1);
    }
    // A blade of one degree, and a spike.
    let flank = 0.05 * (0.5_f64).to_radians().tan();
    let blade =
        [-flank, flank].map(|y| rectangle([-0.05, 0.0, 0.0], [0.1, 0.0, 0.0], [0.0, y, -0.05], [3, 3])).concat();
    assert_eq!(rests(&blade, [0.0, 0.0, -1.0], [0.0031, 0.0, RADIUS]).len(), 1);
    let foot = |k: usize| {
        let angle = k as f64 / 5.0 * std::f64::consts::TAU;
        [0.001 * angle.cos(), 0.001 * angle.sin(), -0.05]
    };
    let spike: Vec<Corners> = (0..5).map(|k| [[0.0; 3], foot(k), foot((k + 1) % 5)]).collect();
    assert_eq!(rests(&spike, [0.0, 0.0, -1.0], [0.0, 0.0, RADIUS]).len(), 1);
}

#[test]
fn a_grain_rests_in_a_hole_of_its_size() {
    // A square hole, whose sides touch the grain below its equator.
    let (inner, outer) = (0.8 * RADIUS, 0.05);
    let frame = |turn: fn([f64; 3]) -> [f64; 3]| {
        let side = rectangle([-inner, inner, 0.0], [2.0 * inner, 0.0, 0.0], [0.0, outer, 0.0], [3, 2]);
        side.into_iter().map(move |corners| corners.map(turn)).collect::<Vec<Corners>>()
    };
    let square = [
        frame(|[x, y, z]| [x, y, z]),
        frame(|[x, y, z]| [-y, x, z]),
        frame(|[x, y, z]| [-x, -y, z]),
        frame(|[x, y, z]| [y, -x, z]),
    ]
    .concat();
    let height = (RADIUS * RADIUS - inner * inner).sqrt();
    assert_eq!(rests(&square, [0.0, 0.0, -1.0], [0.0, 0.0, height]).len(), 4);
    // A round hole has more sides than a grain has contacts: those taken surround it.
    for sides in [7, 24, 96] {
        let ring = |radius: f64, k: usize| {
            let angle = k as f64 / sides as f64 * std::f64::consts::TAU;
            [radius * angle.cos(), radius * angle.sin(), 0.0]
        };
        let round: Vec<Corners> = (0..sides)
            .flat_map(|k| {
                let [a, b, c, d] = [ring(inner, k), ring(inner, k + 1), ring(outer, k + 1), ring(outer, k)];
                [[a, b, c], [a, c, d]]
            })
            .collect();
        let reach = inner * (PI / sides as f64).cos();
        let height = (RADIUS * RADIUS - reach * reach).sqrt();
        let contacts = rests(&round, [0.0, 0.0, -1.0], [0.0, 0.0, height]);
        assert_eq!(contacts.len(), 6, "{contacts:?}");
        let sum: [f64; 3] = std::array::from_fn(|axis| contacts.iter().map(|(normal, _)| normal[axis]).sum());
        assert!(sum[0].abs() < 2.0 && sum[1].abs() < 2.0, "{contacts:?}");
    }
}
