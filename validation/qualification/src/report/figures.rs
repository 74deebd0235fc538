//! The figures of a scene: differences against the margins, observables over time, normal forces.

use super::qualification::join;
use makadam_compare::compare::{Comparison, Row, distinct};
use makadam_measure::observables::{ForceDistribution, Series};
use makadam_view::draw::names;
use makadam_view::draw::numbers::{Rounding, compact, count};
use makadam_view::draw::plot::{Axis, Key, Plot};
use makadam_view::draw::svg::{Anchor, Drawing};
use serde::Serialize;

/// A figure of the page.
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
    forest(comparison).into_iter().chain(over_time).chain(forces(comparison)).collect()
}

const WIDTH: f64 = 580.0;
const LEFT: f64 = 168.0;
const RIGHT: f64 = 88.0;
const LINE: f64 = 21.0;
const HEADING: f64 = 25.0;

/// Largest difference that the forest shows, in margins: beyond it a pair would press all others into a line, and gets an arrow.
const WIDEST: f64 = 4.0;

/// A line of the forest of differences.
struct Line<'a> {
    row: &'a Row,
    /// Difference of the code under test; the others are the floor.
    judged: bool,
    reference: &'a str,
    /// The difference, in margins.
    difference: f64,
    /// The interval of the verdict, in margins; absent for want of seeds.
    interval: Option<[f64; 2]>,
}

/// Returns the lines of the forest, those of an observable together.
fn lines(comparison: &Comparison) -> Vec<Line<'_>> {
    let line = |row: &'_ Row| {
        let margin = row.margin.filter(|margin| *margin > 0.0)?;
        let difference = row.difference.filter(|difference| difference.is_finite())? / margin;
        let interval = row.shown_interval().filter(|ends| ends.iter().all(|end| end.is_finite()));
        Some((difference, interval.map(|ends| ends.map(|end| end / margin))))
    };
    let lines = comparison.rows.iter().filter_map(|row| {
        let (difference, interval) = line(row)?;
        let judged = row.code == comparison.judged;
        Some(Line { row, judged, reference: row.reference_code.as_deref()?, difference, interval })
    });
    let mut lines: Vec<Line<'_>> = lines.collect();
    let observables = distinct(lines.iter().map(|line| line.row.observable.as_str()));
    lines.sort_by_key(|line| observables.iter().position(|known| *known == line.row.observable));
    lines
}

fn forest(comparison: &Comparison) -> Option<Drawn> {
    let lines = lines(comparison);
    let groups = || lines.chunk_by(|one, other| one.row.observable == other.row.observable);
    if lines.is_empty() {
        return None;
    }
    let values = lines.iter().flat_map(|line| line.interval.into_iter().flatten().chain([line.difference]));
    let reach = (values.map(f64::abs).fold(1.6, f64::max) * 1.08).min(WIDEST);
    let height = 26.0 + groups().count() as f64 * HEADING + lines.len() as f64 * LINE + 34.0;
    let mut drawing = Drawing::new(WIDTH, height);
    let x = |v: f64| LEFT + (v / reach + 1.0) / 2.0 * (WIDTH - LEFT - RIGHT);
    let bottom = height - 34.0;

    drawing.rectangle("band", [x(-1.0), 22.0], [x(1.0), bottom]);
    drawing.text("tick", [x(0.0), 14.0], Anchor::Middle, "inside the margin");
    for tick in (-4..=4).map(f64::from).filter(|t| t.abs() <= reach) {
        drawing.line(if tick == 0.0 { "zero" } else { "grid" }, [x(tick), 22.0], [x(tick), bottom]);
        drawing.text("tick", [x(tick), bottom + 14.0], Anchor::Middle, &Rounding::Decimals(0).signed(tick));
    }
    drawing.text("label", [x(0.0), height - 5.0], Anchor::Middle, "difference of the means, in margins");

    let mut y = 24.0;
    for group in groups() {
        y += HEADING;
        drawing.text("heading", [0.0, y - 8.0], Anchor::Start, &names::observable(&group[0].row.observable));
        for line in group {
            draw_line(&mut drawing, line, y + LINE / 2.0 - 4.0, reach, &x);
            y += LINE;
        }
    }
    Some(Drawn {
        title: "Differences against the margins".into(),
        svg: drawing.finish("intervals of differences against the margins"),
        caption: "Each line is one difference of means with the interval of its verdict, in units of the margin. An arrow leaves the \
                  picture; a marker without a line has no interval, for want of seeds. Grey diamonds are the floor: the references against \
                  each other."
            .into(),
        data: "rows.csv",
    })
}

