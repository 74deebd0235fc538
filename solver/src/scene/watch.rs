//! What a run watches for, and what it does then.

use serde::{Deserialize, Serialize};

/// What happens when something is noticed.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Reaction {
    /// The run ends; a checkpoint from before is left.
    Stop,
    /// The run goes on and says so.
    Warn,
    /// Nothing.
    Ignore,
}

/// What is watched for. A state that is not finite always ends a run.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Watch {
    /// Steps from one look to the next; 0 looks never.
    pub every: u32,
    /// Largest overlap of a contact over the smaller radius.
    pub overlap: f64,
    /// When it is larger.
    pub on_overlap: Reaction,
    /// Largest gain of mechanical energy, over the largest kinetic energy so far and what gravity gives the grains over a radius.
    /// Only where no wall moves: walls do work.
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
            energy: 0.02,
            on_energy: Reaction::Warn,
            on_escape: Reaction::Warn,
            residual: 1.0,
            on_stagnation: Reaction::Warn,
        }
    }
}
