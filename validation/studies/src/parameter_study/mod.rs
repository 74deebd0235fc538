//! Scene with several values for some of its keys: every combination, several seeds each, one table.
//!
//! ```text
//! --over KEY=a,b,c ─> points (combinations) x seeds ─> runs in parallel, stored ─> means over seeds ─> report, CSV, JSON
//! ```

mod report;

use makadam_compare::codes::Makadam;
use makadam_compare::compare::{Announce, Harvest, Runs};
use makadam_compare::scenes::{self, Change, SceneError};
use makadam_compare::study::{RunCache, RunError, run_jobs};
use makadam_frames::plan::MeasuredScene;
use makadam_frames::recording::Noticed;
use makadam_measure::observables::Measurement;
use makadam_measure::statistics::Ensemble;
use serde::Serialize;
use std::collections::BTreeMap;
use std::path::Path;
use std::str::FromStr;
use std::time::Duration;
use toml_edit::Value;

/// Most combinations of one study.
const MOST_POINTS: usize = 10_000;

/// Key and its values.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Range {
    /// Key, such as `material.grain.friction`.
    pub key: String,
    /// Values, in the notation of TOML.
    pub values: Vec<String>,
}

impl FromStr for Range {
    type Err = String;

    /// Reads `KEY=a,b,c`; values may be lists or tables of their own.
    fn from_str(text: &str) -> Result<Range, String> {
        let form = "give KEY=a,b,c, such as material.grain.friction=0.1,0.3,0.5";
        let (key, values) = text.split_once('=').ok_or(form)?;
        let (key, values) = (key.trim(), values.trim());
        if key.is_empty() || values.is_empty() {
            return Err(form.into());
        }
        let values: Vec<String> = match format!("[{values}]").parse::<Value>() {
            Ok(Value::Array(list)) => list.iter().map(|value| value.to_string().trim().to_string()).collect(),
            // Text without quotes.
            _ => values.split(',').map(|value| value.trim().to_string()).collect(),
        };
        let same = |one: &String, other: &String| match (one.parse::<f64>(), other.parse::<f64>()) {
            (Ok(one), Ok(other)) => one == other,
            _ => one == other,
        };
        let known = |place: usize| values[..place].iter().any(|value| same(value, &values[place]));
        if let Some(place) = (1..values.len()).find(|&place| known(place)) {
            return Err(format!("{key}: {} is given twice", values[place]));
        }
        Ok(Range { key: key.into(), values })
    }
}

/// Error that ended a study.
#[derive(Debug, thiserror::Error)]
pub enum ParameterError {
    /// The keys cannot be varied.
    #[error("{0}")]
    Usage(String),
    /// A scene with these values is invalid.
    #[error("{values}: {error}")]
    Scene {
        /// Values as given.
        values: String,
        /// Reason.
        error: Box<SceneError>,
    },
    /// A run cannot be stored, or the user asked to stop.
    #[error(transparent)]
    Run(#[from] RunError),
}

/// Runs of a study.
pub struct Plan<'a> {
    /// File of the scene, which is read once.
    pub file: &'a Path,
    /// Keys with their values; every combination is run, the scene itself without keys.
    pub ranges: &'a [Range],
    /// Seeds of each combination.
    pub seeds: &'a [u64],
    /// Folder of the study and of its stored runs.
    pub folder: &'a Path,
    /// True if stored runs are repeated.
    pub again: bool,
    /// Opens progress displays.
    pub announce: Announce<'a>,
}

/// Measurements of one run.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[expect(missing_docs, reason = "validation/docs/json.md describes the fields of documents")]
pub struct Run {
    pub seed: u64,
    /// Wall time of the stepping, s.
    pub wall_seconds: f64,
    pub measurements: Vec<Measurement>,
    /// Violations that a watchdog found.
    pub alarms: Vec<Noticed>,
    /// Requested observables without a value, with the reason.
    pub without_value: BTreeMap<String, String>,
}

/// A run that failed.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[expect(missing_docs, reason = "validation/docs/json.md describes the fields of documents")]
pub struct Failed {
    /// Values, in the order of the keys.
    pub values: Vec<String>,
    pub seed: u64,
    pub problem: String,
}

/// A combination of values, over its seeds.
#[derive(Clone, Debug, Serialize)]
#[expect(missing_docs, reason = "validation/docs/json.md describes the fields of documents")]
pub struct Point {
    /// Values, in the order of the keys.
    pub values: Vec<String>,
    /// Mean and standard deviation by observable, over the seeds that have a value.
    pub observables: BTreeMap<String, Ensemble>,
    pub runs: Vec<Run>,
}

/// Content of `sweep.json`.
#[derive(Clone, Debug, Serialize)]
#[expect(missing_docs, reason = "validation/docs/json.md describes the fields of documents")]
pub struct Study {
    pub version: u32,
    pub command: &'static str,
    pub scene: String,
    /// Keys of the scene that vary.
    pub keys: Vec<String>,
    /// Units, by observable.
    pub units: BTreeMap<String, String>,
    /// Combinations.
    pub points: Vec<Point>,
    /// Runs that failed; the means are over the others.
    pub failed: Vec<Failed>,
    pub provenance: BTreeMap<String, String>,
    /// Observables of the report; all if empty.
    #[serde(skip)]
    pub shown: Vec<String>,
}

/// Returns the name of a run: its values and its seed.
pub fn run_name(values: &[String], seed: u64) -> String {
    let seed = format!("seed {seed}");
    values.iter().chain([&seed]).map(String::as_str).collect::<Vec<_>>().join(", ")
}

