//! Frames that any code has left, read by what their files say of themselves and what the caller states.
//!
//! ```text
//! file ─> dump, text, VTK ─> FrameTable: columns with a meaning ─> assemble, with the scene and what is stated ─> Recording, as of a run
//! ```
//!
//! A column is taken by its name, as the file or the caller gives it, never by its place. What neither states is not made up: it is refused
//! with the option to add, or the [`Recording`](crate::recording::Recording) says that its frames lack it, and what would need it is not
//! measured.

mod arrays;
mod assemble;
mod columns;
mod completeness;
mod contact_series;
mod contacts;
mod dump;
mod format;
mod frame_table;
mod identity;
mod legacy_vtk;
mod manifest;
mod numbering;
mod plausible;
mod sequence;
mod stated;
mod text;
mod timing;
mod vtk;
mod vtkhdf;

pub use assemble::{Assembly, Imported};
pub use columns::{Column, column_of};
pub use contacts::merge_wall_contacts;
pub(crate) use contacts::{contact_from_force, measurable};
pub use dump::{DumpFault, DumpFrame, read_dump};
pub use frame_table::{FrameTable, ImportError, Periods};
pub use identity::check_kinds;
pub use manifest::Manifest;
pub(crate) use plausible::unlike;
pub use stated::{Stated, StatedColumns};

use crate::run_frames::RunFrames;
use format::{Format, format_of, unpacked};
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

/// Grains and contacts as tables, as files hold them.
#[derive(Clone, Debug, Default)]
pub struct Tables {
    /// Frames of grains.
    pub grains: Vec<FrameTable>,
    /// Frames of contacts.
    pub contacts: Vec<FrameTable>,
    /// What a reader must know of the runs that they are from, in sentences.
    pub notes: Vec<String>,
    /// Runs of Makadam that they are from.
    pub runs: Vec<RunFrames>,
    /// Files of grains and of contacts that were added: where they really lie, and as what they were given.
    pub files: [BTreeMap<PathBuf, PathBuf>; 2],
}

impl Tables {
    /// Adds the frames of a file of grains, or those of the folder of a run of Makadam, with their contacts. `columns` name the columns of a
    /// file, where they are stated.
    ///
    /// # Errors
    /// [`ImportError`] with file and line.
    pub fn add_grains(&mut self, path: &Path, columns: &StatedColumns) -> Result<(), ImportError> {
        once(&mut self.files[0], path)?;
        if !path.is_dir() {
            self.grains.extend(read(path, columns)?);
            return Ok(());
        }
        let fault = |problem: String| ImportError::new(path, 1, problem);
        let run = RunFrames::open(path).map_err(|error| fault(error.to_string()))?;
        let timed = |files: &[(f64, PathBuf)]| -> Result<Vec<FrameTable>, ImportError> {
            let mut frames = Vec::new();
            for (time, file) in files {
                let own = read(file, &StatedColumns::default())?.into_iter();
                // A run numbers grains as its scene does, from 0.
                frames.extend(own.map(|frame| FrameTable { time: Some(*time), first_id: Some(0), ..frame }));
            }
            Ok(frames)
        };
        self.grains.extend(timed(run.files("grains"))?);
        self.contacts.extend(timed(run.files("contacts"))?);
        self.notes.extend(run.alarms().map(String::from));
        self.runs.push(run);
        Ok(())
    }

    /// Adds the frames of a file of contacts.
    ///
    /// # Errors
    /// [`ImportError`] with file and line.
    pub fn add_contacts(&mut self, path: &Path, columns: &StatedColumns) -> Result<(), ImportError> {
        once(&mut self.files[1], path)?;
        self.contacts.extend(read(path, columns)?);
        Ok(())
    }
}

/// Refuses a file that has been read, by this name or another one: its frames would count twice.
fn once(known: &mut BTreeMap<PathBuf, PathBuf>, path: &Path) -> Result<(), ImportError> {
    let real = path.canonicalize().unwrap_or_else(|_| path.to_path_buf());
    let Some(earlier) = known.insert(real, path.into()) else { return Ok(()) };
    let also = if earlier == path { String::new() } else { format!(", also as {}", earlier.display()) };
    Err(ImportError::new(path, 1, format!("the file is given twice{also}; name each file once")))
}

/// The frames of a file.
fn read(path: &Path, columns: &StatedColumns) -> Result<Vec<FrameTable>, ImportError> {
    let bytes = std::fs::read(path).map_err(|error| ImportError::new(path, 1, error.to_string()))?;
    parse(path, bytes, columns)
}

/// The frames in the bytes of a file, of whatever format they show themselves to be; any bytes are either frames or an error. `columns` name
/// the columns, where they are stated.
///
/// # Errors
/// [`ImportError`] with file and line.
pub fn parse(path: &Path, bytes: Vec<u8>, columns: &StatedColumns) -> Result<Vec<FrameTable>, ImportError> {
    let bytes = unpacked(path, bytes)?;
    let mut frames = match format_of(path, &bytes)? {
        Format::Dump => {
            is_whole(path, &bytes)?;
            dump::read_named_dump(path, &bytes, columns)?
        }
        Format::Hdf => vtkhdf::hdf(path, bytes, columns)?,
        Format::Xml => vtk::xml(path, &bytes, columns)?,
        Format::LegacyVtk => {
            if !legacy_vtk::is_binary(&bytes) {
                is_whole(path, &bytes)?;
            }
            legacy_vtk::legacy_vtk(path, &bytes, columns)?
        }
        Format::Yade => {
            is_whole(path, &bytes)?;
            text::yade(path, &bytes, columns)?
        }
        Format::Csv => {
            is_whole(path, &bytes)?;
            text::csv(path, &bytes, columns)?
        }
    };
    if let [single] = &mut frames[..]
        && single.step.is_none()
    {
        single.step = number_in(path);
    }
    Ok(frames)
}

/// Refuses rows that may be cut off in the middle of a number. What is no text at all is refused where it is read.
fn is_whole(path: &Path, bytes: &[u8]) -> Result<(), ImportError> {
    if bytes.ends_with(b"\n") || bytes.ends_with(b"\r") || bytes.contains(&0) {
        return Ok(());
    }
    let line = bytes.split(|byte| *byte == b'\n').count();
    let problem = "the last row has no line end: the file may be cut off in the middle of a number; write it anew, or end it with a \
                   line end";
    Err(ImportError::new(path, line, problem))
}

/// The last number in the name of a file, before its extension: codes number their files by time steps.
fn number_in(path: &Path) -> Option<u64> {
    let stem = path.file_stem()?.to_str()?;
    let end = stem.rfind(|letter: char| letter.is_ascii_digit())? + 1;
    let start = stem[..end]
        .rfind(|letter: char| !letter.is_ascii_digit())
        .map_or(0, |place| place + stem[place..].chars().next().map_or(1, char::len_utf8));
    stem[start..end].parse().ok()
}

#[cfg(test)]
mod tests;
