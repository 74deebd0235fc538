//! A study as plain text for a terminal.

use super::{LawResult, Study};
use crate::draw::columns;
use crate::draw::numbers::bounds;
use crate::study::Finding;

/// Each law with its figures and bounds.
pub(crate) fn table(study: &Study) -> String {
    study.laws.iter().map(law).collect::<Vec<_>>().join("\n\n")
}

fn law(result: &LawResult) -> String {
    let verdict = if result.holds { "within tolerance" } else { "outside tolerance" };
    let runs = result.rows.len();
    let seconds: f64 = result.rows.iter().map(|row| row.wall_seconds).sum();
    let head = format!("{}: {verdict}\n{}\n{}\n", result.name, result.statement, result.source);
    let rows: Vec<[String; 4]> = result.findings.iter().map(row).collect();
    format!("{head}\n{}\n{runs} runs, {seconds:.0} s of wall time", columns(&rows, |column| column != 1))
}

/// A figure with its unit, and its bounds.
pub(crate) fn in_words(finding: &Finding) -> [String; 2] {
    let value = format!("{} {}", number(finding.value), finding.unit);
    [value.trim().into(), bounds(finding.bounds(), number)]
}

fn row(finding: &Finding) -> [String; 4] {
    let verdict = match (finding.bounds(), finding.holds()) {
        ([None, None], _) => "",
        (_, true) => "within",
        (_, false) => "OUTSIDE",
    };
    let [value, bounds] = in_words(finding);
    [finding.what.clone(), value, bounds, verdict.to_string()]
}

/// Four digits.
fn number(value: f64) -> String {
    let size = value.abs();
    match size == 0.0 || (1e-2..1e4).contains(&size) {
        true => format!(
            "{value:.*}",
            if size >= 100.0 {
                1
            } else if size >= 10.0 {
                2
            } else {
                3
            }
        ),
        false => format!("{value:.3e}"),
    }
}
