//! Frames of a run, in its folder or in memory.

use super::columns::{Kind, Part};
use super::frame::{FrameTables, Quantity, RunFrame};
use super::store::Store;
use crate::output::RunFiles;
use crate::plan::{MeasuredScene, Observable, setup_hash};
use crate::provenance::VERSION;
use crate::recording::{Content, Recording};
use makadam::scene::Motion;
use makadam::snapshot::Snapshot;
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// Error of frames of a run.
#[derive(Debug, thiserror::Error)]
pub enum RunFolderError {
    /// Unknown run, time or field.
    #[error("{0}")]
    Unknown(String),
    /// Damaged file.
    #[error("{file} {problem}; run the scene again")]
    Damaged {
        /// File.
        file: String,
        /// Error in the file.
        problem: String,
    },
}

/// Rounds off the last digits, which sums of steps leave, for messages.
pub fn rounded(value: f64) -> f64 {
    format!("{value:.8e}").parse().unwrap_or(value)
}

/// Frames of a run, listed but not yet read.
#[derive(Clone, Debug)]
pub struct RunFrames {
    folder: PathBuf,
    source: Source,
    tables: Arc<FrameTables>,
    alarms: Option<String>,
    seed: Option<u64>,
}

/// Source of the frames.
#[derive(Clone, Debug)]
enum Source {
    Store(Box<Store>),
    Memory(Vec<Arc<Snapshot>>),
}

impl RunFrames {
    /// Opens the frames of a run, by its folder or by the name of a folder below `results`. A running or killed run has the frames written
    /// so far.
    ///
    /// # Errors
    /// [`RunFolderError`] if there is no such folder, or it holds no frames.
    pub fn open(run: &Path) -> Result<RunFrames, RunFolderError> {
        let below = Path::new("results").join(run);
        let folder = [run, &below].into_iter().find(|folder| folder.is_dir());
        let folder = folder.ok_or_else(|| {
            let run = run.display();
            RunFolderError::Unknown(format!(
                "no run '{run}': there is no folder of that name, here or below results; give the folder that makadam run wrote into"
            ))
        })?;
        let folder = folder.to_path_buf();
        let file = folder.join(RunFiles::FRAMES);
        let none = |problem: String| {
            let folder = folder.display();
            RunFolderError::Unknown(format!(
                "{folder} holds no frames of a run: {problem}; give the folder that makadam run wrote into"
            ))
        };
        // Reading a pipe would block.
        if !file.is_file() {
            return Err(none(format!("there is no {} in it", RunFiles::FRAMES)));
        }
        let store = Store::open(&file).map_err(|problem| damaged(&file, problem))?;
        if store.count() == 0 {
            return Err(none(format!("{} has no whole frame yet", RunFiles::FRAMES)));
        }
        let summary = summary(&folder);
        // A complete run states its number of frames: fewer frames mean damage, not a kill.
        if summary["complete"] == true && summary["frames"] != store.count() {
            let problem =
                format!("is damaged: it has {} whole frames, and run.json states {}", store.count(), summary["frames"]);
            return Err(damaged(&file, problem));
        }
        let (tables, alarms) = (Arc::new(FrameTables::new(store.scene())), alarms(&folder, &summary));
        let seed = summary["provenance"]["seed"].as_u64();
        Ok(RunFrames { folder, source: Source::Store(Box::new(store)), tables, alarms, seed })
    }

    /// Takes frames of a scene in memory, at least one, in the order of time.
    pub fn in_memory(scene: &MeasuredScene, frames: Vec<Arc<Snapshot>>) -> RunFrames {
        let tables = Arc::new(FrameTables::new(scene));
        RunFrames { folder: PathBuf::new(), source: Source::Memory(frames), tables, alarms: None, seed: None }
    }

    /// Returns the folder.
    pub fn folder(&self) -> &Path {
        &self.folder
    }

