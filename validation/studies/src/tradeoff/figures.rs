//! Figures of error against wall time, one for each observable and stiffness, with all codes.

use super::report::{modulus, titled};
use super::rows::{Deviation, Point, Reference};
use super::study::Study;
use makadam_frames::output::file_stem;
use makadam_view::draw::figure::Figure;
use makadam_view::draw::names::{CodeStyle, Marker, code_style, observable};
use makadam_view::draw::numbers::compact;
use makadam_view::draw::plot::{Axis, Key, Plot};

/// Observables that have a figure at the scene's stiffness; at others only bounded ones have.
const SHOWN: usize = 4;

/// Figures of the scene's stiffness first, then the bounded observables at the others.
pub(super) fn figures(study: &Study) -> Vec<Figure> {
    let mut factors = study.stiffness_factors();
    factors.sort_by(|a, b| (*a != 1.0).cmp(&(*b != 1.0)).then(a.total_cmp(b)));
    let mut all = Vec::new();
    for factor in factors {
        let room = if factor == 1.0 { SHOWN.max(study.bounds.len()) } else { study.bounds.len() };
        for name in study.observables().into_iter().take(room) {
            all.extend(study.reference(name, factor).and_then(|reference| codes(study, reference)));
        }
    }
    all
}

/// All codes on one observable at one stiffness; absent where no point has an error.
fn codes(study: &Study, reference: &Reference) -> Option<Figure> {
    let name = reference.observable.as_str();
    let of = |point: &&Point| point.stiffness_factor == reference.stiffness_factor && !point.reference;
    let all: Vec<&Point> = study.points.iter().filter(of).collect();
    let mut names: Vec<&str> = Vec::new();
    for point in &all {
        if !names.contains(&point.code.as_str()) {
            names.push(&point.code);
        }
    }
    let mut series: Vec<Series<'_>> = Vec::new();
    for code in &names {
        let own: Vec<&Point> = all.iter().copied().filter(|point| point.code == *code).collect();
        let (varied, plain): (Vec<&Point>, Vec<&Point>) = own.iter().partition(|point| point.variation.is_some());
        series.push(Series {
            name: code,
            style: code_style(code),
            members: members_of(&plain, name),
            cut: cut_of(&plain),
            // A code has one front, whatever its settings.
            front: members_of(&own, name).into_iter().filter(|member| member.deviation.on_front).collect(),
        });
        if !varied.is_empty() {
            series.push(Series {
                name: "Makadam, solver varied",
                style: CodeStyle { class: code_style(code).class, marker: Marker::Cross },
                members: members_of(&varied, name),
                cut: cut_of(&varied),
                front: Vec::new(),
            });
        }
    }
    let stiffness = modulus(reference.youngs_modulus);
    let about = format!("Error of the {} against wall time, grains of {stiffness}", observable(name));
    Some(Figure {
        name: format!("{}-{}", file_stem(name), file_stem(&stiffness.replace(' ', ""))),
        svg: panel(study, reference, series, &about)?,
        caption: format!(
            "{about}. Lines are Pareto fronts, bars one standard error over seeds; points at the lower edge lie below it. \
             The numbered settings are named below the plot."
        ),
    })
}

fn members_of<'a>(points: &[&'a Point], name: &str) -> Vec<Member<'a>> {
    let member = |point: &&'a Point| Some(Member { point, deviation: point.deviation(name)? });
    points.iter().filter_map(member).collect()
}

fn cut_of<'a>(points: &[&'a Point]) -> Vec<&'a Point> {
    points.iter().copied().filter(|point| point.extrapolated).collect()
}

/// A point and what is drawn of it.
#[derive(Clone, Copy)]
struct Member<'a> {
    point: &'a Point,
    deviation: &'a Deviation,
}

impl Member<'_> {
    /// Wall time and error.
    fn coordinates(&self) -> [f64; 2] {
        [self.point.wall_seconds_per_simulated_second, self.deviation.deviation.abs()]
    }
}

/// Points that are drawn alike.
struct Series<'a> {
    name: &'a str,
    style: CodeStyle,
    members: Vec<Member<'a>>,
    cut: Vec<&'a Point>,
    /// Members that its line joins, from the cheapest; may be of another series.
    front: Vec<Member<'a>>,
}

fn bound_of(study: &Study, name: &str) -> Option<f64> {
    study.bounds.iter().find(|bound| bound.observable == name).map(|bound| bound.value)
}

/// Seed noise of an observable at the reference's stiffness: the median standard error of its deviations, 0 where there is none.
fn noise_of(study: &Study, reference: &Reference) -> f64 {
    let of = |point: &&Point| point.stiffness_factor == reference.stiffness_factor && !point.reference;
    let known = study.points.iter().filter(of).filter_map(|point| point.deviation(&reference.observable));
    let noise = makadam_measure::statistics::median(known.filter_map(|deviation| deviation.deviation_standard_error));
    if noise.is_finite() { noise } else { 0.0 }
}

