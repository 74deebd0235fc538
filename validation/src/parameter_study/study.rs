//! What is varied, the runs, and their means.

use crate::compare::Announce;
use crate::observables::{Measurement, measure};
use crate::output::{WriteError, file_stem};
use crate::peers::{Code, CodeError, Job, Makadam, Purpose};
use crate::plan::Scene;
use crate::provenance::{Build, scene_hash};
use crate::recording::Noticed;
use crate::scenes::{self, Change, ChangeError, SceneError};
use crate::statistics::Ensemble;
use crate::study::{Key, RunCache};
use makadam::BUILD;
use rayon::prelude::*;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use std::path::Path;
use std::str::FromStr;
use std::time::Duration;
use toml_edit::Value;

/// Most combinations of one study.
const MOST_POINTS: usize = 10_000;

/// A key and the values that it takes.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Range {
    /// The key, such as `material.grain.friction`.
    pub key: String,
    /// Its values, in the notation of TOML.
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
            // Words without quotes.
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

/// Why a study was not made.
#[derive(Debug, thiserror::Error)]
pub enum ParameterError {
    /// A key leads nowhere.
    #[error("--over {0}")]
    Change(#[from] ChangeError),
    /// A key that cannot be varied here.
    #[error("--over {key}: {problem}")]
    Key {
        /// The key.
        key: String,
        /// Why, and what would be right.
        problem: &'static str,
    },
    /// A scene with these values is refused.
    #[error("{values}: {error}")]
    Scene {
        /// The values.
        values: String,
        /// Why.
        error: Box<SceneError>,
    },
    /// There are too many combinations.
    #[error("{0} combinations are too many; the most are {MOST_POINTS}")]
    TooMany(usize),
    /// A run failed.
    #[error("{values}, seed {seed}: {error}")]
    Run {
        /// The values.
        values: String,
        /// The seed.
        seed: u64,
        /// Why.
        error: Box<CodeError>,
    },
    /// The output folder holds another study, or another process writes there.
    #[error("{0}")]
    Folder(String),
    /// A run cannot be kept.
    #[error(transparent)]
    Write(#[from] WriteError),
    /// The user asked to stop.
    #[error("interrupted")]
    Interrupted,
}

/// What is to be run.
pub struct Plan<'a> {
    /// The scene's file; what it says is read once.
    pub file: &'a Path,
    /// Keys with their values; every combination is run.
    pub ranges: &'a [Range],
    /// Seeds of each combination.
    pub seeds: &'a [u64],
    /// Folder that finished runs are kept in.
    pub folder: &'a Path,
    /// Whether runs that are kept are made again.
    pub again: bool,
    /// Opens progress displays.
    pub announce: Announce<'a>,
}

/// One run, measured.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Run {
    /// Seed of the initial positions.
    pub seed: u64,
    /// Wall time of the stepping, s.
    pub wall_seconds: f64,
    /// What was measured.
    pub measurements: Vec<Measurement>,
    /// What a watchdog noticed on the way.
    pub alarms: Vec<Noticed>,
}

/// A run that came to no end.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Failed {
    /// Values, in the order of the keys.
    pub values: Vec<String>,
    /// Seed of the initial positions.
    pub seed: u64,
    /// Why.
    pub problem: String,
}

/// A combination of values, over its seeds.
#[derive(Clone, Debug, Serialize)]
pub struct Point {
    /// Values, in the order of the keys.
    pub values: Vec<String>,
    /// Mean and standard deviation over seeds, by observable; what some seeds have no value of is over the others.
    pub observables: BTreeMap<String, Ensemble>,
    /// The runs.
    pub runs: Vec<Run>,
}

/// All combinations.
#[derive(Clone, Debug, Serialize)]
pub struct Study {
    /// Version of this document.
    pub version: u32,
    /// Always "sweep".
    pub command: &'static str,
    /// Name of the scene.
    pub scene: String,
    /// The keys.
    pub keys: Vec<String>,
    /// Units, by observable.
    pub units: BTreeMap<String, String>,
    /// One a combination.
    pub points: Vec<Point>,
    /// Runs that came to no end; the means are over the others.
    pub failed: Vec<Failed>,
    /// Where the numbers came from, by name.
    pub provenance: BTreeMap<String, String>,
}

