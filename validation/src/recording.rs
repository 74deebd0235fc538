//! What one run of one code leaves behind: its frames and where they came from.

use makadam::snapshot::Snapshot;
use serde::{Deserialize, Serialize};
use std::path::Path;

/// One run of a scene in one code.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Recording {
    /// Name of the scene.
    pub scene: String,
    /// Name of the code: "Makadam", "YADE" or "LIGGGHTS".
    pub code: String,
    /// Version that the code reports of itself.
    pub version: String,
    /// Seed of the initial positions.
    pub seed: u64,
    /// Time step, s.
    pub time_step: f64,
    /// Time step over the Rayleigh step; absent for codes that are not bound by it.
    pub rayleigh_fraction: Option<f64>,
    /// Factor on every Young's modulus of the scene.
    pub stiffness_factor: f64,
    /// Threads used.
    pub threads: usize,
    /// Wall time of the time stepping, s, set-up and output left out as far as the code tells them apart.
    pub wall_seconds: f64,
    /// Simulated time, s.
    pub simulated_seconds: f64,
    /// Frames, in the order of time, the last one at the end of the run.
    pub frames: Vec<Snapshot>,
}

/// Why a recording file could not be written or read.
#[derive(Debug, thiserror::Error)]
pub enum RecordingError {
    /// The system refused.
    #[error("{0}: {1}; check that the path is right and the disk has room")]
    Io(String, std::io::Error),
    /// The bytes are not a recording.
    #[error("{0}: not a recording: {1}; delete it and run the code again")]
    Format(String, postcard::Error),
}

impl Recording {
    /// Writes the recording as one file, through a temporary name so that a half-written file is never read.
    ///
    /// # Errors
    /// [`RecordingError`] if the file cannot be written.
    pub fn save(&self, path: &Path) -> Result<(), RecordingError> {
        let bytes = postcard::to_stdvec(self).map_err(|e| RecordingError::Format(path.display().to_string(), e))?;
        let draft = path.with_extension("part");
        let io = |e| RecordingError::Io(path.display().to_string(), e);
        if let Some(folder) = path.parent() {
            std::fs::create_dir_all(folder).map_err(io)?;
        }
        std::fs::write(&draft, bytes).map_err(io)?;
        std::fs::rename(&draft, path).map_err(io)
    }

    /// Reads a recording.
    ///
    /// # Errors
    /// [`RecordingError`] if the file cannot be read or is not a recording.
    pub fn load(path: &Path) -> Result<Recording, RecordingError> {
        let bytes = std::fs::read(path).map_err(|e| RecordingError::Io(path.display().to_string(), e))?;
        postcard::from_bytes(&bytes).map_err(|e| RecordingError::Format(path.display().to_string(), e))
    }
}
