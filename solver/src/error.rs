//! Common error type of the library.

use crate::SettingError;
use crate::scene::{SceneError, SceneFileError};
use crate::simulation::checkpoint::CheckpointError;
use crate::simulation::intervention::InterventionError;
use crate::solve::NotConverged;

/// Error of the library.
#[derive(Debug, thiserror::Error)]
pub enum Error {
    /// A scene is invalid, or its grains cannot be placed.
    #[error(transparent)]
    Scene(#[from] SceneError),
    /// A scene from a file is invalid; the error contains the line.
    #[error(transparent)]
    SceneFile(#[from] SceneFileError),
    /// A setting is incompatible with the machine or the scene.
    #[error(transparent)]
    Setting(#[from] SettingError),
    /// A checkpoint cannot be written or resumed.
    #[error(transparent)]
    Checkpoint(#[from] CheckpointError),
    /// An intervention between steps cannot be applied.
    #[error(transparent)]
    Intervention(#[from] InterventionError),
    /// A solve ended before its residual bound.
    #[error(transparent)]
    NotConverged(#[from] NotConverged),
}
