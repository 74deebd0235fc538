//! Error against wall time, one figure an observable and a stiffness.

use super::rows::{Deviation, Point, Reference};
use super::study::Study;
use super::words::{modulus, titled};
use crate::prepared::file_stem;
use crate::report::figure::Figure;
use crate::report::names::{CodeStyle, Marker, code_style, observable};
use crate::report::numbers::compact;
use crate::report::plot::{Axis, Key, Plot};
use crate::report::svg::Anchor;

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
            all.extend(study.reference(name, factor).and_then(|reference| figure(study, reference)));
        }
    }
    all
}

/// One observable at one stiffness; absent where no point has an error.
fn figure(study: &Study, reference: &Reference) -> Option<Figure> {
    let name = reference.observable.as_str();
    let of = |point: &&Point| point.stiffness_factor == reference.stiffness_factor && !point.reference;
    let all: Vec<&Point> = study.points.iter().filter(of).collect();
    let known: Vec<(&Point, &Deviation)> = all.iter().filter_map(|p| Some((*p, p.deviation(name)?))).collect();
    let errors = || known.iter().map(|(_, deviation)| deviation.deviation.abs());
    let noise = crate::scaling::median(known.iter().filter_map(|(_, d)| d.deviation_standard_error));
    let largest = errors().chain(bound_of(study, name)).fold(0.0, f64::max);
    let smallest = errors().filter(|error| *error > 0.0).fold(f64::INFINITY, f64::min);
    if !(largest > 0.0 && smallest.is_finite()) {
        return None;
    }
    // What lies far below the noise is luck: it is drawn at the lower edge.
    let low = smallest.max(if noise.is_finite() { 0.3 * noise } else { 0.0 }).min(0.5 * largest);
    let wall = |point: &Point| point.wall_seconds_per_simulated_second;
    let least = all.iter().map(|point| wall(point)).fold(f64::INFINITY, f64::min);
    let most = all.iter().map(|point| wall(point)).fold(0.0, f64::max);
    let label = format!("error of {}", titled(name, &reference.unit));
    // The finer marks of small numbers would run into the label.
    let y = if low < 1e-3 { Axis::logarithmic } else { Axis::fine }(&label, low, 1.5 * largest);
    let (bottom, top) = (y.low, y.high);
    let x = Axis::fine("wall time over simulated time (s/s, one core)", least, 1.4 * most);
    let (left, right) = (x.low, x.high);
    let mut plot = Plot::new(x, y);
    if let Some(bound) = bound_of(study, name) {
        plot.curve("ideal", [[left, bound], [right, bound]].into_iter());
        // On the side away from the noise.
        let down = if noise > bound { 13.0 } else { -5.0 };
        plot.label([right, bound], [-6.0, down], Anchor::End, &format!("bound {}", compact(bound)));
    }
    if noise > bottom {
        plot.curve("ideal noise", [[left, noise], [right, noise]].into_iter());
        // To the left, where settings are too cheap to be that near.
        plot.label([left, noise], [6.0, 13.0], Anchor::Start, "noise of the seeds (median)");
    }
    let mut codes: Vec<&str> = Vec::new();
    for point in &all {
        if !codes.contains(&point.code.as_str()) {
            codes.push(&point.code);
        }
    }
    for code in &codes {
        draw_code(&mut plot, code, &known, [bottom, top]);
    }
    for point in all.iter().filter(|point| point.extrapolated) {
        plot.open_marker(code_style(&point.code), wall(point), top, 5.0);
    }
    let open = CodeStyle { class: "neutral hollow", marker: Marker::Circle };
    let mut keys: Vec<Key<'_>> = codes.iter().map(|code| Key::Code(code)).collect();
    if all.iter().any(|point| point.extrapolated) {
        keys.push(Key::Points(open, "extrapolated, no error"));
    }
    plot.legend(&keys);
    let stiffness = modulus(reference.youngs_modulus);
    let about = format!("Error of the {} against wall time, grains of {stiffness}", observable(name));
    Some(Figure {
        name: format!("{}-{}", file_stem(name), file_stem(&stiffness.replace(' ', ""))),
        svg: plot.finish(&about),
        caption: format!(
            "{about}. Lines are Pareto fronts, bars one standard error over seeds; points at the lower edge lie below it."
        ),
    })
}

fn bound_of(study: &Study, name: &str) -> Option<f64> {
    study.bounds.iter().find(|bound| bound.observable == name).map(|bound| bound.value)
}

/// Points of a code with their bars, and its front as a line with the settings beside it.
fn draw_code(plot: &mut Plot, code: &str, known: &[(&Point, &Deviation)], [bottom, top]: [f64; 2]) {
    let style = code_style(code);
    let mut own: Vec<&(&Point, &Deviation)> = known.iter().filter(|(point, _)| point.code == code).collect();
    own.sort_by(|a, b| a.0.wall_seconds_per_simulated_second.total_cmp(&b.0.wall_seconds_per_simulated_second));
    let at = |(point, deviation): &(&Point, &Deviation)| {
        [point.wall_seconds_per_simulated_second, deviation.deviation.abs().clamp(bottom, top)]
    };
    let front: Vec<&(&Point, &Deviation)> = own.iter().copied().filter(|(_, deviation)| deviation.on_front).collect();
    plot.curve(&format!("{} curve", style.class), front.iter().map(|member| at(member)));
    for member in &own {
        let [x, y] = at(member);
        if let Some(error) = member.1.deviation_standard_error {
            let size = member.1.deviation.abs();
            let (low, high) = ((size - error).max(bottom), (size + error).max(bottom));
            plot.error_bar(&format!("{} error", style.class), x, low, high);
        }
        plot.marker(style, x, y, if member.1.on_front { 5.0 } else { 3.2 });
    }
    for member in front {
        plot.label(at(member), [7.0, -6.0], Anchor::Start, &member.0.short_setting);
    }
}
