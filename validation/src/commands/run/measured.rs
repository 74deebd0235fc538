//! The frames of a run that are measured at its end: on disk, so that memory does not grow with them.
//!
//! They are the frames of the run's store where the scene writes and measures at the same times, with contacts; else a second store holds
//! them, which is removed after the measurement.

use crate::commands::Failure;
use crate::observables::frames::Frames;
use crate::observables::{Measured, measure_frames};
use crate::output::{RunFiles, WriteError};
use crate::plan::Scene;
use crate::run_frames::{Store, StoreMark, StoreWriter};
use makadam::snapshot::Snapshot;
use serde::{Deserialize, Serialize};
use std::ops::Range;
use std::path::{Path, PathBuf};

/// Measured frames of a run under way.
pub(super) struct MeasuredFrames {
    path: PathBuf,
    /// Frames that the run's store does not hold; absent where it holds all.
    own: Option<StoreWriter>,
    /// The last frame, where it alone is measured.
    last: Option<Snapshot>,
}

/// Extent of the measured frames at a checkpoint.
#[derive(Clone, Default, Serialize, Deserialize)]
pub(super) struct Mark {
    own: Option<StoreMark>,
    last: Option<Snapshot>,
}

/// Returns true if the measured frames need a store of their own.
fn needs_own_store(scene: &Scene) -> bool {
    let contacts = scene.output.as_ref().is_none_or(|output| output.contacts);
    scene.measure.from.is_some() && !(contacts && scene.output_interval() == scene.measure.interval)
}

impl MeasuredFrames {
    /// Starts without frames.
    ///
    /// # Errors
    /// [`WriteError`] if the system refuses.
    pub fn begin(output: &Path, scene: &Scene) -> Result<MeasuredFrames, WriteError> {
        let path = output.join(RunFiles::MEASURED);
        let own = needs_own_store(scene).then(|| StoreWriter::create(&path, scene)).transpose()?;
        Ok(MeasuredFrames { path, own, last: None })
    }

    /// Resumes after the frames that a checkpoint knows.
    ///
    /// # Errors
    /// [`WriteError`] if they are not there as they were written.
    pub fn resume(output: &Path, mark: Mark) -> Result<MeasuredFrames, WriteError> {
        let path = output.join(RunFiles::MEASURED);
        let own = mark.own.map(|mark| StoreWriter::resume(&path, mark)).transpose()?;
        Ok(MeasuredFrames { path, own, last: mark.last })
    }

    /// Takes a frame that is due to be measured.
    ///
    /// # Errors
    /// [`WriteError`] if the system refuses; the frames before it stay readable.
    pub fn push(&mut self, scene: &Scene, frame: Snapshot) -> Result<(), WriteError> {
        if scene.measure.from.is_none() {
            self.last = Some(frame);
            return Ok(());
        }
        match &mut self.own {
            Some(own) if is_measured(scene, frame.time, frame.particles.len()) => own.append(&frame),
            _ => Ok(()),
        }
    }

    /// Flushes all frames to the disk, before a checkpoint that knows them.
    ///
    /// # Errors
    /// [`WriteError`] if the system refuses.
    pub fn sync(&self) -> Result<(), WriteError> {
        self.own.as_ref().map_or(Ok(()), StoreWriter::sync)
    }

    /// Returns the extent of the frames.
    pub fn mark(&self) -> Mark {
        Mark { own: self.own.as_ref().map(StoreWriter::mark), last: self.last.clone() }
    }

    /// Measures the frames from `scene.measure.from` on, or the last one where the scene gives no such time; `None` if the run has not
    /// reached it. `written` are the frames of the run's store.
    ///
    /// # Errors
    /// [`Failure`] if a frame cannot be read back.
    pub fn measure(&self, scene: &Scene, written: &StoreWriter) -> Result<Option<Measured>, Failure> {
        if scene.measure.from.is_none() {
            let last: Vec<&Snapshot> = self.last.iter().filter(|last| !last.particles.is_empty()).collect();
            let Ok(measured) = measure_frames(scene, &last[..]);
            return Ok(measured);
        }
        let store = self.own.as_ref().unwrap_or(written).store();
        let measured = measure_frames(scene, &StoredFrames::of(scene, store));
        measured
            .map_err(|problem| Failure::Running(format!("{} {problem}: nothing is measured", store.path().display())))
    }

    /// Removes the second store, once no run resumes from it.
    pub fn clear(&mut self) {
        if self.own.take().is_some() {
            // The next run overwrites it, and only a checkpoint makes a run read it.
            let _ = std::fs::remove_file(&self.path);
        }
    }
}

/// Returns true if a frame of this time (s) with so many grains is measured.
fn is_measured(scene: &Scene, time: f64, grains: usize) -> bool {
    scene.measure.covers(time) && grains > 0
}

/// The measured frames of a store.
struct StoredFrames<'a> {
    store: &'a Store,
    numbers: Vec<usize>,
}

impl<'a> StoredFrames<'a> {
    fn of(scene: &Scene, store: &'a Store) -> StoredFrames<'a> {
        let is_measured = |number: &usize| {
            let entry = &store.entries()[*number];
            is_measured(scene, entry.time, entry.grains as usize)
        };
        StoredFrames { store, numbers: (0..store.count()).filter(is_measured).collect() }
    }
}

impl Frames for StoredFrames<'_> {
    /// The problem, in words that follow the name of the file.
    type Error = String;

    fn count(&self) -> usize {
        self.numbers.len()
    }

    fn grains(&self, range: Range<usize>) -> usize {
        self.numbers[range].iter().map(|number| self.store.entries()[*number].grains as usize).sum()
    }

    fn visit(&self, range: Range<usize>, look: &mut dyn FnMut(&Snapshot)) -> Result<(), String> {
        self.store.visit(self.numbers[range].iter().copied(), look)
    }
}

#[cfg(test)]
#[path = "../../../tests/unit/commands_run_measured.rs"]
mod tests;
