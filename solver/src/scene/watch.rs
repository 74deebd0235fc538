//! What a run watches for, and what it does then.

use serde::{Deserialize, Serialize};

/// What happens when something is noticed.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(rename_all = "kebab-case")]
pub enum Reaction {
    /// The run ends; a checkpoint from before is left.
    Stop,
    /// The run goes on and says so.
    Warn,
    /// Nothing.
    Ignore,
}

impl Reaction {
    fn is_stop(&self) -> bool {
        *self == Reaction::Stop
    }
}

/// What is watched for. What makes the numbers of a run worthless ends it unless the scene says otherwise; a state that
/// is not finite, or a grain that has crossed a wall, always does.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields, default)]
pub struct Watch {
    /// Steps from one look to the next; 0 looks never.
    pub every: u32,
    /// Largest overlap of a contact over the smaller radius.
    pub overlap: f64,
    /// When it is larger.
    pub on_overlap: Reaction,
    /// When it is so large that a centre lies inside its partner: above the smaller radius, and above `overlap`.
    #[serde(skip_serializing_if = "Reaction::is_stop")]
    pub on_deep_overlap: Reaction,
    /// Largest gain of mechanical energy that neither walls nor changes of gravity gave, over the largest kinetic energy so far and
    /// what gravity gives the grains over a radius.
    pub energy: f64,
    /// When it is larger.
    pub on_energy: Reaction,
    /// When a grain leaves the domain.
    pub on_escape: Reaction,
    /// Residual of a solve, in units of g h, that must not be exceeded from one look to the next.
    pub residual: f64,
    /// When it is.
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
