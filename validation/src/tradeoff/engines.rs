//! Engines that stand beside the codes: their runs are made elsewhere, kept with the scene, and shown with the codes' own.
//!
//! An engine is recorded in two files, `NAME.csv` with one row a run and `NAME.json` that tells where they came from, in a
//! folder below `tradeoff` beside the scene.

use super::campaign::Outcome;
use super::configuration::{Configuration, Knobs};
use super::kept::KeptRun;
use super::plan::Plan;
use crate::compare::MeasuredRun;
use crate::observables::Measurement;
use crate::output::{WriteError, create_folder, write_whole};
use crate::plan::{Scene, physics_hash};
use crate::provenance::Build;
use serde::{Deserialize, Serialize};
use std::path::{Path, PathBuf};

/// Engines that are looked for beside a scene, by the name of their files.
const ENGINES: [&str; 2] = ["rapier", "siconos"];

/// The columns before the observables.
const COLUMNS: [&str; 8] = [
    "setting",
    "short_setting",
    "time_step",
    "seed",
    "wall_seconds_per_simulated_second",
    "core_share",
    "simulated_seconds",
    "date",
];

/// Where an engine's runs came from.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct EngineOrigin {
    /// Name of the engine.
    pub code: String,
    /// Crate or package and its version.
    pub engine: String,
    /// What is common to all settings, in words.
    pub common: String,
    /// Name of the scene.
    pub scene: String,
    /// Hash of what the engine was given of the scene ([`physics_hash`]).
    pub scene_hash: String,
    /// When the last run ended, ISO 8601.
    pub date: String,
    /// The command line.
    pub command: String,
    /// How the program that drove the engine was built, and the machine.
    #[serde(flatten)]
    pub build: Build,
}

/// Runs of an engine.
#[derive(Clone, Debug, PartialEq)]
pub struct EngineRecord {
    /// Where they came from.
    pub origin: EngineOrigin,
    /// The runs, setting by setting. Wall times are those of a core of the run's own.
    pub runs: Vec<KeptRun>,
}

/// Why a record could not be read.
#[derive(Debug, thiserror::Error)]
#[error("{}: {problem}; restore the file, or delete it to leave the engine out", file.display())]
pub struct EngineError {
    /// The file.
    pub file: PathBuf,
    /// What is wrong, in words.
    pub problem: String,
}

impl EngineRecord {
    /// Writes `NAME.csv` and `NAME.json`; observables are the columns that `observables` names.
    ///
    /// # Errors
    /// [`WriteError`] if a file cannot be written.
    pub fn save(&self, folder: &Path, name: &str, observables: &[String]) -> Result<(), WriteError> {
        create_folder(folder)?;
        let table = folder.join(format!("{name}.csv"));
        let origin = folder.join(format!("{name}.json"));
        let text = serde_json::to_vec_pretty(&self.origin).map_err(|error| WriteError::new(&origin, error.into()))?;
        let rows = self.rows(observables).map_err(|error| WriteError::new(&table, error.into()))?;
        // The origin first: a table without it could not be gone on with, and an origin alone holds no run.
        write_whole(&origin, &text)?;
        write_whole(&table, &rows)
    }

    fn rows(&self, observables: &[String]) -> Result<Vec<u8>, csv::Error> {
        let mut writer = csv::Writer::from_writer(Vec::new());
        writer.write_record(COLUMNS.iter().copied().chain(observables.iter().map(String::as_str)))?;
        for kept in &self.runs {
            let knobs = &kept.configuration;
            let number = |value: Option<f64>| value.map_or(String::new(), |value| value.to_string());
            let mut row = vec![
                knobs.setting(),
                knobs.short_setting(),
                kept.run.time_step.to_string(),
                kept.run.seed.to_string(),
                kept.pace().to_string(),
                number(kept.core_share),
                kept.run.simulated_seconds.to_string(),
                kept.run.date.clone(),
            ];
            row.extend(observables.iter().map(|name| number(kept.run.value(name))));
            writer.write_record(&row)?;
        }
        writer.into_inner().map_err(|error| error.into_error().into())
    }

    /// Reads what [`save`](EngineRecord::save) wrote.
    ///
    /// # Errors
    /// [`EngineError`] if a file cannot be read or is not a record.
    pub fn load(folder: &Path, name: &str) -> Result<EngineRecord, EngineError> {
        let file = folder.join(format!("{name}.json"));
        let fault = |file: &Path, problem: String| EngineError { file: file.into(), problem };
        let bytes = std::fs::read(&file).map_err(|error| fault(&file, error.to_string()))?;
        let origin: EngineOrigin =
            serde_json::from_slice(&bytes).map_err(|error| fault(&file, format!("not an origin: {error}")))?;
        let file = folder.join(format!("{name}.csv"));
        let bytes = std::fs::read(&file).map_err(|error| fault(&file, error.to_string()))?;
        let runs = read_rows(&bytes, &origin).map_err(|problem| fault(&file, problem))?;
        Ok(EngineRecord { origin, runs })
    }

