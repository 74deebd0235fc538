//! Unit tests of `src/output/vtk.rs`.

use super::*;

#[test]
fn coordinates_far_from_the_origin_keep_their_places() {
    let at = |x: f64| Array::coordinates("Points", [x, 0.0, 0.0, x + 0.01, 0.0, 0.0].into_iter(), 0.005);
    let far = at(9e5);
    assert_eq!((far.kind, &far.values()[..]), (Kind::Float64, &[9e5, 0.0, 0.0, 9e5 + 0.01, 0.0, 0.0][..]));
    assert_eq!(at(0.2).kind, Kind::Float32, "near the origin single precision tells them apart");
}
