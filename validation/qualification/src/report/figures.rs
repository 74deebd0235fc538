//! Figures of a scene: observables over time, normal forces.

use super::qualification::join;
use makadam_compare::compare::{Comparison, distinct};
use makadam_measure::observables::{ForceDistribution, Series};
use makadam_view::draw::names;
use makadam_view::draw::numbers::{Rounding, compact, count};
use makadam_view::draw::plot::{Axis, Key, Plot};
use serde::Serialize;

/// Figure of the page.
#[derive(Serialize)]
pub(super) struct Drawn {
    title: String,
    svg: String,
    caption: String,
    /// File of the numbers.
    data: &'static str,
}

/// Returns the figures of a scene; none without data.
pub(super) fn all(comparison: &Comparison) -> Vec<Drawn> {
    let over_time = observables(comparison).into_iter().filter_map(|observable| over_time(comparison, observable));
    over_time.chain(forces(comparison)).collect()
}

/// Largest number of points of a curve: more would fall on the same pixels.
const MOST_POINTS: usize = 600;

/// Curve of one run.
pub(super) struct Curve<'a> {
    /// Code, seed and observable of the run.
    pub(super) series: &'a Series,
    /// Times, s, and values, thinned where there are many.
    pub(super) points: Vec<[f64; 2]>,
}

fn points(series: &Series) -> impl Iterator<Item = (f64, f64)> {
    series.time.iter().copied().zip(series.value.iter().copied())
}

/// Returns the curves of an observable, one per run.
pub(super) fn curves<'a>(comparison: &'a Comparison, observable: &str) -> Vec<Curve<'a>> {
    let all = comparison.series.iter().filter(|s| s.observable == observable && !s.time.is_empty());
    let curve = |series: &'a Series| {
        let stride = series.time.len().div_ceil(MOST_POINTS);
        Curve { series, points: points(series).step_by(stride).map(|(t, v)| [t, v]).collect() }
    };
    all.map(curve).collect()
}

/// Returns the observables with a curve.
pub(super) fn observables(comparison: &Comparison) -> Vec<&str> {
    let series = comparison.series.iter().filter(|series| !series.time.is_empty());
    distinct(series.map(|series| series.observable.as_str()))
}

fn over_time(comparison: &Comparison, observable: &str) -> Option<Drawn> {
    let all = curves(comparison, observable);
    let values = || all.iter().flat_map(|curve| points(curve.series));
    let end = values().map(|(t, _)| t).filter(|t| t.is_finite()).fold(0.0, f64::max);
    let from = comparison.scene.measure.from;
    // The start-up of a flow may lie far away and would flatten the rest: the range is the window's. An intruder's path is shown whole.
    let shown_from = from.filter(|_| observable != "intruder_height").unwrap_or(0.0);
    let (low, high) = values()
        .filter(|&(t, v)| v.is_finite() && t >= shown_from)
        .fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), (_, v)| (low.min(v), high.max(v)));
    if !(low.is_finite() && high.is_finite() && end > 0.0) {
        return None;
    }
    let rows = || comparison.rows.iter().filter(|row| row.observable == observable);
    let margin = rows().find_map(|row| row.margin).unwrap_or(0.0);
    let room = (0.25 * (high - low)).max(margin).max(1e-3 * high.abs());
    let unit = rows().next().map_or("", |row| row.unit.as_str());
    let codes = distinct(all.iter().map(|curve| curve.series.code.as_str()));
    let mut plot = Plot::with_legend(
        Axis::linear("time (s)", 0.0, end),
        Axis::linear(&names::with_unit(observable, unit, Rounding::Decimals(0)), low - room, high + room),
        &codes.iter().map(|code| Key::Code(code)).collect::<Vec<_>>(),
    );
    if let Some(from) = from {
        plot.window(from, end, "measured window");
    }
    for Curve { series, points } in &all {
        let style = names::code_style(&series.code);
        plot.curve(&format!("{} curve thin", style.class), points.iter().copied());
    }
    let name = names::observable(observable);
    let mut seeds: Vec<u64> = all.iter().map(|curve| curve.series.seed).collect();
    seeds.sort_unstable();
    seeds.dedup();
    let seeds: Vec<String> = seeds.iter().map(u64::to_string).collect();
    let window = match from {
        Some(from) => format!("The tables have the means over the measured window, from {} s on.", compact(from)),
        None => "Only the last frame enters the tables.".into(),
    };
    Some(Drawn {
        title: format!("{}{} over time", name[..1].to_uppercase(), &name[1..]),
        svg: plot.finish(&format!("{name} over time")),
        caption: format!("One run per code (seed {}). {window}", join(&seeds)),
        data: "series.csv",
    })
}

