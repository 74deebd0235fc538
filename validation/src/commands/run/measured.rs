//! The frames of a run that are measured at its end: on disk, so that memory does not grow with them.
//!
//! Measures look at all frames more than once (see [`Frames`]). A run appends each to one file, as it is to the last bit, and
//! removes the file once it is measured. A checkpoint says how far the file went; what stands behind is cut off by the run that
//! goes on from there, and comes again.

use crate::commands::Failure;
use crate::observables::frames::Frames;
use crate::observables::{Measured, measure_frames};
use crate::output::WriteError;
use crate::plan::Scene;
use makadam::checkpoint::{open, seal};
use makadam::snapshot::Snapshot;
use serde::{Deserialize, Serialize};
use std::fs::{File, OpenOptions};
use std::io::{BufReader, Error, ErrorKind, Read, Seek, SeekFrom, Write};
use std::ops::Range;
use std::path::{Path, PathBuf};

/// First bytes of a frame; the last one is the version of the format.
const FRAME: [u8; 8] = *b"mkd-frm\x03";

/// Measured frames of a run under way.
pub(super) struct MeasuredFrames {
    path: PathBuf,
    /// Open for writing, from the first frame on.
    file: Option<File>,
    places: Vec<Place>,
    /// The last frame of all, whether it is measured or not.
    last: Option<Snapshot>,
}

/// Where a frame stands in the file.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
struct Place {
    start: u64,
    length: u64,
    grains: u32,
}

/// How far the frames had come when a checkpoint was written.
#[derive(Clone, Default, Serialize, Deserialize)]
pub(super) struct Mark {
    places: Vec<Place>,
    /// The last frame, where none is in the file.
    last: Option<Snapshot>,
}

impl MeasuredFrames {
    /// No frames yet; what an earlier run has left in the output folder is removed.
    pub fn begin(output: &Path) -> MeasuredFrames {
        let path = output.join("measured-frames");
        // What cannot be removed cannot be written either, which the first frame tells.
        let _ = std::fs::remove_file(&path);
        MeasuredFrames { path, file: None, places: Vec::new(), last: None }
    }

    /// The frames that a checkpoint speaks of.
    ///
    /// # Errors
    /// [`Failure`] if they are not there as they were written.
    pub fn go_on(output: &Path, mark: Mark) -> Result<MeasuredFrames, Failure> {
        let path = output.join("measured-frames");
        let mut frames = MeasuredFrames { path, file: None, places: mark.places, last: mark.last };
        if frames.places.is_empty() {
            return Ok(frames);
        }
        let mut last = None;
        let count = frames.count();
        frames.visit(0..count, &mut |frame| last = Some(frame.clone())).map_err(|problem| {
            Failure::Running(format!("{} {problem}; give --restart to start anew", frames.path.display()))
        })?;
        frames.last = last;
        let file = OpenOptions::new().write(true).open(&frames.path).and_then(|mut file| {
            file.set_len(frames.bytes())?;
            file.seek(SeekFrom::End(0))?;
            Ok(file)
        });
        frames.file = Some(file.map_err(|error| WriteError::new(&frames.path, error))?);
        Ok(frames)
    }

    /// Takes a frame of the run, and keeps it if it is measured.
    ///
    /// # Errors
    /// [`WriteError`] if the system refuses; the frames before stay readable.
    pub fn push(&mut self, scene: &Scene, frame: Snapshot) -> Result<(), WriteError> {
        if scene.measure.covers(frame.time) && !frame.particles.is_empty() {
            let body = postcard::to_stdvec(&frame).expect("a frame holds only numbers and lists");
            let bytes = seal(FRAME, &body);
            let start = self.bytes();
            self.append(&bytes, start).map_err(|error| WriteError::new(&self.path, error))?;
            self.places.push(Place { start, length: bytes.len() as u64, grains: frame.particles.len() as u32 });
        }
        self.last = Some(frame);
        Ok(())
    }

    fn append(&mut self, bytes: &[u8], start: u64) -> Result<(), Error> {
        if self.file.is_none() {
            self.file = Some(File::create(&self.path)?);
        }
        let file = self.file.as_mut().expect("it was opened if it was not");
        // What a write that failed has left behind is written over.
        file.seek(SeekFrom::Start(start))?;
        file.write_all(bytes)
    }

    /// Sees to it that all frames are on the disk, before a checkpoint that speaks of them.
    ///
    /// # Errors
    /// [`WriteError`] if the system refuses.
    pub fn sync(&self) -> Result<(), WriteError> {
        let synced = self.file.as_ref().map_or(Ok(()), File::sync_all);
        synced.map_err(|error| WriteError::new(&self.path, error))
    }

    /// How far the frames have come.
    pub fn mark(&self) -> Mark {
        Mark { places: self.places.clone(), last: self.last.clone().filter(|_| self.places.is_empty()) }
    }

    /// Measures the frames from `scene.measure.from` on, or the last one where the scene gives no such time. `None` if the run
    /// has not come that far.
    ///
    /// # Errors
    /// [`Failure`] if a frame cannot be read back.
    pub fn measure(&self, scene: &Scene) -> Result<Option<Measured>, Failure> {
        if scene.measure.from.is_some() {
            let lost = |problem| Failure::Running(format!("{} {problem}: nothing is measured", self.path.display()));
            return measure_frames(scene, self).map_err(lost);
        }
        let last: Vec<&Snapshot> = self.last.iter().filter(|last| !last.particles.is_empty()).collect();
        let Ok(measured) = measure_frames(scene, &last[..]);
        Ok(measured)
    }

    /// Removes the file, once nobody goes on from it.
    pub fn clear(&mut self) {
        self.file = None;
        // What stays is overwritten by the next run, and never read without a checkpoint that speaks of it.
        let _ = std::fs::remove_file(&self.path);
    }

