//! Distributions of grain radii: range, mean, checks, and the radius of a random grain.
//!
//! A grading curve states the mass P(D) that passes a sieve of aperture D. Mass is uniform in `ln D` between two sieves, so that the number of grains is
//! distributed as `D^-4`. Its inverse gives a diameter from a uniform number u:
//!
//! ```text
//! number in (a, b)    ~  (P_b - P_a) (a^-3 - b^-3) / (3 ln(b/a))
//! diameter in (a, b)  D = (a^-3 - u (a^-3 - b^-3))^(-1/3)
//! ```

use super::document::{Checked, DocumentPath};
use super::error::short;
use super::populate::{symmetric, uniform};
use rand_chacha::ChaCha8Rng;
use serde::{Deserialize, Serialize};

/// Largest ratio of the standard deviation of a normal distribution to its width: above the limit, redrawing takes long.
const MOST_DEVIATIONS: f64 = 100.0;

/// Distribution of grain radii, metres.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(tag = "kind", rename_all = "kebab-case", deny_unknown_fields)]
pub enum RadiusDistribution {
    /// All equal.
    Fixed {
        /// Radius, metres.
        value: f64,
    },
    /// Uniform between `mean (1 - spread)` and `mean (1 + spread)`.
    Uniform {
        /// Mean radius, metres.
        mean: f64,
        /// Half width over the mean.
        spread: f64,
    },
    /// Normal, redrawn outside `min` to `max`.
    Normal {
        /// Mean radius, metres.
        mean: f64,
        /// Standard deviation, metres.
        deviation: f64,
        /// Smallest radius, metres.
        min: f64,
        /// Largest radius, metres.
        max: f64,
    },
    /// Listed radii with fractions by number.
    Discrete {
        /// Radii, metres.
        radii: Vec<f64>,
        /// Fractions, one per radius; need not sum to 1.
        shares: Vec<f64>,
    },
    /// Grading curve of a sieve analysis: mass that passes each sieve. Between two sieves, mass is uniform in the logarithm of the diameter.
    Sieve {
        /// Apertures of the sieves, ascending, metres.
        diameters: Vec<f64>,
        /// Fractions of the mass that pass the sieves, ascending from 0 to 1.
        passing: Vec<f64>,
    },
}

impl RadiusDistribution {
    /// Returns the smallest and largest radius of the distribution, metres.
    pub fn bounds(&self) -> (f64, f64) {
        match self {
            Self::Fixed { value } => (*value, *value),
            Self::Uniform { mean, spread } => (mean * (1.0 - spread), mean * (1.0 + spread)),
            Self::Normal { min, max, .. } => (*min, *max),
            Self::Discrete { radii, .. } => extremes(radii.iter().copied()),
            Self::Sieve { diameters, passing } => {
                extremes(classes(diameters, passing).flat_map(|class| class.ends.map(|diameter| 0.5 * diameter)))
            }
        }
    }

    /// Returns the mean radius (m), before truncation for a normal distribution.
    pub(crate) fn mean(&self) -> f64 {
        match self {
            Self::Fixed { value } => *value,
            Self::Uniform { mean, .. } | Self::Normal { mean, .. } => *mean,
            Self::Discrete { radii, shares } => {
                let weighted: f64 = radii.iter().zip(shares).map(|(radius, share)| radius * share).sum();
                weighted / shares.iter().sum::<f64>()
            }
            Self::Sieve { diameters, passing } => {
                let all = || classes(diameters, passing);
                let weighted: f64 = all().map(|class| class.number * class.mean()).sum();
                0.5 * weighted / all().map(|class| class.number).sum::<f64>()
            }
        }
    }

    /// Draws the radius of a grain, m.
    pub(crate) fn draw(&self, random: &mut ChaCha8Rng) -> f64 {
        match self {
            Self::Fixed { value } => *value,
            Self::Uniform { mean, spread } => mean * (1.0 + spread * symmetric(random)),
            Self::Normal { mean, deviation, min, max } => loop {
                // Marsaglia's polar method: no trigonometric function, and a logarithm with the same bits on every platform.
                let (u, v) = (symmetric(random), symmetric(random));
                let s = u * u + v * v;
                if s > 0.0 && s < 1.0 {
                    let radius = mean + deviation * u * (-2.0 * libm::log(s) / s).sqrt();
                    if (*min..=*max).contains(&radius) {
                        return radius;
                    }
                }
            },
            Self::Discrete { radii, shares } => {
                let mut left = uniform(random) * shares.iter().sum::<f64>();
                for (radius, share) in radii.iter().zip(shares) {
                    left -= share;
                    if left < 0.0 {
                        return *radius;
                    }
                }
                radii[radii.len() - 1]
            }
            Self::Sieve { .. } => self.all(1, random)(random),
        }
    }

