//! Equivalence of two codes: two one-sided tests on the difference of their means.
//!
//! "Not significantly different" does not mean agreement: with few seeds, hardly any difference is significant. The margin is fixed
//! beforehand, and two codes agree if and only if an interval of the difference lies inside it. The interval is Welch's: the
//! spreads need not be equal. At a significance alpha of each one-sided test the interval covers 1 - 2 alpha (Schuirmann,
//! J. Pharmacokinet. Biopharm. 15, 657, 1987). With k codes alpha = 0.05/(k - 1) (Bonferroni), so that all
//! comparisons of one code with its reference codes together err in no more than 5%.

use super::ensemble::{Ensemble, student_quantile};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use statrs::distribution::{ContinuousCDF, Normal};

/// Significance of the whole family of one-sided tests.
const SIGNIFICANCE: f64 = 0.05;

/// Power for the number of seeds needed.
const POWER: f64 = 0.9;

/// Largest difference over the margin with an estimate of the seeds needed.
const NEAR: f64 = 0.9;

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
    /// The interval of the difference lies inside the margin, of runs whose number was not registered beforehand: no agreement.
    Exploratory,
    /// One of the codes has no value of the observable, or one of fewer seeds than it was run with: there is no test.
    NotMeasured,
}

impl Outcome {
    /// Returns the text of the outcome.
    pub fn words(self) -> &'static str {
        match self {
            Outcome::Agree => "agree",
            Outcome::Disagree => "disagree",
            Outcome::Undecided => "undecided",
            Outcome::Exploratory => "exploratory",
            Outcome::NotMeasured => "not measured",
        }
    }

    /// Returns the style class of the outcome's symbol.
    pub fn class(self) -> &'static str {
        match self {
            Outcome::Agree | Outcome::Disagree => self.words(),
            Outcome::Undecided | Outcome::Exploratory | Outcome::NotMeasured => "undecided",
        }
    }
}

/// Difference of two ensembles and the verdict on it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Equivalence {
    /// Mean of the first minus mean of the second.
    pub difference: f64,
    /// 90% interval of the difference (Welch); absent if one ensemble has a single seed.
    pub interval90: Option<[f64; 2]>,
    /// Interval of the verdict: 1 - 2 alpha.
    pub interval_of_verdict: Option<[f64; 2]>,
    /// Verdict; absent without a margin.
    pub outcome: Option<Outcome>,
    /// Seeds per code for probable agreement, if the measured difference is the true one. Present if the outcome is undecided, the spread is
    /// known and the difference is not near the margin.
    pub seeds_needed: Option<usize>,
}

/// Compares two ensembles of one quantity, in a comparison of `codes` codes in total.
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
            // Without a spread of the second, twice this variance over n is that of the mean of the first.
            let variance = 0.5 * (first.standard_deviation.powi(2) + second.standard_deviation.powi(2));
            // The formula assumes a known spread; if it is already satisfied, one more seed.
            let fewest = [first.seeds, second.seeds].into_iter().filter(|seeds| *seeds > 0).min().unwrap_or(1) + 1;
            seeds_needed(variance.sqrt(), difference, margin, alpha).map(|seeds| seeds.max(fewest))
        }
        _ => None,
    };
    Equivalence { difference, interval90: interval(SIGNIFICANCE), interval_of_verdict, outcome, seeds_needed }
}

/// Returns half the width of Welch's interval of the difference, at `alpha` on each side; `None` for a single seed. A published value
/// adds no variance: the interval is Student's interval of the other mean.
fn welch_half_width(first: &Ensemble, second: &Ensemble, alpha: f64) -> Option<f64> {
    if first.seeds == 1 || second.seeds == 1 {
        return None;
    }
    let share = |ensemble: &Ensemble| ensemble.standard_deviation.powi(2) / ensemble.seeds.max(1) as f64;
    let (a, b) = (share(first), share(second));
    if a + b <= 0.0 {
        return Some(0.0);
    }
    // Welch & Satterthwaite.
    let part = |share: f64, ensemble: &Ensemble| share * share / (ensemble.seeds.max(2) - 1) as f64;
    let freedom = (a + b).powi(2) / (part(a, first) + part(b, second));
    Some(student_quantile(1.0 - alpha, freedom) * (a + b).sqrt())
}

/// Returns the fewest seeds per code with which codes of standard deviation `deviation`, with means that differ by `difference`, pass the
/// margin with 90% probability, at `alpha` on each side. Both sides must hold, so the power is
/// Phi((margin - |difference|)/e - z) + Phi((margin + |difference|)/e - z) - 1 with e = s sqrt(2/n) and z = z_alpha (Julious, Stat.
/// Med. 23, 1921, 2004). For equal codes that is n = 2 (z_alpha + 1.645)^2 s^2 / margin^2.
///
/// `None` for a difference of nine tenths of the margin or more: with more seeds, disagreement is as likely as agreement.
pub fn seeds_needed(deviation: f64, difference: f64, margin: f64, alpha: f64) -> Option<usize> {
    let apart = difference.abs();
    if apart >= NEAR * margin {
        return None;
    }
    let normal = Normal::standard();
    let reach = normal.inverse_cdf(1.0 - alpha);
    let passes = |seeds: usize| {
        let error = deviation * (2.0 / seeds as f64).sqrt();
        let side = |room: f64| if error > 0.0 { normal.cdf(room / error - reach) } else { 1.0 };
        side(margin - apart) + side(margin + apart) - 1.0 >= POWER
    };
    // Enough seeds for the nearer side alone at far more than this power.
    let enough = 2.0 * ((reach + 4.0) * deviation / (margin - apart)).powi(2);
    let (mut few, mut many) = (1, (enough.ceil() as usize).max(2));
    while many - few > 1 {
        let middle = few + (many - few) / 2;
        if passes(middle) { many = middle } else { few = middle }
    }
    Some(many)
}