    /// Adds the runs of this record to a campaign's, for the seeds that it has, and notes where they came from. Refused in
    /// a note where the scene has changed since.
    ///
    /// An engine's grains are rigid: they stand at the largest stiffness of the plan.
    pub fn join(&self, scene: &Scene, seeds: u64, plan: &mut Plan, outcome: &mut Outcome) {
        let EngineOrigin { code, engine, date, command, build, .. } = &self.origin;
        if self.origin.scene_hash != physics_hash(scene) {
            outcome.notes.push(format!(
                "{code} is left out: its runs of {date} are of another version of this scene; make them again with `{command}`."
            ));
            return;
        }
        let stiffest = plan.refinements.iter().map(|refinement| refinement.stiffness_factor).fold(1.0, f64::max);
        for kept in self.runs.iter().filter(|kept| (1..=seeds).contains(&kept.run.seed)) {
            let configuration = Configuration { stiffness_factor: stiffest, ..kept.configuration.clone() };
            let known = plan.configurations.iter().position(|other| *other == configuration);
            let place = known.unwrap_or_else(|| {
                plan.configurations.push(configuration);
                outcome.runs.push(Vec::new());
                outcome.runs.len() - 1
            });
            outcome.runs[place].push(kept.clone());
        }
        outcome.notes.push(format!(
            "{code} ({engine}) is from another run than the codes, of {date} on {} with {}: `{command}`. Its grains are \
             rigid; they are compared with the stiffest reference.",
            build.processor, build.compiler
        ));
    }
}

/// Records of engines on a scene that were made on a processor of this model.
///
/// # Errors
/// [`EngineError`] if one cannot be read.
pub fn recorded_engines(scene_file: &Path, processor: &str) -> Result<Vec<EngineRecord>, EngineError> {
    let root = scene_file.parent().unwrap_or(Path::new(".")).join("tradeoff");
    let Ok(entries) = std::fs::read_dir(&root) else { return Ok(Vec::new()) };
    let mut folders: Vec<PathBuf> = entries.filter_map(|entry| Some(entry.ok()?.path())).collect();
    folders.sort();
    let mut records = Vec::new();
    for folder in folders {
        for name in ENGINES.iter().filter(|name| folder.join(format!("{name}.csv")).is_file()) {
            records.push(EngineRecord::load(&folder, name)?);
        }
    }
    records.retain(|record| record.origin.build.processor == processor);
    Ok(records)
}

/// Runs from rows; any bytes are either runs or an error.
fn read_rows(bytes: &[u8], origin: &EngineOrigin) -> Result<Vec<KeptRun>, String> {
    let mut reader = csv::Reader::from_reader(bytes);
    let head = reader.headers().map_err(|error| error.to_string())?.clone();
    if !head.iter().take(COLUMNS.len()).eq(COLUMNS) {
        return Err(format!("line 1: the columns do not begin with {}", COLUMNS.join(",")));
    }
    let observables: Vec<&str> = head.iter().skip(COLUMNS.len()).collect();
    let mut runs = Vec::new();
    for (row, record) in reader.records().enumerate() {
        let record = record.map_err(|error| error.to_string())?;
        runs.push(read_row(&record, &observables, origin).map_err(|problem| format!("line {}: {problem}", row + 2))?);
    }
    match runs.is_empty() {
        true => Err("it holds no run".into()),
        false => Ok(runs),
    }
}

fn read_row(record: &csv::StringRecord, observables: &[&str], origin: &EngineOrigin) -> Result<KeptRun, String> {
    let text = |column: usize| record.get(column).unwrap_or_default();
    let number = |column: usize, name: &str| match text(column).parse::<f64>() {
        Ok(value) if value.is_finite() => Ok(value),
        _ => Err(format!("'{}' is no number for {name}", text(column))),
    };
    let positive = |column: usize| match number(column, COLUMNS[column])? {
        value if value > 0.0 => Ok(value),
        value => Err(format!("{} must be positive, not {value}", COLUMNS[column])),
    };
    let (time_step, pace, simulated_seconds) = (positive(2)?, positive(4)?, positive(6)?);
    let mut measurements = Vec::new();
    for (place, name) in observables.iter().enumerate() {
        let column = COLUMNS.len() + place;
        // An observable that a run does not have is left empty.
        if !text(column).is_empty() {
            let value = number(column, name)?;
            measurements.push(Measurement {
                observable: (*name).into(),
                unit: String::new(),
                value,
                standard_error: None,
                frames: 1,
            });
        }
    }
    let core_share = if text(5).is_empty() { None } else { Some(positive(5)?) };
    Ok(KeptRun {
        configuration: Configuration {
            code: origin.code.clone(),
            stiffness_factor: 1.0,
            knobs: Knobs::Engine { step: time_step, setting: text(0).into(), short_setting: text(1).into() },
        },
        extrapolated: false,
        core_share,
        run: MeasuredRun {
            code: origin.code.clone(),
            version: origin.engine.clone(),
            contact_law: String::new(),
            seed: text(3).parse().map_err(|_| format!("'{}' is no seed", text(3)))?,
            time_step,
            rayleigh_fraction: None,
            wall_seconds: pace * simulated_seconds / core_share.unwrap_or(1.0),
            core_seconds: None,
            simulated_seconds,
            processor: origin.build.processor.clone(),
            date: text(7).into(),
            scene_hash: origin.scene_hash.clone(),
            measurements,
        },
        build: origin.build.clone(),
        command: origin.command.clone(),
    })
}
