//! Files of a run in an output folder, the only files that a new run may remove, and the folder lock. One run at a time writes there; the
//! system releases the lock at the end of the process, also after a crash.

use super::{WriteError, create_folder};
use crate::provenance::command_line;
use makadam::checkpoint::DRAFT;
use rustix::fs::OFlags;
use std::fs::{File, OpenOptions, TryLockError};
use std::io::{ErrorKind, Read, Seek, Write};
use std::os::unix::fs::{MetadataExt, OpenOptionsExt};
use std::path::{Path, PathBuf};

/// Files of a run in an output folder.
pub struct RunFiles<'a> {
    output: &'a Path,
}

impl<'a> RunFiles<'a> {
    /// Frames.
    pub const FRAMES: &'static str = "frames.mkd";

    /// Frames measured at the end and missing from [`RunFiles::FRAMES`].
    pub const MEASURED: &'static str = "measured-frames.mkd";

    /// Summary.
    pub const SUMMARY: &'static str = "run.json";

    /// Checkpoint.
    pub const CHECKPOINT: &'static str = "run.checkpoint";

    /// State without a violation, while the run steps.
    pub const HELD: &'static str = "run.held";

    /// Table over time.
    pub const TABLE: &'static str = "observables.csv";

    /// Files that a new run replaces. The summary is replaced at once, so that a folder always describes its content.
    const RESULTS: [&'static str; 5] = [Self::FRAMES, Self::MEASURED, Self::CHECKPOINT, Self::HELD, Self::TABLE];

    /// Returns the files of a run in a folder, some of them possibly missing.
    pub fn inside(output: &'a Path) -> RunFiles<'a> {
        RunFiles { output }
    }

    /// Returns true if a run has left a file.
    pub fn any(&self) -> bool {
        let mut names = Self::RESULTS.iter().chain([&Self::SUMMARY]);
        names.any(|name| self.output.join(name).symlink_metadata().is_ok())
    }

    /// Removes the results and temporary files; the summary stays until its replacement.
    pub fn remove(&self) -> Result<(), WriteError> {
        self.remove_drafts()?;
        Self::RESULTS.iter().try_for_each(|name| remove(&self.output.join(name)))
    }

    /// Removes temporary files of killed processes. The caller holds the lock of the folder.
    pub fn remove_drafts(&self) -> Result<(), WriteError> {
        let refused = |source| WriteError::new(self.output, source);
        let entries = match std::fs::read_dir(self.output) {
            Ok(entries) => entries,
            Err(error) if matches!(error.kind(), ErrorKind::NotFound | ErrorKind::NotADirectory) => return Ok(()),
            Err(error) => return Err(refused(error)),
        };
        let entries: Vec<PathBuf> =
            entries.map(|entry| entry.map(|entry| entry.path())).collect::<Result<_, _>>().map_err(refused)?;
        entries.iter().filter(|path| is_draft(path)).try_for_each(|path| remove(path))
    }
}

/// Returns true for a temporary file of a run: its name, the mark of temporary files, and numbers.
fn is_draft(path: &Path) -> bool {
    let name = path.file_name().and_then(|name| name.to_str()).unwrap_or_default();
    let Some((stem, number)) = name.rsplit_once(DRAFT) else { return false };
    let plain = number.bytes().all(|byte| byte.is_ascii_digit() || byte == b'-');
    plain && (RunFiles::RESULTS.contains(&stem) || stem == RunFiles::SUMMARY) && !path.is_dir()
}

fn remove(path: &Path) -> Result<(), WriteError> {
    match std::fs::remove_file(path) {
        Err(error) if error.kind() != ErrorKind::NotFound => Err(WriteError::new(path, error)),
        _ => Ok(()),
    }
}

/// Name of the lock file in the folder, removed at the end of an uninterrupted run.
const NAME: &str = "run.lock";

/// Byte limit of the holder's description in messages.
const ACCOUNT: u64 = 300;

/// Attempts to lock a file that the previous holder removes at the same time.
const TRIES: usize = 100;

/// Output folder locked against other runs.
pub struct FolderLock {
    folder: PathBuf,
    /// True if the lock has created the folder.
    made: bool,
    /// Absent if the file system has no locks.
    file: Option<File>,
}

/// Error of a folder that cannot be locked.
#[derive(Debug, thiserror::Error)]
pub enum LockError {
    /// Another run writes there.
    #[error("{folder}: in use by {holder}; wait for its end, or write elsewhere with --output")]
    Taken {
        /// Folder.
        folder: String,
        /// Description of the holder, from the lock file.
        holder: String,
    },
    /// Error of the system.
    #[error(transparent)]
    Write(#[from] WriteError),
}

impl FolderLock {
    /// Locks a folder; creates a missing folder.
    pub fn take(folder: &Path) -> Result<FolderLock, LockError> {
        let made = !folder.exists();
        create_folder(folder)?;
        let path = folder.join(NAME);
        let refused = |source| WriteError::new(&path, source);
        for _ in 0..TRIES {
            let flags = OFlags::NOFOLLOW.bits() as i32;
            let opened =
                OpenOptions::new().read(true).write(true).create(true).truncate(false).custom_flags(flags).open(&path);
            let mut file = opened.map_err(refused)?;
            match file.try_lock() {
                Ok(()) => {}
                Err(TryLockError::WouldBlock) => {
                    let folder = folder.display().to_string();
                    return Err(LockError::Taken { folder, holder: holder(&mut file) });
                }
                Err(TryLockError::Error(_)) => {
                    return Ok(FolderLock { folder: folder.into(), made, file: None });
                }
            }
            // The previous holder may have removed the file after it was opened here: the lock would protect nothing.
            let here = path.symlink_metadata().is_ok_and(|there| {
                file.metadata().is_ok_and(|mine| (mine.dev(), mine.ino()) == (there.dev(), there.ino()))
            });
            if here {
                // The holder's description is for messages only: the lock itself decides.
                let account = format!("process {}: {}", std::process::id(), command_line());
                let _ = file.set_len(0).and_then(|()| file.write_all(account.as_bytes()));
                return Ok(FolderLock { folder: folder.into(), made, file: Some(file) });
            }
        }
        let busy = std::io::Error::from(ErrorKind::ResourceBusy);
        Err(refused(busy).into())
    }

    /// Returns false if the file system has no locks.
    pub fn holds(&self) -> bool {
        self.file.is_some()
    }
}

impl Drop for FolderLock {
    fn drop(&mut self) {
        // Removed while locked: no other process can lock this file. A file that cannot be removed is locked again next time.
        let _ = std::fs::remove_file(self.folder.join(NAME));
        if self.made {
            // Succeeds only for an empty folder.
            let _ = std::fs::remove_dir(&self.folder);
        }
    }
}

/// Reads the description of the holder of a lock.
fn holder(file: &mut File) -> String {
    let mut account = Vec::new();
    let read = file.rewind().and_then(|()| Read::by_ref(file).take(ACCOUNT).read_to_end(&mut account));
    let plain = |c: char| if c.is_control() { ' ' } else { c };
    let account: String = String::from_utf8_lossy(&account).chars().map(plain).collect();
    match read {
        Ok(length) if length > 0 => account,
        _ => "another process".into(),
    }
}

#[cfg(test)]
#[path = "../../tests/unit/output_run_files.rs"]
mod tests;