/// A scene with its values, ready to run.
struct Prepared {
    values: Vec<String>,
    label: String,
    scene: Scene,
}

impl Study {
    /// Runs what is not kept yet, as many runs at a time as the thread pool has threads. A run that comes to no end is listed as such,
    /// and the others go on.
    ///
    /// # Errors
    /// [`ParameterError`]: before anything runs if a combination is refused; afterwards, if runs cannot be kept or the user asks to stop:
    /// what ran is kept.
    pub fn make(plan: &Plan<'_>, scene: &Scene, provenance: BTreeMap<String, String>) -> Result<Study, ParameterError> {
        let points = prepare(plan)?;
        let cache = RunCache::open(&plan.folder.join("runs"))?;
        let jobs: Vec<(&Prepared, u64)> =
            points.iter().flat_map(|point| plan.seeds.iter().map(move |&seed| (point, seed))).collect();
        let ended = jobs.par_iter().map(|(point, seed)| match run(plan, &cache, point, *seed) {
            Ok(run) => Ok(Ok(run)),
            Err(ParameterError::Run { error, .. }) => {
                Ok(Err(Failed { values: point.values.clone(), seed: *seed, problem: error.to_string() }))
            }
            Err(error) => Err(error),
        });
        let ended = ended.collect::<Result<Vec<Result<Run, Failed>>, ParameterError>>()?;
        let failed = ended.iter().filter_map(|ended| ended.as_ref().err()).cloned().collect();
        let runs: Vec<&Run> = ended.iter().flatten().collect();
        let mut units = BTreeMap::new();
        for measurement in runs.iter().flat_map(|run| &run.measurements) {
            units.insert(measurement.observable.clone(), measurement.unit.clone());
        }
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
        })
    }
}

/// Every combination, read and checked.
fn prepare(plan: &Plan<'_>) -> Result<Vec<Prepared>, ParameterError> {
    let refuse = |range: &Range, problem| Err(ParameterError::Key { key: range.key.clone(), problem });
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
        return Err(ParameterError::TooMany(number));
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
        let label = changes.iter().map(ToString::to_string).collect::<Vec<_>>().join(", ");
        let changed = scenes::changed(&text, &changes)?;
        let scene = scenes::parse(&changed, plan.file).map_err(|error| refused(&label, error))?;
        points.push(Prepared { values, label, scene });
    }
    Ok(points)
}

fn run(plan: &Plan<'_>, cache: &RunCache, point: &Prepared, seed: u64) -> Result<Run, ParameterError> {
    let hash = format!("{:016x}", scene_hash(&point.scene));
    // What is watched for decides on how a run ends, and the judge on what is measured.
    let watch = serde_json::to_string(&point.scene.watch).expect("a watch holds numbers and words");
    let parts = [&hash, &seed.to_string(), BUILD, &Build::here().summary(), &watch];
    let key = Key::new(format!("{}-s{seed}", file_stem(&point.scene.name)), &parts).apart();
    cache.take(&key, plan.again, || {
        if crate::interrupt::requested() {
            return Err(ParameterError::Interrupted);
        }
        let progress = (plan.announce)(&format!("{}, seed {seed}", point.label));
        let recorded = Makadam.simulate(&Job {
            scene: &point.scene,
            scene_file: plan.file,
            purpose: Purpose::Measuring,
            seed,
            stiffness_factor: 1.0,
            rayleigh_fraction: 1.0,
            work_folder: plan.folder,
            time_limit: Duration::MAX,
            progress: &*progress,
        });
        let recording = recorded.map_err(|error| match error {
            CodeError::Interrupted { .. } => ParameterError::Interrupted,
            error => ParameterError::Run { values: point.label.clone(), seed, error: Box::new(error) },
        })?;
        let measurements = measure(&point.scene, &recording);
        Ok(Run { seed, wall_seconds: recording.wall_seconds, measurements, alarms: recording.alarms })
    })
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
#[path = "../../tests/unit/parameter_study_study.rs"]
mod tests;
