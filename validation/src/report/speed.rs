//! Makadam's speed against each peer. A ratio is taken only between runs of one qualification on one processor.

use super::names;
use super::numbers::{duration, two_digits};
use super::qualification::{JUDGED, join};
use crate::compare::{CodeSummary, Comparison, Source};
use serde::Serialize;

/// The speeds of one scene, ready for the page.
#[derive(Serialize)]
pub(super) struct SpeedLine {
    scene: String,
    codes: Vec<SpeedCell>,
}

#[derive(Serialize)]
struct SpeedCell {
    code: String,
    class: &'static str,
    time: String,
    source: &'static str,
    ratio: Option<String>,
    setting: String,
    from: String,
}

/// The runs that a speed is quoted from, one a code, at the scene's own stiffness.
///
/// Live runs go before recorded ones. Of a peer that ran with several time steps the fastest counts, so that no
/// speed-up is taken over a needlessly slow peer; of Makadam's runs those that were timed as a peer was.
fn timed(comparison: &Comparison) -> Vec<&CodeSummary> {
    let usable = |code: &&CodeSummary| {
        code.stiffness_factor == 1.0
            && code.wall_seconds_per_simulated_second.is_finite()
            && code.wall_seconds_per_simulated_second > 0.0
    };
    let faster = |a: &CodeSummary, b: &CodeSummary| {
        let rank = |code: &CodeSummary| (code.source == Source::Recorded, code.wall_seconds_per_simulated_second);
        rank(a) < rank(b)
    };
    let mut best: Vec<&CodeSummary> = Vec::new();
    for code in comparison.codes.iter().filter(usable) {
        match best.iter_mut().find(|b| b.code == code.code) {
            Some(known) if faster(code, known) => *known = code,
            Some(_) => {}
            None => best.push(code),
        }
    }
    let ways: Vec<&str> = best
        .iter()
        .filter(|code| code.code != JUDGED && code.source == Source::Live)
        .map(|code| code.provenance.as_str())
        .collect();
    let alike =
        comparison.codes.iter().filter(usable).find(|code| {
            code.code == JUDGED && code.source == Source::Live && ways.contains(&code.provenance.as_str())
        });
    if let (Some(alike), Some(judged)) = (alike, best.iter_mut().find(|code| code.code == JUDGED)) {
        *judged = alike;
    }
    best
}

/// How many times faster the first is; none unless both were run here and now on one processor.
fn ratio(judged: &CodeSummary, peer: &CodeSummary) -> Option<f64> {
    let comparable = judged.source == Source::Live
        && peer.source == Source::Live
        && judged.processor == peer.processor
        && peer.code != judged.code;
    comparable.then(|| peer.wall_seconds_per_simulated_second / judged.wall_seconds_per_simulated_second)
}

/// The speeds of a scene in one sentence, such as "Makadam 0.9 s, LIGGGHTS 3.1 s, YADE 14 s a simulated second:
/// 3.4 and 16 times faster than LIGGGHTS and YADE."; none if nothing was timed.
pub fn speed_sentence(comparison: &Comparison) -> Option<String> {
    let timed = timed(comparison);
    if timed.is_empty() {
        return None;
    }
    let times: Vec<String> = timed
        .iter()
        .map(|code| {
            let time = duration(code.wall_seconds_per_simulated_second);
            match code.source {
                Source::Live => format!("{} {time}", code.code),
                Source::Recorded => format!("{} {time} (recorded on {})", code.code, processor(code)),
            }
        })
        .collect();
    let head = format!("{} a simulated second", times.join(", "));
    let Some(judged) = timed.iter().find(|code| code.code == JUDGED) else { return Some(format!("{head}.")) };
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
    Some(format!("{head}: {JUDGED} is {}.", join(&parts)))
}

fn processor(code: &CodeSummary) -> &str {
    if code.processor.is_empty() { "an unnamed processor" } else { &code.processor }
}

/// The speeds of a scene for the table; none if nothing was timed.
pub(super) fn line(comparison: &Comparison) -> Option<SpeedLine> {
    let timed = timed(comparison);
    let judged = timed.iter().copied().find(|code| code.code == JUDGED);
    let codes: Vec<SpeedCell> = timed
        .iter()
        .map(|code| SpeedCell {
            code: code.code.clone(),
            class: names::code_style(&code.code).class,
            time: duration(code.wall_seconds_per_simulated_second),
            source: names::source(code.source),
            ratio: judged.and_then(|judged| ratio(judged, code)).map(two_digits),
            setting: setting(code),
            from: match code.source {
                Source::Live => code.provenance.clone(),
                Source::Recorded => processor(code).into(),
            },
        })
        .collect();
    (!codes.is_empty()).then(|| SpeedLine { scene: comparison.scene.name.clone(), codes })
}

/// The time step of a code, and what share of the Rayleigh step it is.
pub(super) fn setting(code: &CodeSummary) -> String {
    let step = format!("step {} s", super::numbers::compact(code.time_step));
    match code.rayleigh_fraction {
        Some(fraction) => format!("{step}, {}% of the Rayleigh step", super::numbers::compact(100.0 * fraction)),
        None => step,
    }
}

/// Peers whose time step is below a fifth of the Rayleigh step in a run that a ratio was taken from.
pub(super) fn slow_settings(comparisons: &[Comparison]) -> Vec<String> {
    let mut found = Vec::new();
    for comparison in comparisons {
        let timed = timed(comparison);
        let Some(judged) = timed.iter().copied().find(|c| c.code == JUDGED) else { continue };
        for peer in timed.iter().filter(|peer| ratio(judged, peer).is_some()) {
            if peer.rayleigh_fraction.is_some_and(|f| f < 0.199) && !found.contains(&peer.code) {
                found.push(peer.code.clone());
            }
        }
    }
    found
}
