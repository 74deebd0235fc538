//! Frames of a run in the formats of other programs. A format is a file of this module and a line of the table in
//! `plan.rs`.

pub mod csv;
mod fields;
mod gsd;
mod vtkhdf;
pub(crate) mod vtp;

pub(crate) use vtkhdf::FIRST_ID;

use crate::output::{WriteError, create_folder};
use crate::plan::{FrameFormat, with_frame_formats};
use crate::run_frames::{RunFolderError, RunFrames};
use std::ops::Range;
use std::path::{Path, PathBuf};

/// Written file.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Written {
    /// File.
    pub path: PathBuf,
    /// Number of frames in the file.
    pub frames: usize,
}

/// Writes all frames of a run into a folder; reports the fraction done.
///
/// # Errors
/// [`ExportError`] if a frame cannot be read, or the system refuses.
pub fn write(
    format: FrameFormat,
    run: &RunFrames,
    folder: &Path,
    progress: &dyn Fn(f64),
) -> Result<Vec<Written>, ExportError> {
    macro_rules! write_as {
        ($($variant:ident $module:ident $program:literal,)*) => {
            match format {
                $(FrameFormat::$variant => $module::write(run, folder, progress),)*
            }
        };
    }
    create_folder(folder)?;
    with_frame_formats!(write_as)
}

/// Iterates over frames by their numbers; reports the fraction done.
///
/// # Errors
/// An error of `work`, or [`ExportError::Interrupted`].
fn for_each(
    numbers: Range<usize>,
    progress: &dyn Fn(f64),
    mut work: impl FnMut(usize) -> Result<(), ExportError>,
) -> Result<(), ExportError> {
    let count = numbers.len() as f64;
    for (done, number) in numbers.enumerate() {
        work(number)?;
        progress((done + 1) as f64 / count);
        if crate::interrupt::requested() {
            return Err(ExportError::Interrupted);
        }
    }
    Ok(())
}

/// Error of an export.
#[derive(Debug, thiserror::Error)]
pub enum ExportError {
    /// Unreadable frames.
    #[error(transparent)]
    Frames(#[from] RunFolderError),
    /// Error of the system.
    #[error(transparent)]
    Write(#[from] WriteError),
    /// HDF5 cannot hold the numbers.
    #[error("{file}: {problem}")]
    Format {
        /// File.
        file: String,
        /// Error message.
        problem: String,
    },
    /// Stop request of the user.
    #[error("interrupted")]
    Interrupted,
}
