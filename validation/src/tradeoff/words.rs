//! Numbers as the table, the page and the sentences write them.

use super::rows::{Bound, Deviation};
use crate::draw::names::{observable, unit};
use crate::draw::numbers::{compact, two_digits};

/// A value to the second digit of its error; to four digits where the error is not known.
pub(super) fn measured(value: f64, error: Option<f64>) -> String {
    let scale = error.filter(|error| *error > 0.0).unwrap_or(1e-2 * value.abs());
    let decimals = (1.0 - scale.max(1e-12).log10().floor()).clamp(0.0, 8.0) as usize;
    let error = error.map_or(String::new(), |error| format!(" ± {error:.decimals$}"));
    format!("{value:.decimals$}{error}").replace('-', "−")
}

/// A deviation with its sign and its standard error.
pub(super) fn signed(value: f64, error: Option<f64>) -> String {
    let text = measured(value, error);
    if value > 0.0 { format!("+{text}") } else { text }
}

/// A deviation with its sign and its standard error; a reference's is zero by definition.
pub(super) fn deviation(deviation: &Deviation) -> String {
    match deviation.deviation == 0.0 && deviation.interval90.is_none() {
        true => "0".into(),
        false => signed(deviation.deviation, deviation.deviation_standard_error),
    }
}

/// A bound in words: "dynamic angle of repose within 0.5°".
pub(super) fn bound(bound: &Bound) -> String {
    let degrees = if bound.observable.contains("angle") { "°" } else { "" };
    format!("{} within {}{degrees}", observable(&bound.observable), compact(bound.value))
}

/// Young's modulus with its prefix.
pub(super) fn modulus(pascal: f64) -> String {
    match pascal {
        p if p >= 1e9 => format!("{} GPa", compact(1e-9 * p)),
        p => format!("{} MPa", compact(1e-6 * p)),
    }
}

/// An observable with its unit in brackets.
pub(super) fn titled(name: &str, of: &str) -> String {
    match unit(of) {
        "" => observable(name),
        "°" => format!("{} (degrees)", observable(name)),
        symbol => format!("{} ({symbol})", observable(name)),
    }
}

/// What a ratio of wall times would be with other seeds: "8.1 to 15".
pub(super) fn range(ends: [Option<f64>; 2]) -> String {
    match ends {
        [Some(low), Some(high)] => format!("{} to {}", two_digits(low), two_digits(high)),
        [Some(low), None] => format!("at least {}", two_digits(low)),
        [None, _] => String::new(),
    }
}

/// Whether the 90% intervals keep the bounds, in words.
pub(super) fn sureness(intervals: Option<bool>) -> &'static str {
    match intervals {
        Some(true) => "interval within too",
        Some(false) => "interval reaches beyond",
        None => "interval not known",
    }
}
