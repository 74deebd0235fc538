//! Means with their errors: over seeds, over blocks of time, and prediction intervals for further seeds.

use serde::{Deserialize, Serialize};
use statrs::distribution::{ContinuousCDF, StudentsT};

/// Mean and spread of one quantity over seeds.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Ensemble {
    /// Number of seeds; 0 for a published value, which is compared as it is.
    pub seeds: usize,
    /// Mean over seeds.
    pub mean: f64,
    /// Standard deviation over seeds (n - 1 in the denominator); 0 for a single seed, whose spread is unknown.
    pub standard_deviation: f64,
}

impl Ensemble {
    /// Returns the ensemble of one value per seed; `None` without values.
    pub fn of(values: &[f64]) -> Option<Ensemble> {
        (!values.is_empty()).then(|| Ensemble {
            seeds: values.len(),
            mean: mean(values),
            standard_deviation: standard_deviation(values).unwrap_or(0.0),
        })
    }

    /// Returns a published value: a number without a spread.
    pub fn published(value: f64) -> Ensemble {
        Ensemble { seeds: 0, mean: value, standard_deviation: 0.0 }
    }

    /// Returns the 90% interval of the mean, by Student's t; `None` for a single seed.
    pub fn interval90(&self) -> Option<[f64; 2]> {
        if self.seeds < 2 {
            return None;
        }
        let half =
            student_quantile(0.95, (self.seeds - 1) as f64) * self.standard_deviation / (self.seeds as f64).sqrt();
        Some([self.mean - half, self.mean + half])
    }
}

/// Returns the arithmetic mean; NaN without values.
pub fn mean(values: &[f64]) -> f64 {
    values.iter().sum::<f64>() / values.len() as f64
}

/// Returns the median of a few numbers; NaN without numbers.
pub fn median(values: impl IntoIterator<Item = f64>) -> f64 {
    let mut values: Vec<f64> = values.into_iter().collect();
    values.sort_by(f64::total_cmp);
    match (values.len(), values.len() / 2) {
        (0, _) => f64::NAN,
        (length, middle) if length % 2 == 1 => values[middle],
        (_, middle) => 0.5 * (values[middle - 1] + values[middle]),
    }
}

/// Returns the standard deviation with n - 1 in the denominator; `None` for fewer than two values.
pub fn standard_deviation(values: &[f64]) -> Option<f64> {
    let middle = mean(values);
    let squares: f64 = values.iter().map(|value| (value - middle).powi(2)).sum();
    (values.len() >= 2).then(|| (squares / (values.len() - 1) as f64).sqrt())
}

/// Returns the standard error of the mean of independent values; `None` for fewer than two.
pub fn standard_error(values: &[f64]) -> Option<f64> {
    Some(standard_deviation(values)? / (values.len() as f64).sqrt())
}

/// Returns the quantile of Student's t with `freedom` degrees of freedom (above 0) at `probability`.
pub fn student_quantile(probability: f64, freedom: f64) -> f64 {
    match StudentsT::new(0.0, 1.0, freedom) {
        Ok(student) => student.inverse_cdf(probability),
        Err(_) => f64::NAN,
    }
}

const FEWEST_FRAMES: usize = 4;

/// Largest number of blocks: few and long blocks are nearly uncorrelated.
const MOST_BLOCKS: usize = 5;

/// Mean over time.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Average {
    /// Mean of all values.
    pub mean: f64,
    /// Standard error of the mean, from the spread of the means of blocks; absent for fewer than 8 values.
    pub standard_error: Option<f64>,
}

/// Returns the number of blocks for `frames` frames: five, or fewer so that a block holds at least four frames;
/// `None` for fewer than two blocks.
pub fn block_count(frames: usize) -> Option<usize> {
    let blocks = (frames / FEWEST_FRAMES).min(MOST_BLOCKS);
    (blocks >= 2).then_some(blocks)
}

/// Returns the mean of consecutive values with the standard error over blocks of time (method of batch means).
///
/// Blocks are as equal in length as the number of values allows.
pub fn block_average(values: &[f64]) -> Average {
    let blocks = block_count(values.len()).map(|blocks| {
        let part = |block: usize| &values[block * values.len() / blocks..(block + 1) * values.len() / blocks];
        (0..blocks).map(|block| mean(part(block))).collect::<Vec<f64>>()
    });
    Average { mean: mean(values), standard_error: blocks.and_then(|means| standard_error(&means)) }
}

/// Joint confidence of all values of live runs: without any change, one qualification in a hundred has a value outside.
///
/// The level is deliberately high: false alarms reduce trust.
pub const CONFIDENCE: f64 = 0.99;

/// Returns the confidence per value for a joint confidence of at least [`CONFIDENCE`] over `values` values (Bonferroni; the values of one
/// run are not independent).
pub fn confidence_of_each(values: usize) -> f64 {
    1.0 - (1.0 - CONFIDENCE) / values.max(1) as f64
}

/// Returns the interval that holds the mean of `live_seeds` more seeds with probability `confidence`, given recorded values:
/// mean +- t s sqrt(1/m + 1/n), with t Student's quantile for n - 1 degrees of freedom.
///
/// `None` for fewer than two recorded values.
pub fn prediction_interval(recorded: &[f64], live_seeds: usize, confidence: f64) -> Option<[f64; 2]> {
    let ensemble = Ensemble::of(recorded).filter(|ensemble| ensemble.seeds >= 2 && live_seeds >= 1)?;
    let quantile = student_quantile(0.5 * (1.0 + confidence), (ensemble.seeds - 1) as f64);
    let half = quantile * ensemble.standard_deviation * (1.0 / live_seeds as f64 + 1.0 / ensemble.seeds as f64).sqrt();
    Some([ensemble.mean - half, ensemble.mean + half])
}
