//! Published laws of granular matter in a report: figures that were measured, beside what experiments found.

use crate::draw::numbers;
use crate::study::{Cell, Table, cells};
use minijinja::{Value, context};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// A law and what was measured of it.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct PublishedLaw {
    /// Its name.
    pub name: String,
    /// What it says.
    pub statement: String,
    /// Where it was published.
    pub source: String,
    /// Runs behind the figures.
    pub runs: usize,
    /// Their wall time, s.
    pub wall_seconds: f64,
    /// Version of Makadam that ran them.
    pub version: String,
    /// Figures that the law sets bounds for.
    pub judged: Vec<Judged>,
    /// Drawings with their captions; only the page has them.
    #[serde(skip)]
    pub figures: Vec<(String, String)>,
    /// Rows of the runs that they draw the means of, as CSV; only the file beside the page has them.
    #[serde(skip)]
    pub rows: String,
}

impl PublishedLaw {
    /// Name of the file of its rows.
    pub(super) fn file(&self) -> String {
        format!("law-{}.csv", self.name)
    }
}

/// A figure and its bounds.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Judged {
    /// What was measured.
    pub what: String,
    /// Its unit; empty for a number.
    pub unit: String,
    /// The figure.
    pub value: f64,
    /// Least right value, where there is one.
    pub low: Option<f64>,
    /// Largest right value, where there is one.
    pub high: Option<f64>,
    /// Whether it keeps its bounds.
    pub holds: bool,
}

/// The figures of all laws and their bounds.
pub(super) fn table(laws: &[PublishedLaw]) -> Table {
    let table = Table::new(&["law", "measured"], &["value", "bounds"]).styled("results").with_words("");
    let mut table = table;
    for law in laws {
        table.group(&law.name, &law.judged, |judged| {
            let bounds = numbers::bounds([judged.low, judged.high], number);
            let value = format!("{} {}", number(judged.value), judged.unit);
            let outcome = if judged.holds { ("agree", "within") } else { ("disagree", "outside") };
            cells![&judged.what, value.trim_end(), bounds, Cell::from("").outcome(Some(outcome))]
        });
    }
    table
}

/// What the template shows of a law beside its figures.
pub(super) fn shown(law: &PublishedLaw) -> Value {
    let figures = law.figures.iter().map(|(svg, caption)| context! { svg => svg, caption => caption });
    let data = (!law.rows.is_empty()).then(|| law.file());
    context! { law => law, data => data, wall_time => numbers::duration(law.wall_seconds), figures => figures.collect::<Vec<_>>() }
}

/// Three decimals; a typographic minus.
fn number(value: f64) -> String {
    format!("{value:.3}").replace('-', "−")
}
