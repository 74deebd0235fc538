//! Measured frames of a run: each is read once, when it is due; quantities of all frames together are measured at the end.
//!
//! For the latter the frames are on disk, so that memory does not grow with their number: in the run's store if the scene writes and measures
//! at the same times, with contacts; otherwise in a second store, which is removed after the measurement.

use crate::commands::Failure;
use makadam::snapshot::Snapshot;
use makadam_frames::output::{RunFiles, WriteError};
use makadam_frames::plan::MeasuredScene;
use makadam_frames::run_frames::{Store, StoreMark, StoreWriter};
pub use makadam_measure::observables::frames::Frames;
use makadam_measure::observables::setting::Properties;
use makadam_measure::observables::{Measured, Meter, counts, measure_frames, unmeasured};
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use std::io::{Error, ErrorKind};
use std::ops::Range;
use std::path::{Path, PathBuf};

/// Measured frames of a run in progress.
pub(super) struct MeasuredFrames {
    path: PathBuf,
    /// Store of frames missing from the run's store; absent if none is missing.
    own: Option<StoreWriter>,
    /// Readings of the frames so far.
    meter: Meter,
    /// Last frame, if only the last frame is measured.
    last: Option<Snapshot>,
}

/// Extent of the measured frames at a checkpoint.
#[derive(Clone, Default, Serialize, Deserialize)]
pub(super) struct Mark {
    own: Option<StoreMark>,
    last: Option<Snapshot>,
}

/// Returns true if the measured frames need a store of their own.
fn needs_own_store(scene: &MeasuredScene) -> bool {
    let contacts = scene.output.as_ref().is_none_or(|output| output.contacts);
    let mut intervals = (0..scene.stage.len().max(1)).map(|number| scene.output_interval_in(Some(number)));
    scene.measure.from.is_some() && !(contacts && intervals.all(|interval| interval == scene.measure.interval))
}

impl MeasuredFrames {
    /// Starts without frames.
    pub fn begin(output: &Path, scene: &MeasuredScene) -> Result<MeasuredFrames, WriteError> {
        let path = output.join(RunFiles::MEASURED);
        let own = needs_own_store(scene).then(|| StoreWriter::create(&path, scene)).transpose()?;
        Ok(MeasuredFrames { path, own, meter: Meter::default(), last: None })
    }

    /// Resumes after the frames of a checkpoint, which are read again; `written` are the frames of the run's store.
    ///
    /// # Errors
    /// [`WriteError`] if the frames are missing or changed.
    pub fn resume(
        output: &Path,
        scene: &MeasuredScene,
        mark: Mark,
        written: &StoreWriter,
    ) -> Result<MeasuredFrames, WriteError> {
        let path = output.join(RunFiles::MEASURED);
        let own = mark.own.map(|mark| StoreWriter::resume(&path, mark)).transpose()?;
        let mut meter = Meter::default();
        if scene.measure.from.is_some() {
            let store = own.as_ref().unwrap_or(written).store();
            meter = Meter::of_frames(&Properties::new(scene), &StoredFrames::of(scene, store))
                .map_err(|problem| WriteError::new(store.path(), Error::new(ErrorKind::InvalidData, problem)))?;
        }
        Ok(MeasuredFrames { path, own, meter, last: mark.last })
    }

    /// Measures a frame, and returns its own results.
    pub fn push(&mut self, properties: &Properties<'_>, frame: Snapshot) -> Result<Measured, WriteError> {
        let scene = &*properties.scene;
        let (read, alone) = match counts(scene, frame.particles.len()) {
            true => Meter::read(properties, &frame),
            false => Default::default(),
        };
        if scene.measure.from.is_none() {
            self.last = Some(frame).filter(|frame| scene.is_of_measured_stage(frame.stage)).or(self.last.take());
        } else if scene.covers(frame.time, frame.stage) && counts(scene, frame.particles.len()) {
            self.meter.append(read);
            self.own.as_mut().map_or(Ok(()), |own| own.append(&frame))?;
        }
        Ok(alone)
    }

    /// Flushes all frames to the disk, before a checkpoint that counts them.
    pub fn sync(&self) -> Result<(), WriteError> {
        self.own.as_ref().map_or(Ok(()), StoreWriter::sync)
    }

