//! Gauges count the grains that pass, to the grain.

use crate::common::bits::{start, steps};
use crate::common::{DENSITY, Setup, grain, parse};
use approx::assert_relative_eq;
use makadam::{Passages, Simulation};
use std::f64::consts::PI;

const SOLVER: &str = "step = 5e-4\nnormal_law = { kind = 'hertz' }\nstop = { kind = 'sweeps', sweeps = 20 }";

fn disc(name: &str, centre: [f64; 3], normal: [f64; 3], radius: f64) -> String {
    format!(
        "[[gauge]]\nname = '{name}'\nshape = {{ kind = 'disc', centre = {centre:?}, normal = {normal:?}, radius = {radius:?} }}\n"
    )
}

fn rectangle(name: &str, corner: [f64; 3], edges: [[f64; 3]; 2]) -> String {
    format!("[[gauge]]\nname = '{name}'\nshape = {{ kind = 'rectangle', corner = {corner:?}, edges = {edges:?} }}\n")
}

/// A stream that falls through a shaft with gauges across it.
fn stream(until: f64) -> makadam::Scene {
    let body = format!(
        "[[wall]]\nname = 'shaft'\nmaterial = 'wall'\n\
         shape = {{ kind = 'box', min = [0, 0, 0], max = [0.06, 0.06, 0.4], open = ['+z', '-z'] }}\n\
         [[insert]]\nmaterial = 'grain'\nradius = {{ kind = 'uniform', mean = 0.004, spread = 0.2 }}\nrate = 500\nuntil = {until:?}\n\
         velocity = [0, 0, -0.5]\nregion = {{ kind = 'box', min = [0, 0, 0.3], max = [0.06, 0.06, 0.36] }}\n\
         [[remove]]\nregion = {{ kind = 'box', min = [-1, -1, -0.9], max = [1, 1, 0.0] }}\n{}{}{}",
        disc("below", [0.03, 0.03, 0.1], [0.0, 0.0, -2.0], 0.1),
        rectangle("half", [0.0, 0.0, 0.1], [[0.03, 0.0, 0.0], [0.0, 0.06, 0.0]]),
        rectangle("rest", [0.03, 0.0, 0.1], [[0.03, 0.0, 0.0], [0.0, 0.06, 0.0]]),
    );
    Setup { restitution: 0.2, solver: SOLVER.into(), body, ..Setup::default() }.scene()
}

fn net(gauge: &[Passages; 2]) -> i64 {
    gauge[0].grains as i64 - gauge[1].grains as i64
}

#[test]
fn what_comes_passes_and_goes() {
    let mut simulation = start(&stream(0.5));
    for step in 0..2000 {
        simulation.step();
        // Grains that came and are not above the gauge have passed it.
        let frame = simulation.snapshot();
        let above = frame.particles.iter().filter(|grain| grain.position[2] >= 0.1).count() as i64;
        let [below, half, rest] = [0, 1, 2].map(|gauge| net(&frame.gauges[gauge]));
        let came = frame.passed[0].grains as i64;
        // The disc looks down, the rectangles look up: a centre on the surface is on the side of the normal.
        assert_eq!((below, half + rest), (came - above, above - came), "step {step}");
    }
    let ([came, went], gauges) = (simulation.passed(), simulation.gauges());
    assert!(came.grains > 200 && came.grains == went.grains && net(&gauges[0]) == went.grains as i64);
    let [down, up] = gauges[0];
    assert_relative_eq!(down.mass - up.mass, went.mass, max_relative = 1e-12);
    assert!(down.momentum[2] < -1.4 * down.mass && gauges[1][1].grains > 50 && gauges[2][1].grains > 50);
}

#[test]
fn counts_are_the_same_on_any_threads_and_after_a_checkpoint() {
    let scene = stream(1.0);
    let mut whole = start(&scene);
    steps(&mut whole, 1200);
    let mut halves = start(&scene);
    steps(&mut halves, 601);
    halves = Simulation::resume(&scene, &halves.checkpoint()).unwrap();
    steps(&mut halves, 599);
    let mut shared = Simulation::builder(&scene).threads(3).build().unwrap();
    steps(&mut shared, 1200);
    assert!(net(&whole.gauges()[0]) > 100);
    assert_eq!([halves.gauges(), shared.gauges()], [whole.gauges(); 2]);
}

