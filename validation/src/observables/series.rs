//! Quantities over time.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// An observable over time in one run.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Series {
    /// The code.
    pub code: String,
    /// Seed of the run.
    pub seed: u64,
    /// Name of the observable.
    pub observable: String,
    /// Times, s.
    pub time: Vec<f64>,
    /// Values at these times.
    pub value: Vec<f64>,
}
