//! A frame as a file tells it: rows of numbers under named columns.

use makadam::snapshot::DrivenWall;
use std::path::{Path, PathBuf};

/// Rows of numbers under named columns, at one time.
#[derive(Clone, Debug, PartialEq)]
pub struct FrameTable {
    /// File that it stands in.
    pub file: PathBuf,
    /// Line of its first row, from 1; 1 where the file has no lines.
    pub line: usize,
    /// Simulated time, s, if the file tells it.
    pub time: Option<f64>,
    /// Number of the time step, if the file or its name tells it.
    pub step: Option<u64>,
    /// Names of the columns.
    pub columns: Vec<String>,
    /// Numbers, row after row.
    pub values: Vec<f64>,
    /// Poses of the driven walls, if the file states them.
    pub driven_walls: Vec<DrivenWall>,
}

impl FrameTable {
    /// Its rows.
    pub fn rows(&self) -> impl Iterator<Item = &[f64]> {
        self.values.chunks_exact(self.columns.len().max(1))
    }

    /// A fault of a row.
    pub(super) fn fault(&self, row: usize, problem: impl Into<String>) -> ImportError {
        ImportError::new(&self.file, self.line + row, problem)
    }
}

/// Why a file cannot be read, or holds no frame of the scene.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[error("{}: line {line}: {problem}", file.display())]
pub struct ImportError {
    /// The file.
    pub file: PathBuf,
    /// Line, from 1.
    pub line: usize,
    /// What is wrong, and the remedy.
    pub problem: String,
}

impl ImportError {
    pub(super) fn new(file: &Path, line: usize, problem: impl Into<String>) -> ImportError {
        ImportError { file: file.to_path_buf(), line, problem: problem.into() }
    }
}
