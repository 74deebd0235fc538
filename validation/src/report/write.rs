//! The files of a report: rendered whole in memory, then written together.

use super::qualification::{Qualification, Verdict};
use super::{badge, drawn, junit, page, rows};
use crate::study::{DocumentError, write_together};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::path::{Path, PathBuf};

/// Version of the layout of `report.json`; raised whenever a field changes its name or meaning.
pub const REPORT_VERSION: u32 = 1;

/// What `report.json` holds.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
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

/// Writes `report.html`, `report.json`, `rows.csv`, `junit.xml`, `badge.svg` and the CSV files that the figures link to into a folder, which
/// is made if it is not there.
///
/// All of them are complete on disk under temporary names before the first is renamed, so an earlier report stays
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
    let mut files = vec![
        ("report.html".to_string(), page::render(qualification)?.into_bytes()),
        ("report.json".to_string(), serde_json::to_vec(&document)?),
        rows::table(qualification).csv("rows")?,
        ("junit.xml".to_string(), junit::document(qualification)?.into_bytes()),
        ("badge.svg".to_string(), badge::svg(qualification).into_bytes()),
    ];
    files.extend(drawn::files(qualification)?);
    write_together(folder, &files)?;
    Ok(paths)
}

/// Reads the `report.json` of an earlier report.
///
/// # Errors
/// What is wrong with the file, in words.
pub fn read(file: &Path) -> Result<Qualification, String> {
    let fault = |problem: String| format!("{}: {problem}; give the report.json of a report", file.display());
    let bytes = std::fs::read(file).map_err(|error| fault(error.to_string()))?;
    let document: ReportDocument = serde_json::from_slice(&bytes).map_err(|error| fault(error.to_string()))?;
    match document.version == REPORT_VERSION {
        true => Ok(document.qualification),
        false => Err(fault(format!("its version is {}, not {REPORT_VERSION}", document.version))),
    }
}
