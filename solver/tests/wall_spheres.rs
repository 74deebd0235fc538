//! Walls of many spheres: an index finds those that are near, in any frame and in a periodic domain.

use crate::common::{Setup, grain};
use makadam::effects::period::Period;
use makadam::scene::Scene;
use makadam::{Axis, Partner, Simulation};
use nalgebra::Vector3;

type Vector = Vector3<f64>;

/// Radius of the spheres of the wall, m.
const BALL: f64 = 0.03;
/// Radii of the grains, m.
const RADII: [f64; 5] = [0.01, 0.05, 0.15, 0.3, 0.002];
/// Velocity of the wall, m/s.
const VELOCITY: [f64; 3] = [3.0, -5.0, 0.5];

/// Spheres here and there, some of them beyond the domain, m.
fn centres() -> Vec<Vector> {
    let at = |number: usize, factor: usize| (number * factor % 1009) as f64 / 1009.0 * 3.0 - 1.5;
    (0..500).map(|number| Vector::new(at(number, 211), at(number, 367), 0.1 * at(number, 523))).collect()
}

/// Grains of all radii among the spheres of a wall. Nothing but the spheres touches them: each is in a scene of its own.
fn scene(number: usize, periodic: bool, motion: &str) -> Scene {
    let centres: Vec<[f64; 3]> = centres().into_iter().map(Into::into).collect();
    let place = [0.9 * (number as f64).sin(), 0.9 * (number as f64).cos(), 0.05];
    let body = format!(
        "[[wall]]\nname = 'balls'\nmaterial = 'wall'\nshape = {{ kind = 'spheres', radius = {BALL}, centres = {centres:?} }}\n{motion}\n{}",
        grain(RADII[number % RADII.len()], place, [0.0; 3])
    );
    // Soft, so that a step moves nothing far.
    let solver = "step = 1e-6\nnormal_law = { kind = 'hertz' }".into();
    let mut scene = Setup { gravity: [0.0; 3], youngs_modulus: 1e3, solver, body, ..Setup::default() }.scene();
    scene.largest_start_overlap = 2.0;
    if periodic {
        (scene.domain.min, scene.domain.max) = ([-1.2; 3], [1.2; 3]);
        scene.domain.periodic = vec![Axis::X, Axis::Y];
    }
    scene
}

/// Spheres that overlap a grain, counted one by one: each image of the wall is shifted by `shift` (m).
fn overlapping(centre: Vector, radius: f64, period: &Period, shift: Vector) -> usize {
    let near = |ball: &Vector| period.arm(&centre, &(ball + shift)).norm() < radius + BALL;
    centres().iter().filter(|ball| near(ball)).count()
}

#[test]
fn every_near_sphere_touches() {
    let moving = format!("motion = {{ kind = 'translating', velocity = {VELOCITY:?} }}");
    let mut found = 0;
    for (periodic, motion) in [(false, ""), (true, ""), (false, &*moving)] {
        let period = Period::new([2.4; 3], [periodic, periodic, false]);
        for number in 0..40 {
            let scene = scene(number, periodic, motion);
            let mut simulation = Simulation::new(&scene, 1).unwrap();
            for _ in 0..3 {
                let (time, one) = (simulation.time(), simulation.snapshot().particles[0]);
                simulation.step();
                let shift = if motion.is_empty() { Vector::zeros() } else { Vector::from(VELOCITY) * time };
                let expected = overlapping(one.position.into(), one.radius, &period, shift);
                assert_eq!(simulation.layout().contacts, expected, "grain {number}, periodic {periodic}, {motion}");
                found += expected;
            }
            let on_walls = |contact: &makadam::Contact| contact.second == Partner::Wall(0);
            assert!(simulation.snapshot().contacts.iter().all(on_walls));
        }
    }
    assert!(found > 1000, "{found} contacts");
}

#[test]
fn grains_beyond_all_numbers_end_no_run() {
    for velocity in [1e200, 1e300] {
        let mut scene = scene(0, true, "");
        scene.grain[0].velocity = [velocity, velocity, 0.0];
        let Ok(mut simulation) = Simulation::new(&scene, 1) else { continue };
        for _ in 0..5 {
            simulation.step();
        }
        assert_eq!(simulation.steps_taken(), 5);
    }
}
