//! A roofline as data.

use super::machine::Roofs;
use super::point::Point;
use makadam::sweep::Operations;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;

/// Roofs and the sweeps beneath them, from one run.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Study {
    /// Version of this layout.
    pub version: u32,
    /// Always "roofline".
    pub command: String,
    /// Instruction set of roofs and kernels.
    pub instruction_set: String,
    /// Operations of a contact of two grains.
    pub pair: Operations,
    /// Operations of a contact with a wall.
    pub wall: Operations,
    /// By number of threads.
    pub roofs: Vec<Roofs>,
    /// Measured sweeps.
    pub points: Vec<Point>,
    /// Where they came from.
    pub provenance: BTreeMap<String, String>,
}
