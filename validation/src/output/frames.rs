//! Frames on disk: for each a file of grains, one of contacts and one of walls, and collections that list them over time.

use super::collection::Collection;
use super::grain_fields::GrainTable;
use super::vtk::Packer;
use super::wall_mesh::WallMesh;
use super::{RunFiles, WriteError, create_folder, write_durably, write_whole};
use crate::plan::Scene;
use makadam::checkpoint::{sync_file, sync_folder};
use makadam::snapshot::Snapshot;
use serde::{Deserialize, Serialize};
#[cfg(target_os = "linux")]
use std::fs::File;
use std::path::{Path, PathBuf};

/// Files that are written to the disk one by one; more than these go together with whatever else waits to be written.
#[cfg(target_os = "linux")]
const ONE_BY_ONE: usize = 64;

/// What frames are of, in the names of files.
pub(super) const KINDS: [&str; 3] = ["grains", "contacts", "walls"];

const CONTACTS: usize = 1;
const WALLS: usize = 2;

/// Folder of frames inside an output folder.
pub(super) const FOLDER: &str = "frames";

/// What opens the frames in ParaView.
const SCRIPT: &str = include_str!("open-in-paraview.py");

/// Writes frames as they come. The collections are whole after every frame, so what is there can be opened at any time.
pub struct FrameWriter {
    output: PathBuf,
    count: usize,
    /// Frames that are safely on the disk.
    synced: usize,
    /// One per kind; none for a kind that is not written.
    lists: [Option<Collection>; 3],
    grains: GrainTable,
    walls: WallMesh,
    /// One per kind.
    packers: [Packer; 3],
}

/// How far a [`FrameWriter`] has come, for a checkpoint.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct FramesWritten {
    /// Number of frames.
    pub count: usize,
    /// Bytes of each collection before its closing tags; zero for a kind that is not written.
    pub listed: [u64; 3],
}

impl FrameWriter {
    /// Makes the folder `frames` inside `output`, collections without frames, and a script that opens them in ParaView.
    ///
    /// # Errors
    /// [`WriteError`] if the system refuses.
    pub fn create(output: &Path, scene: &Scene) -> Result<FrameWriter, WriteError> {
        create_folder(&output.join(FOLDER))?;
        write_durably(&output.join(RunFiles::PARAVIEW), SCRIPT.as_bytes())?;
        FrameWriter::new(output, scene, 0, |_, list| Collection::create(&list))
    }

    /// Goes on after the frames that an earlier part of the run has written.
    ///
    /// # Errors
    /// [`WriteError`] if the system refuses, or a collection is shorter than it then was.
    pub fn go_on(output: &Path, scene: &Scene, written: FramesWritten) -> Result<FrameWriter, WriteError> {
        create_folder(&output.join(FOLDER))?;
        FrameWriter::new(output, scene, written.count, |kind, list| Collection::go_on(&list, written.listed[kind]))
    }

    fn new(
        output: &Path,
        scene: &Scene,
        count: usize,
        list: impl Fn(usize, PathBuf) -> Result<Collection, WriteError>,
    ) -> Result<FrameWriter, WriteError> {
        let asked = scene.output.clone().unwrap_or_default();
        let mut lists = [None, None, None];
        for (kind, is_written) in [true, asked.contacts, asked.walls && !scene.wall.is_empty()].into_iter().enumerate()
        {
            if is_written {
                lists[kind] = Some(list(kind, list_of(output, KINDS[kind]))?);
            }
        }
        let (grains, walls) = (GrainTable::new(scene), WallMesh::new(scene));
        let packers = KINDS.map(|_| Packer::new());
        Ok(FrameWriter { output: output.to_path_buf(), count, synced: count, lists, grains, walls, packers })
    }

    /// How far it has come.
    pub fn written(&self) -> FramesWritten {
        let listed = self.lists.each_ref().map(|list| list.as_ref().map_or(0, Collection::body));
        FramesWritten { count: self.count, listed }
    }

    /// Writes one frame and lists it in `grains.pvd`, `contacts.pvd` and `walls.pvd`. Walls that all rest are written with the first
    /// frame alone.
    ///
    /// # Errors
    /// [`WriteError`] if the system refuses; the frames before it stay readable.
    pub fn write(&mut self, frame: &Snapshot) -> Result<(), WriteError> {
        for kind in self.kinds_of(self.count) {
            let data = match kind {
                CONTACTS => self.grains.contacts(frame),
                WALLS => self.walls.at(frame.time, &frame.driven_walls),
                _ => self.grains.grains(frame),
            };
            write_whole(&self.output.join(file_name(KINDS[kind], self.count)), &data.encode(&mut self.packers[kind]))?;
        }
        for kind in self.kinds_of(self.count) {
            if let Some(list) = &mut self.lists[kind] {
                list.push(frame.time, &file_name(KINDS[kind], self.count))?;
            }
        }
        self.count += 1;
        Ok(())
    }

    /// What is written of a frame.
    fn kinds_of(&self, number: usize) -> Vec<usize> {
        let is_due = |kind: &usize| *kind != WALLS || number == 0 || self.walls.moves();
        (0..KINDS.len()).filter(|kind| self.lists[*kind].is_some()).filter(is_due).collect()
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
        // Elsewhere many files are written one by one.
        #[cfg(target_os = "linux")]
        if KINDS.len() * (self.count - self.synced) > ONE_BY_ONE {
            let open = File::open(&folder).map_err(refused(&folder))?;
            rustix::fs::syncfs(&open).map_err(|error| refused(&folder)(error.into()))?;
            self.synced = self.count;
        }
        while self.sync_next()? {}
        sync_folder(&folder).map_err(refused(&folder))?;
        self.lists.iter().flatten().try_for_each(Collection::sync)
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
        for kind in self.kinds_of(self.synced) {
            let path = self.output.join(file_name(KINDS[kind], self.synced));
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
pub(super) fn list_of(output: &Path, kind: &str) -> PathBuf {
    output.join(format!("{kind}.pvd"))
}
