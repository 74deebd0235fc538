//! Collapse of a column: the run-out length.
//!
//! A tube full of grains on a rough plane is lifted off. The run-out over the initial radius, `(r - r0)/r0`, depends on the
//! aspect ratio `a = h0/r0` alone: 1.24 a up to a = 1.7 and 1.6 sqrt(a) beyond.
//!
//! The law holds where the column is hundreds of grains wide, as in the experiments. A deposit of few grains ends where it is about one
//! grain thick: a length is missing, and the ratio to the law falls by that length over `r0`. So each aspect ratio is run at several
//! radii. The tested value is the ratio at `d/r0 = 0` of the line through the ratios over `d/r0`: the
//! first-order effect of a finite grain. Columns of less than 12 diameters are reported but not fitted, since their
//! deposits are less than three grains thick in the mean. Where fewer than three widths are left, as in quick runs, there is no
//! such line, and the widest column itself is tested.
//!
//! The experiments were made with sand, salt, sugar, rice and couscous. Rolling friction of spheres models the angularity. The coefficient
//! is chosen by the angle of repose of a heap, not by run-outs. The heap is run first, and its angle reported.
//!
//! Wide columns are run as a quarter of the column between two smooth planes without friction, planes of symmetry in the mean;
//! one column is run whole as well.
//!
//! ```text
//! column ─> Run ─> deposit ─> run-outs of a case ─> line over d/r0 ─> finding
//! ```

mod column;
mod deposit;

use super::campaign::values;
use super::results::{at_zero, line};
use super::{Case, DIAMETER, Law, Mean, Run, RunError, Values, figure};
use crate::sketch::GRAVITY;
use crate::study::Finding;
use column::{Part, case, heap};
use deposit::{
    angle_of_repose, centre_of_mass, connected, coverage, edge, height_at_axis, holding, solid_volume, speed,
};
use makadam_view::draw::figure::Figure;
use makadam_view::draw::names::{CodeStyle, Marker};
use makadam_view::draw::plot::{Axis, Key, Plot};
use makadam_view::draw::svg::Anchor;
use std::f64::consts::PI;

/// Coverage at which the deposit ends: half the plane under grains. Thinner deposits are scattered grains, which the
/// experiments exclude.
const EDGE: f64 = 0.5;
/// Mean speed over `sqrt(g d)` below which grains are at rest.
const REST: f64 = 0.01;
/// Radius of the narrowest fitted column, diameters.
const NARROWEST: f64 = 12.0;
/// Tolerated deviation from the law.
const TOLERANCE: f64 = 0.1;
/// Name of the measured angle of repose, degrees.
const REPOSE: &str = "angle_of_repose";

/// Law of the run-out.
pub(super) const LAW: Law = Law {
    name: "collapse",
    statement: "a column of radius r0 and height h0 = a r0 runs out to r with (r - r0)/r0 = 1.24 a for a < 1.7, 1.6 sqrt(a) beyond",
    source: "Lube, Huppert, Sparks & Hallworth, J. Fluid Mech. 508, 175 (2004); Lajeunesse, Mangeney-Castelnau & Vilotte, Phys. Fluids \
                 16, 2371 (2004)",
    cases,
    measure,
    judge,
    figures,
};

/// Run-out over the initial radius at an aspect ratio (Lube et al. 2004, equations 3.1 and 3.2).
fn law(aspect: f64) -> f64 {
    if aspect < 1.7 { 1.24 * aspect } else { 1.6 * aspect.sqrt() }
}

fn cases(quick: bool) -> Vec<Case> {
    if quick {
        return vec![case(8.0, 0.5, Part::Whole), case(8.0, 2.0, Part::Quarter)];
    }
    let (whole, quarter) = (Part::Whole, Part::Quarter);
    let series: [(f64, &[(f64, Part)]); 4] = [
        (0.5, &[(8.0, whole), (12.0, whole), (20.0, quarter), (30.0, quarter), (40.0, quarter), (60.0, quarter)]),
        (1.0, &[(8.0, whole), (12.0, whole), (20.0, whole), (20.0, quarter), (30.0, quarter), (40.0, quarter)]),
        (2.0, &[(8.0, whole), (12.0, whole), (20.0, quarter), (30.0, quarter), (40.0, quarter)]),
        (4.0, &[(8.0, whole), (12.0, whole), (16.0, quarter), (20.0, quarter), (30.0, quarter)]),
    ];
    let columns = |(aspect, columns): (f64, &[(f64, Part)])| -> Vec<Case> {
        columns.iter().map(|&(radius, part)| case(radius, aspect, part)).collect()
    };
    std::iter::once(heap()).chain(series.into_iter().flat_map(columns)).collect()
}

