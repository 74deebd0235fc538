//! An observable over time: all codes in one plot, the measured window marked, the means drawn in.

use crate::compare::Comparison;
use crate::draw::names;
use crate::draw::numbers::Rounding;
use crate::draw::plot::{Axis, Key, Plot};
use crate::observables::{Series, intruder};

/// A figure and what it says.
pub(super) struct SeriesFigure {
    /// The observable.
    pub(super) observable: String,
    /// The plot.
    pub(super) svg: String,
    /// What to see.
    pub(super) caption: String,
}

/// Points beyond this number are thinned: they would fall on the same pixels.
const MOST_POINTS: usize = 600;

/// What a figure shows of one run.
pub(super) struct Curve<'a> {
    /// The run's code, seed and observable.
    pub(super) series: &'a Series,
    /// Times, s, and values, thinned where there are many.
    pub(super) points: Vec<[f64; 2]>,
    /// The mean over the measured window, at the window's beginning and end, s.
    pub(super) mean: Option<[[f64; 2]; 2]>,
}

/// What is shown of an observable: a curve a run.
pub(super) fn curves<'a>(comparison: &'a Comparison, observable: &str) -> Vec<Curve<'a>> {
    let all = comparison.series.iter().filter(|s| s.observable == observable && !s.time.is_empty());
    let points = |series: &'a Series| series.time.iter().copied().zip(series.value.iter().copied());
    let end = all.clone().flat_map(points).map(|(t, _)| t).filter(|t| t.is_finite()).fold(0.0, f64::max);
    all.map(|series| {
        let stride = series.time.len().div_ceil(MOST_POINTS);
        let mean = comparison.scene.measure.from.and_then(|from| {
            let window = points(series).filter(|&(t, v)| t >= from && v.is_finite()).map(|(_, v)| v);
            let window: Vec<f64> = window.collect();
            let mean = window.iter().sum::<f64>() / window.len() as f64;
            (!window.is_empty()).then_some([[from, mean], [end, mean]])
        });
        Curve { series, points: points(series).step_by(stride).map(|(t, v)| [t, v]).collect(), mean }
    })
    .collect()
}

/// The observables that there is a figure of.
pub(super) fn observables(comparison: &Comparison) -> Vec<&str> {
    let mut observables: Vec<&str> = Vec::new();
    for series in &comparison.series {
        if !observables.contains(&series.observable.as_str()) && !series.time.is_empty() {
            observables.push(&series.observable);
        }
    }
    observables
}

/// One figure an observable that was followed over time.
pub(super) fn figures(comparison: &Comparison) -> Vec<SeriesFigure> {
    observables(comparison).into_iter().filter_map(|observable| figure(comparison, observable)).collect()
}

fn figure(comparison: &Comparison, observable: &str) -> Option<SeriesFigure> {
    let all = curves(comparison, observable);
    let points = || all.iter().flat_map(|c| c.series.time.iter().copied().zip(c.series.value.iter().copied()));
    let end = points().map(|(t, _)| t).filter(|t| t.is_finite()).fold(0.0, f64::max);
    let from = comparison.scene.measure.from;
    // The start-up of a flow may lie far away and would flatten what is measured: the range is the window's. An intruder's way is shown whole.
    let is_steady = observable != intruder::HEIGHT_NAME;
    let shown_from = from.filter(|_| is_steady).unwrap_or(0.0);
    let (low, high) = points()
        .filter(|&(t, v)| v.is_finite() && t >= shown_from)
        .fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), (_, v)| (low.min(v), high.max(v)));
    if !(low.is_finite() && high.is_finite() && end > 0.0) {
        return None;
    }
    let margin = comparison.rows.iter().filter(|r| r.observable == observable).find_map(|r| r.margin);
    let room = (0.25 * (high - low)).max(margin.unwrap_or(0.0)).max(1e-3 * high.abs());
    let unit = comparison.rows.iter().find(|r| r.observable == observable).map_or("", |r| r.unit.as_str());
    let mut codes: Vec<&str> = Vec::new();
    for Curve { series, .. } in &all {
        if !codes.contains(&series.code.as_str()) {
            codes.push(&series.code);
        }
    }
    let mut plot = Plot::with_legend(
        Axis::linear("time (s)", 0.0, end),
        Axis::linear(&names::with_unit(observable, unit, Rounding::Decimals(0)), low - room, high + room),
        &codes.iter().map(|code| Key::Code(code)).collect::<Vec<_>>(),
    );
    if let Some(from) = from {
        plot.window(from, end, "measured window");
    }
    for Curve { series, points, .. } in &all {
        let style = names::code_style(&series.code);
        plot.curve(&format!("{} curve thin", style.class), points.iter().copied());
    }
    // Means last, so that they lie on top of the curves.
    for Curve { series, mean, .. } in &all {
        let Some([[from, mean], [end, _]]) = *mean else { continue };
        let style = names::code_style(&series.code);
        plot.curve(&format!("{} curve strong", style.class), [[from, mean], [end, mean]].into_iter());
        let place = codes.iter().position(|&c| c == series.code).unwrap_or(0) as f64;
        plot.marker(style, from + (end - from) * (0.15 + 0.2 * place), mean, 4.5);
    }
    let name = names::observable(observable);
    let seeds: Vec<String> = {
        let mut seeds: Vec<u64> = all.iter().map(|c| c.series.seed).collect();
        seeds.sort_unstable();
        seeds.dedup();
        seeds.iter().map(u64::to_string).collect()
    };
    let window = match from {
        Some(from) => format!(
            "Thick lines with markers are the means over the shaded window, from {} s on; what comes before is not measured.",
            crate::draw::numbers::compact(from)
        ),
        None => "Only the last frame enters the tables.".into(),
    };
    let expected = match is_steady {
        true => " The codes should wander about the same mean; single excursions need not coincide.",
        false => "",
    };
    Some(SeriesFigure {
        svg: plot.finish(&format!("{name} over time")),
        caption: format!(
            "{}{} over time, one run a code (seed {}). {window}{expected}",
            name[..1].to_uppercase(),
            &name[1..],
            super::qualification::join(&seeds),
        ),
        observable: name,
    })
}
