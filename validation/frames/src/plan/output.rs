//! Content and interval of the frames on disk.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Content, interval and export of frames: the table `output` of a scene.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Output {
    /// Time between frames on disk, s; default: that of `measure`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub interval: Option<f64>,
    /// Fields of grains in exported frames, in addition to number, diameter and material; default: all.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub fields: Option<Vec<GrainField>>,
    /// Writes contacts.
    pub contacts: bool,
    /// Writes walls.
    pub walls: bool,
    /// Formats in which the frames of a complete run are exported into its folder, as `makadam export` does.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub formats: Vec<FrameFormat>,
}

/// A format of frames for other programs.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum FrameFormat {
    /// ParaView: one file per frame, and a script that opens them.
    Vtp,
    /// ParaView: one file for all frames of grains, contacts or walls.
    Vtkhdf,
    /// OVITO and HOOMD-blue: grains over time.
    Gsd,
}

impl Default for Output {
    fn default() -> Self {
        Self { interval: None, fields: None, contacts: true, walls: true, formats: Vec::new() }
    }
}

/// A quantity of grains in the frames of a run; hyphens are read as underscores.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum GrainField {
    /// Index of the grain's population; -1 for a grain listed by itself.
    Population,
    /// Mass, kg.
    Mass,
    /// Magnitude of the velocity, m/s.
    Speed,
    /// Velocity, m/s.
    Velocity,
    /// Angular velocity, rad/s.
    #[serde(alias = "angular-velocity")]
    AngularVelocity,
    /// Sum of the contact forces on the grain, N.
    Force,
    /// Number of force-carrying contacts.
    #[serde(alias = "coordination-number")]
    CoordinationNumber,
    /// Symmetric part of the mean stress of the grain, pressure positive, Pa: xx, yy, zz, xy, yz, xz.
    Stress,
    /// A third of the trace of the stress, Pa.
    Pressure,
}
