//! Streams through hoppers of triangles: nobody is lost, and the bits are the same.

use super::{Corners, mesh, moving};
use crate::common::Setup;
use crate::common::bits::same_bits_everywhere;
use makadam::Simulation;
use makadam::scene::{Motion, Scene};
use std::f64::consts::TAU;

/// Radius and height of the rings of a funnel, m: outlet, top of the cone, top.
const RINGS: [[f64; 2]; 3] = [[0.013, 0.0], [0.03, 0.05], [0.03, 0.12]];

/// Funnel with a number of sides, turned by an angle, and displaced rings.
fn funnel(sides: usize, turn: f64, shift: f64) -> Vec<Corners> {
    let point = |ring: usize, side: usize| {
        let ([radius, height], angle) = (RINGS[ring], (side % sides) as f64 / sides as f64 * TAU + turn);
        [radius * angle.cos() + shift * ring as f64, radius * angle.sin(), height]
    };
    let mut all = Vec::new();
    for (ring, side) in (0..2).flat_map(|ring| (0..sides).map(move |side| (ring, side))) {
        let [a, b, c, d] = [point(ring, side), point(ring, side + 1), point(ring + 1, side + 1), point(ring + 1, side)];
        match (ring + side) % 2 {
            0 => all.extend([[a, b, c], [a, c, d]]),
            _ => all.extend([[a, b, d], [b, c, d]]),
        }
    }
    all
}

/// A stream into a funnel, out of its outlet and into a sink; the kind of the funnel follows from a number.
fn hopper(kind: u64) -> Scene {
    let [sides, step, spread, motion] = [5 + kind % 11, kind / 11 % 3, kind / 33 % 4, kind % 4];
    let body = format!(
        "[[insert]]\nmaterial = 'grain'\nrate = {}\nvelocity = [0, 0, -{}]\n\
         radius = {{ kind = 'uniform', mean = 0.0025, spread = {} }}\n\
         region = {{ kind = 'cylinder', base = [0, 0, 0.07], axis = [0, 0, 1], radius = 0.018, length = 0.04 }}\n\
         [[remove]]\nregion = {{ kind = 'box', min = [-1, -1, -0.4], max = [1, 1, -0.05] }}\n",
        2000 + 400 * (kind % 5),
        0.3 + 0.4 * (kind % 3) as f64,
        0.15 * spread as f64,
    );
    let solver = format!(
        "step = {}\nnormal_law = {{ kind = 'hertz' }}\nstop = {{ kind = 'sweeps', sweeps = 10 }}",
        [2e-4, 4e-4, 1e-3][step as usize]
    );
    let mut scene = Setup { youngs_modulus: 1e6, solver, body, ..Setup::default() }.scene();
    let triangles = funnel(sides as usize, 0.1 * kind as f64, 1e-3 * (kind % 7) as f64);
    let turning =
        Motion::Rotating { point: [0.0; 3], axis: [0.0, 0.0, 1.0], rate: 4.0, start: 0.0, stop: None, reverse: None };
    let shaking = Motion::Vibrating { amplitude: [5e-4, 0.0, 0.0], frequency: 30.0, start: 0.0, stop: None };
    scene.wall.push(match motion {
        0 => moving("funnel", &triangles, turning),
        1 => moving("funnel", &triangles, shaking),
        _ => mesh("funnel", &triangles),
    });
    scene.seed = kind;
    scene
}

/// Runs a stream, and checks that all grains are in the funnel, on the way down, or gone; returns the numbers that came and went.
fn run(kind: u64, time: f64) -> [u64; 2] {
    let mut simulation = Simulation::new(&hopper(kind), kind).unwrap();
    while simulation.time() < time {
        simulation.step();
        let [came, went] = simulation.passed().map(|passed| passed.grains);
        assert_eq!(came, went + simulation.grains() as u64, "funnel {kind} at {} s", simulation.time());
        assert_eq!(simulation.crossing(), None, "funnel {kind} at {} s", simulation.time());
    }
    for grain in simulation.snapshot().particles {
        let [x, y, z] = grain.position;
        // Below the brim the centres are inside the funnel: its radius at this height, its displacement, and its shaking.
        let (cone, tube) = ((z / 0.05).clamp(0.0, 1.0), ((z - 0.05) / 0.07).clamp(0.0, 1.0));
        let inside = 0.013 + 0.017 * cone + 1e-3 * (kind % 7) as f64 * (cone + tube) + 5e-4;
        assert!(!(0.0..=0.12).contains(&z) || x.hypot(y) < inside, "funnel {kind}: {grain:?}");
    }
    simulation.passed().map(|passed| passed.grains)
}

#[test]
fn streams_through_funnels_lose_nobody() {
    let asked = std::env::var("MAKADAM_FUNNELS").ok().map(|count| count.parse().expect("a whole number"));
    let (mut came, mut went) = (0, 0);
    for kind in 0..asked.unwrap_or(12) {
        let [into, out] = run(kind, 0.4);
        (came, went) = (came + into, went + out);
    }
    println!("{came} grains came and {went} went");
    assert!(went > 0 && came > went);
}

#[test]
fn a_stream_through_a_funnel_has_the_same_bits() {
    same_bits_everywhere(&hopper(4), 400);
}