    /// Returns the seed of the run, if its summary states it.
    pub fn seed(&self) -> Option<u64> {
        self.seed
    }

    /// Returns the names of the materials, in the order of their numbers.
    pub(crate) fn materials(&self) -> Vec<String> {
        self.tables.materials()
    }

    /// Returns the scene.
    pub fn own_scene(&self) -> &MeasuredScene {
        &self.tables.scene
    }

    /// Returns the name of the scene.
    pub fn scene(&self) -> &str {
        &self.tables.scene.name
    }

    /// Returns the number of frames.
    pub fn count(&self) -> usize {
        match &self.source {
            Source::Store(store) => store.count(),
            Source::Memory(frames) => frames.len(),
        }
    }

    /// Returns the time of a frame, s.
    pub fn time(&self, number: usize) -> f64 {
        match &self.source {
            Source::Store(store) => store.entries()[number].time,
            Source::Memory(frames) => frames[number].time,
        }
    }

    /// Returns the number of steps before a frame, by its stage or its time.
    pub fn step(&self, number: usize) -> u64 {
        let stage = match &self.source {
            Source::Store(store) => store.entries()[number].stage,
            Source::Memory(frames) => frames[number].stage,
        };
        if let Some(stage) = stage {
            return stage.before + stage.steps;
        }
        (self.time(number) / self.tables.scene.solver.step).round() as u64
    }

    /// Returns the number of the frame nearest to a time (s).
    ///
    /// # Errors
    /// [`RunFolderError::Unknown`] if the time lies outside the run.
    pub fn at(&self, time: f64) -> Result<usize, RunFolderError> {
        let (first, last) = (self.time(0), self.time(self.count() - 1));
        // Users type times with few digits.
        let slack = 1e-6 * (last - first).abs().max(1e-9);
        if !(first - slack..=last + slack).contains(&time) {
            return Err(RunFolderError::Unknown(format!(
                "{}: {time} s lies outside the run, whose {} frames are from {} s to {} s",
                self.folder.display(),
                self.count(),
                rounded(first),
                rounded(last)
            )));
        }
        let off = |number: &usize| (self.time(*number) - time).abs();
        Ok((0..self.count()).min_by(|a, b| off(a).total_cmp(&off(b))).unwrap_or(0))
    }

    /// Reads a frame.
    ///
    /// # Errors
    /// [`RunFolderError::Damaged`] if it cannot be read.
    pub fn read(&self, number: usize) -> Result<RunFrame, RunFolderError> {
        Ok(self.tables.frame(&self.snapshot(number)?))
    }

    /// Reads a part of a frame, with the fields that the scene requests.
    ///
    /// # Errors
    /// [`RunFolderError::Damaged`] if it cannot be read.
    pub(crate) fn part(&self, number: usize, kind: Kind) -> Result<Part, RunFolderError> {
        let frame = self.snapshot(number)?;
        Ok(match kind {
            Kind::Grains => self.tables.grains(&frame),
            Kind::Contacts => self.tables.contacts(&frame),
            Kind::Walls => self.tables.walls_part(&frame),
        })
    }

    /// Returns the numbers of the frames that have a part: walls at rest without wear are in the first frame alone.
    pub(crate) fn numbers(&self, kind: Kind) -> std::ops::Range<usize> {
        let (scene, count) = (&self.tables.scene, self.count());
        let output = scene.output.clone().unwrap_or_default();
        match kind {
            Kind::Grains => 0..count,
            Kind::Contacts => 0..if output.contacts { count } else { 0 },
            Kind::Walls if !output.walls || scene.wall.is_empty() => 0..0,
            Kind::Walls if scene.measure.observables.contains(&Observable::Wear) => 0..count,
            Kind::Walls if scene.wall.iter().all(|wall| wall.motion == Motion::Fixed) && !self.tables.stages_move() => {
                0..1
            }
            Kind::Walls => 0..count,
        }
    }

