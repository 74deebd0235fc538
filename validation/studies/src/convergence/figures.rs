//! Residuals against iterations and against wall time.

use super::{Curve, Study};
use makadam::ConvergencePoint;
use makadam::scene::SolverMethod;
use makadam::sweep::Residuals;
use makadam_measure::statistics::median;
use makadam_view::draw::figure::Figure;
use makadam_view::draw::numbers::plural;
use makadam_view::draw::plot::{Axis, Key, Plot};

/// Residuals below this, in the study's unit, are rounding errors: no figure extends below.
const LOWEST: f64 = 1e-14;
/// Factor over the initial residual at which curves of divergent methods are cut off.
const HIGHEST: f64 = 10.0;

type Part = fn(&Residuals) -> f64;

/// Three directions, and turning: name, class of the curve, its value.
const DIRECTIONS: [(&str, &str, Part); 4] = [
    ("normal", "direction-normal curve", |residuals| residuals.normal.rms),
    ("tangent u", "direction-tangent-u curve", |residuals| residuals.tangential_u.rms),
    ("tangent v", "direction-tangent-v curve", |residuals| residuals.tangential_v.rms),
    ("turning", "direction-turning curve", |residuals| residuals.turning.rms),
];

fn title(method: SolverMethod) -> String {
    match method {
        SolverMethod::GaussSeidel => "Gauss-Seidel".into(),
        SolverMethod::Anderson { .. } => "Anderson".into(),
        SolverMethod::Jacobi { .. } => "Jacobi".into(),
        other => other.name().replace('-', " "),
    }
}

/// Directions of the first method, all methods against iterations and against wall time, the directions of the others.
pub(super) fn figures(study: &Study) -> Vec<Figure> {
    let mut figures: Vec<Figure> = study.methods.iter().map(|curve| directions(study, curve)).collect();
    let all = [all_methods(study, false), all_methods(study, true)];
    figures.splice(figures.len().min(1)..figures.len().min(1), all);
    figures
}

/// Normal and tangential residuals of one method against iterations, as in the thesis's figure 6.1.
fn directions(study: &Study, curve: &Curve) -> Figure {
    // Where nothing resists turning, its curve is absent.
    let shown: Vec<_> = DIRECTIONS
        .into_iter()
        .filter(|(name, _, part)| *name != "turning" || curve.points.iter().any(|point| part(&point.residuals) > 0.0))
        .collect();
    let parts: Vec<Part> = shown.iter().map(|(_, _, part)| *part).collect();
    let keys: Vec<Key<'_>> = shown.iter().map(|(name, class, _)| Key::Line(class, name)).collect();
    let x = Axis::linear("iterations", 0.0, f64::from(study.effort.iterations));
    let mut plot = Plot::with_legend(x, residual_axis(study, std::slice::from_ref(curve), &parts), &keys);
    for (_, class, part) in shown {
        plot.curve(class, line(curve, part, |point| f64::from(point.iterations)));
    }
    let about = format!("Residuals of {} against iterations, by direction", title(curve.method));
    Figure {
        name: format!("directions-{}", curve.method.name()),
        svg: plot.finish(&about),
        caption: format!("{about}: root mean squares over contacts, in the form of the thesis's figure 6.1."),
    }
}

/// Residuals of all methods over all directions, against iterations or against wall time. Wall time ends at the end of the median method:
/// the slowest would compress all others to the edge.
fn all_methods(study: &Study, against_time: bool) -> Figure {
    let classes = study.methods.iter().map(|curve| format!("method-{} curve", curve.method.name()));
    let styles: Vec<(String, String)> = classes.zip(study.methods.iter().map(|curve| title(curve.method))).collect();
    let keys: Vec<Key<'_>> = styles.iter().map(|(class, name)| Key::Line(class, name)).collect();
    let across = |point: &ConvergencePoint| match against_time {
        true => 1e3 * point.seconds,
        false => f64::from(point.iterations),
    };
    let ends = study.methods.iter().map(|curve| curve.points.last().map_or(0.0, across));
    let x = match against_time {
        true => Axis::linear("wall time (ms)", 0.0, median(ends)),
        false => Axis::linear("iterations", 0.0, f64::from(study.effort.iterations)),
    };
    let mut plot = Plot::with_legend(x, residual_axis(study, &study.methods, &[Residuals::rms]), &keys);
    for (curve, (class, _)) in study.methods.iter().zip(&styles) {
        plot.curve(class, line(curve, Residuals::rms, across));
    }
    let (against, name) = if against_time { ("wall time", "time") } else { ("iterations", "iterations") };
    let about = format!("Residuals of all methods against {against}");
    let threads = plural(study.provenance.threads, "thread");
    let how = match against_time {
        false => String::new(),
        true => format!(" {threads}; the figure ends where half of the methods are done."),
    };
    Figure {
        name: format!("methods-{name}"),
        svg: plot.finish(&about),
        caption: format!("{about}: root mean square over contacts and all directions.{how}"),
    }
}

fn residual_axis(study: &Study, curves: &[Curve], parts: &[Part]) -> Axis {
    let values = || {
        let points = curves.iter().flat_map(|curve| &curve.points);
        let values = points.flat_map(|point| parts.iter().map(|part| part(&point.residuals)));
        values.filter(|value| value.is_finite() && *value > 0.0)
    };
    let starts = curves.iter().filter_map(|curve| curve.points.first());
    let start = starts.flat_map(|point| parts.iter().map(|part| part(&point.residuals))).fold(LOWEST, f64::max);
    let highest = values().fold(start, f64::max).min(HIGHEST * start);
    let lowest = values().fold(start, f64::min).max(LOWEST);
    Axis::logarithmic(&format!("residual ({})", study.problem.residual_unit_name), lowest, highest)
}

fn line(curve: &Curve, part: Part, across: impl Fn(&ConvergencePoint) -> f64) -> impl Iterator<Item = [f64; 2]> {
    curve.points.iter().map(move |point| [across(point), part(&point.residuals)])
}
