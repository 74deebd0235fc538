//! Unit tests of `src/detect/drift.rs`.

use super::*;

fn bounds(points: &[[f64; 3]]) -> Bounds {
    let mut bounds = Bounds::EMPTY;
    points.iter().for_each(|point| bounds.add(Vector3::from(*point)));
    bounds
}

#[test]
fn bounds_cover_every_pair_of_displacements() {
    let a = bounds(&[[0.0, 0.0, 0.0], [1.0, 0.0, 0.0]]);
    let b = bounds(&[[3.0, 4.0, 0.0]]);
    assert_eq!(a.largest_distance_squared(&b), 25.0);
    assert_eq!(a.largest_distance_squared(&a), 1.0);
    assert_eq!(b.largest_distance_squared(&b), 0.0, "what moves together comes no closer");
    assert_eq!(b.largest_squared(), 25.0);
    assert!(Bounds::EMPTY.is_empty() && !a.is_empty());
    assert_eq!(a.moved([b, Bounds::EMPTY].iter()), Moved { shift: 1.0, approach: 5.0 });
    assert_eq!(Bounds::EMPTY.moved([a, b].iter()), Moved::default(), "where no grain is");
    let both = a.with(&b).with(&Bounds::EMPTY);
    assert_eq!(both.moved(std::iter::empty()), Moved { shift: 5.0, approach: 5.0 }, "bounds of all hold everything");
}
