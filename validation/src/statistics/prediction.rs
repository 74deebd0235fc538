//! Does a live run lie where recorded runs say that it should?

use super::ensemble::{Ensemble, student_quantile};

/// Confidence of all values of live runs together: where nothing has changed, one qualification in a hundred has a value outside.
///
/// It is high on purpose: a false alarm costs trust.
pub const CONFIDENCE: f64 = 0.99;

/// Confidence of each of so many values by which all of them together have [`CONFIDENCE`] at least (Bonferroni; the values of one run
/// are not independent).
pub fn confidence_of_each(values: usize) -> f64 {
    1.0 - (1.0 - CONFIDENCE) / values.max(1) as f64
}

/// The interval in which a live value was expected, and whether it was there.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Spread {
    /// The interval.
    pub interval: [f64; 2],
    /// Whether the live value lies inside.
    pub inside: bool,
}

/// Interval that holds the mean of `live_seeds` more seeds with probability `confidence`, given recorded ones:
/// mean +- t s sqrt(1/m + 1/n), with t Student's quantile for n - 1 degrees of freedom.
///
/// Absent for fewer than two recorded values.
pub fn prediction_interval(recorded: &[f64], live_seeds: usize, confidence: f64) -> Option<[f64; 2]> {
    let ensemble = Ensemble::of(recorded).filter(|ensemble| ensemble.seeds >= 2 && live_seeds >= 1)?;
    let quantile = student_quantile(0.5 * (1.0 + confidence), (ensemble.seeds - 1) as f64);
    let half = quantile * ensemble.standard_deviation * (1.0 / live_seeds as f64 + 1.0 / ensemble.seeds as f64).sqrt();
    Some([ensemble.mean - half, ensemble.mean + half])
}

/// Whether the value of one more seed lies in the interval that recorded seeds predict with `confidence`. The seed must be none of those
/// recorded: a value lies among others of which it is one.
///
/// Absent for fewer than two recorded values.
pub fn inside_recorded_spread(live: f64, recorded: &[f64], confidence: f64) -> Option<Spread> {
    let interval = prediction_interval(recorded, 1, confidence)?;
    Some(Spread { interval, inside: (interval[0]..=interval[1]).contains(&live) })
}
