//! The table of a comparison as plain text for a terminal.

use super::tables::{ratio, rounding, time};
use makadam_compare::compare::{Comparison, Row, Source};
use makadam_measure::statistics::Outcome;
use makadam_view::draw::{columns, names};

/// A comparison as text, whose tables have at most 80 columns: for each observable the means of the codes, then their differences with the outcomes;
/// below, speed and notes. Outcomes are coloured if `colour` is set.
///
/// Columns are padded by characters, so it wants a terminal that knows UTF-8.
pub fn comparison_table(comparison: &Comparison, colour: bool) -> String {
    let mut text = format!("{}: {}\n", comparison.scene.name, comparison.scene.description);
    if comparison.rows.is_empty() {
        text.push_str("\nno rows\n");
    } else {
        text.push_str("mean ± spread (seeds); difference [interval of the verdict], outcome\n");
    }
    for rows in comparison.rows.chunk_by(|one, next| one.observable == next.observable) {
        text.push('\n');
        text.push_str(&block(comparison, rows, colour));
    }
    let speeds = comparison.codes.iter().filter_map(|code| {
        let ratio = ratio(comparison, code).map_or(String::new(), |ratio| format!(" ({ratio})"));
        let recorded = if code.source == Source::Recorded { ", recorded" } else { "" };
        Some(format!("{} {}{ratio}{recorded}", code.code, time(code)?))
    });
    let speeds: Vec<String> = speeds.collect();
    if !speeds.is_empty() {
        text.push_str(&format!("\ntime per simulated second: {}\n", speeds.join("; ")));
    }
    for note in &comparison.notes {
        text.push_str(&format!("note: {note}\n"));
    }
    text
}

/// The rows of one observable.
fn block(comparison: &Comparison, rows: &[Row], colour: bool) -> String {
    let rounding = rounding(rows.iter());
    let mut text = names::with_unit(&rows[0].observable, &rows[0].unit, rounding);
    if let Some(margin) = rows.iter().find_map(|row| row.margin) {
        text.push_str(&format!(", margin {}", rounding.margin(margin)));
    }
    text.push('\n');
    let mut lines: Vec<[String; 3]> = Vec::new();
    for (place, row) in rows.iter().enumerate() {
        if rows[..place].iter().any(|other| other.code == row.code) {
            continue;
        }
        let spread = row.standard_deviation.filter(|_| row.seeds > 1);
        let spread = spread.map_or(String::new(), |spread| format!(" ± {}", rounding.value(spread)));
        let mean = row.mean.map_or("–".into(), |mean| rounding.value(mean));
        lines.push([format!("  {}", row.code), format!("{mean}{spread} ({})", row.seeds), String::new()]);
    }
    for row in rows.iter().filter(|row| row.difference.is_some() || row.outcome.is_some()) {
        let reference = row.reference_code.as_ref().map_or(String::new(), |code| format!(" − {code}"));
        let interval = row.shown_interval().map(|interval| format!(" {}", rounding.interval(interval)));
        let difference = row.difference.map(|difference| rounding.signed(difference) + &interval.unwrap_or_default());
        let at_odds = row.code == comparison.judged && comparison.references_at_odds(row);
        let outcome = row.outcome.map(|outcome| match colour {
            true => format!("\x1b[{}m{}\x1b[0m", code_of(outcome), outcome_of(row, outcome, at_odds)),
            false => outcome_of(row, outcome, at_odds),
        });
        lines.push([format!("  {}{reference}", row.code), difference.unwrap_or_default(), outcome.unwrap_or_default()]);
    }
    text.push_str(&columns(&lines, |_| true));
    let mut reasons: Vec<&str> =
        rows.iter().filter(|row| row.outcome == Some(Outcome::NotMeasured)).map(reason).collect();
    reasons.dedup();
    for reason in reasons {
        text.push_str(&format!("  not measured: {reason}\n"));
    }
    text
}

/// Reason for which a row is not measured.
fn reason(row: &Row) -> &str {
    row.missing.as_deref().unwrap_or("a value is missing")
}

/// The outcome of a row in words; `at_odds`: the references differ by more than its margin.
fn outcome_of(row: &Row, outcome: Outcome, at_odds: bool) -> String {
    match (outcome, row.seeds_needed) {
        (Outcome::Undecided | Outcome::Exploratory, _) if at_odds => "undecided (references differ)".into(),
        (Outcome::Undecided, Some(seeds)) => format!("undecided, register {seeds} seeds"),
        (Outcome::Exploratory, _) => "exploratory: within the margin".into(),
        (outcome, _) => outcome.words().into(),
    }
}

/// Escape code of an outcome's colour: blue, red and yellow are told apart by colour-blind readers too.
fn code_of(outcome: Outcome) -> &'static str {
    match outcome {
        Outcome::Agree => "34",
        Outcome::Disagree => "31;1",
        Outcome::Undecided | Outcome::Exploratory | Outcome::NotMeasured => "33",
    }
}
