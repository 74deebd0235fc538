//! The table of a comparison as plain text for a terminal.

use super::speed::speed_sentence;
use super::{tables, words};
use crate::compare::{Comparison, Row};
use crate::draw::names;
use crate::draw::numbers::Rounding;
use crate::statistics::Outcome;

const HEAD: [&str; 7] =
    ["observable", "code", "mean ± spread (seeds)", "against", "difference [90% interval]", "margin", "outcome"];

/// The rows of a comparison as aligned text, with the speed below; outcomes are coloured if `colour` is set.
///
/// Columns are padded by characters, so it wants a terminal that knows UTF-8.
pub fn comparison_table(comparison: &Comparison, colour: bool) -> String {
    let mut lines: Vec<([String; 7], Option<Outcome>)> = Vec::new();
    let mut last = "";
    for row in &comparison.rows {
        let rounding = words::rounding(comparison.rows.iter().filter(|other| other.observable == row.observable));
        let first = row.observable != last;
        lines.push((cells(row, rounding, first), row.outcome));
        last = &row.observable;
    }
    let mut widths = HEAD.map(|text| text.chars().count());
    for (cells, _) in &lines {
        for (width, cell) in widths.iter_mut().zip(cells) {
            *width = (*width).max(cell.chars().count());
        }
    }
    let mut text = format!("{}: {}\n\n", comparison.scene.name, comparison.scene.description);
    text.push_str(&padded(&HEAD.map(String::from), &widths, None, colour));
    text.push_str(&widths.map(|width| "─".repeat(width)).join("  "));
    text.push('\n');
    for (cells, outcome) in &lines {
        text.push_str(&padded(cells, &widths, *outcome, colour));
    }
    if lines.is_empty() {
        text.push_str("no rows\n");
    }
    if let Some(speed) = speed_sentence(comparison) {
        text.push_str(&format!("\n{speed}\n"));
    }
    for limit in tables::limits(comparison).iter().chain(&comparison.notes) {
        text.push_str(&format!("note: {limit}\n"));
    }
    text
}

fn cells(row: &Row, rounding: Rounding, first: bool) -> [String; 7] {
    let spread = row.standard_deviation.filter(|_| row.seeds > 1);
    let spread = spread.map_or(String::new(), |spread| format!(" ± {}", rounding.value(spread)));
    let mean = row.mean.map_or("–".into(), |mean| rounding.value(mean));
    let interval = row.interval90.map(|interval| format!(" {}", rounding.interval(interval))).unwrap_or_default();
    let outcome = match (row.outcome, row.seeds_needed) {
        (Some(Outcome::Undecided), Some(seeds)) => format!("undecided, {seeds} seeds would decide"),
        (Some(Outcome::NotMeasured), _) => {
            format!("not measured: {}", row.missing.as_deref().unwrap_or("a value is missing"))
        }
        (Some(outcome), _) => words::outcome(outcome).into(),
        (None, _) => String::new(),
    };
    [
        if first { names::with_unit(&row.observable, &row.unit, rounding) } else { String::new() },
        row.code.clone(),
        format!("{mean}{spread} ({})", row.seeds),
        row.reference_code.clone().unwrap_or_default(),
        row.difference.map(|difference| rounding.signed(difference) + &interval).unwrap_or_default(),
        row.margin.map(|margin| rounding.margin(margin)).unwrap_or_default(),
        outcome,
    ]
}

/// One line; words to the left, numbers to the right.
fn padded(cells: &[String; 7], widths: &[usize; 7], outcome: Option<Outcome>, colour: bool) -> String {
    let mut line = String::new();
    for (column, (cell, &width)) in cells.iter().zip(widths).enumerate() {
        let gap = " ".repeat(width - cell.chars().count());
        let last = column + 1 == cells.len();
        match column {
            2 | 4 | 5 => line.push_str(&format!("{gap}{cell}")),
            6 if colour && outcome.is_some() => line.push_str(&format!("\x1b[{}m{cell}\x1b[0m", code_of(outcome))),
            _ if last => line.push_str(cell),
            _ => line.push_str(&format!("{cell}{gap}")),
        }
        if !last {
            line.push_str("  ");
        }
    }
    format!("{}\n", line.trim_end())
}

/// Escape code of an outcome's colour: blue, red and yellow are told apart by colour-blind readers too.
fn code_of(outcome: Option<Outcome>) -> &'static str {
    match outcome {
        Some(Outcome::Agree) => "34",
        Some(Outcome::Disagree) => "31;1",
        Some(Outcome::Undecided | Outcome::NotMeasured) => "33",
        None => "0",
    }
}