    /// Returns the extent of the frames.
    pub fn mark(&self) -> Mark {
        Mark { own: self.own.as_ref().map(StoreWriter::mark), last: self.last.clone() }
    }

    /// Measures the frames from `scene.measure.from` on, or without `from` the last frame; `None` if the run has not
    /// reached this time. `written` are the frames of the run's store.
    pub fn measure(&self, scene: &MeasuredScene, written: &StoreWriter) -> Result<Option<Measured>, Failure> {
        if scene.measure.from.is_none() {
            let last: Vec<&Snapshot> = self.last.iter().filter(|last| counts(scene, last.particles.len())).collect();
            let Ok(measured) = measure_frames(scene, &last[..]);
            return Ok(measured);
        }
        let store = self.own.as_ref().unwrap_or(written).store();
        let measured = self.meter.finish(&Properties::new(scene), &StoredFrames::of(scene, store));
        measured
            .map_err(|problem| Failure::Running(format!("{} {problem}: nothing is measured", store.path().display())))
    }

    /// Removes the second store, when no run resumes from it.
    pub fn clear(&mut self) {
        if self.own.take().is_some() {
            // The next run overwrites a remaining file, and only a checkpoint makes a run read it.
            let _ = std::fs::remove_file(&self.path);
        }
    }
}

/// Measured frames of a store.
struct StoredFrames<'a> {
    store: &'a Store,
    numbers: Vec<usize>,
}

impl<'a> StoredFrames<'a> {
    fn of(scene: &MeasuredScene, store: &'a Store) -> StoredFrames<'a> {
        let is_measured = |number: &usize| {
            let entry = &store.entries()[*number];
            scene.covers(entry.time, entry.stage) && counts(scene, entry.grains as usize)
        };
        StoredFrames { store, numbers: (0..store.count()).filter(is_measured).collect() }
    }
}

impl Frames for StoredFrames<'_> {
    /// Message, to follow the file name.
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

    fn visit_grains(&self, range: Range<usize>, look: &mut dyn FnMut(&Snapshot)) -> Result<(), String> {
        self.store.visit_grains(self.numbers[range].iter().copied(), look)
    }
}

/// Measured numbers of a run, as in `run.json`.
#[derive(Default, Serialize)]
pub(super) struct Measurements {
    pub observables: BTreeMap<String, Value>,
    pub not_measured: Option<String>,
    pub without_value: BTreeMap<String, String>,
}

#[derive(Serialize)]
pub(super) struct Value {
    pub value: f64,
    pub standard_error: Option<f64>,
    pub unit: String,
}

impl Measurements {
    /// Returns no measurements, with the reason.
    pub fn none(reason: String) -> Measurements {
        Measurements { not_measured: Some(reason), ..Measurements::default() }
    }

    /// Measures the frames of a run that is `complete` or not, and `ended` at this time (s).
    pub fn of(
        scene: &MeasuredScene,
        frames: &MeasuredFrames,
        written: &StoreWriter,
        complete: bool,
        ended: f64,
    ) -> Result<Measurements, Failure> {
        let from = scene.measure.from;
        let measured = match from.is_some() || complete {
            true => frames.measure(scene, written)?,
            false => None,
        };
        let Some(measured) = measured else {
            // A run without grains has nothing to measure at any time.
            if complete && from.is_none_or(|from| ended >= from) {
                return Ok(Measurements::none("there are no grains".into()));
            }
            let before = match (&scene.measure.stage, from) {
                (Some(stage), _) => format!("the measured part of stage '{stage}'"),
                (None, from) => from.map_or("its last step".into(), |from| format!("measure.from = {from} s")),
            };
            return Ok(Measurements::none(format!("the run ended after {ended:.4} s, before {before}")));
        };
        let without = unmeasured(scene, &[], &measured).into_iter();
        let finite = measured.measurements.into_iter().filter(|one| one.value.is_finite());
        let observables = finite.map(|one| {
            (one.observable, Value { value: one.value, standard_error: one.standard_error, unit: one.unit })
        });
        Ok(Measurements {
            observables: observables.collect(),
            not_measured: None,
            without_value: without.map(|one| (one.observable.to_string(), one.reason)).collect(),
        })
    }
}

#[cfg(test)]
#[path = "../../../tests/unit/commands_run_measured.rs"]
mod tests;
