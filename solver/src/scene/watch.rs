//! What a run watches for, and what it does then.

use serde::{Deserialize, Serialize};

/// Reaction to a violation.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(rename_all = "kebab-case")]
pub enum Reaction {
    /// The run ends and leaves a checkpoint from before.
    Stop,
    /// The run continues with a warning.
    Warn,
    /// No reaction.
    Ignore,
}

impl Reaction {
    fn is_stop(&self) -> bool {
        *self == Reaction::Stop
    }
}

/// Watchdogs. Violations that invalidate a run end it unless the scene says otherwise; a state that is not finite, or a crossed wall,
/// always does.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields, default)]
pub struct Watch {
    /// Steps between checks; 0: never.
    pub every: u32,
    /// Largest overlap of a contact over the smaller radius.
    pub overlap: f64,
    /// Reaction to an overlap above `overlap`.
    pub on_overlap: Reaction,
    /// Reaction to an overlap above the smaller radius and above `overlap`.
    #[serde(skip_serializing_if = "Reaction::is_stop")]
    pub on_deep_overlap: Reaction,
    /// Largest spurious gain of mechanical energy, over the largest kinetic energy so far plus the weight of the grains times their mean
    /// radius.
    pub energy: f64,
    /// Reaction to a gain above `energy`.
    pub on_energy: Reaction,
    /// Reaction to a grain outside the domain.
    pub on_escape: Reaction,
    /// Residual, in g h, that some solve between two checks must reach.
    pub residual: f64,
    /// Reaction to a residual above `residual`.
    pub on_stagnation: Reaction,
}

impl Default for Watch {
    fn default() -> Self {
        Self {
            every: 64,
            overlap: 0.5,
            on_overlap: Reaction::Warn,
            on_deep_overlap: Reaction::Stop,
            energy: 0.02,
            on_energy: Reaction::Stop,
            on_escape: Reaction::Stop,
            residual: 1.0,
            on_stagnation: Reaction::Warn,
        }
    }
}