/// Scene with its values, ready to run.
struct Prepared {
    values: Vec<String>,
    label: String,
    scene: MeasuredScene,
}

impl Study {
    /// Runs all combinations that are not stored yet. Failed runs are listed.
    ///
    /// # Errors
    /// [`ParameterError`]: before any run if a combination is refused; later if runs cannot be stored or the user asks to stop.
    pub fn make(
        plan: &Plan<'_>,
        scene: &MeasuredScene,
        provenance: BTreeMap<String, String>,
        shown: Vec<String>,
    ) -> Result<Study, ParameterError> {
        let points = prepare(plan)?;
        let cache = RunCache::open(&plan.folder.join("runs"), plan.again).map_err(RunError::from)?;
        let jobs: Vec<(&Prepared, u64)> =
            points.iter().flat_map(|point| plan.seeds.iter().map(move |&seed| (point, seed))).collect();
        let work = |(point, _): &(&Prepared, u64)| {
            point.scene.grain_count() as f64 * point.scene.duration / point.scene.solver.step
        };
        let ended = run_jobs(&jobs, work, &|_| {}, |&(point, seed), _| match run(plan, &cache, point, seed) {
            Err(error) if error.ends_all() => Err(error),
            Err(error) => Ok(Err(Failed { values: point.values.clone(), seed, problem: error.to_string() })),
            Ok(run) => Ok(Ok(run)),
        })?;
        let failed = ended.iter().filter_map(|ended| ended.as_ref().err()).cloned().collect();
        let measurements = ended.iter().flatten().flat_map(|run| &run.measurements);
        let units = measurements.map(|measured| (measured.observable.clone(), measured.unit.clone())).collect();
        let mut ended = ended.into_iter();
        let points = points.into_iter().map(|point| {
            let own: Vec<Run> = ended.by_ref().take(plan.seeds.len()).flatten().collect();
            Point { values: point.values, observables: means(&own), runs: own }
        });
        Ok(Study {
            version: 1,
            command: "sweep",
            scene: scene.name.clone(),
            keys: plan.ranges.iter().map(|range| range.key.clone()).collect(),
            units,
            points: points.collect(),
            failed,
            provenance,
            shown,
        })
    }
}

/// Reads and checks every combination.
fn prepare(plan: &Plan<'_>) -> Result<Vec<Prepared>, ParameterError> {
    let refuse = |range: &Range, problem| Err(ParameterError::Usage(format!("--over {}: {problem}", range.key)));
    for (place, range) in plan.ranges.iter().enumerate() {
        if scenes::key_of(&range.key) == ["seed"] {
            return refuse(range, "--seeds varies the seed, from the scene's on (--set seed=N)");
        }
        if plan.ranges[..place].iter().any(|other| scenes::key_of(&other.key) == scenes::key_of(&range.key)) {
            return refuse(range, "it is given twice; give all its values at once");
        }
    }
    let number: usize = plan.ranges.iter().map(|range| range.values.len()).product();
    if number > MOST_POINTS {
        return Err(ParameterError::Usage(format!("{number} combinations are too many; the most are {MOST_POINTS}")));
    }
    let refused = |values: &str, error| ParameterError::Scene { values: values.into(), error: Box::new(error) };
    let text = scenes::text(plan.file).map_err(|error| refused("the scene", error))?;
    let mut points = Vec::with_capacity(number);
    for mut place in 0..number {
        // The last key varies fastest.
        let mut values = vec![String::new(); plan.ranges.len()];
        for (range, value) in plan.ranges.iter().zip(&mut values).rev() {
            *value = range.values[place % range.values.len()].clone();
            place /= range.values.len();
        }
        let pairs = plan.ranges.iter().zip(&values);
        let changes: Vec<Change> =
            pairs.map(|(range, value)| Change::new(&scenes::key_of(&range.key), value)).collect();
        let mut label = changes.iter().map(ToString::to_string).collect::<Vec<_>>().join(", ");
        let changed = scenes::changed(&text, &scenes::folder(plan.file), &changes)
            .map_err(|error| ParameterError::Usage(format!("--over {error}")))?;
        let scene = scenes::parse(&changed, plan.file).map_err(|error| refused(&label, error))?;
        if label.is_empty() {
            label.clone_from(&scene.name);
        }
        points.push(Prepared { values, label, scene });
    }
    Ok(points)
}

fn run(plan: &Plan<'_>, cache: &RunCache, point: &Prepared, seed: u64) -> Result<Run, RunError> {
    let announce = |_: &str| (plan.announce)(&format!("{}, seed {seed}", point.label));
    let runs = Runs::of_one_seed(&point.scene, plan.file, seed, Duration::MAX, &announce);
    let Harvest { run, alarms, without_value, .. } = runs.take(cache, &Makadam, seed)?;
    let without_value = without_value.into_iter().collect();
    Ok(Run { seed, wall_seconds: run.wall_seconds, measurements: run.measurements, alarms, without_value })
}

/// Mean and spread over runs, by observable.
fn means(runs: &[Run]) -> BTreeMap<String, Ensemble> {
    let mut values: BTreeMap<&str, Vec<f64>> = BTreeMap::new();
    for measurement in runs.iter().flat_map(|run| &run.measurements).filter(|one| one.value.is_finite()) {
        values.entry(&measurement.observable).or_default().push(measurement.value);
    }
    let named = values.into_iter().filter_map(|(name, values)| Some((name.to_string(), Ensemble::of(&values)?)));
    named.collect()
}

#[cfg(test)]
#[path = "../../tests/unit/parameter_study.rs"]
mod tests;
