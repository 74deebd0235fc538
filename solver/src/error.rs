//! All that can go wrong with the use of the library, as one type.

use crate::SettingError;
use crate::scene::{SceneError, SceneFileError};
use crate::simulation::checkpoint::CheckpointError;
use crate::simulation::intervention::InterventionError;
use crate::solve::NotConverged;

/// Error of the library.
#[derive(Debug, thiserror::Error)]
pub enum Error {
    /// A scene breaks a rule, or its grains cannot be placed.
    #[error(transparent)]
    Scene(#[from] SceneError),
    /// A scene from a file breaks a rule, with the line.
    #[error(transparent)]
    SceneFile(#[from] SceneFileError),
    /// The machine, or the scene, does not go with a setting.
    #[error(transparent)]
    Setting(#[from] SettingError),
    /// A checkpoint cannot be written, or gone on from.
    #[error(transparent)]
    Checkpoint(#[from] CheckpointError),
    /// An intervention between steps cannot be applied.
    #[error(transparent)]
    Intervention(#[from] InterventionError),
    /// A solve ended before it came to its bound.
    #[error(transparent)]
    NotConverged(#[from] NotConverged),
}
