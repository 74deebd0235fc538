//! The rows of all tables as CSV, one line a row, numbers at full precision.

use super::qualification::Qualification;
use crate::compare::{Row, Source};
use crate::output::cells::without_formulas;
use serde::Serialize;

/// A line of `rows.csv`; the names of its fields are the head of the file.
#[derive(Serialize)]
struct Line<'a> {
    scene: &'a str,
    /// "comparison", or "stiffness" for the bias of soft grains.
    table: &'static str,
    observable: &'a str,
    unit: &'a str,
    code: &'a str,
    source: Option<Source>,
    mean: Option<f64>,
    standard_deviation: Option<f64>,
    seeds: usize,
    reference_code: Option<&'a str>,
    difference: Option<f64>,
    interval90_low: Option<f64>,
    interval90_high: Option<f64>,
    verdict_low: Option<f64>,
    verdict_high: Option<f64>,
    margin: Option<f64>,
    outcome: Option<&'static str>,
    seeds_needed: Option<usize>,
    missing: Option<&'a str>,
}

/// All rows of a qualification as CSV.
pub(super) fn to_csv(qualification: &Qualification) -> Result<Vec<u8>, csv::Error> {
    let mut writer = csv::WriterBuilder::new().has_headers(false).from_writer(Vec::new());
    // Written by hand, so that a qualification without rows still has a head.
    writer.write_record([
        "scene",
        "table",
        "observable",
        "unit",
        "code",
        "source",
        "mean",
        "standard_deviation",
        "seeds",
        "reference_code",
        "difference",
        "interval90_low",
        "interval90_high",
        "verdict_low",
        "verdict_high",
        "margin",
        "outcome",
        "seeds_needed",
        "missing",
    ])?;
    for comparison in &qualification.comparisons {
        let source = |row: &Row| comparison.codes.iter().find(|code| code.code == row.code).map(|code| code.source);
        for row in &comparison.rows {
            writer.serialize(line("comparison", row, source(row)))?;
        }
        for row in &comparison.soft_bias {
            writer.serialize(line("stiffness", row, source(row)))?;
        }
    }
    let table = writer.into_inner().map_err(|error| csv::Error::from(error.into_error()))?;
    Ok(without_formulas(table))
}

fn line<'a>(table: &'static str, row: &'a Row, source: Option<Source>) -> Line<'a> {
    Line {
        scene: &row.scene,
        table,
        observable: &row.observable,
        unit: &row.unit,
        code: &row.code,
        source,
        mean: row.mean,
        standard_deviation: row.standard_deviation,
        seeds: row.seeds,
        reference_code: row.reference_code.as_deref(),
        difference: row.difference,
        interval90_low: row.interval90.map(|i| i[0]),
        interval90_high: row.interval90.map(|i| i[1]),
        verdict_low: row.interval_of_verdict.map(|i| i[0]),
        verdict_high: row.interval_of_verdict.map(|i| i[1]),
        margin: row.margin,
        outcome: row.outcome.map(super::words::outcome),
        seeds_needed: row.seeds_needed,
        missing: row.missing.as_deref(),
    }
}
