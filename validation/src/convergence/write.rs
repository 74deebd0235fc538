//! The files of a study: curves as CSV, all of it as JSON, figures as SVG, one page to read.

use super::figures::figures;
use super::page;
use super::study::{Curve, Study};
use crate::draw::svg::standalone;
use crate::output::cells::csv;
use crate::output::{create_folder, write_whole};
use crate::report::ReportError;
use makadam::ConvergencePoint;
use serde::Serialize;
use std::path::{Path, PathBuf};

/// A method after some iterations, as a row of `convergence.csv`. Residuals are in units of g h, or in m/s where there is no
/// gravity.
#[derive(Serialize)]
struct Row {
    method: &'static str,
    iteration: u32,
    seconds: f64,
    normal_rms: f64,
    normal_max: f64,
    tangential_u_rms: f64,
    tangential_u_max: f64,
    tangential_v_rms: f64,
    tangential_v_max: f64,
    turning_rms: f64,
    turning_max: f64,
}

impl Row {
    fn of(curve: &Curve, point: &ConvergencePoint) -> Row {
        let residuals = &point.residuals;
        Row {
            method: curve.method.name(),
            iteration: point.iterations,
            seconds: point.seconds,
            normal_rms: residuals.normal.rms,
            normal_max: residuals.normal.max,
            tangential_u_rms: residuals.tangential_u.rms,
            tangential_u_max: residuals.tangential_u.max,
            tangential_v_rms: residuals.tangential_v.rms,
            tangential_v_max: residuals.tangential_v.max,
            turning_rms: residuals.turning.rms,
            turning_max: residuals.turning.max,
        }
    }
}

/// Writes all files of a study into a folder, which is made if it is not there; returns the page's path.
///
/// # Errors
/// [`ReportError`] if a file cannot be written.
pub fn write(study: &Study, folder: &Path) -> Result<PathBuf, ReportError> {
    write_tables(study, folder)?;
    write_whole(&folder.join("convergence.json"), &serde_json::to_vec_pretty(study)?)?;
    let figures = figures(study);
    for figure in &figures {
        write_whole(&folder.join(format!("{}.svg", figure.name)), standalone(&figure.svg).as_bytes())?;
    }
    let html = folder.join("convergence.html");
    write_whole(&html, page::render(study, &figures)?.as_bytes())?;
    Ok(html)
}

/// Writes `convergence.csv` into a folder, and where it came from as `provenance.json`.
///
/// # Errors
/// [`ReportError`] if a file cannot be written.
pub fn write_tables(study: &Study, folder: &Path) -> Result<(), ReportError> {
    create_folder(folder)?;
    let rows = study.methods.iter().flat_map(|curve| curve.points.iter().map(|point| Row::of(curve, point)));
    write_whole(&folder.join("convergence.csv"), &csv(&rows.collect::<Vec<_>>())?)?;
    write_whole(&folder.join("provenance.json"), &serde_json::to_vec_pretty(&study.provenance)?)?;
    Ok(())
}
