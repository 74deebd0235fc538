//! Do two codes agree? Two one-sided tests on the difference of their means.
//!
//! "Not significantly different" is no agreement: with few seeds everything is. The margin is fixed beforehand, and
//! two codes agree if and only if an interval of the difference lies inside it. The interval is Welch's: the
//! spreads need not be equal. At a significance alpha of each one-sided test the interval covers 1 - 2 alpha (Schuirmann,
//! J. Pharmacokinet. Biopharm. 15, 657, 1987). With k codes alpha = 0.05/(k - 1) (Bonferroni), so that all
//! comparisons of one code with its peers together err in no more than 5%.

use super::ensemble::{Ensemble, student_quantile};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use statrs::distribution::{ContinuousCDF, Normal};

/// Significance of the whole family of one-sided tests.
const SIGNIFICANCE: f64 = 0.05;

/// Power for which seeds are counted: normal quantile 1.28.
const POWER: f64 = 0.9;

/// Verdict of the equivalence test.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Outcome {
    /// The interval of the difference lies inside the margin.
    Agree,
    /// The interval of the difference lies outside the margin.
    Disagree,
    /// The interval straddles the margin: too few seeds to tell.
    Undecided,
    /// One of the codes has no value of the observable, or one of fewer seeds than it was run with: there is no test.
    NotMeasured,
}

/// The difference of two ensembles and the verdict on it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Equivalence {
    /// Mean of the first minus mean of the second.
    pub difference: f64,
    /// Its 90% interval (Welch); absent where one ensemble has a single seed.
    pub interval90: Option<[f64; 2]>,
    /// The interval that the verdict rests on: 1 - 2 alpha.
    pub interval_of_verdict: Option<[f64; 2]>,
    /// Verdict; absent without a margin.
    pub outcome: Option<Outcome>,
    /// Seeds a code that would decide, where the outcome is undecided and the spread is known.
    pub seeds_needed: Option<usize>,
}

/// Compares two ensembles of one quantity, `codes` codes being compared in all.
///
/// Agree: the interval of the verdict lies inside the margin. Disagree: it lies outside, on one side. Undecided: it
/// straddles the margin, or an ensemble has a single seed.
pub fn equivalence(first: &Ensemble, second: &Ensemble, margin: Option<f64>, codes: usize) -> Equivalence {
    let alpha = SIGNIFICANCE / (codes.max(2) - 1) as f64;
    let difference = first.mean - second.mean;
    let interval =
        |alpha: f64| welch_half_width(first, second, alpha).map(|half| [difference - half, difference + half]);
    let interval_of_verdict = interval(alpha);
    let outcome = margin.map(|margin| match interval_of_verdict {
        Some([low, high]) if -margin < low && high < margin => Outcome::Agree,
        Some([low, high]) if low >= margin || high <= -margin => Outcome::Disagree,
        _ => Outcome::Undecided,
    });
    let seeds_needed = match (outcome, margin, interval_of_verdict) {
        (Some(Outcome::Undecided), Some(margin), Some(_)) => {
            let variance = 0.5 * (first.standard_deviation.powi(2) + second.standard_deviation.powi(2));
            // The formula supposes equal means; where it is already met, chance or a true difference wants one more.
            Some(seeds_needed(variance.sqrt(), margin, alpha).max(first.seeds.min(second.seeds) + 1))
        }
        _ => None,
    };
    Equivalence { difference, interval90: interval(SIGNIFICANCE), interval_of_verdict, outcome, seeds_needed }
}

/// Half the width of Welch's interval of the difference, at `alpha` on each side; absent for a single seed.
fn welch_half_width(first: &Ensemble, second: &Ensemble, alpha: f64) -> Option<f64> {
    if first.seeds < 2 || second.seeds < 2 {
        return None;
    }
    let share = |ensemble: &Ensemble| ensemble.standard_deviation.powi(2) / ensemble.seeds as f64;
    let (a, b) = (share(first), share(second));
    if a + b <= 0.0 {
        return Some(0.0);
    }
    // Welch & Satterthwaite.
    let freedom = (a + b).powi(2) / (a * a / (first.seeds - 1) as f64 + b * b / (second.seeds - 1) as f64);
    Some(student_quantile(1.0 - alpha, freedom) * (a + b).sqrt())
}

/// Seeds a code that let equal codes of standard deviation `deviation` pass the margin with 90% probability at `alpha` on
/// each side: n = 2 (z_alpha + 1.28)^2 s^2 / margin^2, with z = 1.645 at 5%.
pub fn seeds_needed(deviation: f64, margin: f64, alpha: f64) -> usize {
    let normal = Normal::standard();
    let reach = normal.inverse_cdf(1.0 - alpha) + normal.inverse_cdf(POWER);
    let seeds = 2.0 * (reach * deviation / margin).powi(2);
    (seeds.ceil() as usize).max(2)
}
