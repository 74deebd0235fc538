//! Shared arguments of commands, and parsers of their values.

use super::{Failure, beforehand};
use clap::Args;
use clap::builder::{PossibleValuesParser, TypedValueParser};
use makadam::scene::{Accuracy, suggestion};
use makadam_compare::scenes::{self, Change};
use makadam_frames::output::file_stem;
use makadam_frames::plan::{MeasuredScene, observable_name};
use makadam_measure::observables::catalogue;
use makadam_studies::tradeoff::Bound;
use std::path::PathBuf;

/// Scene of a command.
#[derive(Debug, Args)]
pub(super) struct SourceArguments {
    /// Path to a TOML file, name of a scene (see `makadam print scenes`), or - for standard input.
    #[arg(value_name = "SCENE")]
    pub scene: String,
    /// Replace a value of the scene, such as material.grain.friction=0.3 or wall.shell.motion.rate=2; can be given several times.
    #[arg(long = "set", value_name = "KEY=VALUE")]
    pub changes: Vec<Change>,
}

impl SourceArguments {
    /// Returns file and scene, see [`load`].
    pub fn load(&self) -> Result<(PathBuf, MeasuredScene), Failure> {
        load(&self.scene, &self.changes)
    }
}

/// Scene of a command, and its initial positions.
#[derive(Debug, Args)]
pub(super) struct SceneArguments {
    #[command(flatten)]
    pub source: SourceArguments,
    /// Seed of the initial positions, the first seed if --seeds takes several; if absent, the scene's.
    #[arg(long)]
    pub seed: Option<u64>,
}

impl SceneArguments {
    /// Returns file, scene and seed, see [`load`].
    pub fn load(&self) -> Result<(PathBuf, MeasuredScene, u64), Failure> {
        let (file, scene) = self.source.load()?;
        let seed = self.seed.unwrap_or(scene.seed);
        Ok((file, scene, seed))
    }
}

/// Finds, reads, changes and checks a scene, which must fit into memory.
pub(super) fn load(name: &str, changes: &[Change]) -> Result<(PathBuf, MeasuredScene), Failure> {
    let file = scenes::take(name, &scenes::roots(), changes)?;
    let scene = scenes::load(&file)?;
    beforehand::refuse_beyond_memory(&scene, &file)?;
    Ok((file, scene))
}

/// Destination of the results of a command.
#[derive(Debug, Args)]
pub(super) struct OutputArguments {
    /// Folder to write to; studies reuse their finished runs there. If absent, a folder under results/, named after command
    /// and scene.
    #[arg(short, long)]
    pub output: Option<PathBuf>,
    /// Print the results as JSON.
    #[arg(long)]
    pub json: bool,
}

impl OutputArguments {
    /// Returns the given folder, or one below `results`.
    pub fn folder(&self, default: &str) -> PathBuf {
        self.output.clone().unwrap_or_else(|| PathBuf::from("results").join(default))
    }

    /// Returns the folder of a study of a scene.
    pub fn folder_of(&self, command: &str, scene: &MeasuredScene) -> PathBuf {
        self.folder(&format!("{command}/{}", file_stem(&scene.name)))
    }
}

/// Number of concurrent runs of a command.
#[derive(Debug, Args)]
pub(super) struct JobArguments {
    /// Number of runs at the same time, each on one thread; if absent, the number of cores.
    #[arg(short, long, value_parser = clap::value_parser!(u16).range(1..=1024))]
    pub jobs: Option<u16>,
}

impl JobArguments {
    /// Limits the thread pool to this number.
    pub fn apply(&self) -> Result<(), Failure> {
        let Some(jobs) = self.jobs else { return Ok(()) };
        let pool = rayon::ThreadPoolBuilder::new().num_threads(usize::from(jobs)).build_global();
        pool.map_err(|error| Failure::Running(format!("cannot start {jobs} runs at the same time: {error}")))
    }
}

/// Runs and results of a study with stored runs.
#[derive(Debug, Args)]
pub(super) struct StudyArguments {
    /// Start again: repeat runs whose results are stored, and replace the tables of an earlier study in the folder.
    #[arg(long)]
    pub restart: bool,
    #[command(flatten)]
    pub jobs: JobArguments,
    #[command(flatten)]
    pub output: OutputArguments,
}