fn measure(case: &Case, run: &mut Run<'_>) -> Result<Values, RunError> {
    // The heap has no chosen values.
    if case.given.is_empty() {
        run.to(case.scene.duration)?;
        return Ok(values([(REPOSE, angle_of_repose(&case.scene, &run.frame()))]));
    }
    let (radius, part) = (case.of("radius"), Part::of(case));
    run.to(case.of("release"))?;
    let column = run.frame();
    let height = 2.0 * centre_of_mass(&column);
    let (fall, last) = ((height / GRAVITY).sqrt(), case.scene.duration);
    while !run.has_reached(last) {
        run.to((run.time() + 0.1 * fall).min(last))?;
        if run.time() > case.of("release") + 2.0 * fall && speed(&run.frame()) < REST {
            break;
        }
    }
    let deposit = run.frame();
    let coverage = coverage(&deposit.particles, part);
    let run_out = |edge: f64| (edge - radius) / radius;
    Ok(values([
        ("height", height),
        ("aspect", height / radius),
        ("solid_fraction", solid_volume(&column) / (part.share() * PI * radius * radius * height)),
        ("speed_at_release", speed(&column)),
        ("speed_at_end", speed(&deposit)),
        ("collapse_time", (run.time() - case.of("release")) / fall),
        ("run_out", run_out(edge(&coverage, EDGE))),
        ("run_out_coverage_25", run_out(edge(&coverage, 0.25))),
        ("run_out_coverage_100", run_out(edge(&coverage, 1.0))),
        ("run_out_connected", run_out(connected(&deposit.particles, part))),
        ("run_out_95_percent", run_out(holding(&deposit, 0.95))),
        ("run_out_99_percent", run_out(holding(&deposit, 0.99))),
        ("deposit_height", height_at_axis(&deposit.particles)),
    ]))
}

fn judge(means: &[Mean]) -> Vec<Finding> {
    let all = Series::all(means);
    let mut findings = Vec::new();
    for heap in means.iter().filter(|mean| mean.values.contains_key(REPOSE)) {
        findings.push(Finding::reported("angle of repose of these grains", heap.of_value(REPOSE)).in_unit("degree"));
    }
    for series in &all {
        match at_zero(&series.fitted("run_out")) {
            Some((limit, error)) => {
                let near = format!("a near {}", series.aspect);
                let what = format!("run-out over the law's at d/r0 = 0, by a line, {near}");
                findings.push(Finding::near(what, limit, 1.0, TOLERANCE));
                findings.push(Finding::reported(format!("its standard error, {near}"), error));
            }
            None => {
                let what = format!("run-out over the law's, {}", words(series.widest()));
                findings.push(Finding::near(what, ratio(series.widest(), "run_out"), 1.0, TOLERANCE));
            }
        }
    }
    for series in all.iter().filter(|series| series.columns.len() > 1) {
        for column in series.columns.iter().rev() {
            findings.push(Finding::reported(
                format!("run-out over the law's, {}", words(column)),
                ratio(column, "run_out"),
            ));
        }
        for (name, definition) in ALTERNATIVES {
            if let Some((limit, _)) = at_zero(&series.fitted(name)) {
                let what = format!("at d/r0 = 0 by another edge, a near {}, {definition}", series.aspect);
                findings.push(Finding::reported(what, limit));
            }
        }
    }
    findings
}

fn figures(means: &[Mean]) -> Vec<Figure> {
    let all = Series::all(means);
    vec![run_outs(&all), widths(&all)]
}

/// Other definitions of the deposit's edge, reported in addition to the tested one.
const ALTERNATIVES: [(&str, &str); 5] = [
    ("run_out_coverage_25", "a quarter covered"),
    ("run_out_coverage_100", "fully covered"),
    ("run_out_connected", "grains that touch the deposit"),
    ("run_out_95_percent", "95% of the solid volume"),
    ("run_out_99_percent", "99% of the solid volume"),
];

/// Columns of one aspect ratio, narrow ones first.
struct Series<'a> {
    /// Requested aspect ratio.
    aspect: f64,
    columns: Vec<&'a Mean>,
}

impl<'a> Series<'a> {
    /// Returns a series for each aspect ratio, in their order.
    fn all(means: &'a [Mean]) -> Vec<Series<'a>> {
        let groups = means.chunk_by(|a, b| a.of_value("nominal_aspect") == b.of_value("nominal_aspect"));
        let columns = groups.filter(|group| group[0].values.contains_key("nominal_aspect"));
        columns
            .map(|group| Series { aspect: group[0].of_value("nominal_aspect"), columns: group.iter().collect() })
            .collect()
    }

    fn widest(&self) -> &'a Mean {
        self.columns[self.columns.len() - 1]
    }

