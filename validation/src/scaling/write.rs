//! The files of a study: tables as CSV, all of it as JSON, figures as SVG, one page to read.

use super::figures::figures;
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
    write_tables(study, folder)?;
    put(&folder.join("scaling.json"), &serde_json::to_vec_pretty(study)?)?;
    let figures = figures(study);
    for figure in figures.iter().flatten() {
        put(&folder.join(format!("{}.svg", figure.name)), standalone(&figure.svg).as_bytes())?;
    }
    let html = folder.join("scaling.html");
    put(&html, page::render(study, &figures)?.as_bytes())?;
    Ok(html)
}

/// Writes `measured.csv`, `replayed.csv` and `tasks.csv` into a folder, and where they came from as `provenance.json`.
///
/// # Errors
/// [`ReportError`] if a file cannot be written.
pub fn write_tables(study: &Study, folder: &Path) -> Result<(), ReportError> {
    create_folder(folder)?;
    put(&folder.join("measured.csv"), &csv(&study.measured)?)?;
    put(&folder.join("replayed.csv"), &csv(&study.replayed)?)?;
    put(&folder.join("checks.csv"), &csv(&study.checks)?)?;
    put(&folder.join("tasks.csv"), &csv(&study.tasks)?)?;
    put(&folder.join("provenance.json"), &serde_json::to_vec_pretty(&study.provenance)?)
}

fn put(path: &Path, bytes: &[u8]) -> Result<(), ReportError> {
    Ok(write_whole(path, bytes)?)
}
