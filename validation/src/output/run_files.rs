//! Which files a run writes, by their names: what may be removed for the next one, and nothing else.

use super::{WriteError, create_folder, frames};
use makadam::checkpoint::{DRAFT, sync_folder};
use std::io::ErrorKind;
use std::path::{Path, PathBuf};

/// The files of a run in an output folder.
pub struct RunFiles<'a> {
    output: &'a Path,
}

/// What a name in an output folder stands for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Kind {
    /// What a run has made.
    Result,
    /// What a process that was killed had not finished.
    Draft,
}

impl<'a> RunFiles<'a> {
    /// The frames that are measured at the end.
    pub const MEASURED: &'static str = "measured-frames";

    /// The summary.
    pub const SUMMARY: &'static str = "run.json";

    /// The checkpoint.
    pub const CHECKPOINT: &'static str = "run.checkpoint";

    /// What opens the frames in ParaView.
    pub const PARAVIEW: &'static str = "open-in-paraview.py";

    /// The table over time.
    pub const TABLE: &'static str = "observables.csv";

    /// The files of a run in a folder, which may be missing.
    pub fn inside(output: &'a Path) -> RunFiles<'a> {
        RunFiles { output }
    }

    /// Whether there is anything that a run has made.
    ///
    /// # Errors
    /// [`WriteError`] if the folder cannot be read.
    pub fn any(&self) -> Result<bool, WriteError> {
        Ok(!self.of(Kind::Result)?.is_empty() || self.output.join(Self::SUMMARY).symlink_metadata().is_ok())
    }

    /// Removes frames, collections, table, checkpoint and drafts, and folders that are empty then; the summary stays, to be
    /// replaced.
    ///
    /// # Errors
    /// [`WriteError`] if the system refuses.
    pub fn remove(&self) -> Result<(), WriteError> {
        self.remove_drafts()?;
        remove_all(&self.of(Kind::Result)?)?;
        // One that holds something of somebody else's stays.
        let _ = std::fs::remove_dir(self.output.join(frames::FOLDER));
        Ok(())
    }

    /// Removes what processes that were killed had not finished. Only for who holds the folder.
    ///
    /// # Errors
    /// [`WriteError`] if the system refuses.
    pub fn remove_drafts(&self) -> Result<(), WriteError> {
        remove_all(&self.of(Kind::Draft)?)
    }

    /// Removes frames from a number on.
    ///
    /// # Errors
    /// [`WriteError`] if the system refuses.
    pub fn remove_frames_from(&self, number: usize) -> Result<(), WriteError> {
        let late = |path: &PathBuf| frame_number(path).is_some_and(|found| found >= number);
        remove_all(&self.of(Kind::Result)?.into_iter().filter(late).collect::<Vec<_>>())
    }

    /// Moves everything but the summary into another folder, over what stands there.
    ///
    /// # Errors
    /// [`WriteError`] if the system refuses.
    pub fn move_to(&self, folder: &Path) -> Result<(), WriteError> {
        create_folder(&folder.join(frames::FOLDER))?;
        for path in self.of(Kind::Result)? {
            let place = folder.join(path.strip_prefix(self.output).unwrap_or(&path));
            std::fs::rename(&path, &place).map_err(|source| WriteError::new(&place, source))?;
        }
        for folder in [folder.join(frames::FOLDER), folder.to_path_buf()] {
            sync_folder(&folder).map_err(|source| WriteError::new(&folder, source))?;
        }
        Ok(())
    }

    fn of(&self, kind: Kind) -> Result<Vec<PathBuf>, WriteError> {
        let mut found = Vec::new();
        for (folder, named) in
            [(self.output.to_path_buf(), top as fn(&str) -> bool), (self.output.join(frames::FOLDER), frame)]
        {
            let refused = |source| WriteError::new(&folder, source);
            let entries = match std::fs::read_dir(&folder) {
                Ok(entries) => entries,
                Err(error) if matches!(error.kind(), ErrorKind::NotFound | ErrorKind::NotADirectory) => continue,
                Err(error) => return Err(refused(error)),
            };
            for entry in entries {
                let entry = entry.map_err(refused)?;
                let name = entry.file_name();
                let is_folder = entry.file_type().map_err(refused)?.is_dir();
                if !is_folder && name.to_str().and_then(|name| meaning(name, named)) == Some(kind) {
                    found.push(entry.path());
                }
            }
        }
        Ok(found)
    }
}

/// What a name stands for where results have such names.
fn meaning(name: &str, result: impl Fn(&str) -> bool) -> Option<Kind> {
    if result(name) {
        return Some(Kind::Result);
    }
    let (stem, number) = name.rsplit_once(DRAFT)?;
    let plain = number.bytes().all(|byte| byte.is_ascii_digit() || byte == b'-');
    (plain && (result(stem) || stem == RunFiles::SUMMARY)).then_some(Kind::Draft)
}

/// The summary is none of them: it is replaced, so that there is always one that tells what the folder holds.
fn top(name: &str) -> bool {
    let collection = name.strip_suffix(".pvd").is_some_and(|kind| frames::KINDS.contains(&kind));
    collection || [RunFiles::CHECKPOINT, RunFiles::TABLE, RunFiles::MEASURED, RunFiles::PARAVIEW].contains(&name)
}

fn frame(name: &str) -> bool {
    let kind_and_number = name.strip_suffix(".vtp").and_then(|stem| stem.split_once('-'));
    kind_and_number.is_some_and(|(kind, number)| frames::KINDS.contains(&kind) && is_number(number))
}

/// Frames are numbered with five digits or more.
fn is_number(text: &str) -> bool {
    text.len() >= 5 && text.bytes().all(|byte| byte.is_ascii_digit())
}

fn frame_number(path: &Path) -> Option<usize> {
    let name = path.file_name()?.to_str()?;
    let (_, number) = name.strip_suffix(".vtp")?.split_once('-')?;
    frame(name).then(|| number.parse().ok())?
}

fn remove_all(paths: &[PathBuf]) -> Result<(), WriteError> {
    paths.iter().try_for_each(|path| match std::fs::remove_file(path) {
        Err(error) if error.kind() != ErrorKind::NotFound => Err(WriteError::new(path, error)),
        _ => Ok(()),
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_names_that_a_run_gives_are_removed() {
        let folder = tempfile::tempdir().unwrap();
        let ours = [
            "run.checkpoint",
            "observables.csv",
            "grains.pvd",
            "contacts.pvd",
            "frames/grains-00000.vtp",
            "frames/contacts-123456.vtp",
            "measured-frames",
            "walls.pvd",
            "open-in-paraview.py",
            "frames/walls-00000.vtp",
            "observables.csv.part12",
            "run.json.part12-3",
            "frames/grains-00001.vtp.part12-7",
            "frames/grains-00001.vtp.part",
            "measured-frames.part9-9",
        ];
        let others = [
            "run.json",
            "scene.toml",
            "observables.csv.bak",
            "frames/grains-1.vtp",
            "frames/others-00000.vtp",
            "frames/grains-00000.vtp.partial",
            "measured-frames.old",
            "other/grains-00000.vtp",
        ];
        for name in ours.iter().chain(&others) {
            let path = folder.path().join(name);
            std::fs::create_dir_all(path.parent().unwrap()).unwrap();
            std::fs::write(path, "").unwrap();
        }
        let files = RunFiles::inside(folder.path());
        files.remove_drafts().unwrap();
        assert!(files.any().unwrap());
        assert!(ours.iter().all(|name| folder.path().join(name).exists() != name.contains(DRAFT)));
        files.remove_frames_from(1).unwrap();
        assert!(folder.path().join("frames/grains-00000.vtp").exists());
        assert!(!folder.path().join("frames/contacts-123456.vtp").exists());
        files.remove().unwrap();
        assert!(ours.iter().all(|name| !folder.path().join(name).exists()));
        assert!(others.iter().all(|name| folder.path().join(name).exists()));
        std::fs::remove_file(folder.path().join("run.json")).unwrap();
        assert!(!files.any().unwrap());
        assert!(!RunFiles::inside(&folder.path().join("nowhere")).any().unwrap());
    }
}
