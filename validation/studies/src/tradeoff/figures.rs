//! Figures of error against wall time, one for each observable and stiffness, with all codes.

use super::report::modulus;
use super::rows::{Deviation, Point, Reference};
use super::study::Study;
use makadam_frames::output::file_stem;
use makadam_measure::statistics::median;
use makadam_view::draw::figure::Figure;
use makadam_view::draw::names::{CodeStyle, Marker, code_style, observable, with_unit};
use makadam_view::draw::numbers::{Rounding, compact};
use makadam_view::draw::plot::{Axis, Key, Plot};

/// Number of observables with a figure at the scene's stiffness; at others only bounded ones have figures.
const SHOWN: usize = 4;

/// Figures of the scene's stiffness first, then the bounded observables at the others.
pub(super) fn figures(study: &Study) -> Vec<Figure> {
    let mut factors: Vec<f64> = study.points.iter().map(|point| point.stiffness_factor).collect();
    factors.sort_by(|a, b| (*a != 1.0).cmp(&(*b != 1.0)).then(a.total_cmp(b)));
    factors.dedup();
    let mut all = Vec::new();
    for factor in factors {
        let room = if factor == 1.0 { SHOWN.max(study.terms.bounds.len()) } else { study.terms.bounds.len() };
        for name in study.observables().into_iter().take(room) {
            all.extend(study.reference(name, factor).and_then(|reference| codes(study, reference)));
        }
    }
    all
}

/// Point with an error: wall time and size of the error.
#[derive(Clone, Copy)]
struct Member<'a> {
    point: &'a Point,
    deviation: &'a Deviation,
    at: [f64; 2],
}

/// Points with an error, the cheapest first.
fn members<'a>(points: &[&'a Point], name: &str) -> Vec<Member<'a>> {
    let member = |point: &&'a Point| {
        let deviation = point.deviation(name)?;
        Some(Member { point, deviation, at: [point.wall_seconds_per_simulated_second, deviation.deviation.abs()] })
    };
    let mut members: Vec<Member<'_>> = points.iter().filter_map(member).collect();
    members.sort_by(|a, b| a.at[0].total_cmp(&b.at[0]));
    members
}

/// Points with the same style.
struct Series<'a> {
    name: &'a str,
    style: CodeStyle,
    members: Vec<Member<'a>>,
    /// Members joined by its line, also of other series: a code has one front, whatever its settings.
    front: Vec<Member<'a>>,
}

/// Draws all codes on one observable at one stiffness; absent where no point has an error.
fn codes(study: &Study, reference: &Reference) -> Option<Figure> {
    let name = reference.observable.as_str();
    let of = |point: &&Point| point.stiffness_factor == reference.stiffness_factor && !point.reference;
    let all: Vec<&Point> = study.points.iter().filter(of).collect();
    let mut series: Vec<Series<'_>> = Vec::new();
    for point in &all {
        let (code, style) = (point.code.as_str(), code_style(&point.code));
        if series.iter().any(|known| known.name == code) {
            continue;
        }
        let own: Vec<&Point> = all.iter().copied().filter(|point| point.code == code).collect();
        let front = members(&own, name).into_iter().filter(|member| member.deviation.on_front).collect();
        let (varied, points): (Vec<&Point>, Vec<&Point>) = own.iter().partition(|point| point.variation.is_some());
        series.push(Series { name: code, style, members: members(&points, name), front });
        if !varied.is_empty() {
            let (name_of_varied, style) = ("Makadam, solver varied", CodeStyle { marker: Marker::Cross, ..style });
            let members = members(&varied, name);
            series.push(Series { name: name_of_varied, style, members, front: Vec::new() });
        }
    }
    let stiffness = modulus(reference.youngs_modulus);
    let about = format!("Error of the {} against wall time, grains of {stiffness}", observable(name));
    // Seed noise: the median standard error.
    let noises = all.iter().filter_map(|point| point.deviation(name)?.deviation_standard_error);
    let noise = Some(median(noises)).filter(|noise| noise.is_finite()).unwrap_or(0.0);
    Some(Figure {
        name: format!("{}-{}", file_stem(name), file_stem(&stiffness.replace(' ', ""))),
        svg: panel(&with_unit(name, &reference.unit, Rounding::Decimals(0)), &series, noise, study.terms.bound(name))?
            .finish(&about),
        caption: format!(
            "{about}. Lines are Pareto fronts, bars one standard error over seeds; points at the lower edge lie below it. \
             The numbered settings are named below the plot."
        ),
    })
}