/// Probability density of a normal force over its mean after Mueth, Jaeger and Nagel (Phys. Rev. E 57, 3164, 1998):
/// `P(f) = 3 (1 - 0.75 exp(-f^2)) exp(-1.5 f)`.
fn mueth(force: f64) -> f64 {
    3.0 * (1.0 - 0.75 * (-force * force).exp()) * (-1.5 * force).exp()
}

/// Name of the curve of the literature.
const LITERATURE: &str = "Mueth 1998";

/// Point of a distribution of forces.
pub(super) struct Point {
    /// Normal force over its mean.
    pub(super) force: f64,
    /// Probability density.
    pub(super) density: f64,
    /// Lower and upper end of the counting error; absent on the curve of the literature.
    pub(super) error: Option<[f64; 2]>,
}

/// Returns the distribution of each code with its name, then that of the literature; empty if no code has forces.
pub(super) fn force_curves(comparison: &Comparison) -> Vec<(&str, Vec<Point>)> {
    let of_code = comparison.forces.iter().map(|one| (one.code.as_str(), bins(one)));
    let mut curves: Vec<_> = of_code.filter(|(_, points)| !points.is_empty()).collect();
    if !curves.is_empty() {
        let right = right(&curves);
        let literature = (0..=200).map(|k| right * f64::from(k) / 200.0);
        let literature = literature.map(|force| Point { force, density: mueth(force), error: None }).collect();
        curves.push((LITERATURE, literature));
    }
    curves
}

/// Returns the bins with forces.
fn bins(distribution: &ForceDistribution) -> Vec<Point> {
    let width = match distribution.force.as_slice() {
        [first, second, ..] => (second - first).abs(),
        _ => 1.0,
    };
    let bins = distribution.force.iter().copied().zip(distribution.density.iter().copied());
    let held = bins.filter(|&(force, density)| force.is_finite() && density.is_finite() && density > 0.0);
    held.map(|(force, density)| {
        let held = density * width * distribution.samples as f64;
        let relative = 1.0 / held.sqrt();
        let error = (held > 0.0).then(|| [density * (1.0 - relative).max(1e-12), density * (1.0 + relative)]);
        Point { force, density, error }
    })
    .collect()
}

/// Right end of the axis: beyond eight mean forces there are few contacts in a scene.
fn right(curves: &[(&str, Vec<Point>)]) -> f64 {
    let forces = curves.iter().flat_map(|(_, points)| points.iter().map(|point| point.force));
    forces.fold(1.0, f64::max).clamp(1.0, 8.0)
}

fn forces(comparison: &Comparison) -> Option<Drawn> {
    let curves = force_curves(comparison);
    let (literature, all) = curves.split_last()?;
    let right = right(all);
    let shown = || all.iter().flat_map(|(_, points)| points.iter()).filter(|p| p.force <= right).map(|p| p.density);
    let low = shown().fold(0.1, f64::min).max(1e-5);
    let high = shown().fold(1.0, f64::max);
    let mut keys: Vec<Key<'_>> = all.iter().map(|(code, _)| Key::Code(code)).collect();
    keys.push(Key::Line("literature", LITERATURE));
    let mut plot = Plot::with_legend(
        Axis::linear("normal force over its mean, f", 0.0, right),
        Axis::logarithmic("probability density P(f)", low, high),
        &keys,
    );
    let line = |points: &[Point]| points.iter().map(|point| [point.force, point.density]).collect::<Vec<_>>();
    plot.curve("literature", line(&literature.1).into_iter());
    for (code, points) in all {
        let style = names::code_style(code);
        plot.curve(&format!("{} curve thin", style.class), line(points).into_iter());
        for point in points {
            if let Some([low, high]) = point.error {
                plot.error_bar(&format!("{} error", style.class), point.force, low, high);
            }
            plot.marker(style, point.force, point.density, 3.2);
        }
    }
    let counted = comparison.forces.iter().filter(|one| all.iter().any(|(code, _)| *code == one.code));
    let samples: Vec<String> = counted.map(|one| format!("{} {}", one.code, count(one.samples))).collect();
    Some(Drawn {
        title: "Normal forces".into(),
        svg: plot.finish("distribution of normal forces"),
        caption: format!(
            "The grey curve is the fit of Mueth et al. (1998) to forces at the walls of a packing of glass beads, P(f) = 3 (1 − 0.75 \
             exp(−f²)) exp(−1.5 f). Bars are the counting error of a bin, a lower bound, since forces of one packing and of successive \
             frames are correlated. Forces counted: {}.",
            join(&samples)
        ),
        data: "forces.csv",
    })
}

#[cfg(test)]
#[path = "../../tests/unit/report_figures.rs"]
mod tests;
