//! Frames of a run in the formats of other programs. A format is one file of this module and one entry of [`FORMATS`].

mod gsd;
mod vtkhdf;
mod vtp;

pub(crate) use vtkhdf::FIRST_ID;

use crate::output::WriteError;
use crate::plan::FrameFormat;
use crate::run_frames::{RunFolderError, RunFrames};
use std::path::{Path, PathBuf};

/// The formats.
pub const FORMATS: [Format; 3] = [
    Format { format: FrameFormat::Vtp, name: "vtp", write: vtp::write },
    Format { format: FrameFormat::Vtkhdf, name: "vtkhdf", write: vtkhdf::write },
    Format { format: FrameFormat::Gsd, name: "gsd", write: gsd::write },
];

/// A format of frames.
#[derive(Clone, Copy, Debug)]
pub struct Format {
    format: FrameFormat,
    /// Name in commands and scenes.
    pub name: &'static str,
    write: Write,
}

/// Writes all frames of a run into a folder; reports the fraction that is done.
type Write = fn(&RunFrames, &Path, &dyn Fn(f64)) -> Result<Vec<Written>, ExportError>;

/// A file that was written.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Written {
    /// The file.
    pub path: PathBuf,
    /// Number of frames in it.
    pub frames: usize,
}

impl Format {
    /// Returns a format that a scene requests.
    ///
    /// # Panics
    /// The table lacks a format.
    pub fn of(format: FrameFormat) -> Format {
        *FORMATS.iter().find(|known| known.format == format).expect("the table holds every format")
    }

    /// Writes all frames of a run into a folder; reports the fraction that is done.
    ///
    /// # Errors
    /// [`ExportError`] if a frame cannot be read, or the system refuses.
    pub fn write(&self, run: &RunFrames, folder: &Path, progress: &dyn Fn(f64)) -> Result<Vec<Written>, ExportError> {
        (self.write)(run, folder, progress)
    }
}

/// Error of an export.
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
        /// Fault.
        problem: String,
    },
    /// The user asked to stop.
    #[error("interrupted")]
    Interrupted,
}
