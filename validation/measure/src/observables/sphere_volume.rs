//! Exact volume of the part of a sphere that lies in an axis-aligned box.
//!
//! The box is a signed sum of octants {X > a, Y > b, Z > c}, so one formula for an octant suffices. Take the
//! unit ball centred at the origin with the corner (a, b, c) inside it. By the divergence theorem the volume is
//!
//! ```text
//! V = (S - a A_a - b A_b - c A_c) / 3
//! ```
//!
//! where A_a is the flat face in X = a and S the curved face. A_a is a disc of radius sqrt(1 - a^2) cut by Y > b,
//! Z > c; the same theorem in the plane gives A_a = (r_a^2 phi_a - b L_b - c L_c) / 2, with phi_a the angle of its arc
//! and L the lengths of its straight sides. S follows from Gauss and Bonnet: 2 pi less the turning at its three
//! corners, less the geodesic curvature of its three arcs, which is a phi_a for the circle in X = a. Two circles cross
//! at the angle whose cosine is -a b / (r_a r_b). Negative coordinates are mirrored: V(a,b,c) = V(b,c) - V(-a,b,c).
//! The angles are computed with atan2, which has full accuracy where arccosine would lose half the digits.

use makadam::lanes::Number;
use std::f64::consts::{FRAC_PI_2, FRAC_PI_4, PI, SQRT_2, TAU};

/// Returns the volume of a sphere, m3.
pub fn sphere(radius: f64) -> f64 {
    4.0 / 3.0 * PI * radius.powi(3)
}

/// Returns the volume (m3) of the part of a sphere in the box between the corners `min` and `max`; bounds may be infinite.
/// Absolute error: some 1e-15 of the sphere's volume.
pub fn sphere_in_box(centre: [f64; 3], radius: f64, min: [f64; 3], max: [f64; 3]) -> f64 {
    let low: [f64; 3] = std::array::from_fn(|axis| (min[axis] - centre[axis]) / radius);
    let high: [f64; 3] = std::array::from_fn(|axis| (max[axis] - centre[axis]) / radius);
    if (0..3).any(|axis| low[axis] >= 1.0 || high[axis] <= -1.0 || low[axis] >= high[axis]) {
        return 0.0;
    }
    if (0..3).all(|axis| low[axis] <= -1.0 && high[axis] >= 1.0) {
        return sphere(radius);
    }
    let mut volume = 0.0;
    for corner in 0..8_usize {
        let pick = |axis: usize| if corner >> axis & 1 == 0 { low[axis] } else { high[axis] };
        let sign = if corner.count_ones() % 2 == 0 { 1.0 } else { -1.0 };
        volume += sign * octant(pick(0), pick(1), pick(2));
    }
    volume.max(0.0) * radius.powi(3)
}

/// Returns the volume of the unit ball beyond the plane X = a.
#[inline(always)]
pub fn half_space<N: Number>(a: N) -> N {
    let one = N::splat(1.0);
    let a = a.larger(-one).smaller(one);
    N::splat(PI / 3.0) * ((one - a) * (one - a)) * (N::splat(2.0) + a)
}

/// Returns the volume of the unit ball in the quadrant X > a, Y > b.
#[inline(always)]
pub fn quadrant<N: Number>(a: N, b: N) -> N {
    let (zero, one, two, half) = (N::zero(), N::splat(1.0), N::splat(2.0), N::splat(0.5));
    let (x, y) = (a.abs(), b.abs());
    let square = one - x * x - y * y;
    let w = square.larger(zero).sqrt();
    let (half_a, half_b) = (angle(w, y), angle(w, x));
    let (arc_a, arc_b) = (two * half_a, two * half_b);
    let curved = two * angle(w, x * y) - x * arc_a - y * arc_b;
    let face_a = half * (one - x * x) * arc_a - y * w;
    let face_b = half * (one - y * y) * arc_b - x * w;
    let corner = (curved - x * face_a - y * face_b) / N::splat(3.0);
    let corner = N::select(square.at_most(zero), zero, corner);
    // Mirrored, first in Y, then in X.
    let beyond = N::select(b.below(zero), half_space(x) - corner, corner);
    N::select(a.below(zero), half_space(b) - beyond, beyond)
}

/// Returns the angle in the first quadrant with tangent `y / x`, both positive or zero. Absolute error: some 2e-16.
///
/// Angles above 22.5 degrees are computed from 45 degrees; the arctangent is then a minimax polynomial. Unlike the system's function it works on
/// lanes, and gives the same bits on every processor.
#[inline(always)]
fn angle<N: Number>(y: N, x: N) -> N {
    /// Coefficients of (atan(u)/u - 1) / u^2 in powers of u^2 from the highest, for |u| below tan 22.5; relative error of atan(u) 4e-17.
    const SERIES: [f64; 10] = [
        0.021280192555442355,
        -0.04360829784095313,
        0.056931664315277374,
        -0.06641246581733311,
        0.07690083396171621,
        -0.0909078353178512,
        0.11111106703701282,
        -0.14285714196530166,
        0.19999999999104698,
        -0.3333333333333022,
    ];
    let (low, high) = (y.smaller(x), y.larger(x));
    let is_steep = (N::splat(SQRT_2 - 1.0) * high).below(low);
    let u = N::select(is_steep, low - high, low) / N::select(is_steep, low + high, high);
    let square = u * u;
    let mut series = N::splat(SERIES[0]);
    for next in &SERIES[1..] {
        series = series * square + N::splat(*next);
    }
    let from_axis = N::select(is_steep, N::splat(FRAC_PI_4), N::zero()) + (u + u * square * series);
    N::select(y.below(x), from_axis, N::splat(FRAC_PI_2) - from_axis)
}

/// Returns the volume of the unit ball in the octant X > a, Y > b, Z > c.
pub fn octant(a: f64, b: f64, c: f64) -> f64 {
    if a < 0.0 {
        return quadrant(b, c) - octant(-a, b, c);
    }
    if b < 0.0 {
        return quadrant(a, c) - octant(a, -b, c);
    }
    if c < 0.0 {
        return quadrant(a, b) - octant(a, b, -c);
    }
    if 1.0 - a * a - b * b - c * c <= 0.0 {
        return 0.0;
    }
    // Third coordinate of the point at which the edge of two faces pierces the sphere.
    let on_edge = |x: f64, y: f64| (1.0 - x * x - y * y).sqrt();
    let (ab, bc, ca) = (on_edge(a, b), on_edge(b, c), on_edge(c, a));
    let arc_a = ab.atan2(b) - c.atan2(ca);
    let arc_b = bc.atan2(c) - a.atan2(ab);
    let arc_c = ca.atan2(a) - b.atan2(bc);
    let turning = ab.atan2(-a * b) + bc.atan2(-b * c) + ca.atan2(-c * a);
    let curved = TAU - turning - a * arc_a - b * arc_b - c * arc_c;
    let face_a = 0.5 * ((1.0 - a * a) * arc_a - b * (ab - c) - c * (ca - b));
    let face_b = 0.5 * ((1.0 - b * b) * arc_b - c * (bc - a) - a * (ab - c));
    let face_c = 0.5 * ((1.0 - c * c) * arc_c - a * (ca - b) - b * (bc - a));
    (curved - a * face_a - b * face_b - c * face_c) / 3.0
}
