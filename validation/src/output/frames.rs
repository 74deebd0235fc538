//! Frames on disk: one file of grains and one of contacts a frame, and two collections that list them over time.

use super::collection::Collection;
use super::{WriteError, create_folder, vtk, write_whole};
use makadam::checkpoint::{sync_file, sync_folder};
use makadam::snapshot::Snapshot;
use serde::{Deserialize, Serialize};
use std::fs::File;
use std::path::{Path, PathBuf};

/// Files that are written to the disk one by one; more than these go together with whatever else waits to be written.
const ONE_BY_ONE: usize = 64;

/// What frames are of, in the names of files.
pub(super) const KINDS: [&str; 2] = ["grains", "contacts"];

/// Folder of frames inside an output folder.
pub(super) const FOLDER: &str = "frames";

/// Writes frames as they come. The collections are whole after every frame, so what is there can be opened at any time.
pub struct FrameWriter {
    output: PathBuf,
    count: usize,
    /// Frames that are safely on the disk.
    synced: usize,
    lists: [Collection; 2],
}

/// How far a [`FrameWriter`] has come, for a checkpoint.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct FramesWritten {
    /// Number of frames.
    pub count: usize,
    /// Bytes of each collection before its closing tags.
    pub listed: [u64; 2],
}

impl FrameWriter {
    /// Makes the folder `frames` inside `output`, and collections without frames.
    ///
    /// # Errors
    /// [`WriteError`] if the system refuses.
    pub fn create(output: &Path) -> Result<FrameWriter, WriteError> {
        create_folder(&output.join(FOLDER))?;
        let [grains, contacts] = KINDS.map(|kind| Collection::create(&list_of(output, kind)));
        Ok(FrameWriter { output: output.to_path_buf(), count: 0, synced: 0, lists: [grains?, contacts?] })
    }

    /// Goes on after the frames that an earlier part of the run has written.
    ///
    /// # Errors
    /// [`WriteError`] if the system refuses, or a collection is shorter than it then was.
    pub fn go_on(output: &Path, written: FramesWritten) -> Result<FrameWriter, WriteError> {
        create_folder(&output.join(FOLDER))?;
        let [grains, contacts] = [0, 1].map(|n| Collection::go_on(&list_of(output, KINDS[n]), written.listed[n]));
        let FramesWritten { count, .. } = written;
        Ok(FrameWriter { output: output.to_path_buf(), count, synced: count, lists: [grains?, contacts?] })
    }

    /// How far it has come.
    pub fn written(&self) -> FramesWritten {
        FramesWritten { count: self.count, listed: [self.lists[0].body(), self.lists[1].body()] }
    }

    /// Writes one frame and lists it in `grains.pvd` and `contacts.pvd`.
    ///
    /// # Errors
    /// [`WriteError`] if the system refuses; the frames before it stay readable.
    pub fn write(&mut self, frame: &Snapshot) -> Result<(), WriteError> {
        let names = KINDS.map(|kind| file_name(kind, self.count));
        write_whole(&self.output.join(&names[0]), vtk::grains(frame).as_bytes())?;
        write_whole(&self.output.join(&names[1]), vtk::contacts(frame).as_bytes())?;
        for (list, name) in self.lists.iter_mut().zip(&names) {
            list.push(frame.time, name)?;
        }
        self.count += 1;
        Ok(())
    }

    /// Writes all frames and collections to the disk: afterwards they outlast a cut of power, once the output folder's own names
    /// are written too.
    ///
    /// # Errors
    /// [`WriteError`] if the system refuses.
    pub fn sync(&mut self) -> Result<(), WriteError> {
        let folder = self.output.join(FOLDER);
        let refused = |path: &Path| {
            let path = path.to_path_buf();
            move |source| WriteError::new(&path, source)
        };
        if KINDS.len() * (self.count - self.synced) > ONE_BY_ONE {
            let open = File::open(&folder).map_err(refused(&folder))?;
            rustix::fs::syncfs(&open).map_err(|error| refused(&folder)(error.into()))?;
        } else {
            for number in self.synced..self.count {
                for path in KINDS.map(|kind| self.output.join(file_name(kind, number))) {
                    sync_file(&path).map_err(refused(&path))?;
                }
            }
        }
        sync_folder(&folder).map_err(refused(&folder))?;
        self.lists.iter().try_for_each(Collection::sync)?;
        self.synced = self.count;
        Ok(())
    }

    /// Writes the files of the next frame that is not safely on the disk there, so that a later [`FrameWriter::sync`] has less to
    /// do. Gives whether there was one.
    ///
    /// # Errors
    /// [`WriteError`] if the system refuses.
    pub fn sync_next(&mut self) -> Result<bool, WriteError> {
        if self.synced == self.count {
            return Ok(false);
        }
        for path in KINDS.map(|kind| self.output.join(file_name(kind, self.synced))) {
            sync_file(&path).map_err(|source| WriteError::new(&path, source))?;
        }
        self.synced += 1;
        Ok(true)
    }

    /// Number of frames on disk.
    pub fn count(&self) -> usize {
        self.count
    }
}

/// Name of a frame's file inside the output folder.
fn file_name(kind: &str, number: usize) -> String {
    format!("{FOLDER}/{kind}-{number:05}.vtp")
}

/// The collection of one kind of files.
fn list_of(output: &Path, kind: &str) -> PathBuf {
    output.join(format!("{kind}.pvd"))
}
