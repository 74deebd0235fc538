//! A frame as a file states it: rows of numbers under named columns.

use makadam::snapshot::DrivenWall;
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

/// Rows of numbers under named columns, at one time.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct FrameTable {
    /// File of the frame.
    pub file: PathBuf,
    /// Line of the first row, from 1; 1 where the file has no lines.
    pub line: usize,
    /// Lines of the rows, from 1, where the reader counts them; else each row has a line of its own from `line` on.
    pub lines: Vec<usize>,
    /// Simulated time, s, if the file states it.
    pub time: Option<f64>,
    /// Number of the time step, if the file or its name states it.
    pub step: Option<u64>,
    /// Names of the columns that have a meaning.
    pub columns: Vec<String>,
    /// Names of the columns that have none: these are not read.
    pub unread: Vec<String>,
    /// Numbers, row after row; NaN for a cell that holds no finite number.
    pub values: Vec<f64>,
    /// Cells that hold no finite number, by their place in `values`.
    pub words: BTreeMap<usize, String>,
    /// Lengths of the box along its periodic axes (m), zero along the others, where the file states its box.
    pub periods: Option<Periods>,
    /// Number in the file of the scene's first grain, where the file numbers grains as the scene does.
    pub first_id: Option<i64>,
    /// Poses of the driven walls, if the file states them.
    pub driven_walls: Vec<DrivenWall>,
}

/// Periodic box of a file.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Periods {
    /// Lengths along the periodic axes (m), zero along the others.
    pub lengths: [f64; 3],
    /// Error of the lengths by the digits of the file, m.
    pub rounding: f64,
}

impl FrameTable {
    /// Rows of numbers.
    pub fn rows(&self) -> impl Iterator<Item = &[f64]> {
        self.values.chunks_exact(self.columns.len().max(1))
    }

    /// The text of a cell that holds no finite number.
    pub(super) fn word(&self, row: usize, column: usize) -> Option<&str> {
        self.words.get(&(row * self.columns.len() + column)).map(String::as_str)
    }

    /// Reports a fault of a row.
    pub(super) fn fault(&self, row: usize, problem: impl Into<String>) -> ImportError {
        let line = self.lines.get(row).copied().unwrap_or(self.line + row);
        ImportError::new(&self.file, line.max(1), problem)
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
