//! Unit tests of `src/laws/collapse/column.rs`.

use super::*;
use makadam::scene::populate;

#[test]
fn a_quarter_has_a_quarter_of_the_grains_all_of_them_between_the_planes_and_in_the_tube() {
    let (whole, quarter) = (case(12.0, 1.0, Part::Whole), case(12.0, 1.0, Part::Quarter));
    let grains = |case: &Case| populate(&case.scene, 1).unwrap();
    let (all, some) = (grains(&whole), grains(&quarter));
    assert!((4 * some.len()).abs_diff(all.len()) <= 2, "{} of {}", some.len(), all.len());
    for grain in &some {
        let [x, y, _] = grain.position;
        assert!(x >= grain.radius && y >= grain.radius && x.hypot(y) + grain.radius <= 0.12, "{grain:?}");
    }
    // Both stand on their lattices to the same height, but for a layer.
    let top = |grains: &[makadam::scene::Grain]| grains.iter().map(|grain| grain.position[2]).fold(0.0, f64::max);
    assert!((top(&some) - top(&all)).abs() < 2.5 * DIAMETER, "{} and {}", top(&some), top(&all));
}

#[test]
fn layers_of_a_quarter_are_alike_in_all_strips() {
    let strips = strips(0.3, 1.0, 10_000);
    assert_eq!(strips.iter().map(|(count, _)| count).sum::<usize>(), 10_000);
    let sites = |region: &Region| match region {
        Region::Box { max, .. } => (max[1] / 0.01144).floor(),
        Region::Cylinder { .. } => panic!("a strip is a box"),
    };
    let layers = 10_000.0 / strips.iter().map(|(_, region)| sites(region)).sum::<f64>();
    assert!(strips.iter().all(|(count, region)| (*count as f64 - layers * sites(region)).abs() <= 1.0));
}
