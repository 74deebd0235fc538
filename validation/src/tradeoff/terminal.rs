//! A trade-off as plain text for a terminal.

use super::rows::Point;
use super::study::Study;
use super::words::{self, modulus, titled};
use crate::draw::numbers::two_digits;
use crate::study::{Cell, Table};

/// Observables that a terminal has room for, bounded ones first.
const SHOWN: usize = 2;

/// Points by stiffness, code and wall time, and the sentences below.
pub fn table(study: &Study) -> String {
    let names: Vec<&str> = study.observables().into_iter().take(SHOWN).collect();
    let unit = |name: &str| study.references.iter().find(|row| row.observable == name).map_or("", |row| &row.unit);
    let errors = names.iter().map(|name| format!("error of {}", titled(name, unit(name))));
    let points = Table::new(&["stiffness", "code", "setting"], &["s a simulated s"])
        .with_numbers(errors)
        .with_words("bounds")
        .of(ordered(study), |point| cells(study, point, &names));
    let mut text = format!("{}: {} grains, {} seeds\n\n", study.scene, study.particles, study.seeds);
    text += &points.text();
    text += "\n* on the Pareto front of its code; ~ extrapolated; ± standard error over seeds\n\n";
    for sentence in study.findings.iter().chain(&study.notes) {
        text += &format!("{sentence}\n");
    }
    text
}

/// Points by stiffness, code and wall time.
pub(super) fn ordered(study: &Study) -> Vec<&Point> {
    let mut points: Vec<&Point> = study.points.iter().collect();
    let rank = |code: &str| study.points.iter().position(|point| point.code == code);
    points.sort_by(|a, b| {
        let wall = |point: &Point| point.wall_seconds_per_simulated_second;
        a.stiffness_factor
            .total_cmp(&b.stiffness_factor)
            .then(rank(&a.code).cmp(&rank(&b.code)))
            .then(wall(a).total_cmp(&wall(b)))
    });
    points
}

/// Whether a point keeps the bounds, in words.
pub(super) fn verdict(study: &Study, point: &Point) -> &'static str {
    match (point.reference, point.within_bounds, point.intervals_within_bounds) {
        _ if study.bounds.is_empty() => "",
        (true, ..) => "reference",
        (_, Some(true), Some(true)) => "within, interval too",
        (_, Some(true), _) => "within",
        (_, Some(false), _) => "beyond",
        (_, None, _) => "",
    }
}

fn cells(study: &Study, point: &Point, names: &[&str]) -> Vec<Cell> {
    let about = if point.extrapolated { "~" } else { "" };
    let mut cells = vec![
        modulus(point.youngs_modulus).into(),
        point.code.as_str().into(),
        point.setting.as_str().into(),
        format!("{about}{}", two_digits(point.wall_seconds_per_simulated_second)).into(),
    ];
    cells.extend(names.iter().map(|name| {
        let star = |on_front| if on_front { " *" } else { "  " };
        let found = point.deviation(name);
        found.map(|deviation| format!("{}{}", words::deviation(deviation), star(deviation.on_front))).into()
    }));
    cells.push(verdict(study, point).into());
    cells
}
