//! The rows of all tables as CSV, one line a row, numbers at full precision.

use super::qualification::Qualification;
use super::words::outcome;
use crate::compare::{Comparison, Row};
use crate::study::{Cell, Table, cells};

/// All rows of a qualification.
pub(super) fn table(qualification: &Qualification) -> Table {
    let mut table = Table::named(
        "scene observable unit code source mean standard_deviation seeds reference_code difference interval90_low \
         interval90_high verdict_low verdict_high margin outcome seeds_needed missing",
    );
    for comparison in &qualification.comparisons {
        comparison.rows.iter().for_each(|row| table.row(line(comparison, row)));
    }
    table
}

fn line(comparison: &Comparison, row: &Row) -> Vec<Cell> {
    let code = comparison.codes.iter().find(|code| code.code == row.code);
    let [low, high] = [0, 1].map(|end| row.interval90.map(|interval| interval[end]));
    let [verdict_low, verdict_high] = [0, 1].map(|end| row.interval_of_verdict.map(|interval| interval[end]));
    cells![
        &row.scene,
        &row.observable,
        &row.unit,
        &row.code,
        code.map(|code| super::words::source(code.source)),
        row.mean,
        row.standard_deviation,
        row.seeds,
        row.reference_code.as_deref(),
        row.difference,
        low,
        high,
        verdict_low,
        verdict_high,
        row.margin,
        row.outcome.map(outcome),
        row.seeds_needed,
        row.missing.as_deref(),
    ]
}
