//! Arguments that commands have in common.

use super::values::{rayleigh_fraction, time_limit};
use crate::commands::{Failure, beforehand};
use crate::output::file_stem;
use crate::plan::Scene;
use crate::scenes::{self, Change};
use clap::Args;
use std::path::PathBuf;

/// The scene of a command.
#[derive(Debug, Args)]
pub struct SourceArguments {
    /// Path to a TOML file, name of a scene (see `makadam print scenes`), or - for standard input.
    #[arg(value_name = "SCENE")]
    pub scene: String,
    /// Replace a value of the scene, such as material.grain.friction=0.3 or wall.shell.motion.rate=2; can be given several times.
    #[arg(long = "set", value_name = "KEY=VALUE")]
    pub changes: Vec<Change>,
}

impl SourceArguments {
    /// File and scene: found, read and checked; the scene has to find room in memory.
    pub fn load(&self) -> Result<(PathBuf, Scene), Failure> {
        load(&self.scene, &self.changes)
    }
}

/// The scene of a command, and its initial positions.
#[derive(Debug, Args)]
pub struct SceneArguments {
    /// The scene.
    #[command(flatten)]
    pub source: SourceArguments,
    /// Seed of the initial positions, the first one where --seeds takes several; if absent, the scene's.
    #[arg(long)]
    pub seed: Option<u64>,
}

impl SceneArguments {
    /// File, scene and seed; see [`SourceArguments::load`].
    pub fn load(&self) -> Result<(PathBuf, Scene, u64), Failure> {
        let (file, scene) = self.source.load()?;
        let seed = self.seed.unwrap_or(scene.seed);
        Ok((file, scene, seed))
    }
}

/// Finds, reads and checks a scene with changes made, which has to find room in memory.
pub fn load(name: &str, changes: &[Change]) -> Result<(PathBuf, Scene), Failure> {
    let file = scenes::take(name, &scenes::roots(), changes)?;
    let scene = scenes::load(&file)?;
    beforehand::refuse_beyond_memory(&scene, &file)?;
    Ok((file, scene))
}

/// Where the results of a command go.
#[derive(Debug, Args)]
pub struct OutputArguments {
    /// Folder to write to; studies take the runs that they finished there before. If absent, one under results/, named after command
    /// and scene.
    #[arg(short, long)]
    pub output: Option<PathBuf>,
    /// Print the results as JSON.
    #[arg(long)]
    pub json: bool,
}

impl OutputArguments {
    /// The folder that was asked for, or one below `results`.
    pub fn folder(&self, default: &str) -> PathBuf {
        self.output.clone().unwrap_or_else(|| PathBuf::from("results").join(default))
    }

    /// The folder of a study of a scene.
    pub fn folder_of(&self, command: &str, scene: &Scene) -> PathBuf {
        self.folder(&format!("{command}/{}", file_stem(&scene.name)))
    }
}

/// Number of runs of a command that go at the same time.
#[derive(Debug, Args)]
pub struct JobArguments {
    /// Number of runs at the same time, each on one thread; if absent, the number of cores.
    #[arg(short, long, value_parser = clap::value_parser!(u16).range(1..=1024))]
    pub jobs: Option<u16>,
}

impl JobArguments {
    /// Limits the runs at the same time to that number.
    pub fn apply(&self) -> Result<(), Failure> {
        let Some(jobs) = self.jobs else { return Ok(()) };
        let pool = rayon::ThreadPoolBuilder::new().num_threads(usize::from(jobs)).build_global();
        pool.map_err(|error| Failure::Running(format!("cannot start {jobs} runs at the same time: {error}")))
    }
}

/// How the codes of a comparison are run, and what is told of it.
#[derive(Debug, Args)]
pub struct CodeRunArguments {
    /// Number of seeds, counted from 1; if absent, those that the scene registers (measure.seeds), or as many as are recorded, or 3.
    /// Seeds that are not registered are exploratory: exit code 4.
    #[arg(long, value_parser = clap::value_parser!(u64).range(1..=1000))]
    pub seeds: Option<u64>,
    /// Run the other codes now instead of reading recorded numbers.
    #[arg(long)]
    pub live: bool,
    /// Time step of explicit codes, as a fraction of the Rayleigh step; 0.1 if absent.
    #[arg(long, value_parser = rayleigh_fraction)]
    pub rayleigh_fraction: Option<f64>,
    /// Wall time after which a run is stopped, s; Makadam's own runs have no limit here.
    #[arg(long, default_value_t = 7200.0, value_parser = time_limit)]
    pub time_limit: f64,
    /// Number of runs at the same time.
    #[command(flatten)]
    pub jobs: JobArguments,
    /// Folder for report.html, report.json, rows.csv, junit.xml, and the CSV files that figures link to; if absent, nothing is written.
    #[arg(short, long)]
    pub output: Option<PathBuf>,
    /// Print the comparison as JSON.
    #[arg(long)]
    pub json: bool,
}

impl CodeRunArguments {
    /// Time step of explicit codes over the Rayleigh step.
    pub fn rayleigh_fraction(&self) -> f64 {
        self.rayleigh_fraction.unwrap_or(0.1)
    }

    /// Refuses a time step of codes that are not run.
    pub fn check(&self) -> Result<(), Failure> {
        match self.rayleigh_fraction {
            Some(_) if !self.live => Err(Failure::Usage(
                "--rayleigh-fraction is of runs, and recorded numbers have their own: add --live or --record (of 'makadam compare')"
                    .into(),
            )),
            _ => Ok(()),
        }
    }
}