    fn bytes(&self) -> u64 {
        self.places.last().map_or(0, |place| place.start + place.length)
    }
}

impl Frames for MeasuredFrames {
    /// What is wrong, in words that follow the file's name.
    type Error = String;

    fn count(&self) -> usize {
        self.places.len()
    }

    fn grains(&self, range: Range<usize>) -> usize {
        self.places[range].iter().map(|place| place.grains as usize).sum()
    }

    fn visit(&self, range: Range<usize>, look: &mut dyn FnMut(&Snapshot)) -> Result<(), String> {
        let places = &self.places[range];
        let Some(first) = places.first() else { return Ok(()) };
        let unread = |error: Error| match error.kind() {
            ErrorKind::UnexpectedEof => "is cut off".to_string(),
            _ => format!("cannot be read: {error}"),
        };
        let mut file = BufReader::new(File::open(&self.path).map_err(unread)?);
        file.seek(SeekFrom::Start(first.start)).map_err(unread)?;
        let mut bytes = Vec::new();
        for place in places {
            bytes.clear();
            file.by_ref().take(place.length).read_to_end(&mut bytes).map_err(unread)?;
            let body = open(FRAME, &bytes)?;
            let frame: Snapshot =
                postcard::from_bytes(body).map_err(|error| format!("does not hold what it should ({error})"))?;
            look(&frame);
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use makadam::Simulation;

    const SCENE: &str = "../tests/scenes/smoke.toml";

    /// The small scene measured from 0.1 s on, and frames of it.
    fn frames() -> (Scene, Vec<Snapshot>) {
        let file = Path::new(env!("CARGO_MANIFEST_DIR")).join(SCENE);
        let mut scene = Scene::load(&file).unwrap();
        scene.measure.from = Some(0.1);
        let mut simulation = Simulation::new(&scene, 1).unwrap();
        let mut frames = Vec::new();
        while simulation.time() < 0.3 {
            frames.push(simulation.snapshot());
            for _ in 0..40 {
                simulation.step();
            }
        }
        (scene, frames)
    }

    fn in_memory(scene: &Scene, frames: &[Snapshot]) -> Measured {
        let late: Vec<&Snapshot> = frames.iter().filter(|frame| scene.measure.covers(frame.time)).collect();
        let Ok(measured) = measure_frames(scene, &late[..]);
        measured.unwrap()
    }

    #[test]
    fn frames_on_disk_are_measured_as_those_in_memory_and_go_on_from_a_mark() {
        let folder = tempfile::tempdir().unwrap();
        let (scene, frames) = frames();
        let expected = in_memory(&scene, &frames);
        let numbers = &expected.measurements;
        assert!(numbers.iter().any(|one| one.observable == "coordination_number" && one.frames > 8), "{expected:?}");

        let mut kept = MeasuredFrames::begin(folder.path());
        for frame in &frames[..3] {
            kept.push(&scene, frame.clone()).unwrap();
        }
        assert!(kept.measure(&scene).unwrap().is_none(), "the run has not come to the first measured frame");
        for frame in &frames[3..9] {
            kept.push(&scene, frame.clone()).unwrap();
        }
        let mark = kept.mark();
        for frame in &frames[9..] {
            kept.push(&scene, frame.clone()).unwrap();
        }
        assert_eq!(kept.measure(&scene).unwrap().unwrap(), expected);
        drop(kept);

        let mut gone_on = MeasuredFrames::go_on(folder.path(), mark).unwrap();
        assert_eq!(gone_on.last.as_ref(), Some(&frames[8]));
        assert_eq!(gone_on.measure(&scene).unwrap().unwrap(), in_memory(&scene, &frames[..9]));
        for frame in &frames[9..] {
            gone_on.push(&scene, frame.clone()).unwrap();
        }
        assert_eq!(gone_on.measure(&scene).unwrap().unwrap(), expected);
        gone_on.clear();
        assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 0);
    }

    #[test]
    fn without_a_first_time_the_last_frame_is_measured_and_nothing_goes_to_disk() {
        let folder = tempfile::tempdir().unwrap();
        let (mut scene, frames) = frames();
        scene.measure.from = None;
        let mut kept = MeasuredFrames::begin(folder.path());
        for frame in &frames {
            kept.push(&scene, frame.clone()).unwrap();
        }
        let gone_on = MeasuredFrames::go_on(folder.path(), kept.mark()).unwrap();
        let Ok(expected) = measure_frames(&scene, &[&frames[frames.len() - 1]][..]);
        assert_eq!(gone_on.measure(&scene).unwrap(), expected);
        assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 0);
    }

    #[test]
    fn frames_that_are_damaged_or_cut_off_are_refused_in_words() {
        let folder = tempfile::tempdir().unwrap();
        let (scene, frames) = frames();
        let mut kept = MeasuredFrames::begin(folder.path());
        for frame in &frames {
            kept.push(&scene, frame.clone()).unwrap();
        }
        let file = folder.path().join("measured-frames");
        let sound = std::fs::read(&file).unwrap();
        let refused = |bytes: &[u8], words: &str| {
            std::fs::write(&file, bytes).unwrap();
            for failure in [MeasuredFrames::go_on(folder.path(), kept.mark()).err(), kept.measure(&scene).err()] {
                let message = failure.unwrap_or_else(|| panic!("accepted where {words} was expected")).to_string();
                assert!(message.contains(words) && message.contains("measured-frames"), "{message}");
            }
        };
        let mut damaged = sound.clone();
        damaged[sound.len() / 2] ^= 4;
        refused(&damaged, "damaged");
        refused(&sound[..sound.len() - 1], "cut off");
        refused(&[], "too short");
    }
}