/// The drawing; absent where no point has an error.
fn panel(study: &Study, reference: &Reference, mut series: Vec<Series<'_>>, about: &str) -> Option<String> {
    let name = reference.observable.as_str();
    for one in &mut series {
        one.front.sort_by(|a, b| a.coordinates()[0].total_cmp(&b.coordinates()[0]));
    }
    let known = || series.iter().flat_map(|series| &series.members);
    let errors = || known().map(|member| member.coordinates()[1]);
    let noise = noise_of(study, reference);
    let largest = errors().chain(bound_of(study, name)).fold(0.0, f64::max);
    let smallest = errors().filter(|error| *error > 0.0).fold(f64::INFINITY, f64::min);
    if !(largest > 0.0 && smallest.is_finite()) {
        return None;
    }
    // What lies far below the noise is luck: it is drawn at the lower edge.
    let low = smallest.max(0.3 * noise).min(0.5 * largest);
    let cut = || series.iter().flat_map(|series| series.cut.iter().map(move |point| (series.style, *point)));
    let wall = |point: &Point| point.wall_seconds_per_simulated_second;
    let walls = || known().map(|member| wall(member.point)).chain(cut().map(|(_, point)| wall(point)));
    let (least, most) = (walls().fold(f64::INFINITY, f64::min), walls().fold(0.0, f64::max));
    let label = format!("error of {}", titled(name, &reference.unit));
    // The finer marks of small numbers would run into the label.
    let y = if low < 1e-3 { Axis::logarithmic } else { Axis::fine }(&label, low, 1.5 * largest);
    let (bottom, top) = (y.low, y.high);
    let x = Axis::fine("wall time over simulated time (s/s, one core)", least, 1.4 * most);
    let (left, right) = (x.low, x.high);
    let open = CodeStyle { class: "neutral hollow", marker: Marker::Circle };
    let lines = |series: &Series<'_>| !series.front.is_empty();
    let mut keys: Vec<Key<'_>> = series
        .iter()
        .map(|series| if lines(series) { Key::Series } else { Key::Points }(series.style, series.name))
        .collect();
    if cut().next().is_some() {
        keys.push(Key::Points(open, "extrapolated, no error"));
    }
    let bound = bound_of(study, name);
    let (within_bound, noisy) = (bound.map(|bound| format!("bound {}", compact(bound))), noise > bottom);
    keys.extend(within_bound.as_deref().map(|words| Key::Line("ideal", words)));
    keys.extend(noisy.then_some(Key::Line("ideal noise", "noise of the seeds (median)")));
    let mut plot = Plot::with_legend(x, y, &keys);
    let mut level = |class: &str, value: f64| plot.curve(class, [[left, value], [right, value]].into_iter());
    if let Some(bound) = bound {
        level("ideal", bound);
    }
    if noisy {
        level("ideal noise", noise);
    }
    let fronts: Vec<&Point> = series.iter().flat_map(|series| series.front.iter().map(|member| member.point)).collect();
    for one in &series {
        draw(&mut plot, one, &fronts, [bottom, top]);
    }
    for (style, point) in cut() {
        plot.open_marker(style, wall(point), top, 5.0);
    }
    // Numbers come last, so that they find room between the markers.
    let (mut number, mut groups) = (0, Vec::new());
    for one in series.iter().filter(|series| lines(series)) {
        let mut entries = Vec::new();
        for member in &one.front {
            number += 1;
            plot.number(within(member, [bottom, top]), number);
            entries.push((number, member.point.short_setting.as_str()));
        }
        groups.push((one.style, entries));
    }
    plot.key_of_numbers(&groups);
    Some(plot.finish(about))
}

/// Wall time and error, moved into the frame.
fn within(member: &Member<'_>, [bottom, top]: [f64; 2]) -> [f64; 2] {
    let [wall, error] = member.coordinates();
    [wall, error.clamp(bottom, top)]
}

/// A series with its bars and its front. Points of any front are larger.
fn draw(plot: &mut Plot, series: &Series<'_>, fronts: &[&Point], [bottom, top]: [f64; 2]) {
    let style = series.style;
    let at = |member: &Member<'_>| within(member, [bottom, top]);
    plot.curve(&format!("{} curve", style.class), series.front.iter().map(at));
    let mut members: Vec<&Member<'_>> = series.members.iter().collect();
    members.sort_by(|a, b| a.coordinates()[0].total_cmp(&b.coordinates()[0]));
    for member in members {
        let [x, y] = at(member);
        if let Some(error) = member.deviation.deviation_standard_error {
            let size = member.deviation.deviation.abs();
            let (low, high) = ((size - error).max(bottom), (size + error).max(bottom));
            plot.error_bar(&format!("{} error", style.class), x, low, high);
        }
        let on_front = fronts.iter().any(|point| std::ptr::eq(*point, member.point));
        plot.marker(style, x, y, if on_front { 5.0 } else { 3.2 });
    }
}
