//! What is kept of a finished run.

use super::configuration::Configuration;
use crate::compare::MeasuredRun;
use crate::output::file_stem;
use crate::plan::Scene;
use crate::provenance::{Build, JUDGE, scene_hash};
use crate::study::Key;
use serde::{Deserialize, Serialize};

/// What is kept of one run.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct KeptRun {
    /// How it was run.
    pub configuration: Configuration,
    /// Whether it was stopped before the scene's end, so that it tells wall time and nothing else.
    pub extrapolated: bool,
    /// Share of a core that the run got, 0 to 1; absent where the system does not tell.
    pub core_share: Option<f64>,
    /// Its measurements and times.
    pub run: MeasuredRun,
    /// The program that started it, and the machine.
    pub build: Build,
    /// The command line.
    pub command: String,
}

impl KeptRun {
    /// Processor time of the stepping on one core, s; where the run does not tell it, wall time times the share of a core that it got.
    pub fn core_seconds(&self) -> f64 {
        self.run.core_seconds.unwrap_or(self.run.wall_seconds * self.core_share.unwrap_or(1.0))
    }

    /// The same over simulated time.
    pub fn pace(&self) -> f64 {
        self.core_seconds() / self.run.simulated_seconds
    }
}

/// The key of a seed's run: scene, knobs, seed, the code and its version (which holds the [key of the build](makadam::BUILD)
/// where the code is Makadam), the key of the sources that measure, and the processor, since a wall time of another one is another
/// number.
pub fn run_key(scene: &Scene, configuration: &Configuration, version: &str, seed: u64, processor: &str) -> Key {
    let scene = configuration.scene(scene);
    let knobs = serde_json::to_string(configuration).expect("a configuration holds only numbers and plain text");
    let name = format!("{}-{}-s{seed}", file_stem(&scene.name), configuration.code.to_lowercase());
    // Explicit codes are run from inputs for timing.
    let purpose = if configuration.rayleigh_fraction().is_some() { "timing" } else { "" };
    let scene = format!("{:016x}", scene_hash(&scene));
    Key::new(name, &[&scene, &knobs, version, &seed.to_string(), processor, JUDGE, purpose]).apart()
}
