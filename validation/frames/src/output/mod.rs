//! Files of a run: tables as CSV, the summary as JSON, and the building blocks of frames for exports and pictures.

pub mod cells;
mod folders;
pub mod mesh;
mod run_files;
mod table;

pub use cells::shown;
pub use folders::{cache_folder, file_stem, record_folder, run_folder};
pub use run_files::{FolderLock, LockError, RunFiles};
pub(crate) use table::open_to_grow;
pub use table::{TableWritten, TimeTable};

/// Version of the JSON documents, raised when a field changes its meaning or is removed.
pub const JSON_VERSION: u32 = 1;

/// Section of the arrays of a whole file in VTK's formats.
pub(crate) const FIELD_DATA: &str = "FieldData";

/// First bytes of every HDF5 file.
pub const HDF5: [u8; 8] = *b"\x89HDF\r\n\x1a\n";

use makadam::checkpoint::{replace_with, write_atomically};
use std::io::Write;
use std::path::{Path, PathBuf};

/// Error of a file that cannot be written.
#[derive(Debug, thiserror::Error)]
#[error("{path}: {source}{}", remedy(source))]
pub struct WriteError {
    /// File or folder.
    pub path: String,
    /// Error of the system.
    pub source: std::io::Error,
}

/// Returns the remedy; messages about invalid data hold their own.
fn remedy(source: &std::io::Error) -> &'static str {
    match source.kind() {
        std::io::ErrorKind::InvalidData => "",
        std::io::ErrorKind::AlreadyExists | std::io::ErrorKind::NotADirectory => "; a file is there: name a folder",
        _ => "; check that the path is writable and the disk has room",
    }
}

impl WriteError {
    /// Makes an error about a path.
    pub fn new(path: &Path, source: std::io::Error) -> WriteError {
        WriteError { path: path.display().to_string(), source }
    }
}

/// Creates a folder and its parent folders.
pub fn create_folder(path: &Path) -> Result<(), WriteError> {
    std::fs::create_dir_all(path).map_err(|source| WriteError::new(path, source))
}

/// Creates the parent folders of a file, if its path names any.
pub fn create_folder_of(file: &Path) -> Result<(), WriteError> {
    match file.parent().filter(|folder| !folder.as_os_str().is_empty()) {
        Some(folder) => create_folder(folder),
        None => Ok(()),
    }
}

/// Temporary file, removed unless finished.
pub struct Draft {
    path: PathBuf,
    draft: PathBuf,
}

impl Draft {
    /// Returns the temporary file for a path.
    pub fn of(path: &Path) -> Draft {
        let mut draft = path.as_os_str().to_owned();
        draft.push(format!(".part{}", std::process::id()));
        Draft { path: path.to_path_buf(), draft: draft.into() }
    }

    /// Returns the temporary name.
    pub fn name(&self) -> &Path {
        &self.draft
    }

    /// Renames the file to its final name.
    ///
    /// # Errors
    /// [`WriteError`] if the system refuses.
    pub fn finish(self) -> Result<(), WriteError> {
        std::fs::rename(&self.draft, &self.path).map_err(|source| WriteError::new(&self.path, source))
    }
}

impl Drop for Draft {
    fn drop(&mut self) {
        // A temporary file that cannot be removed is recognised by its name.
        let _ = std::fs::remove_file(&self.draft);
    }
}

/// Writes a file through a temporary file: the previous content stays intact until the new file is complete.
pub fn write_whole(path: &Path, bytes: &[u8]) -> Result<(), WriteError> {
    replace_with(path, |draft| draft.write_all(bytes)).map_err(|source| WriteError::new(path, source))
}

/// Writes a file as [`write_whole`] does, and flushes it to the disk: the file survives a power failure.
pub fn write_durably(path: &Path, bytes: &[u8]) -> Result<(), WriteError> {
    write_atomically(path, bytes).map_err(|source| WriteError::new(path, source))
}