fn draw_line(drawing: &mut Drawing, line: &Line<'_>, y: f64, reach: f64, x: &impl Fn(f64) -> f64) {
    let Line { row, judged, reference, difference, interval } = *line;
    let style = names::code_style(if judged { reference } else { "" });
    let label = format!("{} − {reference}", row.code);
    drawing.text(if judged { "name" } else { "name faint" }, [LEFT - 10.0, y + 4.0], Anchor::End, &label);
    if let Some([low, high]) = interval {
        let ends = [low, high].map(|end| x(end.clamp(-reach, reach)));
        let whisker = format!("{} whisker", style.class);
        drawing.line(&whisker, [ends[0], y], [ends[1], y]);
        for (end, at) in [low, high].into_iter().zip(ends) {
            if end.abs() > reach {
                let way = end.signum();
                let arrow = [[at + 7.0 * way, y], [at - way, y - 5.0], [at - way, y + 5.0]];
                drawing.polygon(&format!("{} marker", style.class), &arrow);
            } else {
                drawing.line(&whisker, [at, y - 4.0], [at, y + 4.0]);
            }
        }
    }
    if difference.abs() <= reach {
        drawing.marker(style, [x(difference), y], 4.5, !judged);
    }
    let (class, text) = match (judged, row.outcome) {
        (false, _) => ("faint", "floor"),
        (true, Some(outcome)) => (outcome.class(), outcome.words()),
        (true, None) => ("", ""),
    };
    drawing.text(&format!("name {class}"), [WIDTH - RIGHT + 14.0, y + 4.0], Anchor::Start, text);
}

/// Largest number of points of a curve: more would fall on the same pixels.
const MOST_POINTS: usize = 600;

/// A curve of one run.
pub(super) struct Curve<'a> {
    /// The run's code, seed and observable.
    pub(super) series: &'a Series,
    /// Times, s, and values, thinned where there are many.
    pub(super) points: Vec<[f64; 2]>,
    /// The mean over the measured window, at the window's beginning and end, s.
    pub(super) mean: Option<[[f64; 2]; 2]>,
}

fn points(series: &Series) -> impl Iterator<Item = (f64, f64)> {
    series.time.iter().copied().zip(series.value.iter().copied())
}

/// Returns the curves of an observable, one per run.
pub(super) fn curves<'a>(comparison: &'a Comparison, observable: &str) -> Vec<Curve<'a>> {
    let all = comparison.series.iter().filter(|s| s.observable == observable && !s.time.is_empty());
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
    // The start-up of a flow may lie far away and would flatten the rest: the range is the window's. An intruder's way is shown whole.
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
    for Curve { series, points, .. } in &all {
        let style = names::code_style(&series.code);
        plot.curve(&format!("{} curve thin", style.class), points.iter().copied());
    }
    // Means last, on top of the curves.
    for Curve { series, mean, .. } in &all {
        let Some([[from, mean], [end, _]]) = *mean else { continue };
        let style = names::code_style(&series.code);
        plot.curve(&format!("{} curve strong", style.class), [[from, mean], [end, mean]].into_iter());
        let place = codes.iter().position(|&c| c == series.code).unwrap_or(0) as f64;
        plot.marker(style, from + (end - from) * (0.15 + 0.2 * place), mean, 4.5);
    }
    let name = names::observable(observable);
    let mut seeds: Vec<u64> = all.iter().map(|curve| curve.series.seed).collect();
    seeds.sort_unstable();
    seeds.dedup();
    let seeds: Vec<String> = seeds.iter().map(u64::to_string).collect();
    let window = match from {
        Some(from) => format!("Thick lines are the means over the measured window, from {} s on.", compact(from)),
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

/// A point of a distribution of forces.
pub(super) struct Point {
    /// Normal force over its mean.
    pub(super) force: f64,
    /// Probability density.
    pub(super) density: f64,
    /// Lower and upper end of the counting error; absent on the curve of the literature.
    pub(super) error: Option<[f64; 2]>,
}

/// Returns the distribution of each code with its name, then that of the literature; nothing if no code has forces.
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

/// Bins that hold forces.
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

/// Right end of the axis: beyond eight mean forces there are a handful of contacts in a scene.
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
