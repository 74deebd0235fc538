//! Published laws of granular matter, measured in Makadam and compared with the published value.
//!
//! ```text
//! Law ─> cases ─> Run (a case, a seed) ─> measure ─> Row ─> means over seeds ─> judge ─> Finding
//!                                         stored at once                     ─> figures, report
//! ```
//!
//! A law is one file with a constant `LAW`, and one entry of [`LAWS`]. Its inputs (sizes, friction, definitions) are constants of that
//! file, chosen before the first measurement (`validation/docs/laws.md` lists the exceptions). Only the open constants of a law are fitted.

mod beverloo;
mod campaign;
mod chute;
mod collapse;
mod janssen;
mod results;
#[cfg(test)]
#[path = "../../tests/unit/laws.rs"]
mod tests;

use crate::study::{Finding, RunError};
pub use campaign::{Case, Run, Values, row_of, run_cases, work};
use makadam_view::draw::figure::Figure;
use makadam_view::draw::plot::Plot;
pub use results::{LawResult, Mean, Row, Study, figure_and_bounds, runs};
use std::f64::consts::PI;

/// Mean diameter of the grains of all laws, m.
const DIAMETER: f64 = 0.01;

/// Half width of the radii's distribution over their mean, so that the grains form no crystal.
const SPREAD: f64 = 0.1;

/// Number of grains of a solid volume, m3.
fn grains_of(solid: f64) -> usize {
    (solid / (PI / 6.0 * DIAMETER.powi(3) * (1.0 + SPREAD * SPREAD))).round() as usize
}

/// A published law.
pub struct Law {
    /// Name on the command line.
    pub name: &'static str,
    /// Statement, with its formula.
    pub statement: &'static str,
    /// Publication.
    pub source: &'static str,
    /// Cases in the order of tables; fewer and smaller ones for a quick study.
    pub cases: fn(quick: bool) -> Vec<Case>,
    /// Simulates a case and measures it.
    measure: fn(&Case, &mut Run<'_>) -> Result<Values, RunError>,
    /// Figures with the bounds that the law sets; those without bounds are reported only.
    judge: fn(&[Mean]) -> Vec<Finding>,
    /// Measured values next to the law.
    figures: fn(&[Mean]) -> Vec<Figure>,
}

/// Returns a finished figure; the title begins its caption.
fn figure(name: &str, plot: Plot, title: &str, caption: &str) -> Figure {
    Figure { name: name.into(), svg: plot.finish(title), caption: format!("{title}: {caption}") }
}

/// All laws, in the order of listings.
pub static LAWS: [Law; 4] = [janssen::LAW, beverloo::LAW, collapse::LAW, chute::LAW];
