//! How unequal positive values are: numbers that tell one distribution of contact forces from another.
//!
//! All are free of the values' unit. For an exponential distribution they are 1 - 1/e = 0.632, 1/2, 2 and
//! 1 - 2/e = 0.264, in the order below. All are NaN for no values.

use super::ensemble::mean;

/// Share of the values that lie below their mean.
pub fn share_below_mean(values: &[f64]) -> f64 {
    let middle = mean(values);
    values.iter().filter(|value| **value < middle).count() as f64 / values.len() as f64
}

/// Gini coefficient: half the mean absolute difference of two values over the mean, 0 for equal values.
///
/// From sorted values x_1 to x_n: sum of (2 i - n - 1) x_i over n sum x.
pub fn gini(values: &[f64]) -> f64 {
    let mut sorted = values.to_vec();
    sorted.sort_by(f64::total_cmp);
    let count = sorted.len() as f64;
    let ranked: f64 =
        sorted.iter().enumerate().map(|(index, value)| (2.0 * (index as f64 + 1.0) - count - 1.0) * value).sum();
    ranked / (count * sorted.iter().sum::<f64>())
}

/// Second moment over the square of the mean, `<f^2>/<f>^2`.
pub fn second_moment(values: &[f64]) -> f64 {
    let middle = mean(values);
    values.iter().map(|value| value * value).sum::<f64>() / (values.len() as f64 * middle * middle)
}

/// Share of the sum that the values below the mean make up.
pub fn weak_load_share(values: &[f64]) -> f64 {
    let middle = mean(values);
    let weak: f64 = values.iter().filter(|value| **value < middle).sum();
    weak / values.iter().sum::<f64>()
}
