//! Checksums of recorded references: a number that was changed by hand, or by a bad disk, is no reference any more.

use super::ReferenceError;
use crate::output::{WriteError, write_whole};
use makadam::checkpoint::checksum;
use std::collections::BTreeMap;
use std::io::ErrorKind;
use std::path::{Path, PathBuf};

/// The file that lists them.
const FILE: &str = "checksums.csv";

/// Head of that file.
const HEAD: &str = "file,fnv1a_64";

/// Checksum of a table, 16 hexadecimal digits; a system's way to end lines is left out.
fn of(bytes: &[u8]) -> String {
    let plain: Vec<u8> = bytes.iter().copied().filter(|byte| *byte != b'\r').collect();
    format!("{:016x}", checksum(&plain))
}

/// The tables in a folder, by name.
fn tables(folder: &Path) -> std::io::Result<BTreeMap<String, PathBuf>> {
    let mut tables = BTreeMap::new();
    for entry in std::fs::read_dir(folder)? {
        let path = entry?.path();
        let name = path.file_name().unwrap_or_default().to_string_lossy().into_owned();
        if name.ends_with(".csv") && name != FILE {
            tables.insert(name, path);
        }
    }
    Ok(tables)
}

/// Lists the tables of a folder with their checksums.
///
/// # Errors
/// [`WriteError`] if the system refuses.
pub(super) fn write(folder: &Path) -> Result<(), WriteError> {
    let mut text = format!("{HEAD}\n");
    for (name, path) in tables(folder).map_err(|error| WriteError::new(folder, error))? {
        let bytes = std::fs::read(&path).map_err(|error| WriteError::new(&path, error))?;
        text += &format!("{name},{}\n", of(&bytes));
    }
    write_whole(&folder.join(FILE), text.as_bytes())
}

/// Whether a folder has the list.
pub(super) fn are_in(folder: &Path) -> bool {
    folder.join(FILE).is_file()
}

/// Holds the tables of a folder against the list. Without a list nothing is held against anything: an earlier version wrote none.
///
/// # Errors
/// [`ReferenceError`] if a table has changed, is missing, or is not in the list, or the list is not one.
pub(super) fn check(folder: &Path) -> Result<(), ReferenceError> {
    let list = folder.join(FILE);
    let text = match std::fs::read_to_string(&list) {
        Ok(text) => text,
        Err(error) if error.kind() == ErrorKind::NotFound => return Ok(()),
        Err(source) => return Err(ReferenceError::Io { file: list, source }),
    };
    let refuse = |line: usize, problem: &str| {
        let (file, problem) = (list.clone(), problem.to_string());
        Err(ReferenceError::Line { file, line: line as u64 + 1, problem })
    };
    let mut unlisted = tables(folder).map_err(|source| ReferenceError::Io { file: folder.into(), source })?;
    for (number, line) in text.lines().enumerate() {
        match (number, line.split_once(',')) {
            (0, _) if line == HEAD => {}
            (0, _) => return refuse(0, "not a list of checksums"),
            (_, Some((name, expected))) if !name.contains(['/', '\\']) => {
                let file = unlisted.remove(name).unwrap_or_else(|| folder.join(name));
                match std::fs::read(&file) {
                    Err(source) => return Err(ReferenceError::Io { file, source }),
                    Ok(bytes) if of(&bytes) != expected => return Err(ReferenceError::Changed { file }),
                    Ok(_) => {}
                }
            }
            _ => return refuse(number, "not a file and its checksum"),
        }
    }
    match unlisted.into_values().next() {
        Some(file) => Err(ReferenceError::Changed { file }),
        None => Ok(()),
    }
}
