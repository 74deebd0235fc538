//! Unit tests of `src/observables/static_angle.rs`.

use super::*;
use crate::statistics::mean;
use approx::assert_relative_eq;

#[test]
fn ball_of_points_has_the_moments_of_a_ball() {
    let ball = unit_ball();
    assert_relative_eq!(mean(&ball.iter().map(|p| p.x).collect::<Vec<_>>()), 0.0, epsilon = 1e-12);
    let square = mean(&ball.iter().map(|p| p.norm_squared()).collect::<Vec<_>>());
    assert_relative_eq!(square, 0.6, epsilon = 0.02);
}

#[test]
fn a_flank_has_the_angle_of_its_slope() {
    for degrees in [5.0_f64, 20.0, 35.0, 60.0] {
        let height = 20.0 * degrees.to_radians().tan();
        let cone = vec![[-20.0, 0.0], [20.0, 0.0], [0.0, height]];
        assert_relative_eq!(flank_angle(&cone, 0.5).unwrap(), degrees, max_relative = 1e-12);
    }
}
