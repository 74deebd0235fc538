//! Arguments of the commands that study the solver.

use super::shared::{JobArguments, OutputArguments, SceneArguments, SourceArguments};
use super::values::{BoundArgument, InstructionSetName, bound, method, positive, time_limit};
use crate::peers::CodeName;
use clap::Args;

/// Arguments of `makadam lab scaling`.
#[derive(Debug, Args)]
pub struct ScalingArguments {
    /// The scene.
    #[command(flatten)]
    pub scene: SceneArguments,
    /// Numbers of threads to measure; if absent, 1, 2, 4, ... and all cores.
    #[arg(long, value_delimiter = ',', value_parser = clap::value_parser!(u16).range(1..=256))]
    pub threads_list: Option<Vec<u16>>,
    /// Instruction sets to measure; if absent, all of this processor.
    #[arg(long, value_enum, value_delimiter = ',')]
    pub isa: Option<Vec<InstructionSetName>>,
    /// Simulated time before the measurement, if the scene prepares no flowing state, s.
    #[arg(long, default_value_t = 0.5, value_parser = positive)]
    pub settle: f64,
    /// Timed steps of each repetition.
    #[arg(long, default_value_t = 20, value_parser = clap::value_parser!(u64).range(1..))]
    pub steps: u64,
    /// Number of these steps, from the first, that are traced and replayed.
    #[arg(long, default_value_t = 10, value_parser = clap::value_parser!(u64).range(1..))]
    pub traced_steps: u64,
    /// Number of repetitions of all measurements, in turn.
    #[arg(long, default_value_t = 5, value_parser = clap::value_parser!(u64).range(1..=1000))]
    pub repetitions: u64,
    /// Memory bandwidth of this machine for any number of cores, GB/s, for the replay. If absent, the bandwidth of the available
    /// cores is measured, and more cores are assumed to bring more memory.
    #[arg(long, value_parser = positive)]
    pub memory_bandwidth: Option<f64>,
    /// Write the tables also next to the scene, in a folder named after processor, instruction set and number of cores.
    #[arg(long)]
    pub record: bool,
    /// Where the results go.
    #[command(flatten)]
    pub output: OutputArguments,
}

/// Arguments of `makadam lab convergence`.
#[derive(Debug, Args)]
pub struct ConvergenceArguments {
    /// The scene.
    #[command(flatten)]
    pub scene: SceneArguments,
    /// Iterations of each method.
    #[arg(long, default_value_t = 200, value_parser = clap::value_parser!(u32).range(1..=100_000))]
    pub iterations: u32,
    /// Number of times that each method solves the problem, in turn; each iteration counts with its shortest time.
    #[arg(long, default_value_t = 3, value_parser = clap::value_parser!(u32).range(1..=1000))]
    pub repetitions: u32,
    /// Methods, named as in scenes; if absent, all.
    #[arg(long, value_delimiter = ',', value_parser = method())]
    pub methods: Option<Vec<String>>,
    /// Simulated time before the problem is taken, s. If absent: none if the scene prepares a flowing state, else the time until
    /// it is measured (measure.from), or its whole duration.
    #[arg(long, value_parser = positive)]
    pub settle: Option<f64>,
    /// Number of threads. Residuals do not depend on it.
    #[arg(long, default_value_t = 1, value_parser = clap::value_parser!(u16).range(1..=1024))]
    pub threads: u16,
    /// Write the table also next to the scene, in a folder named after processor and instruction set.
    #[arg(long)]
    pub record: bool,
    /// Where the results go.
    #[command(flatten)]
    pub output: OutputArguments,
}

