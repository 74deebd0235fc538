//! A figure with its bounds.

use serde::{Deserialize, Deserializer, Serialize};
use std::borrow::Cow;

/// A measured figure, and the bounds that the right outcome sets for it.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Finding {
    /// Name.
    pub what: String,
    /// Unit; empty for a pure number.
    pub unit: Cow<'static, str>,
    /// Value.
    #[serde(deserialize_with = "or_nan")]
    pub value: f64,
    /// Lower bound.
    pub low: Option<f64>,
    /// Upper bound.
    pub high: Option<f64>,
}

/// JSON has `null` for a value that is not finite.
fn or_nan<'de, D: Deserializer<'de>>(deserializer: D) -> Result<f64, D::Error> {
    Ok(Option::deserialize(deserializer)?.unwrap_or(f64::NAN))
}

impl Finding {
    /// A figure without bounds and unit, which is reported only.
    pub(crate) fn reported(what: impl Into<String>, value: f64) -> Finding {
        Finding { what: what.into(), unit: "".into(), value, low: None, high: None }
    }

    pub(crate) fn between(what: impl Into<String>, value: f64, low: f64, high: f64) -> Finding {
        Finding { low: Some(low), high: Some(high), ..Finding::reported(what, value) }
    }

    /// A figure that may deviate by so much from a target.
    pub(crate) fn near(what: impl Into<String>, value: f64, target: f64, deviation: f64) -> Finding {
        Finding::between(what, value, target - deviation, target + deviation)
    }

    pub(crate) fn at_most(what: impl Into<String>, value: f64, high: f64) -> Finding {
        Finding { high: Some(high), ..Finding::reported(what, value) }
    }

    pub(crate) fn at_least(what: impl Into<String>, value: f64, low: f64) -> Finding {
        Finding { low: Some(low), ..Finding::reported(what, value) }
    }

    pub(crate) fn in_unit(self, unit: &'static str) -> Finding {
        Finding { unit: unit.into(), ..self }
    }

    /// Returns true within the bounds; false if it is not a number.
    pub fn holds(&self) -> bool {
        !self.value.is_nan()
            && self.low.is_none_or(|low| self.value >= low)
            && self.high.is_none_or(|high| self.value <= high)
    }

    /// Returns the relative distance from the exceeded bound, 0 inside: the order of findings by their error.
    pub fn excess(&self) -> f64 {
        let exceeded = self.high.filter(|high| self.value > *high).or(self.low);
        match exceeded {
            _ if self.holds() => 0.0,
            Some(bound) if self.value.is_finite() => (self.value - bound).abs() / bound.abs().max(1e-300),
            _ => f64::INFINITY,
        }
    }
}
