//! Frames on disk: one file of grains and one of contacts a frame, and two collections that list them over time.

use super::{WriteError, create_folder, vtk, write_whole};
use makadam::snapshot::Snapshot;
use std::path::{Path, PathBuf};

/// Writes frames as they come. The collections are whole after every frame, so what is there can be opened at any time.
pub struct FrameWriter {
    folder: PathBuf,
    written: Vec<f64>,
}

impl FrameWriter {
    /// Makes the folder `frames` inside `output`.
    ///
    /// # Errors
    /// [`WriteError`] if the system refuses.
    pub fn create(output: &Path) -> Result<FrameWriter, WriteError> {
        let folder = output.join("frames");
        create_folder(&folder)?;
        Ok(FrameWriter { folder: output.to_path_buf(), written: Vec::new() })
    }

    /// Takes frames that an earlier part of the run has written as written.
    pub fn go_on(&mut self, times: &[f64]) {
        self.written = times.to_vec();
    }

    /// Simulated times of the frames on disk, s.
    pub fn times(&self) -> &[f64] {
        &self.written
    }

    /// Writes one frame and lists it in `grains.pvd` and `contacts.pvd`.
    ///
    /// # Errors
    /// [`WriteError`] if the system refuses; the frames before it stay readable.
    pub fn write(&mut self, frame: &Snapshot) -> Result<(), WriteError> {
        let number = self.written.len();
        write_whole(&self.folder.join(file_name("grains", number)), vtk::grains(frame).as_bytes())?;
        write_whole(&self.folder.join(file_name("contacts", number)), vtk::contacts(frame).as_bytes())?;
        self.written.push(frame.time);
        for kind in ["grains", "contacts"] {
            let files: Vec<_> =
                self.written.iter().enumerate().map(|(number, &time)| (time, file_name(kind, number))).collect();
            write_whole(&self.folder.join(format!("{kind}.pvd")), vtk::collection(&files).as_bytes())?;
        }
        Ok(())
    }

    /// Number of frames on disk.
    pub fn count(&self) -> usize {
        self.written.len()
    }
}

fn file_name(kind: &str, number: usize) -> String {
    format!("frames/{kind}-{number:05}.vtp")
}
