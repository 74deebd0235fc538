//! One run at a time writes into an output folder: a lock that the system releases when the process ends, however it ends.

use super::{WriteError, create_folder};
use crate::provenance::command_line;
use rustix::fs::OFlags;
use std::fs::{File, OpenOptions, TryLockError};
use std::io::{Read, Seek, Write};
use std::os::unix::fs::{MetadataExt, OpenOptionsExt};
use std::path::{Path, PathBuf};

/// Name of the file in the folder that is locked; it is removed when the run ends by itself.
const NAME: &str = "run.lock";

/// Longest account of the holder that is repeated, bytes.
const ACCOUNT: u64 = 300;

/// Tries to lock a file that the holder before removes at the same time.
const TRIES: usize = 100;

/// A folder that no other run writes into.
pub struct FolderLock {
    folder: PathBuf,
    /// True if the lock has made the folder.
    made: bool,
    /// Absent where the file system knows no locks.
    file: Option<File>,
}

/// Error of a folder that cannot be locked.
#[derive(Debug, thiserror::Error)]
pub enum LockError {
    /// Another run writes there.
    #[error("{folder}: in use by {holder}; wait for its end, or write elsewhere with --output")]
    Taken {
        /// The folder.
        folder: String,
        /// Who says to use it.
        holder: String,
    },
    /// The system refused.
    #[error(transparent)]
    Write(#[from] WriteError),
}

impl FolderLock {
    /// Takes a folder; makes it where it is missing.
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
            // The holder before may have removed the file after it was opened here: then this lock is one on nothing.
            let here = path.symlink_metadata().is_ok_and(|there| {
                file.metadata().is_ok_and(|mine| (mine.dev(), mine.ino()) == (there.dev(), there.ino()))
            });
            if here {
                // Who has the folder is told for convenience: the lock itself is what counts.
                let account = format!("process {}: {}", std::process::id(), command_line());
                let _ = file.set_len(0).and_then(|()| file.write_all(account.as_bytes()));
                return Ok(FolderLock { folder: folder.into(), made, file: Some(file) });
            }
        }
        let busy = std::io::Error::from(std::io::ErrorKind::ResourceBusy);
        Err(refused(busy).into())
    }

    /// Returns false where the file system knows no locks.
    pub fn holds(&self) -> bool {
        self.file.is_some()
    }
}

impl Drop for FolderLock {
    fn drop(&mut self) {
        // Removed while the lock is held: nobody else can hold one on this file. What cannot be removed is locked again next time.
        let _ = std::fs::remove_file(self.folder.join(NAME));
        if self.made {
            // Only where nothing was written.
            let _ = std::fs::remove_dir(&self.folder);
        }
    }
}

/// Reads the account of the holder of a lock.
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
#[path = "../../tests/unit/output_lock.rs"]
mod tests;
