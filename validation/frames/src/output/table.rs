//! Observables over time as CSV, one row per frame.

use super::{WriteError, write_whole};
use makadam::checkpoint::{checksum, checksum_after, sync_file};
use rustix::fs::OFlags;
use serde::{Deserialize, Serialize};
use std::fs::{File, OpenOptions};
use std::io::{Error, ErrorKind};
use std::os::unix::fs::{FileExt, OpenOptionsExt};
use std::path::{Path, PathBuf};

const MEMORY: &str = "memory takes any number of bytes";

/// Table that grows by one row at a time and is readable at any time. Columns may appear during the run, which is rare: then the
/// whole file is rewritten, with empty cells in the earlier rows.
pub struct TimeTable {
    path: PathBuf,
    file: File,
    written: TableWritten,
}

/// Extent of a [`TimeTable`], for a checkpoint.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct TableWritten {
    /// Names of the columns.
    pub columns: Vec<String>,
    /// Number of rows below the names.
    pub rows: u64,
    /// Length of the file, bytes.
    pub length: u64,
    /// Checksum of the file.
    pub checksum: u64,
}

impl TimeTable {
    /// Creates a table without rows in `path`, with these columns first.
    pub fn create(path: &Path, columns: &[&str]) -> Result<TimeTable, WriteError> {
        let names = line(columns);
        write_whole(path, &names)?;
        let columns = columns.iter().map(ToString::to_string).collect();
        let written = TableWritten { columns, rows: 0, length: names.len() as u64, checksum: checksum(&names) };
        Ok(TimeTable { path: path.to_path_buf(), file: open_to_grow(path)?, written })
    }

    /// Resumes a table at a checkpoint; later rows are removed.
    ///
    /// # Errors
    /// [`WriteError`] if the system refuses, or the file differs from its state at the checkpoint.
    pub fn go_on(path: &Path, written: TableWritten) -> Result<TimeTable, WriteError> {
        let refused = |source| WriteError::new(path, source);
        let file = open_to_grow(path)?;
        let names = csv::Reader::from_reader(&file).headers().map_err(|error| refused(error.into()))?.clone();
        if !written.columns.iter().eq(names.iter().take(written.columns.len())) {
            return Err(does_not_fit(path, "its columns are others"));
        }
        let expected = written.clone();
        let mut table = TimeTable { path: path.to_path_buf(), file, written };
        if names.len() == table.written.columns.len() {
            let (length, least) = (table.file.metadata().map_err(refused)?.len(), table.written.length);
            if length < least {
                return Err(does_not_fit(path, &format!("it has {length} of {least} bytes")));
            }
            table.file.set_len(least).map_err(refused)?;
        } else {
            // The table has gained columns since.
            table.rewrite()?;
        }
        table.written.checksum = checksum(&std::fs::read(path).map_err(refused)?);
        if table.written != expected {
            return Err(does_not_fit(path, "its rows are others"));
        }
        Ok(table)
    }

    /// Returns the extent.
    pub fn written(&self) -> &TableWritten {
        &self.written
    }

    /// Adds a row of named values. Columns without a value stay empty.
    pub fn push(&mut self, values: impl IntoIterator<Item = (String, f64)>) -> Result<(), WriteError> {
        let known = self.written.columns.len();
        let mut row = vec![None; known];
        for (name, value) in values {
            let column = self.written.columns.iter().position(|column| *column == name).unwrap_or_else(|| {
                self.written.columns.push(name);
                row.push(None);
                row.len() - 1
            });
            row[column] = Some(value);
        }
        if row.len() > known {
            self.rewrite().inspect_err(|_| self.written.columns.truncate(known))?;
        }
        let cells = row.into_iter().map(|cell: Option<f64>| cell.map_or(String::new(), |value| format!("{value:?}")));
        let row = line(&cells.collect::<Vec<_>>());
        self.file.write_all_at(&row, self.written.length).map_err(|source| {
            // Rows that cannot be cut off here are cut off when the run resumes.
            let _ = self.file.set_len(self.written.length);
            WriteError::new(&self.path, source)
        })?;
        self.written.rows += 1;
        self.written.length += row.len() as u64;
        self.written.checksum = checksum_after(self.written.checksum, &row);
        Ok(())
    }

    /// Rewrites the file with the present columns and all rows, and empty cells for columns newer than a row.
    fn rewrite(&mut self) -> Result<(), WriteError> {
        let refused = |source| WriteError::new(&self.path, source);
        let TableWritten { columns, rows, .. } = &self.written;
        let old = std::fs::read(&self.path).map_err(refused)?;
        let mut new = line(columns);
        let mut counted = 0;
        for record in csv::Reader::from_reader(&old[..]).byte_records().take(*rows as usize) {
            let record = record.map_err(|error| refused(error.into()))?;
            let cells: Vec<&[u8]> = (0..columns.len()).map(|column| record.get(column).unwrap_or(b"")).collect();
            new.extend(line(&cells));
            counted += 1;
        }
        write_whole(&self.path, &new)?;
        self.file = open_to_grow(&self.path)?;
        (self.written.rows, self.written.length, self.written.checksum) = (counted, new.len() as u64, checksum(&new));
        Ok(())
    }

    /// Flushes the table to the disk.
    pub fn sync(&self) -> Result<(), WriteError> {
        sync_file(&self.path).map_err(|source| WriteError::new(&self.path, source))
    }
}

/// Formats cells as a line of CSV. Names of walls may contain commas, so columns may need quotes.
fn line<Cell: AsRef<[u8]>>(cells: &[Cell]) -> Vec<u8> {
    let mut text = csv::Writer::from_writer(Vec::new());
    text.write_record(cells).expect(MEMORY);
    text.into_inner().expect(MEMORY)
}

/// Opens a file for reading and writing; refuses a link, which may lead to a file of another owner.
pub(crate) fn open_to_grow(path: &Path) -> Result<File, WriteError> {
    let flags = OFlags::NOFOLLOW.bits() as i32;
    let opened = OpenOptions::new().read(true).write(true).custom_flags(flags).open(path);
    opened.map_err(|source| WriteError::new(path, source))
}

/// Makes an error for a file that prevents the resumption of a run.
fn does_not_fit(path: &Path, what: &str) -> WriteError {
    let text = format!("is not what the checkpoint beside it speaks of: {what}; --restart begins anew");
    WriteError::new(path, Error::new(ErrorKind::InvalidData, text))
}

#[cfg(test)]
#[path = "../../tests/unit/output_table.rs"]
mod tests;
