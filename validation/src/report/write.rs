//! The files of a report: rendered whole in memory, then written together.

use super::qualification::{Qualification, Verdict};
use super::{page, rows};
use crate::study::{DocumentError, write_together};
use serde::{Deserialize, Serialize};
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

/// Writes `report.html`, `report.json` and `rows.csv` into a folder, which is made if it is not there.
///
/// All three are complete on disk under temporary names before the first is renamed, so an earlier report stays
/// whole if this one fails.
///
/// # Errors
/// [`DocumentError`] if a file cannot be written.
pub fn write(qualification: &Qualification, folder: &Path) -> Result<ReportPaths, DocumentError> {
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
    let files = [
        ("report.html".to_string(), page::render(qualification)?.into_bytes()),
        ("report.json".to_string(), serde_json::to_vec(&document)?),
        rows::table(qualification).csv("rows")?,
    ];
    write_together(folder, &files)?;
    Ok(paths)
}