/// Drawing; absent where no point has an error.
fn panel(name: &str, series: &[Series<'_>], noise: f64, bound: Option<f64>) -> Option<Plot> {
    let errors = || series.iter().flat_map(|series| &series.members).map(|member| member.at[1]);
    let largest = errors().chain(bound).fold(0.0, f64::max);
    let smallest = errors().filter(|error| *error > 0.0).fold(f64::INFINITY, f64::min);
    if !(largest > 0.0 && smallest.is_finite()) {
        return None;
    }
    // Errors far below the noise are chance: such points are drawn at the lower edge.
    let low = smallest.max(0.3 * noise).min(0.5 * largest);
    let walls = series.iter().flat_map(|series| &series.members).map(|member| member.at[0]);
    let (least, most) = walls.fold((f64::INFINITY, 0.0_f64), |(a, b), wall| (a.min(wall), b.max(wall)));
    // The finer marks of small numbers would overlap the label.
    let scale = if low < 1e-3 { Axis::logarithmic } else { Axis::fine };
    let y = scale(&format!("error of {name}"), low, 1.5 * largest);
    let x = Axis::fine("wall time over simulated time (s/s, one core)", least, 1.4 * most);
    let (left, right, bottom, top) = (x.low, x.high, y.low, y.high);
    let key = |series: &Series<'_>| if series.front.is_empty() { Key::Points } else { Key::Series };
    let keys = series.iter().map(|series| key(series)(series.style, series.name));
    let levels = [
        bound.map(|bound| ("ideal", bound, format!("bound {}", compact(bound)))),
        (noise > bottom).then(|| ("ideal noise", noise, "noise of the seeds (median)".into())),
    ];
    let keys: Vec<Key<'_>> =
        keys.chain(levels.iter().flatten().map(|(class, _, words)| Key::Line(class, words))).collect();
    let mut plot = Plot::with_legend(x, y, &keys);
    for (class, value, _) in levels.iter().flatten() {
        plot.curve(class, [[left, *value], [right, *value]].into_iter());
    }
    let within = |member: &Member<'_>| [member.at[0], member.at[1].clamp(bottom, top)];
    let fronts: Vec<&Point> = series.iter().flat_map(|series| &series.front).map(|member| member.point).collect();
    for Series { style, members, front, .. } in series {
        plot.curve(&format!("{} curve", style.class), front.iter().map(within));
        for member in members {
            let [x, y] = within(member);
            if let Some(error) = member.deviation.deviation_standard_error {
                let [low, high] = [-error, error].map(|error| (member.at[1] + error).max(bottom));
                plot.error_bar(&format!("{} error", style.class), x, low, high);
            }
            // Points of any front are larger.
            let on_front = fronts.iter().any(|point| std::ptr::eq(*point, member.point));
            plot.marker(*style, x, y, if on_front { 5.0 } else { 3.2 });
        }
    }
    // Numbers come last, so that they find free space between the markers.
    let (mut number, mut groups) = (0, Vec::new());
    for Series { style, front, .. } in series.iter().filter(|series| !series.front.is_empty()) {
        let entries = front.iter().map(|member| {
            number += 1;
            plot.number(within(member), number);
            (number, member.point.setting.as_str())
        });
        groups.push((*style, entries.collect::<Vec<_>>()));
    }
    plot.key_of_numbers(&groups);
    Some(plot)
}
