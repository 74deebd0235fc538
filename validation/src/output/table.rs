//! Observables over time as CSV, one row a frame.

use super::{WriteError, write_whole};
use std::path::{Path, PathBuf};

/// A table whose columns may appear as the run goes on; the whole file is written anew with each row, so that it can be
/// read at any time.
pub struct TimeTable {
    path: PathBuf,
    columns: Vec<String>,
    rows: Vec<Vec<Option<f64>>>,
}

impl TimeTable {
    /// A table that will be written to `path`, with these columns first.
    pub fn new(path: &Path, columns: &[&str]) -> TimeTable {
        let columns = columns.iter().map(ToString::to_string).collect();
        TimeTable { path: path.to_path_buf(), columns, rows: Vec::new() }
    }

    /// Takes the columns and rows that an earlier part of the run has written.
    pub fn go_on(&mut self, columns: &[String], rows: &[Vec<Option<f64>>]) {
        (self.columns, self.rows) = (columns.to_vec(), rows.to_vec());
    }

    /// Columns and rows so far.
    pub fn contents(&self) -> (&[String], &[Vec<Option<f64>>]) {
        (&self.columns, &self.rows)
    }

    /// Adds a row of named values and writes the file. What a row does not name stays empty.
    ///
    /// # Errors
    /// [`WriteError`] if the system refuses; the file before it stays as it was.
    pub fn push(&mut self, values: impl IntoIterator<Item = (String, f64)>) -> Result<(), WriteError> {
        let mut row = vec![None; self.columns.len()];
        for (name, value) in values {
            let column = self.columns.iter().position(|column| *column == name).unwrap_or_else(|| {
                self.columns.push(name);
                row.push(None);
                row.len() - 1
            });
            row[column] = Some(value);
        }
        self.rows.push(row);
        write_whole(&self.path, &self.text())
    }

    /// Names of walls may hold commas, so that columns may need quotes.
    fn text(&self) -> Vec<u8> {
        const MEMORY: &str = "memory takes any number of bytes";
        let mut text = csv::Writer::from_writer(Vec::new());
        text.write_record(&self.columns).expect(MEMORY);
        for row in &self.rows {
            let cell = |column| row.get(column).copied().flatten().map_or(String::new(), |value| format!("{value:?}"));
            text.write_record((0..self.columns.len()).map(cell)).expect(MEMORY);
        }
        text.into_inner().expect(MEMORY)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn late_columns_leave_earlier_rows_empty() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("table.csv");
        let mut table = TimeTable::new(&path, &["time"]);
        table.push([("time".to_string(), 0.0)]).unwrap();
        table.push([("time".to_string(), 0.5), ("angle".to_string(), 31.0)]).unwrap();
        assert_eq!(std::fs::read_to_string(path).unwrap(), "time,angle\n0.0,\n0.5,31.0\n");
    }

    #[test]
    fn a_name_with_a_comma_is_one_column() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("table.csv");
        let mut table = TimeTable::new(&path, &["time"]);
        table.push([("time".to_string(), 0.0), ("lid, upper_rate".to_string(), 1.5)]).unwrap();
        assert_eq!(std::fs::read_to_string(path).unwrap(), "time,\"lid, upper_rate\"\n0.0,1.5\n");
    }
}
