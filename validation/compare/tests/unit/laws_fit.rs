//! Unit tests of `src/laws/results.rs`.

use super::*;
use approx::assert_relative_eq;

#[test]
fn a_line_is_found() {
    let (slope, intercept) = line(&[[1.0, 1.0], [2.0, 3.5], [4.0, 8.5]]);
    assert_relative_eq!(slope, 2.5, max_relative = 1e-12);
    assert_relative_eq!(intercept, -1.5, max_relative = 1e-12);
    assert!(line(&[[1.0, 1.0]]).0.is_nan());
}

#[test]
fn a_line_at_zero_has_an_error_that_comes_from_the_scatter() {
    let (value, error) = at_zero(&[[1.0, 1.0], [2.0, 3.5], [4.0, 8.5]]).unwrap();
    assert_relative_eq!(value, -1.5, max_relative = 1e-12);
    assert!(error < 1e-12);
    // y = 1 at x = 1 and 3, 4 at 2: the line is y = 2 with a scatter of 6, and 1/3 + 4/2 of it reach zero.
    let (value, error) = at_zero(&[[1.0, 1.0], [2.0, 4.0], [3.0, 1.0]]).unwrap();
    assert_relative_eq!(value, 2.0, max_relative = 1e-12);
    assert_relative_eq!(error, 14f64.sqrt(), max_relative = 1e-12);
    assert!(at_zero(&[[1.0, 1.0], [2.0, 4.0]]).is_none());
}

#[test]
fn the_least_value_is_found() {
    assert_relative_eq!(least(|x| (x - 1.4).powi(2), 0.0, 9.0), 1.4, max_relative = 1e-7);
    assert_relative_eq!(least(|x| x, 2.0, 3.0), 2.0, max_relative = 1e-7);
}
