//! The table of a comparison as plain text for a terminal.

use super::speed::speed_sentence;
use super::{tables, words};
use crate::compare::{Comparison, Row};
use crate::draw::names;
use crate::draw::numbers::Rounding;
use crate::statistics::Outcome;
use crate::study::{Cell, Table, cells};

/// The rows of a comparison as aligned text, with the speed below; outcomes are coloured if `colour` is set.
///
/// Columns are padded by characters, so it wants a terminal that knows UTF-8.
pub fn comparison_table(comparison: &Comparison, colour: bool) -> String {
    let mut last = "";
    let mut table = Table::new(&["observable", "code"], &["mean ± spread (seeds)"])
        .with_words("against")
        .with_numbers(["difference [interval of the verdict]", "margin"])
        .with_words("outcome");
    for row in &comparison.rows {
        let rounding = words::rounding(comparison.rows.iter().filter(|other| other.observable == row.observable));
        let at_odds = row.code == comparison.judged && comparison.references_at_odds(row);
        table.row(cells(row, at_odds, rounding, row.observable != last, colour));
        last = &row.observable;
    }
    let mut text = format!("{}: {}\n\n{}", comparison.scene.name, comparison.scene.description, table.text());
    if table.is_empty() {
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

/// The cells of a row; `at_odds`: whether the references differ by more than its margin.
fn cells(row: &Row, at_odds: bool, rounding: Rounding, first: bool, colour: bool) -> Vec<Cell> {
    let spread = row.standard_deviation.filter(|_| row.seeds > 1);
    let spread = spread.map_or(String::new(), |spread| format!(" ± {}", rounding.value(spread)));
    let mean = row.mean.map_or("–".into(), |mean| rounding.value(mean));
    let interval = row.shown_interval().map(|interval| format!(" {}", rounding.interval(interval))).unwrap_or_default();
    let outcome = match (row.outcome, row.seeds_needed) {
        (Some(Outcome::Undecided | Outcome::Exploratory), _) if at_odds => {
            "undecided: the references differ by more".into()
        }
        (Some(Outcome::Undecided), Some(seeds)) => format!("undecided, register {seeds} seeds"),
        (Some(Outcome::NotMeasured), _) => {
            format!("not measured: {}", row.missing.as_deref().unwrap_or("a value is missing"))
        }
        (Some(Outcome::Exploratory), _) => "exploratory: within the margin".into(),
        (Some(outcome), _) => words::outcome(outcome).into(),
        (None, _) => String::new(),
    };
    cells![
        if first { names::with_unit(&row.observable, &row.unit, rounding) } else { String::new() },
        &row.code,
        format!("{mean}{spread} ({})", row.seeds),
        row.reference_code.as_deref().unwrap_or_default(),
        row.difference.map(|difference| rounding.signed(difference) + &interval).unwrap_or_default(),
        row.margin.map(|margin| rounding.margin(margin)).unwrap_or_default(),
        match row.outcome.filter(|_| colour) {
            Some(known) => format!("\x1b[{}m{outcome}\x1b[0m", code_of(known)),
            None => outcome,
        },
    ]
}

/// Escape code of an outcome's colour: blue, red and yellow are told apart by colour-blind readers too.
fn code_of(outcome: Outcome) -> &'static str {
    match outcome {
        Outcome::Agree => "34",
        Outcome::Disagree => "31;1",
        Outcome::Undecided | Outcome::Exploratory | Outcome::NotMeasured => "33",
    }
}
