//! A manifest of frames: a TOML file that names the files of a run and states what they do not say themselves.
//!
//! ```toml
//! grains = ["grains.dump"]
//! contacts = ["pairs.dump", "walls.dump"]
//! time-step = 1e-5                    # s; or interval, the time between frames
//! first-id = 1                        # number of the scene's first grain, where grains are numbered as in the scene
//! seed = 1                            # with first-id: grains were placed as the scene places them with this seed
//! kinds = { 1 = "glass", 2 = "steel" }   # what the values of a column type or material stand for
//! walls = [0, 2]                      # walls of the scene that the numbers 0, 1 of a column wall stand for
//!
//! [contact-columns]
//! c_pairs = ["first", "second", "_", "fx", "fy", "fz", "px", "py", "pz"]
//! ```

use super::frame_table::ImportError;
use super::stated::{Stated, StatedColumns};
use serde::Deserialize;
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

/// Files of a run, and statements about them.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields, rename_all = "kebab-case")]
pub struct Manifest {
    /// Folder of the manifest.
    #[serde(skip)]
    file: PathBuf,
    /// Files of grains, below the folder of the manifest; `*` stands for any letters of a name.
    grains: Vec<String>,
    /// Files of contacts.
    #[serde(default)]
    contacts: Vec<String>,
    #[serde(default)]
    columns: StatedColumns,
    #[serde(default)]
    contact_columns: StatedColumns,
    time_step: Option<f64>,
    interval: Option<f64>,
    first_id: Option<i64>,
    seed: Option<u64>,
    #[serde(default)]
    kinds: BTreeMap<String, String>,
    #[serde(default)]
    walls: Vec<u32>,
}

impl Manifest {
    /// Reads a manifest.
    ///
    /// # Errors
    /// [`ImportError`] with the line.
    pub fn load(file: &Path) -> Result<Manifest, ImportError> {
        let text = std::fs::read_to_string(file).map_err(|error| ImportError::new(file, 1, error.to_string()))?;
        Manifest::parse(file, &text)
    }

    /// Reads the text of a manifest.
    ///
    /// # Errors
    /// [`ImportError`] with the line.
    pub fn parse(file: &Path, text: &str) -> Result<Manifest, ImportError> {
        let manifest: Manifest = toml::from_str(text).map_err(|error| {
            let line = error.span().map_or(1, |span| text[..span.start].matches('\n').count() + 1);
            ImportError::new(file, line, format!("manifest: {}", error.message()))
        })?;
        let refused = |problem: &str| Err(ImportError::new(file, 1, problem));
        if manifest.grains.is_empty() {
            return refused("manifest: grains names no file");
        }
        if let Err(problem) = Stated::check_times(manifest.time_step, manifest.interval) {
            return refused(&format!("manifest: {problem}"));
        }
        Ok(Manifest { file: file.to_path_buf(), ..manifest })
    }

    /// Files of grains.
    ///
    /// # Errors
    /// [`ImportError`] where there is none of a name.
    pub fn grains(&self) -> Result<Vec<PathBuf>, ImportError> {
        self.files(&self.grains)
    }

    /// Files of contacts.
    ///
    /// # Errors
    /// [`ImportError`] where there is none of a name.
    pub fn contacts(&self) -> Result<Vec<PathBuf>, ImportError> {
        self.files(&self.contacts)
    }

    fn files(&self, patterns: &[String]) -> Result<Vec<PathBuf>, ImportError> {
        let folder = self.file.parent().unwrap_or(Path::new(""));
        let mut files = Vec::new();
        for pattern in patterns {
            let refused = |problem: String| ImportError::new(&self.file, 1, format!("manifest: {problem}"));
            let own = PathBuf::from(glob::Pattern::escape(&folder.to_string_lossy())).join(pattern);
            let found = glob::glob(&own.to_string_lossy()).map_err(|error| refused(format!("'{pattern}': {error}")))?;
            let before = files.len();
            files.extend(found.flatten());
            if files.len() == before {
                return Err(refused(format!("there is no file {pattern} beside it")));
            }
        }
        Ok(files)
    }

    /// Statements of the manifest.
    pub fn stated(&self) -> Stated {
        Stated {
            columns: self.columns.clone(),
            contact_columns: self.contact_columns.clone(),
            time_step: self.time_step,
            interval: self.interval,
            first_id: self.first_id,
            seed: self.seed,
            kinds: self.kinds.clone(),
            walls: self.walls.clone(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_manifest_states_files_and_columns() {
        let text = "grains = ['g.dump']\ntime-step = 1e-5\nfirst-id = 1\nkinds = { 1 = 'glass' }\n[contact-columns]\nc_pairs = ['first', 'second']\n";
        let stated = Manifest::parse(Path::new("m.toml"), text).unwrap().stated();
        assert_eq!((stated.time_step, stated.first_id, &*stated.kinds["1"]), (Some(1e-5), Some(1), "glass"));
        assert_eq!(stated.contact_columns, "c_pairs:first,second".parse().unwrap());
        for (text, words) in [
            ("grains = ['g']\ntimestep = 1\n", "m.toml: line 2: manifest: unknown field `timestep`"),
            ("grains = []\n", "names no file"),
            ("grains = ['g']\ninterval = 0.0\n", "times above zero"),
            ("grains = ['g']\ninterval = 1.0\ntime-step = 1.0\n", "either time-step or interval"),
        ] {
            let error = Manifest::parse(Path::new("m.toml"), text).unwrap_err().to_string();
            assert!(error.contains(words), "{error}");
        }
        let missing = Manifest::parse(Path::new("nowhere/m.toml"), "grains = ['g.dump']\n").unwrap().grains();
        assert!(missing.unwrap_err().to_string().contains("there is no file g.dump beside it"));
    }
}
