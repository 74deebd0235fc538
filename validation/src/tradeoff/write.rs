//! The files of a trade-off: tables as CSV, all of it as JSON, figures as SVG, one page to read.

use super::figures::figures;
use super::flat::{ReferenceRow, point_rows};
use super::page;
use super::study::Study;
use crate::draw::svg::standalone;
use crate::output::cells::csv;
use crate::output::{create_folder, write_whole};
use crate::report::ReportError;
use std::path::{Path, PathBuf};

/// Writes all files of a study into a folder, which is made if it is not there; returns the page's path.
///
/// # Errors
/// [`ReportError`] if a file cannot be written.
pub fn write(study: &Study, folder: &Path) -> Result<PathBuf, ReportError> {
    create_folder(folder)?;
    let put = |name: &str, bytes: &[u8]| write_whole(&folder.join(name), bytes);
    let points: Vec<_> = study.points.iter().flat_map(point_rows).collect();
    let references: Vec<_> = study.references.iter().map(ReferenceRow::of).collect();
    put("points.csv", &csv(&points)?)?;
    put("references.csv", &csv(&references)?)?;
    put("fastest.csv", &csv(&study.fastest)?)?;
    put("provenance.json", &serde_json::to_vec_pretty(&study.provenance)?)?;
    put("tradeoff.json", &serde_json::to_vec_pretty(study)?)?;
    let figures = figures(study);
    for figure in &figures {
        put(&format!("{}.svg", figure.name), standalone(&figure.svg).as_bytes())?;
    }
    put("tradeoff.html", page::render(study, &figures)?.as_bytes())?;
    Ok(folder.join("tradeoff.html"))
}