    /// Columns wide enough for the fit: `d/r0`, and the run-out over the law's.
    fn fitted(&self, name: &str) -> Vec<[f64; 2]> {
        self.columns.iter().filter(|column| is_fitted(column)).map(|column| point(column, name)).collect()
    }
}

fn is_fitted(mean: &Mean) -> bool {
    mean.of_value("radius") > (NARROWEST - 0.5) * DIAMETER
}

/// `d/r0`, and the run-out over the law's.
fn point(mean: &Mean, name: &str) -> [f64; 2] {
    [DIAMETER / mean.of_value("radius"), ratio(mean, name)]
}

/// Run-out over the law's.
fn ratio(mean: &Mean, name: &str) -> f64 {
    mean.of_value(name) / law(mean.of_value("aspect"))
}

/// Aspect ratio and radius of a column, with a note for a quarter column.
fn words(mean: &Mean) -> String {
    let part = if mean.of_value("share") < 1.0 { ", a quarter" } else { "" };
    format!("a = {:.2}, r0 = {:.0} d{part}", mean.of_value("aspect"), mean.of_value("radius") / DIAMETER)
}

const OWN: CodeStyle = CodeStyle { class: "code-makadam", marker: Marker::Circle };
const OTHER: CodeStyle = CodeStyle { class: "code-other", marker: Marker::Diamond };

/// Run-outs over the aspect ratio, with the law.
fn run_outs(all: &[Series<'_>]) -> Figure {
    let columns = || all.iter().flat_map(|series| series.columns.iter());
    let aspects: Vec<f64> = columns().map(|mean| mean.of_value("aspect")).collect();
    let least = 0.8 * aspects.iter().copied().fold(f64::INFINITY, f64::min);
    let most = 1.25 * aspects.iter().copied().fold(0.0, f64::max);
    let keys = [
        Key::Line("curve neutral", "law"),
        Key::Points(OWN, "widest column (open: narrower)"),
        Key::Points(OTHER, "widest, other edges"),
    ];
    let (x, y) = (Axis::fine("aspect ratio a = h0/r0", least, most), Axis::fine("run-out (r − r0)/r0", 0.3, 8.0));
    let mut plot = Plot::with_legend(x, y, &keys);
    let marks = 60;
    let along = (0..=marks).map(|mark| 0.1 * 200f64.powf(f64::from(mark) / f64::from(marks)));
    plot.curve("curve neutral", along.map(|aspect| [aspect, law(aspect)]));
    for mean in columns() {
        plot.open_marker(OWN, mean.of_value("aspect"), mean.of_value("run_out"), 3.4);
    }
    for widest in all.iter().map(Series::widest) {
        let aspect = widest.of_value("aspect");
        for (name, _) in ALTERNATIVES {
            plot.open_marker(OTHER, aspect, widest.of_value(name), 2.6);
        }
        plot.marker(OWN, aspect, widest.of_value("run_out"), 4.2);
    }
    figure("run-out", plot, "Run-out of collapsing columns", "measured, and the law of Lube et al. (2004).")
}

/// Ratios to the law over `d/r0`, with the lines whose values at zero are tested.
fn widths(all: &[Series<'_>]) -> Figure {
    let keys = [Key::Points(OWN, "measured (open: not fitted)"), Key::Line("curve neutral", "line of an aspect ratio")];
    let (x, y) = (Axis::linear("d/r0", 0.0, 0.14), Axis::linear("run-out over the law's", 0.3, 1.3));
    let mut plot = Plot::with_legend(x, y, &keys);
    for series in all {
        let points = series.fitted("run_out");
        if at_zero(&points).is_some() {
            let (slope, limit) = line(&points);
            plot.curve("curve neutral", [0.0, 1.0 / NARROWEST].into_iter().map(|x| [x, limit + slope * x]));
        }
        for column in &series.columns {
            let [x, y] = point(column, "run_out");
            match is_fitted(column) {
                true => plot.marker(OWN, x, y, 3.4),
                false => plot.open_marker(OWN, x, y, 3.4),
            }
        }
        let [x, y] = point(series.columns[0], "run_out");
        plot.label([x, y], [6.0, 3.0], Anchor::Start, &format!("a = {}", series.aspect));
    }
    figure(
        "widths",
        plot,
        "Run-out over the law's, and the width of the column",
        "a deposit of few grains is too short by some diameters.",
    )
}

#[cfg(test)]
#[path = "../../../tests/unit/laws_collapse.rs"]
mod tests;
