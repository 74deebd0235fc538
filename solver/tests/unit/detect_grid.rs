//! Unit tests of `src/detect/grid.rs`.

use super::*;
use crate::Simulation;
use crate::scene::Scene;
use crate::world::Sphere;

/// Radius of the grains, m.
const RADIUS: f64 = 0.005;
/// Width of a cell at least, m.
const REACH: f64 = 2.2 * RADIUS;
/// Grains along an edge of a block.
const EDGE: i32 = 16;

/// Input of sorting and searching.
#[derive(Debug)]
struct Work {
    boxes: usize,
    cells: usize,
    comparisons: usize,
}

/// The work for blocks of grains around these middles and lone grains, m, in a cube around the origin.
fn work(half: f64, middles: &[[f64; 3]], lone: &[[f64; 3]]) -> Work {
    let text = format!(
        "name = 'blocks'\ndescription = ''\nduration = 1\ngravity = [0, 0, 0]\n\
         domain = {{ min = [{0:?}, {0:?}, {0:?}], max = [{half:?}, {half:?}, {half:?}] }}\n\
         [material.grain]\ndensity = 2500\nyoungs_modulus = 1e7\npoisson_ratio = 0.3\nrestitution = 0.5\nfriction = 0\n\
         [[grain]]\nmaterial = 'grain'\nradius = {RADIUS:?}\nposition = [0, 0, 0]\n",
        -half
    );
    let scene = Scene::parse(&text).unwrap();
    let pattern = Simulation::new(&scene, 1).unwrap().world;
    let blocks = middles.iter().flat_map(|middle| {
        (0..EDGE * EDGE * EDGE).map(|number| {
            let at = [number % EDGE, number / EDGE % EDGE, number / (EDGE * EDGE)];
            std::array::from_fn(|axis| middle[axis] + 2.0 * RADIUS * f64::from(at[axis] - EDGE / 2))
        })
    });
    let spheres: Vec<_> = (blocks.chain(lone.iter().copied()))
        .map(|centre: [f64; 3]| Sphere { centre: centre.into(), radius: RADIUS })
        .collect();
    let grains = spheres.len();
    let world = World { ids: (0..grains as u32).collect(), spheres, ..pattern };
    let boxes = BoxGrid::new(&world.domain, &world.period, grains, RADIUS, REACH - 2.0 * RADIUS);
    let mut grid = CellGrid::new(&boxes, grains, REACH);
    grid.sort(&world, &Team::default());
    let (mut comparisons, mut found) = (0, Neighbourhood::default());
    for number in 0..grid.boxes().boxes() {
        let surroundings = grid.surroundings(number);
        for cell in 0..grid.cells_of_box() {
            grid.neighbourhood(&surroundings, cell, &mut found);
            let own = found.home.len();
            let others: usize = found.runs().iter().map(|(run, _)| run.len()).sum();
            comparisons += own * own.saturating_sub(1) / 2 + own * if own > 0 { others } else { 0 };
        }
    }
    Work { boxes: grid.boxes().boxes(), cells: grid.start.len() - 1, comparisons }
}

/// Grains far from the rest, in all directions and at all distances.
fn scattered(count: usize) -> Vec<[f64; 3]> {
    (0..count)
        .map(|number| {
            let (angle, far) = (number as f64, 10.0 * 1.3_f64.powi(number as i32 % 40));
            [far * angle.cos(), far * angle.sin(), far * (2.3 * angle).sin()]
        })
        .collect()
}

#[test]
fn an_empty_domain_and_lone_grains_cost_nothing() {
    let tight = work(0.1, &[[0.0; 3]], &[]);
    let grains = (EDGE * EDGE * EDGE) as usize;
    assert!(tight.comparisons < 60 * grains, "{tight:?}");
    for half in [0.5, 1.0, 3.0, 1e3, 9e5] {
        let wide = work(half, &[[0.0; 3]], &[]);
        assert!(wide.comparisons * 10 <= tight.comparisons * 12, "{half} m: {wide:?}, {tight:?}");
        assert!(wide.boxes <= 64 + grains / 4 && wide.cells <= 10 * grains, "{half} m: {wide:?}");
    }
    let lone = work(9e5, &[[0.0; 3]], &scattered(1));
    assert!(lone.comparisons * 10 <= tight.comparisons * 12, "one escaped: {lone:?}, {tight:?}");
    let lone = work(9e5, &[[0.0; 3]], &scattered(100));
    assert!(lone.comparisons * 10 <= tight.comparisons * 20, "a hundred: {lone:?}, {tight:?}");
    let fled = work(0.1, &[[0.0; 3]], &scattered(400));
    assert!(fled.comparisons <= tight.comparisons * 6, "four hundred outside: {fled:?}, {tight:?}");
    let two = work(9e5, &[[0.0; 3], [7e5, -3e5, 20.0]], &[]);
    assert!(two.comparisons * 10 <= 2 * tight.comparisons * 12, "two blocks: {two:?}, {tight:?}");
    // Grains that are everywhere apart share wider boxes, and are compared with none.
    let gas = work(9e5, &[], &scattered(8_000));
    assert!(gas.boxes < 2_000 && gas.cells <= 10 * 8_000, "{gas:?}");
}
