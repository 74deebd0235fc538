//! Frames that any code has left, read by what their files say of themselves.
//!
//! ```text
//! file ─> dump, text, VTK ─> FrameTable: named columns ─> assemble, with the scene ─> Recording, as of a run
//! ```
//!
//! What a file does not tell is not made up: the [`Recording`](crate::recording::Recording) says what its frames lack, and what would need that is not measured.

mod assemble;
mod columns;
mod completeness;
mod contact_series;
mod contacts;
mod dump;
mod frame_table;
mod numbering;
mod numbers;
mod plausible;
mod sequence;
mod text;
mod timing;
mod vtk;

pub use assemble::{Assembly, Imported};
pub use columns::{Column, column_of};
pub use contacts::merge_wall_contacts;
pub(crate) use contacts::{contact_from_force, measurable};
pub use dump::{DumpFault, DumpFrame, read_dump, read_named_dump};
pub use frame_table::{FrameTable, ImportError};
pub(crate) use plausible::unlike;

use crate::output::HDF5;
use crate::run_frames::RunFrames;
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

/// Columns of a dump of contacts between grains as LIGGGHTS's `compute pair/gran/local id force contactPoint` has them.
const PAIR_DUMP: [&str; 9] = ["first", "second", "periodic", "fx", "fy", "fz", "px", "py", "pz"];

/// Columns of a dump of contacts with meshes as LIGGGHTS's `compute wall/gran/local pos id force` has them.
const WALL_DUMP: [&str; 12] = ["px", "py", "pz", "cx", "cy", "cz", "wall", "triangle", "first", "fx", "fy", "fz"];

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
    /// Adds the frames of a file of grains, or those of the folder of a run of Makadam, with their contacts. `columns` name the columns
    /// anew, if given.
    ///
    /// # Errors
    /// [`ImportError`] with file and line.
    pub fn add_grains(&mut self, path: &Path, columns: &[String]) -> Result<(), ImportError> {
        once(&mut self.files[0], path)?;
        if !path.is_dir() {
            self.grains.extend(renamed(read(path)?, columns)?);
            return Ok(());
        }
        let fault = |problem: String| ImportError::new(path, 1, problem);
        let run = RunFrames::open(path).map_err(|error| fault(error.to_string()))?;
        let timed = |files: &[(f64, PathBuf)]| -> Result<Vec<FrameTable>, ImportError> {
            let mut frames = Vec::new();
            for (time, file) in files {
                frames.extend(read(file)?.into_iter().map(|frame| FrameTable { time: Some(*time), ..frame }));
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
    pub fn add_contacts(&mut self, path: &Path, columns: &[String]) -> Result<(), ImportError> {
        once(&mut self.files[1], path)?;
        self.contacts.extend(renamed(read(path)?, columns)?);
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
fn read(path: &Path) -> Result<Vec<FrameTable>, ImportError> {
    let bytes = std::fs::read(path).map_err(|error| ImportError::new(path, 1, error.to_string()))?;
    parse(path, bytes)
}

/// The frames in the bytes of a file, of whatever format they show themselves to be; any bytes are either frames or an error.
///
/// # Errors
/// [`ImportError`] with file and line.
pub fn parse(path: &Path, bytes: Vec<u8>) -> Result<Vec<FrameTable>, ImportError> {
    let begins = |mark: &str| bytes.starts_with(mark.as_bytes());
    let mut frames = if bytes.is_empty() {
        return Err(ImportError::new(path, 1, "the file is empty"));
    } else if begins("ITEM:") {
        is_whole(path, &bytes)?;
        dumped(path, &bytes)?
    } else if bytes.starts_with(&HDF5) {
        vtk::hdf(path, bytes)?
    } else if begins("<?xml") || begins("<VTKFile") {
        vtk::xml(path, &bytes)?
    } else if begins("# vtk DataFile") {
        text::legacy_vtk(path, &bytes)?
    } else if begins("#format ") {
        is_whole(path, &bytes)?;
        text::yade(path, &bytes)?
    } else {
        is_whole(path, &bytes)?;
        text::csv(path, &bytes)?
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

fn dumped(path: &Path, bytes: &[u8]) -> Result<Vec<FrameTable>, ImportError> {
    let frames = read_named_dump(bytes).map_err(|fault| ImportError::new(path, fault.line, fault.problem))?;
    let table = |frame: DumpFrame| {
        let (line, time, step) = (frame.line, frame.time, Some(frame.step));
        let known: Option<&[&str]> = match frame.names.len() {
            9 => Some(&PAIR_DUMP),
            12 => Some(&WALL_DUMP),
            _ => None,
        };
        // Local computes have no names of their own: c_pairs[1] and so on.
        let nameless = frame.names.iter().all(|name| name.contains('['));
        let columns = match known.filter(|_| nameless) {
            Some(names) => names.iter().map(ToString::to_string).collect(),
            None => frame.names.clone(),
        };
        FrameTable {
            file: path.into(),
            line,
            time,
            step,
            columns,
            values: frame.into_values(),
            driven_walls: Vec::new(),
        }
    };
    Ok(frames.into_iter().map(table).collect())
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

/// Two columns that tell the same, the second of which would be passed over.
fn told_twice(columns: &[String]) -> Option<[&str; 2]> {
    let meaning = |name: &String| match column_of(name)? {
        Column::Diameter => Some(Column::Radius),
        other => Some(other),
    };
    let meanings: Vec<Option<Column>> = columns.iter().map(meaning).collect();
    (0..columns.len()).find_map(|place| {
        let first = meanings[..place].iter().position(|known| known.is_some() && *known == meanings[place])?;
        Some([&*columns[first], &*columns[place]])
    })
}

/// The same frames with other names of the columns, if there are some.
///
/// # Errors
/// [`ImportError`] where the files have more or fewer columns, or two that tell the same: the second would be passed over.
fn renamed(frames: Vec<FrameTable>, columns: &[String]) -> Result<Vec<FrameTable>, ImportError> {
    let each_once = |frame: FrameTable| match told_twice(&frame.columns) {
        None => Ok(frame),
        Some([one, other]) => {
            let is_one_name = one.trim().eq_ignore_ascii_case(other.trim());
            let named =
                if is_one_name { format!("are named {other}") } else { format!("tell the same, {one} and {other}") };
            let problem = format!("two columns {named}; name each once, those that are not wanted with _");
            Err(ImportError::new(&frame.file, frame.line.saturating_sub(1).max(1), problem))
        }
    };
    if columns.is_empty() {
        return frames.into_iter().map(each_once).collect();
    }
    let rename = |frame: FrameTable| match frame.columns.len() == columns.len() {
        true => each_once(FrameTable { columns: columns.to_vec(), ..frame }),
        false => {
            let problem = format!(
                "its rows have {} numbers, and {} columns are named; name each, those that are not wanted with _",
                frame.columns.len(),
                columns.len()
            );
            Err(frame.fault(0, problem))
        }
    };
    frames.into_iter().map(rename).collect()
}

#[cfg(test)]
mod tests;
