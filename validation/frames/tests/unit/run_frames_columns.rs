//! Unit tests of `src/run_frames/columns.rs`.

use super::*;

#[test]
fn coordinates_far_from_the_origin_keep_their_places() {
    let at = |x: f64| Column::coordinates("Points", vec![x, 0.0, 0.0, x + 0.01, 0.0, 0.0], 0.005);
    let far = at(9e5);
    assert_eq!((far.number, &far.values[..]), (Number::Float64, &[9e5, 0.0, 0.0, 9e5 + 0.01, 0.0, 0.0][..]));
    assert_eq!(at(0.2).number, Number::Float32, "near the origin single precision tells them apart");
}
