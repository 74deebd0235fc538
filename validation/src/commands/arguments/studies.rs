//! Arguments of the commands that study the solver.

use super::shared::{OutputArguments, SceneArguments, SourceArguments, ThreadArguments};
use super::values::{BoundArgument, CodeName, InstructionSetName, bound, method, positive, time_limit};
use crate::scenes::Change;
use clap::Args;

/// Arguments of `makadam scaling`.
#[derive(Debug, Args)]
pub struct ScalingArguments {
    /// The scene.
    #[command(flatten)]
    pub scene: SceneArguments,
    /// Numbers of threads to measure; 1, 2, 4, ... and all cores, if absent.
    #[arg(long, value_delimiter = ',', value_parser = clap::value_parser!(u16).range(1..=256))]
    pub threads_list: Option<Vec<u16>>,
    /// Instruction sets to measure; all that this processor has, if absent.
    #[arg(long, value_enum, value_delimiter = ',')]
    pub isa: Option<Vec<InstructionSetName>>,
    /// Simulated time before the measurement where the scene prepares no flowing state, s.
    #[arg(long, default_value_t = 0.5, value_parser = positive)]
    pub settle: f64,
    /// Timed steps of each repetition.
    #[arg(long, default_value_t = 20, value_parser = clap::value_parser!(u64).range(1..))]
    pub steps: u64,
    /// The first so many of them are traced and replayed.
    #[arg(long, default_value_t = 10, value_parser = clap::value_parser!(u64).range(1..))]
    pub traced_steps: u64,
    /// Times that everything is measured, in turn.
    #[arg(long, default_value_t = 5, value_parser = clap::value_parser!(u64).range(1..=1000))]
    pub repetitions: u64,
    /// What this machine's memory delivers to any number of cores, GB/s, for the replay; if absent, what the cores at hand
    /// get is measured, and more cores are taken to bring more memory.
    #[arg(long, value_parser = positive)]
    pub memory_bandwidth: Option<f64>,
    /// Write the tables beside the scene too, in a folder named after processor and instruction set.
    #[arg(long)]
    pub record: bool,
    /// Where the results go.
    #[command(flatten)]
    pub output: OutputArguments,
}

/// Arguments of `makadam convergence`.
#[derive(Debug, Args)]
pub struct ConvergenceArguments {
    /// The scene.
    #[command(flatten)]
    pub scene: SceneArguments,
    /// Iterations of each method.
    #[arg(long, default_value_t = 200, value_parser = clap::value_parser!(u32).range(1..=100_000))]
    pub iterations: u32,
    /// Times that each method solves the problem, in turn; each iteration counts with its shortest time.
    #[arg(long, default_value_t = 3, value_parser = clap::value_parser!(u32).range(1..=1000))]
    pub repetitions: u32,
    /// Methods, named as in scenes; all, if absent.
    #[arg(long, value_delimiter = ',', value_parser = method())]
    pub methods: Option<Vec<String>>,
    /// Simulated time before the problem is taken, s. If absent: none where the scene prepares a flowing state, else as long as
    /// it settles before it is measured (measure.from), or its whole duration.
    #[arg(long, value_parser = positive)]
    pub settle: Option<f64>,
    /// Threads that share the work. Residuals do not depend on it.
    #[arg(long, default_value_t = 1, value_parser = clap::value_parser!(u16).range(1..=1024))]
    pub threads: u16,
    /// Write the table beside the scene too, in a folder named after processor and instruction set.
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
    /// Few configurations, at the scene's stiffness alone: an answer in about ten minutes for drum or packing.
    #[arg(long)]
    pub quick: bool,
    /// With --quick too: other methods, single precision, no warm start, other sweeps. Without --quick they are always run.
    #[arg(long)]
    pub variations: bool,
    /// Number of seeds, counted from 1; 3, if absent.
    #[arg(long, value_parser = clap::value_parser!(u64).range(1..=1000))]
    pub seeds: Option<u64>,
    /// Codes to run, separated by commas; the converged references are Makadam's in any case.
    #[arg(long, value_enum, value_delimiter = ',', default_value = "makadam,yade,liggghts")]
    pub codes: Vec<CodeName>,
    /// Factors on every Young's modulus; 0.5, 1, 10 and 100, if absent, or 1 with --quick. 1 is always run.
    #[arg(long, value_delimiter = ',', value_parser = positive)]
    pub stiffness_factors: Option<Vec<f64>>,
    /// Tolerated deviation of an observable from the reference; can be given several times. An angle of repose has
    /// 0.5 degrees and packing_fraction 0.002 unless given here.
    #[arg(long, value_name = "OBSERVABLE=VALUE", value_parser = bound)]
    pub bound: Vec<BoundArgument>,
    /// Wall time beyond which a run is cut short and its wall time extrapolated, s; 900, if absent, or 60 with --quick.
    #[arg(long, value_parser = time_limit)]
    pub time_limit: Option<f64>,
    /// Where the results go.
    #[command(flatten)]
    pub output: OutputArguments,
}

