//! Report of a qualification: one self-contained page, and the same as data.
//!
//! ```text
//! Qualification ─> verdict ─┐
//! Comparison ─> tables      ├─> page ──> report.html
//!            ─> figures     │   ──────> report.json, tests.json, rows.csv
//!            ─> pictures    │   ──────> series.csv, forces.csv, grains.csv
//! StudySection ─> table     ┘   ──────> the files of each study
//! ```
//!
//! The page loads nothing, runs no script, follows light and dark, and prints. Its tables and figures compute no verdict of their own.

mod baseline;
mod bias;
mod figures;
mod page;
mod qualification;
mod tables;

pub use baseline::{Changes, Test, TestVerdict, tests};
use makadam_compare::compare::{Comparison, Row};
use makadam_compare::scenes;
use makadam_compare::study::{Cell, DocumentError, File, Table, cells, write_together};
use makadam_measure::statistics::Outcome;
use nalgebra::Vector3;
pub use qualification::{Qualification, Standing, StudyOutcome, StudySection, StudyTest, Verdict};
use schemars::JsonSchema;
use schemars::generate::SchemaSettings;
use serde::{Deserialize, Serialize};
use serde_json::Value;
use std::path::{Path, PathBuf};
pub use tables::comparison_table;
use tables::source_word;

/// Version of the layout of `report.json`; raised whenever a field changes its name or meaning, or goes.
pub const REPORT_VERSION: u32 = 2;

/// Content of `report.json`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct ReportDocument {
    /// [`REPORT_VERSION`] at the time of writing.
    pub version: u32,
    /// The verdict.
    pub verdict: Verdict,
    /// All that it follows from.
    pub qualification: Qualification,
}

/// Writes `report.html`, `report.json`, `tests.json`, `rows.csv`, the CSV files that the figures link to and the files
/// of studies into a folder, creating it if missing, and returns the path of the page.
///
/// All of them are complete on disk under temporary names before the first is renamed: an earlier report stays intact if this one fails.
///
/// # Errors
/// [`DocumentError`] if a file cannot be written.
pub fn write(qualification: &Qualification, folder: &Path) -> Result<PathBuf, DocumentError> {
    let document = ReportDocument {
        version: REPORT_VERSION,
        verdict: qualification.verdict(),
        qualification: qualification.clone(),
    };
    let mut files = vec![
        ("report.html".to_string(), page::render(qualification)?.into_bytes()),
        ("report.json".to_string(), serde_json::to_vec(&document)?),
        ("tests.json".to_string(), baseline::tests_json(qualification)?.into_bytes()),
    ];
    files.extend(files_of(qualification)?);
    files.extend(qualification.studies.iter().flat_map(|study| study.files.clone()));
    write_together(folder, &files)?;
    Ok(folder.join("report.html"))
}

/// Rows of a file for one scene.
type Rows = fn(&Comparison) -> Vec<Vec<Cell>>;

/// Files with their columns: the rows of all tables, and the numbers drawn in figures and pictures.
const FILES: [(&str, &str, Rows); 4] = [
    (
        "rows",
        "scene observable unit code source mean standard_deviation seeds reference_code difference interval90_low \
         interval90_high verdict_low verdict_high margin outcome seeds_needed missing",
        rows,
    ),
    ("series", "scene observable code seed time_s value", over_time),
    ("forces", "scene code force_over_mean density density_low density_high", distributions),
    ("grains", "scene code seed time_s grain x_m y_m z_m radius_m speed_m_s", grains),
];

/// Returns all files, with the scenes one below the other; a file without rows has its head alone.
fn files_of(qualification: &Qualification) -> Result<Vec<File>, DocumentError> {
    let file = |(name, columns, rows): (&str, &str, Rows)| {
        let rows = qualification.comparisons.iter().flat_map(rows);
        Table::named(columns).of(rows, |row| row).csv(name)
    };
    let bias = Table::named("observable scene reference_code ratio bias standard_error scatter scatter_of_references");
    let biases = bias.of(bias::rows(&qualification.comparisons), |row| row).csv("bias");
    FILES.into_iter().map(file).chain([biases]).collect()
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

/// Curves of observables over time.
fn over_time(comparison: &Comparison) -> Vec<Vec<Cell>> {
    let mut rows = Vec::new();
    for curve in figures::observables(comparison).into_iter().flat_map(|name| figures::curves(comparison, name)) {
        let run = curve.series;
        let row = |&[time, value]: &[f64; 2]| {
            cells![&comparison.scene.name, &run.observable, &run.code, run.seed, time, value]
        };
        rows.extend(curve.points.iter().map(row));
    }
    rows
}

/// Distributions of normal forces with their counting errors, and the curve of the literature.
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

/// Grains of the pictures: position, size, and the speed that sets their shade.
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
