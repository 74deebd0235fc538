//! Tables of a scene file. All units are SI: metres, seconds, kilograms, pascals, radians per second.

use super::{Motion, RadiusDistribution};
use crate::laws::period::Period;
use crate::surface::Shape;
use serde::{Deserialize, Serialize};

pub(super) fn earth_gravity() -> [f64; 3] {
    [0.0, 0.0, -9.81]
}

pub(super) fn not_given() -> f64 {
    f64::NAN
}

pub(super) fn first_seed() -> u64 {
    1
}

/// Value of gravity at a time.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct GravityChange {
    /// Time, s.
    pub time: f64,
    /// Acceleration of gravity at that time, m/s2.
    pub gravity: [f64; 3],
}

/// Returns the volume (m3) of a sphere of a radius (m).
pub(crate) fn sphere_volume(radius: f64) -> f64 {
    4.0 / 3.0 * std::f64::consts::PI * radius * radius * radius
}

pub(super) fn slight_overlap() -> f64 {
    0.01
}

/// Returns true if an overlap is the default, as [`crate::is_default`] does.
pub(super) fn is_slight(overlap: &f64) -> bool {
    *overlap == slight_overlap()
}

/// Axis-aligned box that no grain may leave, metres.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct Domain {
    /// Lower corner.
    pub min: [f64; 3],
    /// Upper corner.
    pub max: [f64; 3],
    /// Periodic axes.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub periodic: Vec<Axis>,
}

impl Domain {
    /// Returns the period of the domain along each axis.
    pub fn period(&self) -> Period {
        let repeats = [Axis::X, Axis::Y, Axis::Z].map(|axis| self.periodic.contains(&axis));
        Period::new(std::array::from_fn(|axis| self.max[axis] - self.min[axis]), repeats)
    }
}

/// Axis of the frame of reference.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(rename_all = "lowercase")]
pub enum Axis {
    /// First axis.
    X,
    /// Second axis.
    Y,
    /// Third axis.
    Z,
}

impl Axis {
    /// Returns the index of the axis, from 0.
    pub fn number(self) -> usize {
        self as usize
    }

    /// Returns the name of the axis.
    pub fn name(self) -> &'static str {
        ["x", "y", "z"][self.number()]
    }
}

/// Rigid wall with a material and a prescribed motion.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct Wall {
    /// Name, used in tables and errors.
    pub name: String,
    /// Name of its material.
    pub material: String,
    /// Surface.
    pub shape: Shape,
    /// Motion: one table, or a list of prescribed motions. The first of a list acts on the wall first, and each later one carries it along.
    #[serde(default)]
    pub motion: Motion,
    /// Name of a wall with a prescribed motion that carries this one, such as the shaft of a blade.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub parent: Option<String>,
    /// Velocity of the surface along itself, m/s, while the shape stays: a conveyor belt. At a contact, its component along the normal does not count.
    #[serde(default, skip_serializing_if = "crate::is_default")]
    pub surface_velocity: [f64; 3],
}

/// Group of grains placed by rule: on the lowest sites of a jittered lattice, or at random.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct Population {
    /// Number of grains.
    pub count: usize,
    /// Name of their material.
    pub material: String,
    /// Distribution of their radii.
    pub radius: RadiusDistribution,
    /// Region of placement.
    pub region: Region,
    /// Rule of placement.
    #[serde(default, skip_serializing_if = "crate::is_default")]
    pub placement: Placement,
    /// Lattice spacing over the largest diameter, at least 1; jitter fills the rest. Without meaning for a random placement.
    #[serde(default = "usual_spacing")]
    pub spacing: f64,
    /// Limit of each component of the initial velocity, m/s: uniform between minus and plus this value.
    #[serde(default)]
    pub agitation: f64,
}

/// Lattice spacing of a population without one.
pub(super) fn usual_spacing() -> f64 {
    1.1
}

/// Rule by which the grains of a population get their places.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(rename_all = "kebab-case")]
pub enum Placement {
    /// Sites of a jittered lattice as wide as the largest grain, the lowest sites first.
    #[default]
    Lattice,
    /// Random free places of the region, the largest grains first: for grains of very different sizes, up to a solid fraction of some 0.3.
    Random,
}

/// Region of placement; grains lie entirely inside.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(tag = "kind", rename_all = "kebab-case", deny_unknown_fields)]
pub enum Region {
    /// Axis-aligned box.
    Box {
        /// Lower corner, metres.
        min: [f64; 3],
        /// Upper corner, metres.
        max: [f64; 3],
    },
    /// Cylinder.
    Cylinder {
        /// Centre of the first end, metres.
        base: [f64; 3],
        /// Direction of the axis; need not be of unit length.
        axis: [f64; 3],
        /// Radius, metres.
        radius: f64,
        /// Length along the axis, metres.
        length: f64,
    },
}

/// Source: grains that come to random free places of a region during the run.
///
/// A grain that finds no free place waits. Grains come when the candidate list is rebuilt, at most the time late in which a
/// grain falls by its mean diameter.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct Insertion {
    /// Name of their material.
    pub material: String,
    /// Distribution of their radii.
    pub radius: RadiusDistribution,
    /// Region of placement, inside the domain.
    pub region: Region,
    /// Rate, grains/s.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub rate: Option<f64>,
    /// Rate, kg/s, instead of `rate`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub mass_rate: Option<f64>,
    /// Largest number of grains; default: no limit. Without a rate, all are due at once.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub total: Option<u64>,
    /// Name of the stage in which alone it acts; times then count from its start. Default: all stages.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub stage: Option<String>,
    /// Time at which it begins, s.
    #[serde(default)]
    pub from: f64,
    /// Time at which it ends, s; default: never.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub until: Option<f64>,
    /// Velocity of new grains, m/s.
    #[serde(default)]
    pub velocity: [f64; 3],
}

/// Sink: grains leave the simulation if the path of their centre in a step meets a region.
///
/// Grains leave when the candidate list is rebuilt, at the latest in the step after they crossed the region.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct Removal {
    /// Region.
    pub region: Region,
    /// Name of the stage in which alone it acts; times then count from its start. Default: all stages.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub stage: Option<String>,
    /// Time at which it begins, s.
    #[serde(default)]
    pub from: f64,
    /// Time at which it ends, s; default: never.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub until: Option<f64>,
}

/// Single grain with a given position.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct GrainEntry {
    /// Name of its material.
    pub material: String,
    /// Radius, metres.
    pub radius: f64,
    /// Centre, metres.
    pub position: [f64; 3],
    /// Velocity, m/s.
    #[serde(default)]
    pub velocity: [f64; 3],
    /// Angular velocity, rad/s.
    #[serde(default)]
    pub spin: [f64; 3],
}
