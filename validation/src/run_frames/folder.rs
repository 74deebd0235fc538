//! Which frames the folder of a run holds.

use super::frame::{self, RunFrame};
use crate::output::vtk::PolyData;
use crate::output::{Outline, RunFiles, decode_vtk, outline_vtk};
use roxmltree::Document;
use std::path::{Path, PathBuf};

/// Why frames cannot be read.
#[derive(Debug, thiserror::Error)]
pub enum RunFolderError {
    /// There is no such folder.
    #[error(
        "no run '{run}': there is no folder of that name, here or below results; give the folder that makadam run wrote into"
    )]
    NoFolder {
        /// What was asked for.
        run: String,
    },
    /// There are no frames in it.
    #[error("{folder} holds no frames of a run: {problem}; give the folder that makadam run wrote into")]
    NoFrames {
        /// The folder.
        folder: String,
        /// What is missing.
        problem: String,
    },
    /// A time outside the run.
    #[error("{folder}: {time} s lies outside the run, whose {count} frames are from {first} s to {last} s")]
    OutOfRange {
        /// The folder.
        folder: String,
        /// What was asked for, s.
        time: f64,
        /// Number of frames.
        count: usize,
        /// Time of the first one, s.
        first: f64,
        /// Time of the last one, s.
        last: f64,
    },
    /// A file that is not what it should be.
    #[error("{file}: {problem}; run the scene again")]
    Damaged {
        /// The file.
        file: String,
        /// What is wrong with it.
        problem: String,
    },
    /// A field that colours cannot show.
    #[error(
        "'{field}' is in the frames of {folder}, but {numbers} numbers of a grain are no colour; give one of: {known}"
    )]
    ManyNumbers {
        /// What was asked for.
        field: String,
        /// The folder.
        folder: String,
        /// Numbers per grain.
        numbers: usize,
        /// What can be drawn.
        known: String,
    },
    /// A field that is not there.
    #[error("no field '{field}' in the frames of {folder}; there are: {known}")]
    NoField {
        /// What was asked for.
        field: String,
        /// The folder.
        folder: String,
        /// What there is.
        known: String,
    },
}

/// A number without the digits that sums of steps leave at its end, for messages.
pub(crate) fn rounded(value: f64) -> f64 {
    format!("{value:.8e}").parse().unwrap_or(value)
}

/// The frames that a run has left, listed but not yet read.
#[derive(Clone, Debug)]
pub struct RunFrames {
    folder: PathBuf,
    scene: String,
    /// s, as far as it is known.
    time_step: Option<f64>,
    grains: Vec<(f64, PathBuf)>,
    contacts: Vec<(f64, PathBuf)>,
    walls: Vec<(f64, PathBuf)>,
    alarms: Option<String>,
    setup_hash: Option<String>,
}

impl RunFrames {
    /// The frames of a run, by its folder or by the name of one below `results`. A run that is under way, or was killed, has those that it
    /// has written.
    ///
    /// # Errors
    /// [`RunFolderError`] if there is no such folder, or there are no frames in it.
    pub fn open(run: &Path) -> Result<RunFrames, RunFolderError> {
        let below = Path::new("results").join(run);
        let folder = [run, &below].into_iter().find(|folder| folder.is_dir());
        let folder = folder.ok_or_else(|| RunFolderError::NoFolder { run: run.display().to_string() })?.to_path_buf();
        let list = |kind: &str| {
            let file = folder.join(format!("{kind}.pvd"));
            match std::fs::read_to_string(&file) {
                Ok(text) => entries(&text, &folder).map_err(|problem| damaged(&file, problem)),
                Err(_) => Ok(Vec::new()),
            }
        };
        let (grains, contacts, walls) = (list("grains")?, list("contacts")?, list("walls")?);
        if grains.is_empty() {
            let problem = match folder.join("grains.pvd").exists() {
                true => "grains.pvd lists none yet",
                false => "there is no grains.pvd in it",
            };
            return Err(RunFolderError::NoFrames { folder: folder.display().to_string(), problem: problem.into() });
        }
        let Told { scene, time_step, alarms, setup_hash } = told(&folder, &grains[0].1);
        Ok(RunFrames { scene, time_step, folder, grains, contacts, walls, alarms, setup_hash })
    }

    /// The folder.
    pub fn folder(&self) -> &Path {
        &self.folder
    }

    /// Name of the scene, as far as it is known.
    pub fn scene(&self) -> &str {
        &self.scene
    }

    /// Hash of the physics of the scene ([`setup_hash`](crate::plan::setup_hash)), if the run tells it.
    pub fn setup_hash(&self) -> Option<&str> {
        self.setup_hash.as_deref()
    }

    /// What watchdogs noticed on the way that makes the numbers of the run doubtful or worthless, as far as it is known.
    pub fn alarms(&self) -> Option<&str> {
        self.alarms.as_deref()
    }

    /// Number of frames.
    pub fn count(&self) -> usize {
        self.grains.len()
    }

    /// Time of a frame, s.
    pub fn time(&self, number: usize) -> f64 {
        self.grains[number].0
    }

    /// Steps before a frame, by its time; its number where the time step is not known.
    pub fn step(&self, number: usize) -> u64 {
        self.time_step.map_or(number as u64, |step| (self.time(number) / step).round() as u64)
    }

    /// The frame nearest to a time (s).
    ///
    /// # Errors
    /// [`RunFolderError::OutOfRange`] if the time lies outside the run.
    pub fn at(&self, time: f64) -> Result<usize, RunFolderError> {
        let (first, last) = (self.time(0), self.time(self.count() - 1));
        // Times are typed with few digits.
        let slack = 1e-6 * (last - first).abs().max(1e-9);
        if !(first - slack..=last + slack).contains(&time) {
            let folder = self.folder.display().to_string();
            return Err(RunFolderError::OutOfRange {
                folder,
                time,
                count: self.count(),
                first: rounded(first),
                last: rounded(last),
            });
        }
        let off = |number: &usize| (self.time(*number) - time).abs();
        Ok((0..self.count()).min_by(|a, b| off(a).total_cmp(&off(b))).unwrap_or(0))
    }