    /// Reads a frame as a snapshot of the simulation.
    ///
    /// # Errors
    /// [`RunFolderError::Damaged`] if it cannot be read.
    pub fn snapshot(&self, number: usize) -> Result<Arc<Snapshot>, RunFolderError> {
        match &self.source {
            Source::Store(store) => {
                let read = store.read(number);
                read.map(Arc::new).map_err(|problem| damaged(&self.folder.join(RunFiles::FRAMES), problem))
            }
            Source::Memory(frames) => Ok(Arc::clone(&frames[number])),
        }
    }

    /// Reads all frames as a recording of a code, for measurement by a scene, with notes on the run.
    ///
    /// # Errors
    /// [`RunFolderError`] if a frame cannot be read.
    pub fn recording(&self, code: &str, seed: u64, scene: &MeasuredScene) -> Result<Recording, RunFolderError> {
        let frames = (0..self.count()).map(|number| self.snapshot(number).map(Arc::unwrap_or_clone));
        let frames = frames.collect::<Result<Vec<Snapshot>, _>>()?;
        let own = &self.tables.scene;
        let lacks = match own.output.clone().unwrap_or_default().contacts {
            true => Vec::new(),
            false => vec![Content::Contacts, Content::WallContacts],
        };
        Ok(Recording {
            time_step: own.solver.step,
            lacks,
            notes: self.alarms.iter().cloned().chain(self.of_other_scene(scene)).collect(),
            ..Recording::new(scene, code, VERSION, seed, frames)
        })
    }

    /// Returns a note if the run's scene differs from the given scene.
    fn of_other_scene(&self, scene: &MeasuredScene) -> Option<String> {
        let own = &self.tables.scene;
        let folder = self.folder.display();
        (setup_hash(own) != setup_hash(scene)).then(|| {
            format!(
                "{folder} is a run of {} with other walls, materials, grains or effects than {}; give the scene that was run, with the same \
                 changes (--set)",
                own.name, scene.name
            )
        })
    }

    /// Returns a requested field, by its name with hyphens or underscores.
    ///
    /// # Errors
    /// [`RunFolderError::Unknown`] if the frame has no field of this name.
    pub fn field(&self, frame: &RunFrame, name: &str) -> Result<Quantity, RunFolderError> {
        let name = name.replace('-', "_");
        frame.quantity(&name).ok_or_else(|| {
            let (known, folder) = (frame.quantities().join(", "), self.folder.display().to_string());
            RunFolderError::Unknown(match frame.column(&name) {
                Some(column) => format!(
                    "'{name}' is in the frames of {folder}, but {} numbers of a grain are no colour; give one of: {known}",
                    column.width
                ),
                None => format!("no field '{name}' in the frames of {folder}; there are: {known}"),
            })
        })
    }
}

fn damaged(file: &Path, problem: String) -> RunFolderError {
    RunFolderError::Damaged { file: file.display().to_string(), problem }
}

/// Reads `run.json`; null if the file is missing or damaged.
fn summary(folder: &Path) -> serde_json::Value {
    let text = std::fs::read_to_string(folder.join(RunFiles::SUMMARY)).unwrap_or_default();
    serde_json::from_str(&text).unwrap_or_default()
}

/// Returns the diagnostics of a summary that make the numbers of the run doubtful or invalid.
fn alarms(folder: &Path, summary: &serde_json::Value) -> Option<String> {
    let file = folder.join(RunFiles::SUMMARY);
    let alarms = summary["alarms"].as_array().map(Vec::as_slice).unwrap_or_default();
    let worth = match alarms.iter().any(|alarm| alarm["grave"] == true) {
        true => "that its numbers are invalid",
        false => "that the run was not sound",
    };
    let words: Vec<&str> = alarms.iter().filter_map(|alarm| alarm["first"].as_str()).collect();
    (summary["sound"] == false).then(|| format!("{} says {worth}: {}", file.display(), words.join("; ")))
}
