//! Unit tests of `src/observables/packing_fraction.rs`.

use super::*;

#[test]
fn cubes_of_a_range_are_found_either_way_in_one_order() {
    let cubes: HashSet<[i64; 3]> = in_range([-3, -2, -1], [1, 2, 3]).filter(|[x, y, z]| (x + y * z) % 3 != 0).collect();
    let (low, high) = ([-5, -1, 0], [0, 4, 2]);
    let counted: Vec<[i64; 3]> = in_range(low, high).filter(|cube| cubes.contains(cube)).collect();
    assert!(counted.len() > 10);
    assert_eq!(among(&cubes, low, high), counted);
}
