//! The candidate list: it lives as long as it may, holds all that touches, and costs what the grains cost, however large the domain is.

use crate::common::bits::{same_bits_everywhere, start, steps};
use crate::common::{Setup, grain};
use makadam::Simulation;
use makadam::scene::Scene;

const RADIUS: f64 = 0.005;

/// Two grains with a gap (m), the second of which moves as it is told, m/s, in a wide domain without gravity.
fn two(gap: f64, velocities: [[f64; 3]; 2]) -> Simulation {
    let body = grain(RADIUS, [0.0; 3], velocities[0]) + &grain(RADIUS, [2.0 * RADIUS + gap, 0.0, 0.0], velocities[1]);
    Setup { gravity: [0.0; 3], body, ..Setup::default() }.start()
}

#[test]
fn lists_live_until_grains_approach() {
    // Together they go ten diameters, which is within the space that a box is searched from, and come no closer.
    let speed = 0.3;
    let mut together = two(RADIUS, [[speed, 0.0, 0.0]; 2]);
    steps(&mut together, 200);
    assert_eq!(together.rebuilds(), 1, "what moves together comes no closer");
    // The same path towards each other: the list reaches 0.6 radii.
    let mut apart = two(5.0 * RADIUS, [[speed, 0.0, 0.0], [-speed, 0.0, 0.0]]);
    let mut rebuilt = Vec::new();
    while apart.step().contacts == 0 {
        rebuilt.push(apart.rebuilds());
        assert!(rebuilt.len() < 1000, "they never met");
    }
    let gap = 5.0 * RADIUS - 2.0 * speed * 1e-4 * rebuilt.len() as f64;
    assert!(gap.abs() <= 2.0 * speed * 1e-4, "they met {gap} m apart");
    let expected = 5.0 * RADIUS / (0.6 * RADIUS);
    let lists = rebuilt.last().copied().unwrap_or_default() as f64;
    assert!((lists - expected).abs() <= 2.0, "{lists} lists for {expected} skins");
}

/// Touching pairs of grains here and there in a cube around the origin, in all directions, so that they lie across faces, edges and corners of
/// boxes that hold nothing else.
fn scattered_pairs(half: f64, count: usize) -> Scene {
    let mut state = 1_u64;
    let mut random = || {
        state = state.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
        (state >> 33) as f64 / (1_u64 << 31) as f64
    };
    let mut body = String::new();
    // One of them in each cell of a lattice, so that pairs are apart.
    let edge = (count as f64).cbrt().ceil() as usize;
    let cell = 2.0 * half / edge as f64;
    for number in 0..count {
        let at = [number % edge, number / edge % edge, number / (edge * edge)];
        let corner = at.map(|place| -half + cell * place as f64);
        let [x, y, z] = corner.map(|low| low + 3.0 * RADIUS + (cell - 6.0 * RADIUS) * random());
        let (turn, height) = (6.3 * random(), 2.0 * random() - 1.0);
        let flat = (1.0 - height * height).sqrt();
        let arm = [flat * turn.cos(), flat * turn.sin(), height].map(|part| 1.99999 * RADIUS * part);
        body += &(grain(RADIUS, [x, y, z], [0.0; 3]) + &grain(RADIUS, [x + arm[0], y + arm[1], z + arm[2]], [0.0; 3]));
    }
    let solver = "step = 1e-5\nnormal_law = { kind = 'hertz' }".into();
    let mut scene = Setup { gravity: [0.0; 3], solver, body, ..Setup::default() }.scene();
    (scene.domain.min, scene.domain.max) = ([-half; 3], [half; 3]);
    scene
}

#[test]
fn pairs_touch_across_empty_boxes() {
    // Boxes all over the domain, boxes where grains are, and boxes so far apart that they are made wider.
    for half in [0.3, 2.0, 500.0] {
        let scene = scattered_pairs(half, 1000);
        let mut simulation = start(&scene);
        assert_eq!(simulation.step().contacts, 1000, "{half} m");
        assert!(simulation.layout().plan.tasks().len() < 20_000, "{half} m");
    }
    same_bits_everywhere(&scattered_pairs(2.0, 1000), 5);
}

#[test]
fn the_order_of_pairs_depends_on_positions_and_ids_alone() {
    let scene = scattered_pairs(0.3, 1000);
    // Grains that were elsewhere at the first build have another order in memory.
    let pairs_by_id = |detour: bool| {
        let mut simulation = start(&scene);
        let there: Vec<[f64; 3]> = simulation.frame().positions().to_vec();
        for shift in if detour { vec![997, 0] } else { vec![0] } {
            let mut states = simulation.states();
            for row in 0..states.grains() {
                let id = states.id(row) as usize;
                *states.position(row) = there[(id + shift) % there.len()];
                *states.velocity(row) = [0.0; 3];
                *states.scaled_spin(row) = [0.0; 3];
            }
            drop(states);
            simulation.step();
        }
        let ids = simulation.arrays().2.to_vec();
        let rebuilds = simulation.rebuilds();
        let (pairs, ..) = simulation.pairs_in_list();
        let named = pairs.iter().map(|pair| [ids[pair.first as usize], ids[pair.second as usize]]);
        (rebuilds, named.collect::<Vec<_>>(), ids)
    };
    let ((first, straight, ids), (second, after_detour, ids_after)) = (pairs_by_id(false), pairs_by_id(true));
    assert_eq!((first, second), (1, 2));
    assert!(straight.len() >= 1000, "{} pairs", straight.len());
    assert!(ids == ids_after && straight == after_detour);
}
