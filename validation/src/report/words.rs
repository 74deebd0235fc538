//! Words and style classes of outcomes and sources, and the digits of rows.

use crate::compare::{Row, Source};
use crate::draw::numbers::Rounding;
use crate::statistics::Outcome;

/// Word of an outcome.
pub(super) fn outcome(outcome: Outcome) -> &'static str {
    match outcome {
        Outcome::Agree => "agree",
        Outcome::Disagree => "disagree",
        Outcome::Undecided => "undecided",
        Outcome::Exploratory => "exploratory",
        Outcome::NotMeasured => "not measured",
    }
}

/// Style class of an outcome.
pub(super) fn outcome_class(outcome: Outcome) -> &'static str {
    match outcome {
        Outcome::NotMeasured | Outcome::Exploratory => "undecided",
        other => self::outcome(other),
    }
}

/// Word of a source.
pub(super) fn source(source: Source) -> &'static str {
    match source {
        Source::Live => "live",
        Source::Recorded => "recorded",
    }
}

/// Rounding of the rows of one observable, by their margins, spreads and means.
pub(super) fn rounding<'a>(rows: impl Iterator<Item = &'a Row> + Clone) -> Rounding {
    let largest = |value: fn(&Row) -> f64| {
        rows.clone().map(value).filter(|v| v.is_finite()).fold(0.0, |a: f64, b| a.max(b.abs()))
    };
    let margin = largest(|row| row.margin.unwrap_or(0.0));
    let spread = largest(|row| row.standard_deviation.filter(|_| row.seeds > 1).unwrap_or(0.0));
    Rounding::seeing(margin, spread, largest(|row| row.mean.unwrap_or(0.0)))
}
