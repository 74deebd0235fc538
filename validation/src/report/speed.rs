//! Makadam's speed against each peer. A ratio is taken only between runs for timing of one qualification on one processor: runs side by
//! side share memory and caches, and the inputs of runs for measuring may slow a code down.

use super::qualification::join;
use super::{tables, words};
use crate::compare::{CodeSummary, Comparison, Source, Timing};
use crate::draw::numbers::{compact, duration, two_digits};
use crate::study::{Table, cells};

/// What stands in the place of a speed of runs that were not timed.
fn not_timed(timing: Timing) -> Option<&'static str> {
    match timing {
        Timing::SideBySide => Some("not timed: ran side by side"),
        Timing::Measuring => Some("not timed: ran for measuring"),
        Timing::Alone | Timing::Recorded => None,
    }
}

/// The time of a simulated second, or why there is none.
pub(super) fn time(code: &CodeSummary) -> String {
    not_timed(code.timing).map_or_else(|| duration(code.wall_seconds_per_simulated_second), String::from)
}

/// The runs that a speed is quoted from, one a code.
///
/// Runs for timing go before those for measuring, these before those side by side, and these before recorded ones. Of a peer that ran with several time
/// steps the fastest counts, so that no speed-up is taken over a needlessly slow peer.
fn timed(comparison: &Comparison) -> Vec<&CodeSummary> {
    let usable = |code: &&CodeSummary| {
        code.wall_seconds_per_simulated_second.is_finite() && code.wall_seconds_per_simulated_second > 0.0
    };
    let rank = |code: &CodeSummary| match code.timing {
        Timing::Alone => 0,
        Timing::Measuring => 1,
        Timing::SideBySide => 2,
        Timing::Recorded => 3,
    };
    let better = |a: &CodeSummary, b: &CodeSummary| {
        (rank(a), a.wall_seconds_per_simulated_second) < (rank(b), b.wall_seconds_per_simulated_second)
    };
    let mut best: Vec<&CodeSummary> = Vec::new();
    for code in comparison.codes.iter().filter(usable) {
        match best.iter_mut().find(|b| b.code == code.code) {
            Some(known) if better(code, known) => *known = code,
            Some(_) => {}
            None => best.push(code),
        }
    }
    best
}

/// How many times faster the first is; none unless both were timed here and now on one processor.
fn ratio(judged: &CodeSummary, peer: &CodeSummary) -> Option<f64> {
    let alone = |code: &CodeSummary| code.source == Source::Live && code.timing == Timing::Alone;
    let comparable = alone(judged) && alone(peer) && judged.processor == peer.processor && peer.code != judged.code;
    comparable.then(|| peer.wall_seconds_per_simulated_second / judged.wall_seconds_per_simulated_second)
}

/// The speeds of a scene in one sentence, such as "Makadam 0.9 s, LIGGGHTS 3.1 s, YADE 14 s a simulated second:
/// 3.4 and 16 times faster than LIGGGHTS and YADE."; none if nothing was run.
pub fn speed_sentence(comparison: &Comparison) -> Option<String> {
    let timed = timed(comparison);
    let times: Vec<String> = timed
        .iter()
        .filter(|code| not_timed(code.timing).is_none())
        .map(|code| match code.source {
            Source::Live => format!("{} {}", code.code, time(code)),
            Source::Recorded => format!("{} {} (recorded on {})", code.code, time(code), processor(code)),
        })
        .collect();
    let mut heads = Vec::new();
    if !times.is_empty() {
        heads.push(format!("{} a simulated second", times.join(", ")));
    }
    for timing in [Timing::SideBySide, Timing::Measuring] {
        let untimed: Vec<&str> =
            timed.iter().filter(|code| code.timing == timing).map(|code| code.code.as_str()).collect();
        heads.extend(
            not_timed(timing).filter(|_| !untimed.is_empty()).map(|words| format!("{} {words}", join(&untimed))),
        );
    }
    if heads.is_empty() {
        return None;
    }
    let head = heads.join("; ");
    let Some(judged) = timed.iter().find(|code| code.code == comparison.judged) else {
        return Some(format!("{head}."));
    };
    let ratios: Vec<(&str, f64)> =
        timed.iter().filter_map(|peer| ratio(judged, peer).map(|r| (peer.code.as_str(), r))).collect();
    if timed.len() == 1 {
        return Some(format!("{head}."));
    }
    if ratios.is_empty() {
        return Some(format!("{head}; no ratio is taken, since the codes were not timed in one run."));
    }
    let words = |part: &[&(&str, f64)], factor: fn(f64) -> f64, word: &str| {
        let values: Vec<String> = part.iter().map(|(_, r)| two_digits(factor(*r))).collect();
        let codes: Vec<&str> = part.iter().map(|(code, _)| *code).collect();
        format!("{} times {word} than {}", join(&values), join(&codes))
    };
    let (faster, slower): (Vec<_>, Vec<_>) = ratios.iter().partition(|(_, r)| *r >= 1.0);
    let mut parts = Vec::new();
    if !faster.is_empty() {
        parts.push(words(&faster, |r| r, "faster"));
    }
    if !slower.is_empty() {
        parts.push(words(&slower, |r| 1.0 / r, "slower"));
    }
    Some(format!("{head}: {} is {}.", judged.code, join(&parts)))
}

fn processor(code: &CodeSummary) -> &str {
    if code.processor.is_empty() { "an unnamed processor" } else { &code.processor }
}

/// The speeds of all scenes; nothing where nothing was timed.
pub(super) fn table(comparisons: &[Comparison]) -> Option<Table> {
    let numbers = ["time per simulated second", "over Makadam's"];
    let table = Table::new(&["scene", "code"], &numbers).with_words("setting").with_words("source");
    let mut table = table.of_class("wide");
    for comparison in comparisons {
        let timed = timed(comparison);
        let judged = timed.iter().copied().find(|code| code.code == comparison.judged);
        table.group(&comparison.scene.name, timed, |code| {
            let ratio =
                judged.and_then(|judged| ratio(judged, code)).map(|ratio| format!("{} times", two_digits(ratio)));
            let from = match code.source {
                Source::Live => code.provenance.as_str(),
                Source::Recorded => processor(code),
            };
            let colon = if from.is_empty() { "" } else { ": " };
            let source = format!("{}{colon}{from}", words::source(code.source));
            cells![tables::code(&code.code), time(code), ratio, setting(code), source]
        });
    }
    (!table.is_empty()).then_some(table)
}

/// The time step of a code, and what share of the Rayleigh step it is.
fn setting(code: &CodeSummary) -> String {
    let Some(step) = code.time_step else { return String::new() };
    let step = format!("step {} s", compact(step));
    match code.rayleigh_fraction {
        Some(fraction) => format!("{step}, {}% of the Rayleigh step", compact(100.0 * fraction)),
        None => step,
    }
}

/// Peers whose time step is below a fifth of the Rayleigh step in a run that a ratio was taken from.
pub(super) fn slow_settings(comparisons: &[Comparison]) -> Vec<String> {
    let mut found = Vec::new();
    for comparison in comparisons {
        let timed = timed(comparison);
        let Some(judged) = timed.iter().copied().find(|c| c.code == comparison.judged) else { continue };
        for peer in timed.iter().filter(|peer| ratio(judged, peer).is_some()) {
            if peer.rayleigh_fraction.is_some_and(|f| f < 0.199) && !found.contains(&peer.code) {
                found.push(peer.code.clone());
            }
        }
    }
    found
}
