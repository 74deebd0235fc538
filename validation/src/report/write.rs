//! The files of a report: rendered whole in memory, written under temporary names, renamed when all are complete.

use super::qualification::{Qualification, Verdict};
use super::{page, rows};
use serde::{Deserialize, Serialize};
use std::io::{ErrorKind, Write as _};
use std::path::{Path, PathBuf};

/// Version of the layout of `report.json`; raised whenever a field changes its name or meaning.
pub const REPORT_VERSION: u32 = 1;

/// What `report.json` holds.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct ReportDocument {
    /// [`REPORT_VERSION`] at the time of writing.
    pub version: u32,
    /// The verdict.
    pub verdict: Verdict,
    /// All that it follows from.
    pub qualification: Qualification,
}

/// Where a report was written.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ReportPaths {
    /// The page to read.
    pub html: PathBuf,
    /// The same as data; a [`ReportDocument`].
    pub json: PathBuf,
    /// The rows of all tables.
    pub csv: PathBuf,
}

/// Why a report was not written. No file of the report is left half-written.
#[derive(Debug, thiserror::Error)]
pub enum ReportError {
    /// The system refused.
    #[error("cannot write {}: {source}; {}", path.display(), remedy(source))]
    Io {
        /// File or folder.
        path: PathBuf,
        /// What the system said.
        source: std::io::Error,
    },
    /// A file of a study was not written.
    #[error(transparent)]
    Write(#[from] crate::output::WriteError),
    /// The page's template does not fit its data.
    #[error("cannot render the report: {0:#}; this is a fault of the program")]
    Template(#[from] minijinja::Error),
    /// The data cannot be written as JSON.
    #[error("cannot write the report as JSON: {0}; this is a fault of the program")]
    Json(#[from] serde_json::Error),
    /// The rows cannot be written as CSV.
    #[error("cannot write the rows as CSV: {0}; this is a fault of the program")]
    Csv(#[from] csv::Error),
}

fn remedy(source: &std::io::Error) -> &'static str {
    match source.kind() {
        ErrorKind::StorageFull | ErrorKind::QuotaExceeded => {
            "the disk is full: free some room, or choose another folder"
        }
        ErrorKind::PermissionDenied | ErrorKind::ReadOnlyFilesystem => "choose a folder that you may write to",
        ErrorKind::NotADirectory | ErrorKind::AlreadyExists => {
            "a file stands where a folder is needed: choose another folder"
        }
        _ => "check that the folder exists and the disk has room",
    }
}

/// Writes `report.html`, `report.json` and `rows.csv` into a folder, which is made if it is not there.
///
/// All three are complete on disk under temporary names before the first is renamed, so an earlier report stays
/// whole if this one fails.
///
/// # Errors
/// [`ReportError`] if a file cannot be written.
pub fn write(qualification: &Qualification, folder: &Path) -> Result<ReportPaths, ReportError> {
    let document = ReportDocument {
        version: REPORT_VERSION,
        verdict: qualification.verdict(),
        qualification: qualification.clone(),
    };
    let paths = ReportPaths {
        html: folder.join("report.html"),
        json: folder.join("report.json"),
        csv: folder.join("rows.csv"),
    };
    let contents = [
        (&paths.html, page::render(qualification)?.into_bytes()),
        (&paths.json, serde_json::to_vec(&document)?),
        (&paths.csv, rows::to_csv(qualification)?),
    ];

    std::fs::create_dir_all(folder).map_err(|source| ReportError::Io { path: folder.to_path_buf(), source })?;
    let drafts: Vec<PathBuf> = contents.iter().map(|(path, _)| draft_of(path)).collect();
    let written = contents.iter().zip(&drafts).try_for_each(|((path, bytes), draft)| {
        write_and_sync(draft, bytes).map_err(|source| ReportError::Io { path: path.to_path_buf(), source })
    });
    let renamed = written.and_then(|()| {
        contents.iter().zip(&drafts).try_for_each(|((path, _), draft)| {
            std::fs::rename(draft, path).map_err(|source| ReportError::Io { path: path.to_path_buf(), source })
        })
    });
    if renamed.is_err() {
        for draft in &drafts {
            // The first error is the one to report; a draft that cannot be removed was never a report.
            let _ = std::fs::remove_file(draft);
        }
    }
    renamed.map(|()| paths)
}

/// A temporary name beside a file, so that the rename stays within one file system.
fn draft_of(path: &Path) -> PathBuf {
    let mut name = path.as_os_str().to_owned();
    name.push(format!(".{}.part", std::process::id()));
    PathBuf::from(name)
}

fn write_and_sync(path: &Path, bytes: &[u8]) -> std::io::Result<()> {
    let mut file = std::fs::File::create(path)?;
    file.write_all(bytes)?;
    // Without this a full disk may show only after the rename.
    file.sync_all()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_full_disk_is_named() {
        let error =
            ReportError::Io { path: "out/report.html".into(), source: std::io::Error::from(ErrorKind::StorageFull) };
        assert!(error.to_string().contains("out/report.html"), "{error}");
        assert!(error.to_string().contains("the disk is full"), "{error}");
    }
}