/// Arguments of `makadam tradeoff`.
#[derive(Debug, Args)]
pub struct TradeoffArguments {
    /// The scene.
    #[command(flatten)]
    pub source: SourceArguments,
    /// Run few configurations, only at the scene's stiffness: about ten minutes for drum or packing.
    #[arg(long)]
    pub quick: bool,
    /// Also with --quick, run other methods, single precision, no warm start, other sweeps; without --quick they are always run.
    #[arg(long)]
    pub variations: bool,
    /// Number of seeds of each setting, consecutive from 1; if absent, 3.
    #[arg(long, value_parser = clap::value_parser!(u64).range(1..=1000))]
    pub seeds: Option<u64>,
    /// Codes that take part, separated by commas; the converged references are Makadam's in any case.
    #[arg(long, value_enum, value_delimiter = ',', default_value = "makadam,yade,liggghts")]
    pub codes: Vec<CodeName>,
    /// Factors on every Young's modulus; if absent, 0.5, 1, 10 and 100, or 1 with --quick. 1 is always run.
    #[arg(long, value_delimiter = ',', value_parser = positive)]
    pub stiffness_factors: Option<Vec<f64>>,
    /// Tolerated deviation of an observable from the reference; can be given several times. The defaults are 0.5 degrees for an
    /// angle of repose and 0.002 for packing_fraction.
    #[arg(long, value_name = "OBSERVABLE=VALUE", value_parser = bound)]
    pub bound: Vec<BoundArgument>,
    /// Wall time after which a run is stopped, s, and its wall time extrapolated; if absent, 900, or 60 with --quick.
    #[arg(long, value_parser = time_limit)]
    pub time_limit: Option<f64>,
    /// Where the results go.
    #[command(flatten)]
    pub output: OutputArguments,
}

/// Arguments of `makadam stability`.
#[derive(Debug, Args)]
pub struct StabilityArguments {
    /// Parts of names of cases or groups; if absent, all cases.
    pub cases: Vec<String>,
    /// Leave out the cases that take more than a few seconds.
    #[arg(long)]
    pub quick: bool,
    /// List the cases with the expected outcome and the reason for it; run none.
    #[arg(long, conflicts_with = "json")]
    pub list: bool,
    /// Codes that take part, separated by commas.
    #[arg(long, value_enum, value_delimiter = ',', default_value = "makadam")]
    pub codes: Vec<CodeName>,
    /// Wall time after which a run is stopped, s; if absent, 600, or 60 with --quick.
    #[arg(long, value_parser = time_limit)]
    pub time_limit: Option<f64>,
    /// Start again: repeat cases whose outcomes are stored.
    #[arg(long)]
    pub restart: bool,
    /// Number of runs at the same time.
    #[command(flatten)]
    pub jobs: JobArguments,
    /// Where the results go.
    #[command(flatten)]
    pub output: OutputArguments,
}

/// Arguments of `makadam effects`.
#[derive(Debug, Args)]
pub struct EffectsArguments {
    /// The scene.
    #[command(flatten)]
    pub scene: SceneArguments,
    /// Run the scene with each effect off or on, and report which of its observables depend on it.
    #[arg(long)]
    pub ablate: bool,
    /// Number of seeds of each variation, consecutive from --seed.
    #[arg(long, default_value_t = 4, value_parser = clap::value_parser!(u16).range(2..=1000))]
    pub seeds: u16,
    /// Simulated time before kernels are timed, if the scene prepares no flowing state, s.
    #[arg(long, default_value_t = 0.5, value_parser = positive)]
    pub settle: f64,
    /// Simulated time after it over which the energy loss is measured, s.
    #[arg(long, default_value_t = 0.2, value_parser = positive)]
    pub look: f64,
    /// Wall time after which a run of --ablate is stopped, s.
    #[arg(long, default_value_t = 3600.0, value_parser = time_limit)]
    pub time_limit: f64,
    /// Start again: repeat runs of --ablate whose results are stored.
    #[arg(long)]
    pub restart: bool,
    /// Number of runs at the same time.
    #[command(flatten)]
    pub jobs: JobArguments,
    /// Where the results go.
    #[command(flatten)]
    pub output: OutputArguments,
}

/// Arguments of `makadam laws`.
#[derive(Debug, Args)]
pub struct LawsArguments {
    /// Names of laws; if absent, all.
    pub names: Vec<String>,
    /// Run fewer and smaller cases: results in seconds, with grains that are large for their container.
    #[arg(long)]
    pub quick: bool,
    /// List the laws and their publications; measure none.
    #[arg(long, conflicts_with = "json")]
    pub list: bool,
    /// Seed of the initial positions, the first one where --seeds takes several.
    #[arg(long, default_value_t = 1)]
    pub seed: u64,
    /// Number of seeds of each case, consecutive from --seed; figures are judged by their means.
    #[arg(long, default_value_t = 1, value_parser = clap::value_parser!(u16).range(1..=1000))]
    pub seeds: u16,
    /// Start again: repeat runs whose results are stored.
    #[arg(long)]
    pub restart: bool,
    /// Number of runs at the same time.
    #[command(flatten)]
    pub jobs: JobArguments,
    /// Where the results go.
    #[command(flatten)]
    pub output: OutputArguments,
}
