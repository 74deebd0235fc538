//! The numbers that the figures draw, as CSV beside the page: one file a kind of figure, with the scene in the first column.

use super::qualification::Qualification;
use super::words::outcome;
use super::{forces, forest, pictures, series};
use crate::compare::Comparison;
use crate::study::{Cell, DocumentError, File, Table, cells};
use nalgebra::Vector3;

/// What a file holds of a scene.
type Rows = fn(&Comparison) -> Vec<Vec<Cell>>;

/// All files that figures link to; one whose figure no scene has holds its head alone.
///
/// # Errors
/// [`DocumentError::Csv`] if a row is none.
pub(super) fn files(qualification: &Qualification) -> Result<Vec<File>, DocumentError> {
    let tables: [(&str, &str, Rows); 4] = [
        (
            "differences",
            "scene observable unit code reference_code judged difference margin difference_in_margins low_in_margins \
             high_in_margins outcome",
            differences,
        ),
        ("series", "scene observable code seed line time_s value", over_time),
        ("forces", "scene code force_over_mean density density_low density_high", distributions),
        ("grains", "scene code seed time_s grain x_m y_m z_m radius_m speed_m_s", grains),
    ];
    let files = tables.into_iter().map(|(name, columns, rows)| {
        let rows = qualification.comparisons.iter().flat_map(rows);
        Table::named(columns).of(rows, |row| row).csv(name)
    });
    let laws = qualification.laws.iter().filter(|law| !law.rows.is_empty());
    files.chain(laws.map(|law| Ok((law.file(), law.rows.clone().into_bytes())))).collect()
}

/// The differences and intervals of the forest, in the order of its lines.
fn differences(comparison: &Comparison) -> Vec<Vec<Cell>> {
    let row = |line: &forest::Line<'_>| {
        let [low, high] = [0, 1].map(|end| line.interval.map(|interval| interval[end]));
        cells![
            &comparison.scene.name,
            &line.row.observable,
            &line.row.unit,
            &line.row.code,
            line.reference,
            line.judged,
            line.row.difference,
            line.row.margin,
            line.difference,
            low,
            high,
            line.row.outcome.map(outcome),
        ]
    };
    forest::lines(comparison).iter().map(row).collect()
}

/// The curves of observables over time, then the two ends of the line of each mean.
fn over_time(comparison: &Comparison) -> Vec<Vec<Cell>> {
    let mut rows = Vec::new();
    for curve in series::observables(comparison).into_iter().flat_map(|name| series::curves(comparison, name)) {
        let run = curve.series;
        let lines = [("run", &curve.points[..]), ("mean", curve.mean.as_ref().map_or(&[][..], |ends| &ends[..]))];
        for (line, points) in lines {
            rows.extend(points.iter().map(|&[time, value]| {
                cells![&comparison.scene.name, &run.observable, &run.code, run.seed, line, time, value]
            }));
        }
    }
    rows
}

/// The distributions of normal forces with their counting errors, and the curve of the literature.
fn distributions(comparison: &Comparison) -> Vec<Vec<Cell>> {
    let mut rows = Vec::new();
    for (code, points) in forces::curves(comparison) {
        rows.extend(points.iter().map(|point| {
            let [low, high] = [0, 1].map(|end| point.error.map(|error| error[end]));
            cells![&comparison.scene.name, code, point.force, point.density, low, high]
        }));
    }
    rows
}

/// The grains of the pictures: place, size, and the speed that they are shaded by.
fn grains(comparison: &Comparison) -> Vec<Vec<Cell>> {
    let mut rows = Vec::new();
    for state in pictures::states(comparison) {
        rows.extend(state.particles.iter().map(|grain| {
            let [x, y, z] = grain.position;
            let speed = Vector3::from(grain.velocity).norm();
            let of_run = cells![&comparison.scene.name, &state.code, state.seed, state.time];
            of_run.into_iter().chain(cells![grain.id, x, y, z, grain.radius, speed]).collect()
        }));
    }
    rows
}
