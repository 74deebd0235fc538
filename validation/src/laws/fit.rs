//! Fits by least squares.

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

/// Where a function of one variable that falls and then rises is least, between two bounds: golden section.
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
mod tests {
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
    fn the_least_value_is_found() {
        assert_relative_eq!(least(|x| (x - 1.4).powi(2), 0.0, 9.0), 1.4, max_relative = 1e-7);
        assert_relative_eq!(least(|x| x, 2.0, 3.0), 2.0, max_relative = 1e-7);
    }
}
