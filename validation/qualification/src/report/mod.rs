//! The report of a qualification: one self-contained page to read, and the same as data.
//!
//! ```text
//! Qualification ─> verdict ─┐
//! Comparison ─> tables      ├─> page ──> report.html
//!            ─> figures     │   ──────> report.json, tests.json, rows.csv, junit.xml
//!            ─> pictures    │   ──────> series.csv, forces.csv, grains.csv
//! StudySection ─> table     ┘   ──────> the files of each study
//! ```
//!
//! The page loads nothing, runs no script, follows light and dark, and prints. Its tables and figures compute no verdict of their own.

mod baseline;
mod data;
mod figures;
mod junit;
mod page;
mod pictures;
mod qualification;
mod tables;
mod terminal;

pub use baseline::{Changes, Test, TestVerdict, tests};
pub use data::schema;
pub use qualification::{Qualification, Standing, StudyCount, StudyOutcome, StudySection, StudyTest, Verdict};
pub use terminal::comparison_table;

use makadam_compare::study::{DocumentError, write_together};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::path::{Path, PathBuf};

/// Version of the layout of `report.json`; raised whenever a field changes its name or meaning, or goes.
pub const REPORT_VERSION: u32 = 2;

/// Content of `report.json`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct ReportDocument {
    /// [`REPORT_VERSION`] at the time of writing.
    pub version: u32,
    /// The verdict.
    pub verdict: Verdict,
    /// All that it follows from.
    pub qualification: Qualification,
}

/// Writes `report.html`, `report.json`, `tests.json`, `rows.csv`, `junit.xml`, the CSV files that the figures link to and the files
/// of studies into a folder, which is made if it is missing, and returns the path of the page.
///
/// All of them are complete on disk under temporary names before the first is renamed: an earlier report stays whole if this one fails.
///
/// # Errors
/// [`DocumentError`] if a file cannot be written.
pub fn write(qualification: &Qualification, folder: &Path) -> Result<PathBuf, DocumentError> {
    let document = ReportDocument {
        version: REPORT_VERSION,
        verdict: qualification.verdict(),
        qualification: qualification.clone(),
    };
    let mut files = vec![
        ("report.html".to_string(), page::render(qualification)?.into_bytes()),
        ("report.json".to_string(), serde_json::to_vec(&document)?),
        ("tests.json".to_string(), baseline::document(qualification)?.into_bytes()),
        ("junit.xml".to_string(), junit::document(qualification)?.into_bytes()),
    ];
    files.extend(data::files(qualification)?);
    files.extend(qualification.studies.iter().flat_map(|study| study.files.clone()));
    write_together(folder, &files)?;
    Ok(folder.join("report.html"))
}
