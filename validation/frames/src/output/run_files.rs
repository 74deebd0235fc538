//! Files of a run in an output folder: those that a new run may remove, and no others.

use super::WriteError;
use makadam::checkpoint::DRAFT;
use std::io::ErrorKind;
use std::path::{Path, PathBuf};

/// The files of a run in an output folder.
pub struct RunFiles<'a> {
    output: &'a Path,
}

impl<'a> RunFiles<'a> {
    /// The frames.
    pub const FRAMES: &'static str = "frames.mkd";

    /// Frames that are measured at the end and not among [`RunFiles::FRAMES`].
    pub const MEASURED: &'static str = "measured-frames.mkd";

    /// The summary.
    pub const SUMMARY: &'static str = "run.json";

    /// The checkpoint.
    pub const CHECKPOINT: &'static str = "run.checkpoint";

    /// The table over time.
    pub const TABLE: &'static str = "observables.csv";

    /// Files that a new run replaces. The summary is replaced at once, so that a folder always states what it holds.
    const RESULTS: [&'static str; 4] = [Self::FRAMES, Self::MEASURED, Self::CHECKPOINT, Self::TABLE];

    /// The files of a run in a folder, which may be missing.
    pub fn inside(output: &'a Path) -> RunFiles<'a> {
        RunFiles { output }
    }

    /// Returns true if a run has left a file.
    pub fn any(&self) -> bool {
        let mut names = Self::RESULTS.iter().chain([&Self::SUMMARY]);
        names.any(|name| self.output.join(name).symlink_metadata().is_ok())
    }

    /// Removes the results and drafts; the summary stays, to be replaced.
    pub fn remove(&self) -> Result<(), WriteError> {
        self.remove_drafts()?;
        Self::RESULTS.iter().try_for_each(|name| remove(&self.output.join(name)))
    }

    /// Removes unfinished files of processes that were killed. The caller holds the lock of the folder.
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

/// Returns true for an unfinished file of a run: its name, the mark of drafts, and numbers.
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

#[cfg(test)]
#[path = "../../tests/unit/output_run_files.rs"]
mod tests;
