//! A figure with the bounds that it must keep.

use serde::{Deserialize, Deserializer, Serialize};
use std::borrow::Cow;

/// A figure that was measured, and the bounds that the right outcome sets for it.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Finding {
    /// What was measured.
    pub what: String,
    /// Its unit; empty for a number.
    pub unit: Cow<'static, str>,
    /// The figure.
    #[serde(deserialize_with = "no_number")]
    pub value: f64,
    /// Least right value; minus infinity where there is none.
    #[serde(deserialize_with = "no_lower_bound")]
    pub low: f64,
    /// Largest right value; infinity where there is none.
    #[serde(deserialize_with = "no_upper_bound")]
    pub high: f64,
}

/// JSON has `null` for all that is not finite.
fn or<'de, D: Deserializer<'de>>(deserializer: D, absent: f64) -> Result<f64, D::Error> {
    Ok(Option::<f64>::deserialize(deserializer)?.unwrap_or(absent))
}

fn no_number<'de, D: Deserializer<'de>>(deserializer: D) -> Result<f64, D::Error> {
    or(deserializer, f64::NAN)
}

fn no_lower_bound<'de, D: Deserializer<'de>>(deserializer: D) -> Result<f64, D::Error> {
    or(deserializer, f64::NEG_INFINITY)
}

fn no_upper_bound<'de, D: Deserializer<'de>>(deserializer: D) -> Result<f64, D::Error> {
    or(deserializer, f64::INFINITY)
}

impl Finding {
    /// A figure between two bounds.
    pub fn between(what: impl Into<String>, unit: &'static str, value: f64, low: f64, high: f64) -> Finding {
        Finding { what: what.into(), unit: unit.into(), value, low, high }
    }

    /// A figure that may deviate by so much from a target.
    pub fn near(what: impl Into<String>, unit: &'static str, value: f64, target: f64, deviation: f64) -> Finding {
        Finding::between(what, unit, value, target - deviation, target + deviation)
    }

    /// A figure with an upper bound.
    pub fn at_most(what: impl Into<String>, unit: &'static str, value: f64, high: f64) -> Finding {
        Finding::between(what, unit, value, f64::NEG_INFINITY, high)
    }

    /// A figure with a lower bound.
    pub fn at_least(what: impl Into<String>, unit: &'static str, value: f64, low: f64) -> Finding {
        Finding::between(what, unit, value, low, f64::INFINITY)
    }

    /// Its least and its largest right value, where there are any.
    pub fn bounds(&self) -> [Option<f64>; 2] {
        [self.low, self.high].map(|bound| bound.is_finite().then_some(bound))
    }

    /// Whether it keeps its bounds; what is not a number keeps none.
    pub fn holds(&self) -> bool {
        self.value >= self.low && self.value <= self.high
    }

    /// By how many times its room it leaves its bounds; below 1 inside. Orders findings by how wrong they are.
    pub fn excess(&self) -> f64 {
        match (self.holds(), self.value.is_finite()) {
            (true, _) => 0.0,
            (false, false) => f64::INFINITY,
            (false, true) => {
                let nearest = if self.value > self.high { self.high } else { self.low };
                (self.value - nearest).abs() / nearest.abs().max(1e-300)
            }
        }
    }
}
