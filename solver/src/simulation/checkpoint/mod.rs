//! Checkpoints: a simulation written down, to be continued bit for bit, or to start another one from.
//!
//! What the next step depends on is the state of the grains, the impulses that contacts bore, and the candidate list: the order
//! of its pairs is the order in which contacts are relaxed. The list itself is not written. It follows from where the grains
//! were when it was built, so these places are, and reading builds it again. What it holds besides, because grains were too fast for the step,
//! is written as it is: it came from velocities that nobody knows any more.
//!
//! ```
//! # use makadam::{Face, Material, Population, RadiusDistribution, Region, Scene, Shape, Simulation, Wall};
//! # let [min, max] = [[0.0; 3], [0.04, 0.04, 0.12]];
//! # let scene = Scene::builder()
//! #     .material("glass", Material::default())
//! #     .wall(Wall::new("box", "glass", Shape::cuboid(min, max, &[Face::Top])))
//! #     .population(Population::new(40, "glass", RadiusDistribution::uniform(0.005, 0.05), Region::cuboid(min, max)))
//! #     .build()?;
//! let mut simulation = Simulation::builder(&scene).time_step(5e-4).build()?;
//! for _ in 0..100 {
//!     simulation.step();
//! }
//! let bytes = simulation.checkpoint(); // `save` writes them to a file
//! let mut resumed = Simulation::resume(&scene, &bytes)?;
//! for _ in 0..100 {
//!     simulation.step();
//!     resumed.step();
//! }
//! assert_eq!(resumed.state_hash(), simulation.state_hash());
//! # Ok::<(), makadam::Error>(())
//! ```

mod draft;
mod envelope;
pub(super) mod state;

pub use draft::{DRAFT, replace_with, sync_file, sync_folder, write_atomically};
pub use envelope::{checksum, open, seal};

use crate::Simulation;
use crate::scene::Scene;
use state::State;
use std::path::{Path, PathBuf};

/// First bytes of a file; the last one is the version of the format.
const MARK: [u8; 8] = *b"makadam\x0d";

/// The same of a simulation in which grains have come or gone, walls are moved by the caller, the candidate list holds more than what was
/// near when it was built, or the ledger has something from outside or in tangential springs: what that is follows the state.
const MARK_OF_ALTERED: [u8; 8] = *b"makadam\x0e";

/// Why a checkpoint could not be written or read.
#[derive(Debug, thiserror::Error)]
pub enum CheckpointError {
    /// The system refused.
    #[error("{}: {source}; check that the path is right and the disk has room", file.display())]
    Io {
        /// The file.
        file: PathBuf,
        /// What the system said.
        source: std::io::Error,
    },
    /// The bytes are no checkpoint of this version, or not one of this scene.
    #[error("the checkpoint {problem}; delete it and start anew")]
    Format {
        /// What is wrong.
        problem: String,
    },
}

impl Simulation {
    /// The present state as a checkpoint. Forces that were [applied](Simulation::apply_forces) to the step to come are not part of it.
    pub fn checkpoint(&self) -> Vec<u8> {
        State::of(self).write()
    }

    /// Writes a checkpoint to a file; whatever happens meanwhile, what stood there before or the whole of it is there.
    ///
    /// # Errors
    /// [`CheckpointError::Io`] if the file cannot be written.
    pub fn save(&self, file: impl AsRef<Path>) -> Result<(), CheckpointError> {
        let file = file.as_ref();
        write_atomically(file, &self.checkpoint()).map_err(|source| CheckpointError::Io { file: file.into(), source })
    }

    /// Goes on from a checkpoint of the same scene, bit for bit as if it had never stopped; also where grains had been inserted or removed,
    /// or walls been moved by the caller.
    ///
    /// # Errors
    /// [`CheckpointError::Format`] if the bytes are damaged, or belong to another version or scene.
    pub fn resume(scene: &Scene, bytes: &[u8]) -> Result<Simulation, CheckpointError> {
        let refuse = |problem| CheckpointError::Format { problem };
        State::read(bytes).and_then(|state| state.resume(scene)).map_err(refuse)
    }

    /// Starts a scene at time zero from the grains of a checkpoint in place of its jittered lattice, with the impulses of their
    /// contacts scaled to the scene's time step.
    ///
    /// # Errors
    /// [`CheckpointError::Format`] if the bytes are damaged, of another version, or hold other grains than the scene.
    pub fn start_from(scene: &Scene, bytes: &[u8]) -> Result<Simulation, CheckpointError> {
        let refuse = |problem| CheckpointError::Format { problem };
        State::read(bytes).and_then(|state| state.start(scene)).map_err(refuse)
    }
}