    /// Reads a frame.
    ///
    /// # Errors
    /// [`RunFolderError::Damaged`] if one of its files is missing or is not what it should be.
    pub fn read(&self, number: usize) -> Result<RunFrame, RunFolderError> {
        let (time, file) = &self.grains[number];
        let contacts = self.contacts.iter().find(|(of, _)| of == time).map(|(_, file)| read(file)).transpose()?;
        // Walls that rest are written once, with the first frame.
        let walls = self.walls.iter().rev().find(|(of, _)| of <= time).map(|(_, file)| read(file)).transpose()?;
        let grains = read(file)?;
        frame::assemble(grains, contacts, walls).map_err(|problem| damaged(file, problem))
    }

    /// Times and files of one kind of frames: grains, contacts or walls.
    pub(crate) fn files(&self, kind: &str) -> &[(f64, PathBuf)] {
        match kind {
            "contacts" => &self.contacts,
            "walls" => &self.walls,
            _ => &self.grains,
        }
    }

    /// Counts of a file, and the arrays whose sections and names are wanted.
    pub(crate) fn read_some(
        &self,
        file: &Path,
        wanted: &dyn Fn(&str, &str) -> bool,
    ) -> Result<Outline, RunFolderError> {
        let bytes = std::fs::read(file).map_err(|error| damaged(file, error.to_string()))?;
        outline_vtk(&bytes, wanted).map_err(|problem| damaged(file, problem))
    }

    /// A field that was asked for, by its name with hyphens or underscores.
    ///
    /// # Errors
    /// [`RunFolderError::NoField`] if the frame has none of that name.
    pub fn field(&self, frame: &RunFrame, name: &str) -> Result<super::Quantity, RunFolderError> {
        let name = name.replace('-', "_");
        frame.quantity(&name).ok_or_else(|| {
            let (known, folder) = (frame.quantities().join(", "), self.folder.display().to_string());
            match frame.grains.fields.iter().find(|array| array.name == name) {
                Some(array) => RunFolderError::ManyNumbers { field: name, folder, numbers: array.components, known },
                None => RunFolderError::NoField { folder, known, field: name },
            }
        })
    }
}

fn read(file: &Path) -> Result<PolyData, RunFolderError> {
    let bytes = std::fs::read(file).map_err(|error| damaged(file, error.to_string()))?;
    decode_vtk(&bytes).map_err(|problem| damaged(file, problem))
}

fn damaged(file: &Path, problem: String) -> RunFolderError {
    RunFolderError::Damaged { file: file.display().to_string(), problem }
}

/// Times and files of a collection, in its order.
fn entries(text: &str, folder: &Path) -> Result<Vec<(f64, PathBuf)>, String> {
    let document = Document::parse(text).map_err(|error| format!("it is no list of frames: {error}"))?;
    let sets = document.descendants().filter(|node| node.has_tag_name("DataSet"));
    let entry = |set: roxmltree::Node<'_, '_>| {
        let time = set.attribute("timestep").and_then(|time| time.parse::<f64>().ok()).filter(|time| time.is_finite());
        let name = set.attribute("file").filter(|name| is_below(name));
        match (time, name) {
            (Some(time), Some(name)) => Ok((time, folder.join(name))),
            _ => Err("an entry has no time, or no file below the folder".to_string()),
        }
    };
    sets.map(entry).collect()
}

/// Whether a name leads to nowhere but below the folder that it is read from.
fn is_below(name: &str) -> bool {
    Path::new(name).components().all(|part| matches!(part, std::path::Component::Normal(_)))
}

/// Statements of `run.json`, or of the first frame, about a run: the name of its scene, its time step (s), why it is not sound, and the hash of its physics.
struct Told {
    scene: String,
    time_step: Option<f64>,
    alarms: Option<String>,
    setup_hash: Option<String>,
}

/// Returns the name of the scene that the file of a frame holds.
fn scene_of(file: &Path) -> Option<String> {
    let texts = read(file).ok()?.texts;
    texts.into_iter().find(|(name, _)| name == "scene_name").and_then(|(_, names)| names.into_iter().next())
}

fn told(folder: &Path, first: &Path) -> Told {
    let file = folder.join(RunFiles::SUMMARY);
    let summary = std::fs::read_to_string(&file).unwrap_or_default();
    let summary: serde_json::Value = serde_json::from_str(&summary).unwrap_or_default();
    let name = summary["scene"].as_str().map(String::from).or_else(|| scene_of(first));
    let of_folder = || folder.file_name().map_or(String::new(), |name| name.to_string_lossy().into_owned());
    let alarms = summary["alarms"].as_array().map(Vec::as_slice).unwrap_or_default();
    let is_grave = alarms.iter().any(|alarm| alarm["grave"] == true);
    let words: Vec<&str> = alarms.iter().filter_map(|alarm| alarm["first"].as_str()).collect();
    let alarms = (summary["sound"] == false).then(|| {
        let worth = if is_grave { "that its numbers are worthless" } else { "that the run was not sound" };
        format!("{} says {worth}: {}", file.display(), words.join("; "))
    });
    Told {
        scene: name.unwrap_or_else(of_folder),
        time_step: summary["time_step"].as_f64().filter(|step| *step > 0.0),
        alarms,
        setup_hash: summary["setup_hash"].as_str().map(String::from),
    }
}