#[test]
fn a_grain_passes_once_a_lap_of_a_periodic_axis() {
    let gauges = [
        rectangle("whole", [0.02, 0.0, 0.0], [[0.0, 0.1, 0.0], [0.0, 0.0, 0.1]]),
        disc("end", [0.1, 0.05, 0.05], [-1.0, 0.0, 0.0], 0.04),
        // Oblique across both periods.
        disc("oblique", [0.05, 0.05, 0.05], [1.0, 1.0, 0.0], 0.03),
        disc("beside", [0.05, 0.05, 0.09], [1.0, 0.0, 0.0], 0.01),
    ];
    let body = format!("{}{}", grain(0.004, [0.031, 0.06, 0.05], [1.0, 0.0, 0.0]), gauges.concat());
    let text = format!(
        "name = 'ring'\nduration = 1.0\ngravity = [0, 0, 0]\n\
         domain = {{ min = [0, 0, 0], max = [0.1, 0.1, 0.1], periodic = ['x', 'y'] }}\n\
         [material.grain]\ndensity = {DENSITY}\nyoungs_modulus = 1e7\npoisson_ratio = 0.3\nfriction = 0.5\nrestitution = 0.5\n\
         [solver]\n{SOLVER}\n{body}"
    );
    let mut simulation = start(&parse(&text).unwrap());
    // 10 laps and a bit more than the way to the first gauge.
    steps(&mut simulation, 2190);
    let counted = simulation.gauges().iter().map(|gauge| gauge.map(|way| way.grains)).collect::<Vec<_>>();
    assert_eq!(counted, [[11, 0], [0, 11], [11, 0], [0, 0]]);
    let mass = DENSITY * 4.0 / 3.0 * PI * 0.004_f64.powi(3);
    assert_relative_eq!(simulation.gauges()[0][0].momentum[0], 11.0 * mass, max_relative = 1e-12);
}

/// Rectangles of different size and orientation that share edges and corners: each grain passes one of them.
#[test]
fn a_passage_on_a_common_edge_counts_once() {
    let gauges = [
        rectangle("a", [0.0, 0.0, 0.0], [[0.3, 0.0, 0.0], [0.0, 0.1, 0.0]]),
        rectangle("b", [0.9, 0.0, 0.0], [[-0.6, 0.0, 0.0], [0.0, 0.1, 0.0]]),
        rectangle("c", [0.3, 0.7, 0.0], [[0.0, -0.6, 0.0], [-0.3, 0.0, 0.0]]),
        rectangle("d", [0.3, 0.1, 0.0], [[0.0, 0.6, 0.0], [0.6, 0.0, 0.0]]),
    ];
    let places = [[0.3, 0.05], [0.3, 0.1], [0.1, 0.1], [0.6, 0.1], [0.3, 0.4], [0.2, 0.3], [0.0, 0.1], [0.3, 0.0]];
    let grains = places.map(|[x, y]| grain(0.004, [x, y, 0.001], [0.0, 0.0, -1.0]));
    let text = format!(
        "name = 'edges'\nduration = 1.0\ngravity = [0, 0, 0]\n\
         domain = {{ min = [-1, -1, -1], max = [1, 1, 1] }}\n\
         [material.grain]\ndensity = {DENSITY}\nyoungs_modulus = 1e7\npoisson_ratio = 0.3\nfriction = 0.5\nrestitution = 0.5\n\
         [solver]\n{SOLVER}\n{}{}",
        grains.concat(),
        gauges.concat()
    );
    let mut simulation = start(&parse(&text).unwrap());
    steps(&mut simulation, 4);
    let counted: u64 = simulation.gauges().iter().flatten().map(|way| way.grains).sum();
    assert_eq!(counted, places.len() as u64, "{:?}", simulation.gauges());
}

#[test]
fn a_gauge_without_size_or_place_is_refused() {
    let flat = rectangle("a", [0.0; 3], [[1.0, 0.0, 0.0], [2.0, 0.0, 0.0]]);
    for (gauges, problem) in [
        (flat.clone(), "gauge[0].shape.edges"),
        (disc("a", [0.0; 3], [0.0; 3], 1.0), "gauge[0].shape.normal"),
        (disc("a", [0.0; 3], [1.0, 0.0, 0.0], 0.0), "gauge[0].shape.radius"),
        (disc("a", [0.0, 0.0, 50.0], [0.0, 0.0, 1.0], 1.0), "outside the domain"),
        (disc("a", [0.0; 3], [0.0, 0.0, 1.0], 1.0).repeat(2), "gauge[1].name"),
        (
            "[[gauge]]\nname = 'a'\nshape = { kind = 'plane', point = [0, 0, 0], normal = [0, 0, 1] }\n".into(),
            "a plane that",
        ),
        (disc("", [0.0; 3], [0.0, 0.0, 1.0], 1.0), "gauge[0].name"),
    ] {
        let text = format!(
            "name = 't'\nduration = 1.0\ndomain = {{ min = [-10, -10, -1], max = [10, 10, 10] }}\n\
             [material.grain]\ndensity = 2500\nyoungs_modulus = 1e7\npoisson_ratio = 0.3\nfriction = 0.5\nrestitution = 0.5\n{gauges}"
        );
        let error = parse(&text).unwrap_err();
        assert!(error.contains(problem), "{error}");
    }
}
