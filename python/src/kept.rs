//! Checkpoint of a simulation: the solver's checkpoint, with scene and seed.
//!
//! A checkpoint of the solver contains grains and impulses but not the scene, so that it could resume with another friction, for
//! instance. The label before the checkpoint identifies scene and seed.

use crate::errors::{exception, warn};
use crate::scene::Scene;
use makadam::checkpoint::{open, seal};
use makadam_frames::plan;
use makadam_frames::provenance::scene_hash;
use pyo3::prelude::*;
use serde::{Deserialize, Serialize};

/// Magic bytes of a Python checkpoint; the last byte is the version of the format.
const MARK: [u8; 8] = *b"mkd-py-\x02";

/// Identity of the state.
#[derive(Serialize, Deserialize)]
struct Label {
    scene: String,
    scene_hash: u64,
    seed: u64,
    /// Remaining simulated time of earlier runs below a step, s.
    remainder: f64,
}

/// Parts of a checkpoint to resume from.
pub struct Kept<'a> {
    /// Checkpoint of the solver.
    pub simulation: &'a [u8],
    /// Seed of the positions and radii.
    pub seed: u64,
    /// Remaining simulated time of earlier runs below a step, s.
    pub remainder: f64,
}

/// Creates the checkpoint of a simulation of a scene, with a label and a checksum.
pub fn keep(scene: &Scene, seed: u64, remainder: f64, simulation: &[u8]) -> Vec<u8> {
    let label = Label { scene: scene.plan.name.clone(), scene_hash: hash_to_go_on(&scene.plan), seed, remainder };
    let mut bytes = postcard::to_stdvec(&label).expect("a label holds a name and numbers");
    bytes.extend(simulation);
    seal(MARK, &bytes)
}

/// Reads a checkpoint, which must belong to the scene, and to the seed if given.
pub fn unkeep<'a>(py: Python<'_>, scene: &Scene, seed: Option<u64>, bytes: &'a [u8]) -> PyResult<Kept<'a>> {
    let refuse = |problem: String| exception(py, "CheckpointError", &problem);
    if bytes.starts_with(b"makadam") {
        warn(
            py,
            "the checkpoint names no scene, since the Rust library wrote it: that it is of this scene is not checked",
        )?;
        return Ok(Kept { simulation: bytes, seed: seed.unwrap_or(scene.plan.seed), remainder: 0.0 });
    }
    let body = open(MARK, bytes).map_err(|problem| refuse(format!("the checkpoint {problem}")))?;
    let (label, simulation) = postcard::take_from_bytes::<Label>(body)
        .map_err(|error| refuse(format!("the checkpoint does not hold what it should ({error})")))?;
    if label.scene_hash != hash_to_go_on(&scene.plan) {
        return Err(refuse(format!(
            "the checkpoint belongs to '{}' with other contents or settings than '{}' has here, such as another friction, time step or \
             method; give the same scene and settings (only what is measured, written, compared and watched for may differ)",
            label.scene, scene.plan.name
        )));
    }
    match seed.filter(|seed| *seed != label.seed) {
        Some(seed) => Err(refuse(format!(
            "the checkpoint belongs to seed {}, not to {seed}; leave the seed out, it is taken from the checkpoint",
            label.seed
        ))),
        None => Ok(Kept { simulation, seed: label.seed, remainder: label.remainder }),
    }
}

/// Hash of all scene data that affect the bits of a state. The label contains the seed.
fn hash_to_go_on(scene: &plan::MeasuredScene) -> u64 {
    let mut bare = scene.clone();
    bare.measure = plan::Measure::default();
    (bare.output, bare.compare) = (None, Vec::new());
    (bare.simulated.name, bare.simulated.description) = (String::new(), String::new());
    (bare.simulated.duration, bare.simulated.seed) = (1.0, 0);
    scene_hash(&bare)
}
