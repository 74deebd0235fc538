//! The numbers of a report as CSV, and the JSON Schema of `report.json`.

use super::qualification::Qualification;
use super::tables::source_word;
use super::{ReportDocument, figures};
use makadam_compare::compare::{Comparison, Row};
use makadam_compare::scenes;
use makadam_compare::study::{Cell, DocumentError, File, Table, cells};
use makadam_measure::statistics::Outcome;
use nalgebra::Vector3;
use schemars::generate::SchemaSettings;
use serde_json::Value;

/// Rows of a file for one scene.
type Rows = fn(&Comparison) -> Vec<Vec<Cell>>;

/// Files with their columns: the rows of all tables, and the numbers that figures and pictures draw.
const FILES: [(&str, &str, Rows); 4] = [
    (
        "rows",
        "scene observable unit code source mean standard_deviation seeds reference_code difference interval90_low \
         interval90_high verdict_low verdict_high margin outcome seeds_needed missing",
        rows,
    ),
    ("series", "scene observable code seed line time_s value", over_time),
    ("forces", "scene code force_over_mean density density_low density_high", distributions),
    ("grains", "scene code seed time_s grain x_m y_m z_m radius_m speed_m_s", grains),
];

/// Returns all files, scenes one below the other; a file without rows has its head alone.
pub(super) fn files(qualification: &Qualification) -> Result<Vec<File>, DocumentError> {
    let file = |(name, columns, rows): (&str, &str, Rows)| {
        let rows = qualification.comparisons.iter().flat_map(rows);
        Table::named(columns).of(rows, |row| row).csv(name)
    };
    FILES.into_iter().map(file).collect()
}

fn rows(comparison: &Comparison) -> Vec<Vec<Cell>> {
    let line = |row: &Row| {
        let code = comparison.codes.iter().find(|code| code.code == row.code);
        let [low, high] = [0, 1].map(|end| row.interval90.map(|interval| interval[end]));
        let [verdict_low, verdict_high] = [0, 1].map(|end| row.interval_of_verdict.map(|interval| interval[end]));
        cells![
            &row.scene,
            &row.observable,
            &row.unit,
            &row.code,
            code.map(|code| source_word(code.source)),
            row.mean,
            row.standard_deviation,
            row.seeds,
            row.reference_code.as_deref(),
            row.difference,
            low,
            high,
            verdict_low,
            verdict_high,
            row.margin,
            row.outcome.map(Outcome::words),
            row.seeds_needed,
            row.missing.as_deref(),
        ]
    };
    comparison.rows.iter().map(line).collect()
}

/// The curves of observables over time, then the two ends of the line of each mean.
fn over_time(comparison: &Comparison) -> Vec<Vec<Cell>> {
    let mut rows = Vec::new();
    for curve in figures::observables(comparison).into_iter().flat_map(|name| figures::curves(comparison, name)) {
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
    for (code, points) in figures::force_curves(comparison) {
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
    for state in &comparison.final_states {
        rows.extend(state.particles.iter().map(|grain| {
            let [x, y, z] = grain.position;
            let speed = Vector3::from(grain.velocity).norm();
            let of_run = cells![&comparison.scene.name, &state.code, state.seed, state.time];
            of_run.into_iter().chain(cells![grain.id, x, y, z, grain.radius, speed]).collect()
        }));
    }
    rows
}

/// Returns the JSON Schema (draft 2020-12) of `report.json`. A field that is always written is required.
pub fn schema() -> Value {
    let generator = SchemaSettings::draft2020_12().for_serialize().into_generator();
    let mut schema = generator.into_root_schema_for::<ReportDocument>().to_value();
    // Descriptions of scene keys are those of the scene language.
    let of_file = scenes::schema();
    let keys = schema.pointer_mut("/$defs/Scene/properties").and_then(Value::as_object_mut);
    for (key, value) in keys.into_iter().flatten() {
        if let (Value::Object(value), Some(meaning)) = (value, of_file["properties"][key].get("description")) {
            value.insert("description".into(), meaning.clone());
        }
    }
    schema["title"] = "Makadam report".into();
    schema["description"] = "What report.json of a qualification or a comparison holds. Units are SI.".into();
    schema
}
