//! Runs of one code that differ by their seed.

use serde::{Deserialize, Serialize};
use statrs::distribution::{ContinuousCDF, StudentsT};

/// Mean and spread of one quantity over seeds.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Ensemble {
    /// Number of seeds.
    pub seeds: usize,
    /// Mean over seeds.
    pub mean: f64,
    /// Standard deviation over seeds (n - 1 in the denominator); 0 for a single seed, whose spread is unknown.
    pub standard_deviation: f64,
}

impl Ensemble {
    /// The ensemble of one value a seed; absent for no values.
    pub fn of(values: &[f64]) -> Option<Ensemble> {
        (!values.is_empty()).then(|| Ensemble {
            seeds: values.len(),
            mean: mean(values),
            standard_deviation: standard_deviation(values).unwrap_or(0.0),
        })
    }

    /// The 90% interval of the mean, by Student's t; absent for a single seed.
    pub fn interval90(&self) -> Option<[f64; 2]> {
        if self.seeds < 2 {
            return None;
        }
        let half =
            student_quantile(0.95, (self.seeds - 1) as f64) * self.standard_deviation / (self.seeds as f64).sqrt();
        Some([self.mean - half, self.mean + half])
    }
}

/// Arithmetic mean; NaN for no values.
pub fn mean(values: &[f64]) -> f64 {
    values.iter().sum::<f64>() / values.len() as f64
}

/// Median of a few numbers; not a number if there are none.
pub fn median(values: impl IntoIterator<Item = f64>) -> f64 {
    let mut values: Vec<f64> = values.into_iter().collect();
    values.sort_by(f64::total_cmp);
    match (values.len(), values.len() / 2) {
        (0, _) => f64::NAN,
        (length, middle) if length % 2 == 1 => values[middle],
        (_, middle) => 0.5 * (values[middle - 1] + values[middle]),
    }
}

/// Standard deviation with n - 1 in the denominator; absent for fewer than two values.
pub fn standard_deviation(values: &[f64]) -> Option<f64> {
    let middle = mean(values);
    let squares: f64 = values.iter().map(|value| (value - middle).powi(2)).sum();
    (values.len() >= 2).then(|| (squares / (values.len() - 1) as f64).sqrt())
}

/// Standard error of the mean of independent values; absent for fewer than two.
pub fn standard_error(values: &[f64]) -> Option<f64> {
    Some(standard_deviation(values)? / (values.len() as f64).sqrt())
}

/// The value that Student's t with `freedom` degrees of freedom (above 0) stays below with probability `probability`.
pub fn student_quantile(probability: f64, freedom: f64) -> f64 {
    match StudentsT::new(0.0, 1.0, freedom) {
        Ok(student) => student.inverse_cdf(probability),
        Err(_) => f64::NAN,
    }
}