/// Arguments of `makadam roofline`.
#[derive(Debug, Args)]
pub struct RooflineArguments {
    /// Paths to TOML files, or names that `makadam scenes` lists; the drums whose flowing states are prepared, if absent.
    pub scenes: Vec<String>,
    /// A value in place of that of each scene, such as solver.step=1e-3; can be given several times.
    #[arg(long = "set", value_name = "KEY=VALUE")]
    pub changes: Vec<Change>,
    /// Instruction set of the kernels; the widest that this processor has, if absent.
    #[arg(long, value_enum)]
    pub isa: Option<InstructionSetName>,
    /// Simulated time before the measurement where a scene prepares no flowing state, s.
    #[arg(long, default_value_t = 1.5, value_parser = positive)]
    pub settle: f64,
    /// Where the results go.
    #[command(flatten)]
    pub output: OutputArguments,
}

/// Arguments of `makadam stability`.
#[derive(Debug, Args)]
pub struct StabilityArguments {
    /// Parts of names of cases or groups; all cases, if absent.
    pub cases: Vec<String>,
    /// Leave out the cases that take more than a few seconds.
    #[arg(long)]
    pub quick: bool,
    /// Say which cases there are, what is right in each, and why; run none.
    #[arg(long, conflicts_with = "json")]
    pub list: bool,
    /// Codes to run.
    #[arg(long, value_enum, value_delimiter = ',', default_value = "makadam")]
    pub codes: Vec<CodeName>,
    /// Wall time after which a run is stopped, s; 600, if absent, or 60 with --quick.
    #[arg(long, value_parser = time_limit)]
    pub time_limit: Option<f64>,
    /// How many threads.
    #[command(flatten)]
    pub side_by_side: ThreadArguments,
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
    /// Run the scene with each effect off or on and tell which of its observables need it.
    #[arg(long)]
    pub ablate: bool,
    /// Seeds of each variation.
    #[arg(long, default_value_t = 4, value_parser = clap::value_parser!(u16).range(2..=1000))]
    pub seeds: u16,
    /// Simulated time before kernels are timed where the scene prepares no flowing state, s.
    #[arg(long, default_value_t = 0.5, value_parser = positive)]
    pub settle: f64,
    /// Simulated time after it over which the energy lost is noted, s.
    #[arg(long, default_value_t = 0.2, value_parser = positive)]
    pub look: f64,
    /// Wall time after which a run of --ablate is stopped, s.
    #[arg(long, default_value_t = 3600.0, value_parser = time_limit)]
    pub time_limit: f64,
    /// Make again the runs of --ablate that an earlier start has kept.
    #[arg(long)]
    pub again: bool,
    /// How many threads.
    #[command(flatten)]
    pub side_by_side: ThreadArguments,
    /// Where the results go.
    #[command(flatten)]
    pub output: OutputArguments,
}

/// Arguments of `makadam laws`.
#[derive(Debug, Args)]
pub struct LawsArguments {
    /// Names of laws; all laws, if absent.
    pub names: Vec<String>,
    /// Fewer and smaller cases: an answer in seconds, from grains that are large for their container.
    #[arg(long)]
    pub quick: bool,
    /// Say which laws there are and where they were published; measure none.
    #[arg(long, conflicts_with = "json")]
    pub list: bool,
    /// Seed of the initial positions, the first one if there are several.
    #[arg(long, default_value_t = 1)]
    pub seed: u64,
    /// Seeds of each case; figures are judged by their means.
    #[arg(long, default_value_t = 1, value_parser = clap::value_parser!(u16).range(1..=1000))]
    pub seeds: u16,
    /// Measure again what an earlier start has kept.
    #[arg(long)]
    pub again: bool,
    /// How many threads.
    #[command(flatten)]
    pub side_by_side: ThreadArguments,
    /// Where the results go.
    #[command(flatten)]
    pub output: OutputArguments,
}
