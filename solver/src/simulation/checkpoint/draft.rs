//! Files that are whole or not there: each is written under a name of its own and takes its place when it is finished.

use std::ffi::OsString;
use std::fs::{File, OpenOptions};
use std::io::{Error, ErrorKind, Write};
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicU64, Ordering};

/// What follows the name of a file in the name of its draft; a number follows it in turn.
pub const DRAFT: &str = ".part";

/// Names that are tried before a folder full of drafts is given up.
const TRIES: usize = 1000;

/// Writes a file and its place in the folder to the disk; the folder is made where it is missing. Whatever happens, a cut of power
/// included, the whole new file or the whole old one is there.
///
/// # Errors
/// What the system says; the whole old file or the whole new one stands there then.
pub fn write_atomically(file: &Path, bytes: &[u8]) -> Result<(), Error> {
    if let Some(folder) = file.parent() {
        std::fs::create_dir_all(folder)?;
    }
    replace_with(file, |open| {
        open.write_all(bytes)?;
        open.sync_all()
    })?;
    sync_folder(file.parent().unwrap_or(Path::new("")))
}

/// Puts what `write` writes in the place of a file. Whatever happens to the process, the whole new file or the whole old one is
/// there; a cut of power may leave neither until [`sync_file`] and [`sync_folder`] have returned.
///
/// # Errors
/// What the system or `write` says; the old file stays then.
pub fn replace_with(file: &Path, write: impl FnOnce(&mut File) -> Result<(), Error>) -> Result<(), Error> {
    let (draft, mut open) = draft_of(file)?;
    let written = write(&mut open);
    drop(open);
    written.and_then(|()| std::fs::rename(&draft, file)).inspect_err(|_| {
        // A draft that cannot be removed does no harm: it is never read.
        let _ = std::fs::remove_file(&draft);
    })
}

/// A new file beside `file`. What stands there already is never opened: it may be a link that somebody planted.
fn draft_of(file: &Path) -> Result<(PathBuf, File), Error> {
    static NUMBER: AtomicU64 = AtomicU64::new(0);
    let name = file.file_name().ok_or_else(|| Error::new(ErrorKind::InvalidInput, "is not the name of a file"))?;
    let mut refused = None;
    for _ in 0..TRIES {
        let mut name: OsString = name.to_os_string();
        name.push(format!("{DRAFT}{}-{}", std::process::id(), NUMBER.fetch_add(1, Ordering::Relaxed)));
        let draft = file.with_file_name(name);
        match OpenOptions::new().write(true).create_new(true).open(&draft) {
            Ok(open) => return Ok((draft, open)),
            Err(error) if error.kind() == ErrorKind::AlreadyExists => refused = Some(error),
            Err(error) => return Err(error),
        }
    }
    Err(refused.unwrap_or_else(|| ErrorKind::AlreadyExists.into()))
}

/// Writes what a file holds to the disk.
///
/// # Errors
/// What the system says.
pub fn sync_file(file: &Path) -> Result<(), Error> {
    File::open(file)?.sync_all()
}

/// Writes the names in a folder to the disk: what was made, renamed and removed there. An empty path is the folder at hand.
///
/// # Errors
/// What the system says; a file system that cannot do it is no error.
pub fn sync_folder(folder: &Path) -> Result<(), Error> {
    let here = if folder.as_os_str().is_empty() { Path::new(".") } else { folder };
    match File::open(here)?.sync_all() {
        Err(error) if matches!(error.kind(), ErrorKind::InvalidInput | ErrorKind::Unsupported) => Ok(()),
        done => done,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn folder(name: &str) -> PathBuf {
        let folder = std::env::temp_dir().join(format!("makadam-draft-{name}-{}", std::process::id()));
        let _ = std::fs::remove_dir_all(&folder);
        std::fs::create_dir_all(&folder).unwrap();
        folder
    }

    #[cfg(unix)]
    #[test]
    fn a_draft_never_follows_a_link_that_stands_in_its_place() {
        let folder = folder("links");
        let (file, victim) = (folder.join("state"), folder.join("victim"));
        std::fs::write(&victim, "untouched").unwrap();
        // Names that drafts have had, would have next, or would have in another process.
        for number in 0..200 {
            for name in
                [format!("state.part{}-{number}", std::process::id()), format!("state.part{}", std::process::id())]
            {
                let _ = std::os::unix::fs::symlink(&victim, folder.join(name));
            }
        }
        std::os::unix::fs::symlink(&victim, folder.join("state.part")).unwrap();
        std::os::unix::fs::symlink(&victim, &file).unwrap();
        write_atomically(&file, b"new").unwrap();
        assert_eq!(std::fs::read(&file).unwrap(), b"new");
        assert!(!file.is_symlink());
        assert_eq!(std::fs::read(&victim).unwrap(), b"untouched");
        std::fs::remove_dir_all(folder).unwrap();
    }

    #[test]
    fn what_cannot_be_written_leaves_the_old_file_and_no_draft() {
        let folder = folder("failure");
        let file = folder.join("state");
        write_atomically(&file, b"old").unwrap();
        let failed = replace_with(&file, |open| {
            open.write_all(b"half")?;
            Err(ErrorKind::StorageFull.into())
        });
        assert_eq!(failed.unwrap_err().kind(), ErrorKind::StorageFull);
        assert_eq!(std::fs::read(&file).unwrap(), b"old");
        assert_eq!(std::fs::read_dir(&folder).unwrap().count(), 1);
        std::fs::remove_dir_all(folder).unwrap();
    }
}
