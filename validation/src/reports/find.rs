//! Where the reports below a folder are.

use std::path::{Path, PathBuf};

/// Folders below the given one in which reports are looked for, one in the other.
pub const DEEPEST: usize = 8;

/// Name of the data of a report.
const NAME: &str = "report.json";

/// What lies below a folder.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Found {
    /// Every `report.json`, by path.
    pub reports: Vec<PathBuf>,
    /// Folders that were not looked into, with the reason.
    pub unseen: Vec<(PathBuf, String)>,
}

/// Why nothing was looked for.
#[derive(Debug, thiserror::Error)]
#[error("cannot read the folder {}: {source}; give the folder that holds the reports", folder.display())]
pub struct FindError {
    /// The folder.
    folder: PathBuf,
    /// What the system said.
    source: std::io::Error,
}

/// Finds every report below a folder, no deeper than [`DEEPEST`] folders; links to folders are not followed, since they may lead in circles.
///
/// # Errors
/// [`FindError`] if the folder itself cannot be read.
pub fn find(folder: &Path) -> Result<Found, FindError> {
    let mut found = Found::default();
    look_into(folder, DEEPEST, &mut found).map_err(|source| FindError { folder: folder.to_path_buf(), source })?;
    found.reports.sort();
    found.unseen.sort();
    Ok(found)
}

fn look_into(folder: &Path, deeper: usize, found: &mut Found) -> std::io::Result<()> {
    for entry in std::fs::read_dir(folder)? {
        let entry = entry?;
        let path = entry.path();
        if entry.file_name() == NAME {
            found.reports.push(path);
        } else if entry.file_type()?.is_dir() {
            match deeper {
                0 => found.unseen.push((path, format!("it lies more than {DEEPEST} folders deep"))),
                _ => {
                    if let Err(error) = look_into(&path, deeper - 1, found) {
                        found.unseen.push((path, error.to_string()));
                    }
                }
            }
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::fs;

    #[test]
    fn reports_are_found_and_what_lies_too_deep_is_told() {
        let folder = tempfile::tempdir().unwrap();
        let deep: PathBuf = (0..DEEPEST).map(|level| format!("level-{level}")).collect();
        let deeper = deep.join("one-more");
        fs::create_dir_all(folder.path().join(&deeper)).unwrap();
        for place in [Path::new(""), &deep, &deeper] {
            fs::write(folder.path().join(place).join(NAME), "{}").unwrap();
        }
        let found = find(folder.path()).unwrap();
        assert_eq!(found.reports, [deep.join(NAME), NAME.into()].map(|path| folder.path().join(path)));
        assert_eq!(found.unseen.len(), 1);
        assert_eq!(found.unseen[0].0, folder.path().join(deeper));
        let missing = find(&folder.path().join("none")).unwrap_err();
        assert!(missing.to_string().contains("give the folder that holds the reports"), "{missing}");
    }
}
