//! What a run is.

use crate::plan::Scene;
use crate::provenance::Provenance;
use makadam::scene::Finding;
use std::path::PathBuf;
use std::time::Duration;

/// What a run is, and where and how it is kept.
pub(super) struct Plan<'a> {
    /// The scene.
    pub scene: &'a Scene,
    /// Seed of the initial positions.
    pub seed: u64,
    /// Folder that everything is written into.
    pub output: PathBuf,
    /// Wall time from one checkpoint to the next.
    pub interval: Duration,
    /// What the settings are not expected to bear, told before the run.
    pub findings: Vec<Finding>,
    /// Where the run came from.
    pub provenance: Provenance,
}
