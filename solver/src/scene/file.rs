//! Scenes in files: reading one, and errors that name the file and the line.

use super::Scene;
use std::path::{Path, PathBuf};

/// Why the scene of a file was refused.
#[derive(Debug, thiserror::Error)]
pub enum SceneFileError {
    /// The file cannot be read.
    #[error("{}: cannot be read: {source}; give a path to a readable TOML file", file.display())]
    Missing {
        /// The file.
        file: PathBuf,
        /// What the system said.
        source: std::io::Error,
    },
    /// There is no room for the grains.
    #[error(
        "{}: the memory for its grains is not there: {:.1} GB more were asked for; lower the count, or use a machine with more",
        file.display(),
        *bytes as f64 * 1e-9
    )]
    Memory {
        /// The file, or what stands for it.
        file: PathBuf,
        /// What was asked for, bytes.
        bytes: usize,
    },
    /// The file can be read, but what it says cannot be simulated.
    #[error("{}{}: {problem}; {remedy}", file.display(), line.map(|line| format!(":{line}")).unwrap_or_default())]
    Invalid {
        /// The file, or what stands for it where the scene was built in code.
        file: PathBuf,
        /// Line, from 1; none where there is no file, and the problem names the field by its path.
        line: Option<usize>,
        /// What is wrong.
        problem: String,
        /// What would be right.
        remedy: String,
    },
}

impl Scene {
    /// Reads and checks a scene file.
    ///
    /// # Errors
    /// [`SceneFileError`] if the file is missing, is not TOML, says something that is not read, holds a value out of range, or prescribes
    /// a motion that its step passes over.
    pub fn load(file: impl AsRef<Path>) -> Result<Scene, SceneFileError> {
        let file = file.as_ref();
        let missing = |source| SceneFileError::Missing { file: file.to_path_buf(), source };
        let text = std::fs::read_to_string(file).map_err(missing)?;
        Scene::parse(&text).map_err(|error| error.in_file(file, Some(&text)))
    }
}
