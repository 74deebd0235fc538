//! Frames that exist: a folder for each seed, read as what a code has left.

use super::{DescriptionError, External, read_description};
use crate::import::{Manifest, Tables};
use crate::peers::CodeError;
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

impl External {
    /// Frames in folders that `patterns` name, one folder a seed, whose number ends the folder's name. `file` describes the code; its
    /// command is not run. Without it a folder is that of a run of Makadam, or each of its files holds grains.
    ///
    /// # Errors
    /// [`DescriptionError`].
    pub fn of_frames(file: Option<&Path>, patterns: &[String]) -> Result<External, DescriptionError> {
        let mut folders = BTreeMap::new();
        for pattern in patterns {
            let fault = |problem: String| DescriptionError { file: pattern.into(), problem };
            let found = glob::glob(pattern).map_err(|error| fault(format!("is no pattern of folders: {error}")))?;
            let found: Vec<PathBuf> = found.flatten().filter(|path| path.is_dir()).collect();
            if found.is_empty() {
                return Err(fault("there is no such folder; give one folder for each seed, such as 'seed*/'".into()));
            }
            for folder in found {
                let fault = |problem: String| DescriptionError { file: folder.clone(), problem };
                let seed = seed_of(&folder).ok_or_else(|| {
                    fault("the name of a folder ends with the number of its seed, such as seed1".into())
                })?;
                let other = folders.insert(seed, folder.clone()).filter(|other| *other != folder);
                if let Some(other) = other {
                    return Err(fault(format!(
                        "{} is of seed {seed} too; give one folder for each seed",
                        other.display()
                    )));
                }
            }
        }
        let (description, here) = match file {
            Some(file) => read_description(file)?,
            None => (Manifest { grains: vec!["*".into()], ..Manifest::default() }, PathBuf::new()),
        };
        Ok(External::new(description, here, Some(folders)))
    }

    /// Tables of the frames in a folder.
    pub(super) fn tables_in(&self, folder: &Path) -> Result<Tables, CodeError> {
        let mut tables = Tables::default();
        let files = |pattern: &str| {
            let whole = Path::new(&glob::Pattern::escape(&folder.display().to_string())).join(pattern);
            let found = glob::glob(&whole.display().to_string()).into_iter().flatten().flatten();
            let mut files: Vec<PathBuf> = found.filter(|path| path.is_file()).collect();
            files.sort();
            match files.is_empty() {
                true => Err(self.output(folder, 1, format!("there is no file {pattern}"))),
                false => Ok(files),
            }
        };
        self.fill(&mut tables, files)?;
        Ok(tables)
    }
}

/// The number that ends the name of a folder.
fn seed_of(folder: &Path) -> Option<u64> {
    let name = folder.file_name()?.to_str()?;
    let digits = name.len() - name.trim_end_matches(|letter: char| letter.is_ascii_digit()).len();
    name[name.len() - digits..].parse().ok()
}