    /// Returns a generator of the radii of a number of grains, m. Sieves have strata, one for each grain, in random order: each draw meets the
    /// curve, within a grain for each class.
    pub(crate) fn all(&self, count: usize, random: &mut ChaCha8Rng) -> impl FnMut(&mut ChaCha8Rng) -> f64 + use<'_> {
        let (mut list, mut strata): (Vec<Class>, Vec<usize>) = Default::default();
        if let Self::Sieve { diameters, passing } = self {
            (list, strata) = (classes(diameters, passing).collect(), (0..count).collect());
            (1..count).rev().for_each(|last| strata.swap(last, (uniform(random) * (last + 1) as f64) as usize));
        }
        let total: f64 = list.iter().map(|class| class.number).sum();
        move |random| {
            let Some(stratum) = strata.pop() else { return self.draw(random) };
            let mut left = (stratum as f64 + uniform(random)) / count as f64 * total;
            // The class in which the sum of the numbers passes the drawn one.
            let is_it = |class: &&Class| {
                class.number > left || {
                    left -= class.number;
                    false
                }
            };
            let last = list[list.len() - 1];
            let class = list.iter().find(is_it).copied().unwrap_or(last);
            0.5 * class.diameter((left / class.number).min(1.0))
        }
    }

    /// Checks the values of a distribution.
    pub(super) fn check(&self, at: &DocumentPath) -> Checked {
        match self {
            Self::Fixed { value } => at.key("value").range(*value, 1e-9, 100.0, "m"),
            Self::Uniform { mean, spread } => {
                at.key("mean").range(*mean, 1e-9, 100.0, "m")?;
                at.key("spread").range(*spread, 0.0, 0.99, "(no unit)")
            }
            Self::Normal { mean, deviation, min, max } => {
                at.key("mean").range(*mean, *min, *max, "m")?;
                at.key("deviation").range(*deviation, 0.0, *max, "m")?;
                at.key("min").range(*min, 1e-9, *max, "m")?;
                at.key("max").range(*max, *min, 100.0, "m")?;
                let (fits, all) = (*deviation <= MOST_DEVIATIONS * (max - min), [*deviation, *min, *max].map(short));
                let problem = || {
                    format!("{} m is far wider than the radii from {} to {} m that are kept", all[0], all[1], all[2])
                };
                at.key("deviation").require(fits, problem, "lower it, or use kind = 'uniform'")
            }
            Self::Discrete { radii, shares } => {
                let problem = || format!("{} radii and {} shares", radii.len(), shares.len());
                let is_whole = !radii.is_empty() && radii.len() == shares.len();
                at.require(is_whole, problem, "list as many shares as radii, at least one")?;
                radii.iter().try_for_each(|radius| at.key("radii").range(*radius, 1e-9, 100.0, "m"))?;
                shares.iter().try_for_each(|share| at.key("shares").range(*share, 1e-12, 1e12, "(no unit)"))
            }
            Self::Sieve { diameters, passing } => {
                let ascends = |list: &[f64]| list.windows(2).all(|two| two[0] <= two[1]);
                let is_strict = diameters.windows(2).all(|two| two[0] < two[1]);
                let problem = || format!("{} diameters and {} fractions", diameters.len(), passing.len());
                let is_whole = diameters.len() >= 2 && diameters.len() == passing.len() && is_strict;
                at.require(
                    is_whole,
                    problem,
                    "list at least two diameters, ascending, and as many fractions that pass",
                )?;
                diameters.iter().try_for_each(|diameter| at.key("diameters").range(*diameter, 1e-9, 200.0, "m"))?;
                passing.iter().try_for_each(|share| at.key("passing").range(*share, 0.0, 1.0, "(no unit)"))?;
                let is_curve = ascends(passing) && passing[0] == 0.0 && passing[passing.len() - 1] == 1.0;
                let remedy = "begin with 0 at the smallest diameter, ascend, and end with 1 (fractions, not percent)";
                at.key("passing").require(is_curve, || format!("{passing:?} is no grading curve"), remedy)
            }
        }
    }
}

/// Grains between two sieves.
#[derive(Clone, Copy)]
struct Class {
    /// Apertures, m.
    ends: [f64; 2],
    /// Number of grains, in units of the total mass over that of a cube with sides of a metre.
    number: f64,
}

impl Class {
    /// Returns the mean diameter, m.
    fn mean(&self) -> f64 {
        let [a, b] = self.ends.map(|end| 1.0 / end);
        1.5 * (a * a - b * b) / (a * a * a - b * b * b)
    }

    /// Returns the diameter (m) below which a fraction `u` of the grains lies.
    fn diameter(&self, u: f64) -> f64 {
        let [a, b] = self.ends.map(|end| 1.0 / (end * end * end));
        let diameter = 1.0 / libm::cbrt(a - u * (a - b));
        diameter.clamp(self.ends[0], self.ends[1])
    }
}

/// Iterates over the classes with grains, ascending.
fn classes(diameters: &[f64], passing: &[f64]) -> impl Iterator<Item = Class> {
    let sieves = diameters.iter().zip(passing);
    sieves.clone().zip(sieves.skip(1)).filter(|((_, p), (_, q))| q > p).map(|((&a, p), (&b, q))| {
        let number = (q - p) * (1.0 / (a * a * a) - 1.0 / (b * b * b)) / (3.0 * libm::log(b / a));
        Class { ends: [a, b], number }
    })
}

fn extremes(radii: impl Iterator<Item = f64>) -> (f64, f64) {
    radii.fold((f64::INFINITY, 0.0), |(low, high), radius| (low.min(radius), high.max(radius)))
}
