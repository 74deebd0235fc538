//! Manifest of frames: a TOML file that names the files of a run and states what they do not. `docs/own-code.md` lists the keys.
//!
//! ```toml
//! grains = ["grains_{step}.csv"]
//! contacts = ["pairs.dump", "walls.dump"]
//! time-step = 1e-5
//! contacts-complete = true
//! kinds = { 1 = "glass", 2 = "steel" }
//! contact-columns.c_pairs = ["first", "second", "_", "fx", "fy", "fz", "px", "py", "pz"]
//! ```

use super::columns::{StatedColumns, number as read_number};
use super::table::{FrameTable, ImportError};
use crate::plan::MeasuredScene;
use serde::Deserialize;
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

/// Files of a run, and statements about them that the files do not make.
#[derive(Clone, Debug, Default, PartialEq, Deserialize)]
#[serde(default, deny_unknown_fields, rename_all = "kebab-case")]
pub struct Manifest {
    /// Folder from which files are named.
    #[serde(skip)]
    pub folder: PathBuf,
    /// Name of the code, in tables and pictures.
    pub name: Option<String>,
    /// Version of the code.
    pub version: Option<String>,
    /// Program and arguments that make the frames, for `makadam compare`.
    pub command: Vec<String>,
    /// Files of grains.
    pub grains: Vec<FilePattern>,
    /// Files of contacts.
    pub contacts: Vec<FilePattern>,
    /// Names of the columns of grains, in place of those in the files.
    pub columns: StatedColumns,
    /// Names of the columns of contacts.
    pub contact_columns: StatedColumns,
    /// Time between frames whose numbers differ by one, s: the time step, where frames are numbered by steps.
    pub time_step: Option<f64>,
    /// Time of the only frame, s.
    pub time: Option<f64>,
    /// True if the files of contacts list all contacts of their frames.
    pub contacts_complete: bool,
    /// Number in the files of the scene's first grain, where they number grains as the scene does.
    pub first_id: Option<i64>,
    /// Seed by which the grains were placed as the scene places them; with `first_id` it states their radii.
    pub seed: Option<u64>,
    /// Material, or population, that a value of the column `type` or `material` stands for.
    pub kinds: BTreeMap<String, String>,
    /// Walls of the scene that the numbers of the column `wall` stand for; empty where these are the scene's own.
    pub walls: Vec<u32>,
}

impl Manifest {
    /// Reads and checks a manifest.
    ///
    /// # Errors
    /// [`ImportError`] with the line.
    pub fn load(file: &Path) -> Result<Manifest, ImportError> {
        let text = std::fs::read_to_string(file).map_err(|error| ImportError::new(file, 1, error.to_string()))?;
        Manifest::parse(file, &text)
    }

    /// Reads and checks the text of a manifest.
    ///
    /// # Errors
    /// [`ImportError`] with the line.
    pub fn parse(file: &Path, text: &str) -> Result<Manifest, ImportError> {
        let manifest: Manifest = toml::from_str(text).map_err(|error| {
            let line = error.span().map_or(1, |span| text[..span.start].matches('\n').count() + 1);
            ImportError::new(file, line, error.message())
        })?;
        let refused = |problem: &str| Err(ImportError::new(file, 1, problem));
        if manifest.grains.is_empty() {
            return refused("grains names no file; give at least one, such as grains = [\"out_{step}.csv\"]");
        }
        let is_time = |time: f64| time.is_finite() && time > 0.0;
        if manifest.time_step.is_some_and(|step| !is_time(step)) {
            return refused("time-step is a time above zero, in seconds");
        }
        if manifest.time.is_some_and(|time| !time.is_finite()) {
            return refused("time is a time in seconds");
        }
        Ok(Manifest { folder: file.parent().unwrap_or(Path::new("")).to_path_buf(), ..manifest })
    }

    /// Checks that `kinds` and `walls` name what the scene has.
    ///
    /// # Errors
    /// The key, its value and what the scene has.
    pub fn check(&self, scene: &MeasuredScene) -> Result<(), String> {
        let known = known_kinds(scene);
        if let Some((value, name)) = self.kinds.iter().find(|(_, name)| !known.contains(name)) {
            return Err(format!("kinds: {value}={name}: the scene has no {name}; it has {}", known.join(", ")));
        }
        match self.walls.iter().find(|wall| **wall as usize >= scene.wall.len()) {
            Some(wall) => Err(format!("walls names wall {wall}, and the scene has {}, from 0", scene.wall.len())),
            None => Ok(()),
        }
    }

