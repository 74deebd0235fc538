//! Fits by least squares.

use nalgebra::{Matrix3, Vector3};

/// Slope and intercept of the least-squares line through points; not numbers if they do not define one.
pub(super) fn line(points: &[[f64; 2]]) -> (f64, f64) {
    let count = points.len() as f64;
    let mean = |axis: usize| points.iter().map(|point| point[axis]).sum::<f64>() / count;
    let (x, y) = (mean(0), mean(1));
    let product: f64 = points.iter().map(|point| (point[0] - x) * (point[1] - y)).sum();
    let square: f64 = points.iter().map(|point| (point[0] - x).powi(2)).sum();
    let slope = product / square;
    (slope, y - slope * x)
}

/// Value at zero of the least-squares line through points, and its standard error from the scatter about the line, with two degrees
/// of freedom fewer than points. `None` for fewer than three points.
pub(super) fn at_zero(points: &[[f64; 2]]) -> Option<(f64, f64)> {
    if points.len() < 3 {
        return None;
    }
    let count = points.len() as f64;
    let (slope, intercept) = line(points);
    let scatter = points.iter().map(|[x, y]| (y - intercept - slope * x).powi(2)).sum::<f64>() / (count - 2.0);
    let middle = points.iter().map(|[x, _]| x).sum::<f64>() / count;
    let square: f64 = points.iter().map(|[x, _]| (x - middle).powi(2)).sum();
    Some((intercept, (scatter * (1.0 / count + middle * middle / square)).sqrt()))
}

/// Value at zero of the least-squares parabola through points; `None` if they do not define one.
pub(super) fn parabola_at_zero(points: &[[f64; 2]]) -> Option<f64> {
    // In units of the largest x, so that the normal equations are of order one.
    let unit = points.iter().map(|[x, _]| x.abs()).fold(0.0, f64::max);
    let (mut normal, mut right) = (Matrix3::zeros(), Vector3::zeros());
    for [x, y] in points {
        let powers = Vector3::new(1.0, x / unit, (x / unit).powi(2));
        normal += powers * powers.transpose();
        right += powers * *y;
    }
    let solution = normal.cholesky().map(|factor| factor.solve(&right));
    solution.filter(|_| points.len() >= 3).map(|coefficients| coefficients[0])
}

/// Minimum of a function of one variable that falls and then rises, between two bounds: golden section.
pub(super) fn least(function: impl Fn(f64) -> f64, mut low: f64, mut high: f64) -> f64 {
    let share = 0.5 * (5f64.sqrt() - 1.0);
    let (mut a, mut b) = (high - share * (high - low), low + share * (high - low));
    let (mut at_a, mut at_b) = (function(a), function(b));
    while high - low > 1e-10 * (low.abs() + high.abs()) {
        if at_a < at_b {
            (high, b, at_b) = (b, a, at_a);
            a = high - share * (high - low);
            at_a = function(a);
        } else {
            (low, a, at_a) = (a, b, at_b);
            b = low + share * (high - low);
            at_b = function(b);
        }
        if a >= b {
            break;
        }
    }
    0.5 * (low + high)
}

#[cfg(test)]
#[path = "../../tests/unit/laws_fit.rs"]
mod tests;
