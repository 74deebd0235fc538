//! Arguments of the commands that run scenes and judge them.

use super::shared::{CodeRunArguments, JobArguments, OutputArguments, SceneArguments, SourceArguments};
use super::values::{InstructionSetName, PrecisionName, SchedulerName, accuracy, seconds, time_limit};
use crate::peers::CodeName;
use crate::qualify::Tier;
use clap::Args;
use makadam::scene::Accuracy;
use std::path::PathBuf;

/// Arguments of `makadam run`.
#[derive(Debug, Args)]
pub struct RunArguments {
    /// The scene.
    #[command(flatten)]
    pub scene: SceneArguments,
    /// Number of threads; if absent, all cores, but at most one thread per 1,000 grains. The result does not depend on it.
    #[arg(long, value_parser = clap::value_parser!(u16).range(1..=1024))]
    pub threads: Option<u16>,
    /// Scheduler that distributes the work over threads. The result does not depend on it.
    #[arg(long, value_enum, default_value = "work-stealing")]
    pub scheduler: SchedulerName,
    /// Instruction set of the kernels; if absent, the widest of this processor. The result does not depend on it.
    #[arg(long, value_enum)]
    pub isa: Option<InstructionSetName>,
    /// How many lane groups ahead a sweep prefetches bodies; 0 leaves it to the processor. If absent, 0 in scenes that fit into
    /// the cache, and 4 in others.
    #[arg(long, value_parser = clap::value_parser!(u16).range(..=1024))]
    pub prefetch: Option<u16>,
    /// Target accuracy, which replaces the scene's step and stopping rule: a share such as 1%, or deviations such as
    /// angle=0.5,packing_fraction=0.002,overlap=1e-3 (units: degrees, none, mean radii).
    #[arg(long, value_parser = accuracy)]
    pub accuracy: Option<Accuracy>,
    /// Precision of the sweeps; if absent, the scene's. The result depends on it.
    #[arg(long, value_enum)]
    pub precision: Option<PrecisionName>,
    /// Number of steps, instead of the scene's duration.
    #[arg(long)]
    pub steps: Option<u64>,
    /// Print the energy and momentum budget with its closure error; costs about a sixth of a step's time.
    #[arg(long)]
    pub ledger: bool,
    /// Continue an unfinished run from its checkpoint, if there is one; the result is the same to the last bit. A finished run is
    /// left as it is.
    #[arg(long, conflicts_with = "restart")]
    pub resume: bool,
    /// Start again in the folder of an earlier run: removes its frames, tables and checkpoint, and nothing else.
    #[arg(long)]
    pub restart: bool,
    /// Wall time between checkpoints, s; 0 writes one after every step.
    #[arg(long, value_name = "SECONDS", default_value_t = 60.0, value_parser = seconds)]
    pub checkpoint_interval: f64,
    /// Where the results go.
    #[command(flatten)]
    pub output: OutputArguments,
}

/// Arguments of `makadam compare`.
#[derive(Debug, Args)]
pub struct CompareArguments {
    /// The scene.
    #[command(flatten)]
    pub source: SourceArguments,
    /// Codes that take part, separated by commas; if absent, makadam and those that are recorded on the scene, or with --live
    /// makadam,yade,liggghts.
    #[arg(long, value_enum, value_delimiter = ',')]
    pub codes: Option<Vec<CodeName>>,
    /// Validate your own code instead of Makadam: TOML file with its name, version, command and output files (docs/own-code.md).
    #[arg(long, value_name = "FILE", conflicts_with = "record")]
    pub own_code: Option<PathBuf>,
    /// Folders of existing frames of your own code, one per seed, whose number ends the folder's name: 'seed*/'. The code is not run;
    /// without --own-code each folder is a run of Makadam, or all its files hold grains.
    #[arg(long, num_args = 1.., value_name = "FOLDERS", conflicts_with_all = ["seeds", "record"])]
    pub frames: Vec<String>,
    /// Record results of the other codes as the scene's references. Only seeds not yet recorded for the same scene, version and
    /// time step are measured from raw recordings or run.
    #[arg(long, conflicts_with_all = ["json", "output", "live"])]
    pub record: bool,
    /// Start again: measure or run all seeds and replace the recorded ones; only with --record.
    #[arg(long, requires = "record")]
    pub restart: bool,
    /// Folder of raw recordings that --record reads and writes; if absent, in the user's cache.
    #[arg(long, requires = "record")]
    pub recordings: Option<PathBuf>,
    /// How the codes are run, and what is told.
    #[command(flatten)]
    pub runs: CodeRunArguments,
}

/// Arguments of `makadam qualify`.
#[derive(Debug, Args)]
pub struct QualifyArguments {
    /// Extent of the qualification.
    #[arg(long, value_enum, default_value = "quick")]
    pub tier: Tier,
    /// Baseline (validation/baseline.json, or tests.json of an earlier qualification): lists tests that are missing, new or of another
    /// verdict. A missing test or a worse verdict is exit code 4.
    #[arg(long, value_name = "FILE")]
    pub against: Option<PathBuf>,
    /// Start again: repeat runs whose results are stored in the output folder.
    #[arg(long)]
    pub restart: bool,
    /// Require live runs of YADE and LIGGGHTS in addition to the recorded numbers.
    #[arg(long)]
    pub live: bool,
    /// Wall time after which a run is stopped, s; Makadam's own runs have no limit here.
    #[arg(long, default_value_t = 900.0, value_parser = time_limit)]
    pub time_limit: f64,
    /// Number of runs at the same time.
    #[command(flatten)]
    pub jobs: JobArguments,
    /// Where the results go.
    #[command(flatten)]
    pub output: OutputArguments,
}