    /// Files of a pattern below the folder, in the order of their names.
    ///
    /// # Errors
    /// [`ImportError`] where there is none.
    pub fn files(&self, pattern: &FilePattern) -> Result<Vec<PathBuf>, ImportError> {
        let whole = self.folder.join(&pattern.0);
        // A name without wildcards is taken as it is: a missing file is reported where it is read.
        if whole.exists() || !pattern.glob().contains(['*', '?', '[']) {
            return Ok(vec![whole]);
        }
        let fault = |problem: String| ImportError::new(&whole, 1, problem);
        let glob = PathBuf::from(glob::Pattern::escape(&self.folder.to_string_lossy())).join(pattern.glob());
        let found = glob::glob(&glob.to_string_lossy()).map_err(|error| fault(error.to_string()))?;
        let files: Vec<PathBuf> =
            found.flatten().filter(|file| file.is_file() && pattern.stamp(file).is_some()).collect();
        if files.is_empty() {
            Err(fault("there is no file of this pattern ({step} and {time} stand for numbers)".into()))
        } else {
            Ok(files)
        }
    }
}

/// Names that `kinds` may use: materials, and populations by their numbers.
pub(super) fn known_kinds(scene: &MeasuredScene) -> Vec<String> {
    let populations = (0..scene.population.len()).map(|number| format!("population.{number}"));
    scene.material.keys().cloned().chain(populations).collect()
}

/// Name of files: `*` stands for any letters; in the last part, without other wildcards there, `{step}` stands for the number of a step and
/// `{time}` for a time in seconds.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(transparent)]
pub struct FilePattern(String);

impl From<&str> for FilePattern {
    fn from(text: &str) -> FilePattern {
        FilePattern(text.into())
    }
}

/// Statement of a file's name about the time of its frame.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Stamp {
    pub step: Option<u64>,
    pub time: Option<f64>,
}

impl FilePattern {
    /// The pattern as it is written.
    pub fn text(&self) -> &str {
        &self.0
    }

    /// The pattern with `*` in place of a number.
    pub fn glob(&self) -> String {
        self.0.replace("{step}", "*").replace("{time}", "*")
    }

    /// Reads step or time from the name of a file; none where no number stands there.
    pub(super) fn stamp(&self, file: &Path) -> Option<Stamp> {
        let pattern = self.0.rsplit('/').next()?;
        let number = |(head, tail): (&str, &str)| file.file_name()?.to_str()?.strip_prefix(head)?.strip_suffix(tail);
        match (pattern.split_once("{step}"), pattern.split_once("{time}")) {
            (Some(around), _) => Some(Stamp { step: Some(number(around)?.parse().ok()?), time: None }),
            (None, Some(around)) => Some(Stamp { step: None, time: Some(read_number(number(around)?).ok()?) }),
            (None, None) => Some(Stamp::default()),
        }
    }
}

/// Statements that neither the files nor the manifest make: lines of a manifest, with their meaning.
#[derive(Default)]
pub(super) struct Missing {
    lines: Vec<[String; 2]>,
    /// File and line at which the first of them is missing.
    fault: Option<ImportError>,
}

impl Missing {
    /// Adds a line, unless it is there.
    pub fn add(&mut self, table: &FrameTable, row: usize, line: impl Into<String>, meaning: impl Into<String>) {
        let line = [line.into(), meaning.into()];
        if !self.lines.contains(&line) {
            self.lines.push(line);
        }
        self.fault.get_or_insert_with(|| table.fault(row, ""));
    }

    /// Refuses the frames if lines are missing.
    ///
    /// # Errors
    /// [`ImportError`] with all missing lines.
    pub fn refuse(&self) -> Result<(), ImportError> {
        let Some(fault) = self.fault.clone() else { return Ok(()) };
        let lines = self.lines.iter().map(|[line, meaning]| format!("\n  {line}   # {meaning}"));
        let problem = format!(
            "statements are missing; add them to a manifest, or as options of the same names (--time-step 1e-5):{}",
            lines.collect::<String>()
        );
        Err(ImportError { problem, ..fault })
    }
}
