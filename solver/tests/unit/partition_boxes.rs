//! Unit tests of `src/partition/boxes.rs`.

use super::*;

#[test]
fn full_boxes_are_numbered_first() {
    let step = |at: [i32; 3], towards: [i32; 3]| std::array::from_fn(|axis| at[axis] + towards[axis]);
    // Two boxes that share an edge, whose task belongs to an empty one, and one far away.
    let grains = [[1, 0, 0], [900_000, -7, -5], [0, 1, 0], [1, 0, 0]];
    let (mut occupied, mut numbers) = (Occupied::default(), [0; 4]);
    assert!(occupied.number(grains.into_iter(), &mut numbers, 3, step));
    assert_eq!(occupied.at, [[1, 0, 0], [900_000, -7, -5], [0, 1, 0], [0, 0, 0]]);
    assert_eq!(numbers, [0, 1, 2, 0]);
    let direction = |[x, y, z]: [i32; 3]| ((x + 1) + 3 * (y + 1) + 9 * (z + 1)) as usize;
    assert_eq!(occupied.neighbour(0, direction([-1, 1, 0])), Some(2));
    assert_eq!(occupied.neighbour(0, direction([-1, 0, 0])), Some(3), "home of the task between the two");
    assert_eq!(occupied.neighbour(1, direction([1, 0, 0])), None);
    assert_eq!(occupied.neighbour(1, SAME_BOX), Some(1));
    assert!(!occupied.number(grains.into_iter(), &mut numbers, 2, step), "more boxes than were asked for");
}