/// Parses the name of a value in a list.
pub(super) fn one_of<T: Copy + Send + Sync + 'static, const N: usize>(
    all: [T; N],
    name: fn(T) -> &'static str,
) -> impl TypedValueParser<Value = T> {
    let find = move |given: String| all.into_iter().find(|one| name(*one) == given).ok_or("unknown name");
    PossibleValuesParser::new(all.map(name)).try_map(find)
}

fn number(text: &str, is_accepted: fn(f64) -> bool, problem: &str) -> Result<f64, String> {
    text.trim().parse().ok().filter(|number| is_accepted(*number)).ok_or_else(|| problem.into())
}

pub(super) fn positive(text: &str) -> Result<f64, String> {
    number(text, |number| number.is_finite() && number > 0.0, "give a number above 0")
}

pub(super) fn seconds(text: &str) -> Result<f64, String> {
    number(text, |number| (0.0..=1e9).contains(&number), "give a number of seconds from 0 to 1e9")
}

pub(super) fn time_limit(text: &str) -> Result<f64, String> {
    number(text, |number| number > 0.0 && number <= 1e9, "give a number of seconds above 0 and at most 1e9")
}

pub(super) fn rayleigh_fraction(text: &str) -> Result<f64, String> {
    let problem = "give a number above 0 and at most 0.5; beyond it the reference codes lose their restitution";
    number(text, |number| number > 0.0 && number <= 0.5, problem)
}

/// Largest fraction accepted without a percent sign.
const LARGEST_BARE: f64 = 0.2;

/// Parses an accuracy: one fraction for all deviations, or deviations by name.
pub(super) fn accuracy(text: &str) -> Result<Accuracy, String> {
    let fraction = |text: &str| match text.strip_suffix('%') {
        Some(percent) => percent.trim().parse::<f64>().map(|percent| percent / 100.0),
        None => text.trim().parse::<f64>(),
    };
    let mut accuracy = Accuracy::default();
    for part in text.split(',') {
        let (name, value) = part.split_once('=').unwrap_or(("relative", part));
        let (name, value) = (name.trim(), value.trim());
        // A bare 1 may mean one percent, one degree or all.
        if name == "relative" && !value.contains('%') && fraction(value).is_ok_and(|bare| bare > LARGEST_BARE) {
            return Err(format!("{part}: a share of that size is hardly meant; write {value}% or angle={value}"));
        }
        let deviation = fraction(value).ok().filter(|value| (1e-6..=10.0).contains(value));
        let deviation =
            deviation.ok_or_else(|| format!("{part}: give a number from 1e-6 to 10, or a share such as 1%"))?;
        let entry = match name {
            "angle" => &mut accuracy.angle,
            "packing_fraction" => &mut accuracy.packing_fraction,
            "overlap" => &mut accuracy.overlap,
            "relative" => &mut accuracy.relative,
            other => return Err(format!("{other} is none of angle, packing_fraction, overlap, relative")),
        };
        if entry.replace(deviation).is_some() {
            return Err(format!("{name} is given twice"));
        }
    }
    Ok(accuracy)
}

/// Parses a tolerated deviation of an observable.
pub(super) fn bound(text: &str) -> Result<Bound, String> {
    let (name, value) = text.split_once('=').ok_or("give an observable and a value, such as packing_fraction=0.002")?;
    Ok(Bound { observable: observable(name)?, value: positive(value)? })
}

/// Parses the name of an observable.
pub(super) fn observable(text: &str) -> Result<String, String> {
    let name = observable_name(text.trim());
    match catalogue::group_of(&name) {
        Some(_) => Ok(name),
        None => Err(nothing_measures(&name)),
    }
}

/// Returns the message about an unknown name of an observable.
pub(super) fn nothing_measures(name: &str) -> String {
    let remedy = suggestion(name, catalogue::known(), "`makadam print observables` lists all names");
    format!("nothing measures '{name}'; {remedy}")
}

#[cfg(test)]
#[path = "../../tests/unit/commands_arguments.rs"]
mod tests;
