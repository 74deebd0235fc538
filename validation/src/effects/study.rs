//! What `makadam effects` yields.

use super::{Ablation, Called, Costs, Look};
use crate::provenance::Provenance;
use serde::Serialize;

/// The effects of a scene.
#[derive(Clone, Debug, Serialize)]
pub struct Study {
    /// Version of the document's form.
    pub version: u32,
    /// `effects`.
    pub command: &'static str,
    /// The scene.
    pub scene: String,
    /// Which effects it calls for.
    pub effects: Vec<Called>,
    /// What kernels cost on its contacts; absent where it has none.
    pub costs: Option<Costs>,
    /// A stretch of the run.
    pub look: Option<Look>,
    /// What a user should know.
    pub warnings: Vec<String>,
    /// Each effect off or on; absent where it was not asked for.
    pub ablation: Option<Ablation>,
    /// Where it was measured.
    pub provenance: Provenance,
}
