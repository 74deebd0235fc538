//! What `makadam effects` yields.

use super::{Ablation, Called, Costs, Look, called, markdown, warnings};
use crate::output::JSON_VERSION;
use crate::plan::Scene;
use crate::provenance::Provenance;
use crate::study::{DocumentError, json, write_together};
use serde::Serialize;
use std::path::Path;

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

impl Study {
    /// The effects of a scene, whose file has this text, and what was measured of them.
    pub fn new(
        scene: &Scene,
        text: &str,
        (look, costs): (Option<Look>, Option<Costs>),
        ablation: Option<Ablation>,
        provenance: Provenance,
    ) -> Study {
        Study {
            version: JSON_VERSION,
            command: "effects",
            scene: scene.name.clone(),
            effects: called(scene, text),
            costs,
            warnings: warnings(scene, look.as_ref()),
            look,
            ablation,
            provenance,
        }
    }

    /// Writes `effects.json` and, where there is an ablation, `ablation.md`.
    ///
    /// # Errors
    /// [`DocumentError`] if a file cannot be written; none is changed then.
    pub fn write(&self, folder: &Path) -> Result<(), DocumentError> {
        let table = self.ablation.is_some().then(|| ("ablation.md".into(), markdown(self).into_bytes()));
        let files: Vec<_> = [json("effects", self)?].into_iter().chain(table).collect();
        write_together(folder, &files)
    }
}
