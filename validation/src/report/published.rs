//! Published laws of granular matter in a report: figures that were measured, beside what experiments found.

use crate::draw::numbers;
use minijinja::{Value, context};
use serde::{Deserialize, Serialize};

/// A law and what was measured of it.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
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
}

/// A figure and its bounds.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
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

/// What the template shows of a law.
pub(super) fn shown(law: &PublishedLaw) -> Value {
    let lines = law.judged.iter().map(|judged| {
        context! {
            what => judged.what,
            value => number(judged.value),
            unit => judged.unit,
            bounds => numbers::bounds([judged.low, judged.high], number),
            holds => judged.holds,
        }
    });
    let figures = law.figures.iter().map(|(svg, caption)| context! { svg => svg, caption => caption });
    context! {
        name => law.name,
        statement => law.statement,
        source => law.source,
        runs => law.runs,
        wall_time => numbers::duration(law.wall_seconds),
        version => law.version,
        lines => lines.collect::<Vec<_>>(),
        figures => figures.collect::<Vec<_>>(),
    }
}

/// Three decimals; a typographic minus.
fn number(value: f64) -> String {
    format!("{value:.3}").replace('-', "−")
}
