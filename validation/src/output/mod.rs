//! What `makadam run` leaves on disk: frames for ParaView, observables as CSV, a summary as JSON.

pub(crate) mod cells;
mod frames;
mod record;
mod summary;
mod table;
mod vtk;

pub use frames::FrameWriter;
pub use record::record_folder;
pub use summary::{AlarmSummary, JSON_VERSION, Measured, PhaseTimes, RunSummary, SolveSummary};
pub use table::TimeTable;

use std::path::Path;

/// Why something could not be written.
#[derive(Debug, thiserror::Error)]
#[error("{path}: {source}; check that the path is writable and the disk has room")]
pub struct WriteError {
    /// What was being written.
    pub path: String,
    /// What the system said.
    pub source: std::io::Error,
}

impl WriteError {
    /// An error about a path.
    pub fn new(path: &Path, source: std::io::Error) -> WriteError {
        WriteError { path: path.display().to_string(), source }
    }
}

/// Makes a folder and those above it.
///
/// # Errors
/// [`WriteError`] if the system refuses.
pub fn create_folder(path: &Path) -> Result<(), WriteError> {
    std::fs::create_dir_all(path).map_err(|source| WriteError::new(path, source))
}

/// Writes a file through a temporary name, so that what stood there before stays whole until the new one is.
///
/// # Errors
/// [`WriteError`] if the system refuses; the half-written file is removed then.
pub fn write_whole(path: &Path, bytes: &[u8]) -> Result<(), WriteError> {
    let mut name = path.file_name().unwrap_or_default().to_os_string();
    name.push(".part");
    let draft = path.with_file_name(name);
    let written = std::fs::write(&draft, bytes).and_then(|()| std::fs::rename(&draft, path));
    written.map_err(|source| {
        // Only a regular file is ours to remove.
        if draft.symlink_metadata().is_ok_and(|data| data.is_file()) {
            let _ = std::fs::remove_file(&draft);
        }
        WriteError::new(path, source)
    })
}
