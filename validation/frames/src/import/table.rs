//! Frame of a file: rows of numbers under named columns.

use super::columns::{Column, OfComponent, StatedColumns, column_of, number};
use makadam::snapshot::DrivenWall;
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

/// Rows of numbers under named columns, at one time.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct FrameTable {
    /// File of the frame.
    pub file: PathBuf,
    /// Line of the frame, from 1; 1 where the file has no lines.
    pub line: usize,
    /// Lines of the rows, from 1, if the file has lines.
    pub lines: Vec<usize>,
    /// Simulated time, s, if the file or its name states it.
    pub time: Option<f64>,
    /// Number of the time step, if the file or its name states it.
    pub step: Option<u64>,
    /// Names of the columns that have a meaning.
    pub columns: Vec<String>,
    /// Meanings of these columns.
    pub meanings: Vec<Column>,
    /// Indices of these columns among the columns of the file.
    pub places: Vec<usize>,
    /// Names of the columns without a meaning, which are not read.
    pub unread: Vec<String>,
    /// Numbers, row after row; NaN for a cell without a finite number.
    pub values: Vec<f64>,
    /// Cells without a finite number, by their index in `values`.
    pub words: BTreeMap<usize, String>,
    /// Periodic box, if the file states it.
    pub periods: Option<Periods>,
    /// Number of the scene's first grain, in files of Makadam, which use the scene's grain numbers and list all contacts.
    pub first_id: Option<i64>,
    /// Poses of the dynamic walls, if the file states them.
    pub driven_walls: Vec<DrivenWall>,
}

/// Periodic box of a file.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Periods {
    /// Lengths along the periodic axes (m), zero along the others.
    pub lengths: [f64; 3],
    /// Rounding error of the lengths from the digits of the file, m.
    pub rounding: f64,
}

impl FrameTable {
    /// Returns the rows of numbers.
    pub fn rows(&self) -> impl ExactSizeIterator<Item = &[f64]> {
        self.values.chunks_exact(self.columns.len().max(1))
    }

    /// Returns the text of a cell without a finite number.
    pub fn word(&self, row: usize, column: usize) -> Option<&str> {
        self.words.get(&(row * self.columns.len() + column)).map(String::as_str)
    }

    /// Returns the index of a column, if the table has it.
    pub fn find(&self, column: Column) -> Option<usize> {
        self.meanings.iter().position(|known| *known == column)
    }

    /// Returns the indices of three components, if the table has all of them.
    pub(super) fn vector(&self, of: OfComponent) -> Option<[usize; 3]> {
        let [x, y, z] = [0, 1, 2].map(|axis| self.find(of(axis)));
        Some([x?, y?, z?])
    }

    /// Returns the index of the radius or the diameter, and the factor from it to the radius.
    pub(super) fn radius(&self) -> Option<(usize, f64)> {
        let of_diameter = || Some((self.find(Column::Diameter)?, 0.5));
        self.find(Column::Radius).map(|place| (place, 1.0)).or_else(of_diameter)
    }

    /// Returns the names of all columns, for an error.
    pub(super) fn names(&self) -> String {
        self.columns.iter().chain(&self.unread).map(String::as_str).collect::<Vec<_>>().join(", ")
    }

    /// Returns the number of columns of the file.
    pub(super) fn width(&self) -> usize {
        self.columns.len() + self.unread.len()
    }

    /// Adds the cells of a line in columns with a meaning.
    ///
    /// # Errors
    /// [`ImportError`] for missing cells, or for a cell with a meaning and without a finite number.
    pub(super) fn add_row(&mut self, line: usize, cells: &[&str]) -> Result<(), ImportError> {
        let fault = |problem: String| ImportError::new(&self.file, line, problem);
        if cells.len() != self.width() {
            return Err(fault(format!("{} numbers where {} belong", cells.len(), self.width())));
        }
        for (column, place) in self.places.iter().enumerate() {
            let value = match number(cells[*place]) {
                Ok(value) => value,
                Err(_) if self.meanings[column] == Column::Kind => {
                    self.words.insert(self.values.len(), cells[*place].to_string());
                    f64::NAN
                }
                Err(problem) => {
                    let is_partner = matches!(self.meanings[column], Column::Second | Column::Wall);
                    let remedy = if is_partner { "; give -1 where a contact has no such partner" } else { "" };
                    return Err(fault(format!("column {}: {problem}{remedy}", self.columns[column])));
                }
            };
            self.values.push(value);
        }
        self.lines.push(line);
        Ok(())
    }

    /// Makes an error for a row.
    pub(super) fn fault(&self, row: usize, problem: impl Into<String>) -> ImportError {
        ImportError::new(&self.file, *self.lines.get(row).unwrap_or(&self.line), problem)
    }
}

/// Error of a file that cannot be read, or holds no frame of the scene.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[error("{}: line {line}: {problem}", file.display())]
pub struct ImportError {
    /// File.
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
    /// Numbers, tuple after tuple; absent for a skipped array, with a name without meaning.
    numbers: Option<Vec<f64>>,
}

impl Named {
    pub fn new(name: impl Into<String>, components: usize, numbers: Option<Vec<f64>>) -> Named {
        Named { name: name.into(), components, numbers }
    }
}

/// Returns the names of the columns of an array.
fn component_names(name: &str, components: usize) -> Vec<String> {
    match components {
        1 => vec![name.to_string()],
        _ => (0..components).map(|axis| format!("{name}_{axis}")).collect(),
    }
}

/// Returns true if an array is read: its columns have a meaning, or the caller names all columns.
pub(super) fn is_wanted(name: &str, components: usize, stated: &StatedColumns) -> bool {
    !stated.is_empty() || component_names(name, components).iter().any(|name| column_of(name).is_some())
}

/// Joins arrays of `count` tuples into one table.
///
/// # Errors
/// [`ImportError`] for a shorter array, or for numbers that are not finite under a name with a meaning.
pub(super) fn table_of(
    file: &Path,
    count: usize,
    arrays: &[Named],
    stated: &StatedColumns,
) -> Result<FrameTable, ImportError> {
    let fault = |problem: String| ImportError::new(file, 1, problem);
    let names = arrays.iter().flat_map(|array| component_names(&array.name, array.components));
    let mut table = stated.table(file, 1, names.collect())?;
    let sources: Vec<(&Named, usize)> =
        arrays.iter().flat_map(|array| (0..array.components).map(move |axis| (array, axis))).collect();
    let mut columns: Vec<(&[f64], usize, usize)> = Vec::new();
    for (Named { name, components, numbers }, axis) in table.places.iter().map(|place| sources[*place]) {
        let numbers = numbers.as_deref().ok_or_else(|| fault(format!("array {name} holds no numbers")))?;
        if numbers.len() != components * count {
            let problem = format!("array {name} has {} numbers where {} belong", numbers.len(), components * count);
            return Err(fault(problem));
        }
        if !numbers.iter().all(|number| number.is_finite()) {
            return Err(fault(format!("array {name}: a number is not finite: the run diverged")));
        }
        columns.push((numbers, *components, axis));
    }
    table.values.reserve(count * columns.len());
    for tuple in 0..count {
        table.values.extend(columns.iter().map(|(numbers, components, axis)| numbers[tuple * components + axis]));
    }
    Ok(table)
}
