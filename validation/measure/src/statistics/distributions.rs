//! Distributions of values: inequality, and values of a given rank.
//!
//! Measures of inequality are independent of the values' unit, and NaN without values. For an exponential distribution they are
//! 1 - 1/e = 0.632, 1/2, 2 and 1 - 2/e = 0.264, in the order below.

use super::ensemble::mean;

/// Returns the fraction of the values below their mean.
pub fn share_below_mean(values: &[f64]) -> f64 {
    let middle = mean(values);
    values.iter().filter(|value| **value < middle).count() as f64 / values.len() as f64
}

/// Returns the Gini coefficient: half the mean absolute difference of two values over the mean, 0 for equal values.
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

/// Returns the second moment over the square of the mean, `<f^2>/<f>^2`.
pub fn second_moment(values: &[f64]) -> f64 {
    let middle = mean(values);
    values.iter().map(|value| value * value).sum::<f64>() / (values.len() as f64 * middle * middle)
}

/// Returns the fraction of the sum that the values below the mean contribute.
pub fn weak_load_share(values: &[f64]) -> f64 {
    let middle = mean(values);
    let weak: f64 = values.iter().filter(|value| **value < middle).sum();
    weak / values.iter().sum::<f64>()
}

/// Bits of a number determined per pass.
const DIGIT: u32 = 16;

/// Returns the number of a rank, from 0 for the smallest, among the numbers from `each`: none of them negative, and more of them
/// than the rank. `each` is called four times and must give the same numbers each time; they are counted, not stored.
///
/// # Errors
/// Errors of `each`.
pub fn ranked<E>(rank: u64, mut each: impl FnMut(&mut dyn FnMut(f64)) -> Result<(), E>) -> Result<f64, E> {
    // The bits of non-negative numbers have the order of the numbers: each pass determines one digit.
    let (mut known, mut left) = (0_u64, rank);
    for shift in [3 * DIGIT, 2 * DIGIT, DIGIT, 0] {
        let mut counts = vec![0_u64; 1 << DIGIT];
        each(&mut |number| {
            let bits = number.to_bits() >> shift;
            if bits >> DIGIT == known {
                counts[(bits & ((1 << DIGIT) - 1)) as usize] += 1;
            }
        })?;
        let mut digit = 0;
        while left >= counts[digit] && digit + 1 < counts.len() {
            left -= counts[digit];
            digit += 1;
        }
        known = known << DIGIT | digit as u64;
    }
    Ok(f64::from_bits(known))
}

#[cfg(test)]
#[path = "../../tests/unit/statistics_distributions.rs"]
mod tests;
