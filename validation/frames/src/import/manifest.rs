//! Manifest of frames: a TOML file with the names of a run's files and statements missing from them. `docs/own-code.md` lists the keys.
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

/// Files of a run, and further statements about them.
#[derive(Clone, Debug, Default, PartialEq, Deserialize)]
#[serde(default, deny_unknown_fields, rename_all = "kebab-case")]
pub struct Manifest {
    /// Base folder of file names.
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
    /// Names of the columns of grains, replacing the names in the files.
    pub columns: StatedColumns,
    /// Names of the columns of contacts.
    pub contact_columns: StatedColumns,
    /// Time between frames with consecutive numbers, s: the time step, if frames are numbered by steps.
    pub time_step: Option<f64>,
    /// Time of the only frame, s.
    pub time: Option<f64>,
    /// True if the files of contacts list all contacts of their frames.
    pub contacts_complete: bool,
    /// File number of the scene's first grain, for files with the scene's numbering.
    pub first_id: Option<i64>,
    /// Seed of the scene's grain positions; with `first_id`, determines their radii.
    pub seed: Option<u64>,
    /// Material or population for each value of the column `type` or `material`.
    pub kinds: BTreeMap<String, String>,
    /// Walls of the scene for the numbers of the column `wall`; empty if these are the scene's own.
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

    /// Checks that `kinds` and `walls` name items of the scene.
    ///
    /// # Errors
    /// The key, its value and the names in the scene.
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

    /// Returns the files of a pattern below the folder, in the order of their names.
    ///
    /// # Errors
    /// [`ImportError`] if there is no file.
    pub fn files(&self, pattern: &FilePattern) -> Result<Vec<PathBuf>, ImportError> {
        let whole = self.folder.join(&pattern.0);
        // A name without wildcards is used unchanged: a missing file is reported when it is read.
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

/// Returns the names for `kinds`: materials, and populations by their numbers.
pub(super) fn known_kinds(scene: &MeasuredScene) -> Vec<String> {
    let populations = (0..scene.population.len()).map(|number| format!("population.{number}"));
    scene.material.keys().cloned().chain(populations).collect()
}

/// Pattern of file names: `*` matches any letters. In the last part, without other wildcards there, `{step}` matches a step number and
/// `{time}` a time in seconds.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(transparent)]
pub struct FilePattern(String);

impl From<&str> for FilePattern {
    fn from(text: &str) -> FilePattern {
        FilePattern(text.into())
    }
}

/// Time or step of a frame, from the name of its file.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Stamp {
    pub step: Option<u64>,
    pub time: Option<f64>,
}

impl FilePattern {
    /// Returns the text of the pattern.
    pub fn text(&self) -> &str {
        &self.0
    }

    /// Returns the pattern with `*` instead of a number.
    pub fn glob(&self) -> String {
        self.0.replace("{step}", "*").replace("{time}", "*")
    }

    /// Reads step or time from the name of a file; `None` without a number there.
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

/// Statements missing from the files and the manifest: lines of a manifest, with their meaning.
#[derive(Default)]
pub(super) struct Missing {
    lines: Vec<[String; 2]>,
    /// File and line of the first missing statement.
    fault: Option<ImportError>,
}

impl Missing {
    /// Adds a line, unless present.
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
