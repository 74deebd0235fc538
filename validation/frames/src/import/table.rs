//! Frame of a file: rows of numbers under named columns.

use super::columns::{StatedColumns, column_of};
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
    /// Simulated time, s, if the file or its name states it.
    pub time: Option<f64>,
    /// Number of the time step, if the file or its name states it.
    pub step: Option<u64>,
    /// Names of the columns that have a meaning.
    pub columns: Vec<String>,
    /// Names of the columns that have none: these are not read.
    pub unread: Vec<String>,
    /// Numbers, row after row; NaN for a cell that holds no finite number.
    pub values: Vec<f64>,
    /// Cells that hold no finite number, by their index in `values`.
    pub words: BTreeMap<usize, String>,
    /// Periodic box, if the file states it.
    pub periods: Option<Periods>,
    /// Number of the scene's first grain, in files of Makadam: these number grains as the scene does, and list all contacts.
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
    pub fn rows(&self) -> impl ExactSizeIterator<Item = &[f64]> {
        self.values.chunks_exact(self.columns.len().max(1))
    }

    /// Text of a cell that holds no finite number.
    pub fn word(&self, row: usize, column: usize) -> Option<&str> {
        self.words.get(&(row * self.columns.len() + column)).map(String::as_str)
    }

    /// Reports a fault of a row.
    pub(super) fn fault(&self, row: usize, problem: impl Into<String>) -> ImportError {
        let line = self.lines.get(row).copied().unwrap_or(self.line + row);
        ImportError::new(&self.file, line.max(1), problem)
    }
}

/// Error of a file that cannot be read, or holds no frame of the scene.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[error("{}: line {line}: {problem}", file.display())]
pub struct ImportError {
    /// The file.
    pub file: PathBuf,
    /// Line, from 1.
    pub line: usize,
    /// Problem and remedy.
    pub problem: String,
}

impl ImportError {
    pub(super) fn new(file: &Path, line: usize, problem: impl Into<String>) -> ImportError {
        ImportError { file: file.to_path_buf(), line, problem: problem.into() }
    }
}

/// Array of a VTK file.
#[derive(Debug, PartialEq)]
pub(super) struct Named {
    name: String,
    components: usize,
    /// Numbers, tuple after tuple; none where the array was passed over, since its name has no meaning.
    numbers: Option<Vec<f64>>,
}

impl Named {
    pub fn new(name: impl Into<String>, components: usize, numbers: Option<Vec<f64>>) -> Named {
        Named { name: name.into(), components, numbers }
    }
}

/// Names of the columns that an array becomes.
fn component_names(name: &str, components: usize) -> Vec<String> {
    match components {
        1 => vec![name.to_string()],
        _ => (0..components).map(|axis| format!("{name}_{axis}")).collect(),
    }
}

/// Reports whether an array is to be read: its columns have a meaning, or the caller names all columns.
pub(super) fn is_wanted(name: &str, components: usize, stated: &StatedColumns) -> bool {
    !stated.is_empty() || component_names(name, components).iter().any(|name| column_of(name).is_some())
}

/// Puts arrays of `count` tuples into one table.
///
/// # Errors
/// [`ImportError`] where an array is shorter, or holds no finite number under a name that has a meaning.
pub(super) fn table_of(
    file: &Path,
    count: usize,
    arrays: &[Named],
    stated: &StatedColumns,
) -> Result<FrameTable, ImportError> {
    let fault = |problem: String| ImportError::new(file, 1, problem);
    let names: Vec<String> = arrays.iter().flat_map(|array| component_names(&array.name, array.components)).collect();
    let heads = stated.heads(file, 1, names)?;
    let sources: Vec<(usize, usize)> =
        (0..arrays.len()).flat_map(|array| (0..arrays[array].components).map(move |axis| (array, axis))).collect();
    let mut table = heads.table(file);
    let mut columns: Vec<(&[f64], usize, usize)> = Vec::new();
    for (array, axis) in heads.used().iter().map(|column| sources[*column]) {
        let Named { name, components, numbers } = &arrays[array];
        let numbers = numbers.as_deref().ok_or_else(|| fault(format!("array {name} holds no numbers")))?;
        if numbers.len() != components * count {
            let problem = format!("array {name} has {} numbers where {} belong", numbers.len(), components * count);
            return Err(fault(problem));
        }
        if !numbers.iter().all(|number| number.is_finite()) {
            return Err(fault(format!("array {name}: a number is not finite: the run has blown up")));
        }
        columns.push((numbers, *components, axis));
    }
    table.values.reserve(count * columns.len());
    for tuple in 0..count {
        table.values.extend(columns.iter().map(|(numbers, components, axis)| numbers[tuple * components + axis]));
    }
    Ok(table)
}
