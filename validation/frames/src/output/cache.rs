//! The folder in which the program keeps what it can make again.

use super::WriteError;
use std::fs::DirBuilder;
use std::io::{Error, ErrorKind};
use std::os::unix::fs::{DirBuilderExt, MetadataExt};
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicU64, Ordering};

/// Folder in which prepared states and recordings are kept: `makadam` in `XDG_CACHE_HOME` or in `~/.cache`. Without either it is
/// `makadam-UID` where the system keeps temporary files, with the number of the user, who alone may read and write it.
///
/// # Errors
/// [`WriteError`] if the folder among temporary files belongs to somebody else, or others may write to it.
pub fn cache_folder() -> Result<PathBuf, WriteError> {
    let absolute = |name| std::env::var_os(name).map(PathBuf::from).filter(|path| path.is_absolute());
    let own = absolute("XDG_CACHE_HOME").or_else(|| absolute("HOME").map(|home| home.join(".cache")));
    match own {
        Some(folder) => Ok(folder.join("makadam")),
        None => private_folder(&std::env::temp_dir(), rustix::process::getuid().as_raw()),
    }
}

/// Path for the files of one run of a code in [`cache_folder`], which no other run has while this process lives: not of another process,
/// and not of this one, where several may be made of the same scene and seed. Nothing is created.
pub fn run_folder(name: &str) -> Result<PathBuf, WriteError> {
    static RUNS: AtomicU64 = AtomicU64::new(1);
    let number = RUNS.fetch_add(1, Ordering::Relaxed);
    Ok(cache_folder()?.join("runs").join(format!("{name}-{}-{number}", std::process::id())))
}

/// The folder of a user in one that all users share.
fn private_folder(shared: &Path, user: u32) -> Result<PathBuf, WriteError> {
    let folder = shared.join(format!("makadam-{user}"));
    let refuse = |error| WriteError::new(&folder, error);
    match DirBuilder::new().mode(0o700).create(&folder) {
        Err(error) if error.kind() != ErrorKind::AlreadyExists => return Err(refuse(error)),
        _ => {}
    }
    // Not through a link: anybody may have put one there.
    let data = folder.symlink_metadata().map_err(refuse)?;
    let problem = match () {
        () if !data.is_dir() => "it is not a folder",
        () if data.uid() != user => "it belongs to somebody else",
        () if data.mode() & 0o022 != 0 => "others may write to it",
        () => return Ok(folder),
    };
    let words =
        format!("{problem}, so that what is kept there cannot be trusted; set XDG_CACHE_HOME to a folder of your own");
    Err(refuse(Error::new(ErrorKind::PermissionDenied, words)))
}

#[cfg(test)]
#[path = "../../tests/unit/output_cache.rs"]
mod tests;
