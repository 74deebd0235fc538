//! Frames of a run in the formats of other programs: VTKHDF for ParaView, GSD for OVITO.
//!
//! Both are made from the frames on disk, finished run or not, so that a run that is killed loses nothing: its frames are there, and this
//! makes one file of them whenever it is wanted.

mod gsd;
mod vtkhdf;

pub use gsd::{absent_from_gsd, write_gsd};
pub(crate) use vtkhdf::FIRST_ID;
pub use vtkhdf::{Kind, write_vtkhdf};

use crate::output::WriteError;
use crate::run_frames::RunFolderError;

/// Why frames cannot be exported.
#[derive(Debug, thiserror::Error)]
pub enum ExportError {
    /// The frames cannot be read.
    #[error(transparent)]
    Frames(#[from] RunFolderError),
    /// The system refuses.
    #[error(transparent)]
    Write(#[from] WriteError),
    /// HDF5 cannot hold the numbers.
    #[error("{file}: {problem}")]
    Format {
        /// The file.
        file: String,
        /// What is wrong.
        problem: String,
    },
    /// The user asked to stop.
    #[error("interrupted")]
    Interrupted,
}
