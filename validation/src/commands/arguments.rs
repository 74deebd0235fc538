//! The command line.

use clap::builder::PossibleValuesParser;
use clap::{Args, Parser, Subcommand, ValueEnum};
use makadam::lanes::{InstructionSet, PREFETCH};
use makadam::scene::{Accuracy, Precision, SolverMethod};
use makadam::schedule::Scheduler;
use std::path::PathBuf;

const EXIT_CODES: &str = "Exit codes: 0 pass, 1 failure while running, 2 usage, 3 invalid scene, \
    4 outside tolerance or undecided, 5 a reference code is missing.";

/// Granular matter by non-smooth contact dynamics, judged against YADE and LIGGGHTS.
#[derive(Debug, Parser)]
#[command(name = "makadam", version, about, after_help = EXIT_CODES)]
pub struct Arguments {
    /// What to do.
    #[command(subcommand)]
    pub command: Command,
    /// Say nothing but results and errors.
    #[arg(short, long, global = true)]
    pub quiet: bool,
    /// Say more.
    #[arg(short, long, global = true)]
    pub verbose: bool,
}

/// The commands.
#[derive(Debug, Subcommand)]
pub enum Command {
    /// Simulate a scene; frames for ParaView, observables as CSV, provenance as JSON.
    Run(RunArguments),
    /// Compare Makadam with YADE and LIGGGHTS on one scene.
    Compare(CompareArguments),
    /// Judge Makadam on the reference scenes and write one report.
    Qualify(QualifyArguments),
    /// Measure how a scene's step scales with threads, and replay it beyond the cores at hand.
    Scaling(ScalingArguments),
    /// Show how each method converges on the problem of one step: residual against iterations and wall time.
    Convergence(ConvergenceArguments),
    /// Show what accuracy costs in time: error against wall time over the settings of each code.
    Tradeoff(TradeoffArguments),
    /// Measure the contact sweep against what arithmetic and memory deliver.
    Roofline(RooflineArguments),
    /// Run the hard cases: what breaks simulators, the right outcome, and who survives it.
    Stability(StabilityArguments),
    /// Tell which effects a scene calls for, what each costs, and, with --ablate, whether it matters.
    Effects(EffectsArguments),
    /// Measure published laws of granular matter and judge them against the published values.
    Laws(LawsArguments),
}

/// Arguments of `makadam run`.
#[derive(Debug, Args)]
pub struct RunArguments {
    /// A folder under reference-scenes/, or a path to a TOML file.
    pub scene: String,
    /// Seed of the initial positions; the scene's, if absent.
    #[arg(long)]
    pub seed: Option<u64>,
    /// Threads that share the work; as many as there are cores, if absent. The result does not depend on it.
    #[arg(long, value_parser = clap::value_parser!(u16).range(1..=1024))]
    pub threads: Option<u16>,
    /// How threads share the work. The result does not depend on it.
    #[arg(long, value_enum, default_value = "work-stealing")]
    pub scheduler: SchedulerName,
    /// Instruction set of the kernels; the widest that this processor has, if absent. The result does not depend on it.
    #[arg(long, value_enum)]
    pub isa: Option<InstructionSetName>,
    /// Lane groups ahead of a sweep whose bodies are fetched into the cache; 0 leaves it to the processor.
    #[arg(long, default_value_t = PREFETCH as u16, value_parser = clap::value_parser!(u16).range(..=1024))]
    pub prefetch: u16,
    /// Accuracy in place of the scene's step and sweeps: a share such as 1%, or deviations such as
    /// angle=0.5,packing_fraction=0.002,overlap=1e-3 (degrees, none, mean radii).
    #[arg(long, value_parser = accuracy)]
    pub accuracy: Option<Accuracy>,
    /// The best accuracy that fits into so much wall time, s: the coarsest setting first, then a finer one if there is time.
    #[arg(long, value_name = "SECONDS", value_parser = positive, conflicts_with_all = ["accuracy", "resume"])]
    pub time_budget: Option<f64>,
    /// Precision of the sweeps; the scene's, if absent. The result depends on it.
    #[arg(long, value_enum)]
    pub precision: Option<PrecisionName>,
    /// Steps to take, in place of the scene's duration.
    #[arg(long)]
    pub steps: Option<u64>,
    /// Keep a ledger of energy and momentum, and print how it closes; costs about a sixth of a step's time.
    #[arg(long)]
    pub ledger: bool,
    /// Go on from the checkpoint of a run that did not end, if there is one; the result is the same to the last bit.
    #[arg(long, conflicts_with = "restart")]
    pub resume: bool,
    /// Begin anew where a run that did not end has left a checkpoint.
    #[arg(long)]
    pub restart: bool,
    /// Wall time between checkpoints, s; 0 writes one after every step.
    #[arg(long, value_name = "SECONDS", default_value_t = 60.0, value_parser = seconds)]
    pub checkpoint_interval: f64,
    /// Folder to write into; results/SCENE, if absent.
    #[arg(short, long)]
    pub output: Option<PathBuf>,
    /// Print the summary as JSON.
    #[arg(long)]
    pub json: bool,
}

/// Reads an accuracy: one share of everything, or deviations by name.
fn accuracy(text: &str) -> Result<Accuracy, String> {
    let number = |text: &str| match text.strip_suffix('%') {
        Some(percent) => percent.trim().parse::<f64>().map(|percent| percent / 100.0),
        None => text.trim().parse::<f64>(),
    };
    let mut accuracy = Accuracy::default();
    for part in text.split(',') {
        let (name, value) = part.split_once('=').unwrap_or(("relative", part));
        let value = number(value).ok().filter(|value| (1e-6..=10.0).contains(value));
        let value = value.ok_or_else(|| format!("{part}: give a number from 1e-6 to 10, or a share such as 1%"))?;
        let place = match name.trim() {
            "angle" => &mut accuracy.angle,
            "packing_fraction" => &mut accuracy.packing_fraction,
            "overlap" => &mut accuracy.overlap,
            "relative" => &mut accuracy.relative,
            other => return Err(format!("{other} is none of angle, packing_fraction, overlap, relative")),
        };
        if place.replace(value).is_some() {
            return Err(format!("{} is given twice", name.trim()));
        }
    }
    Ok(accuracy)
}

/// A way in which threads share tasks.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum SchedulerName {
    /// One thread.
    Serial,
    /// One queue behind a lock.
    CentralQueue,
    /// A queue a thread; idle threads steal.
    WorkStealing,
}

impl From<SchedulerName> for Scheduler {
    fn from(name: SchedulerName) -> Scheduler {
        match name {
            SchedulerName::Serial => Scheduler::Serial,
            SchedulerName::CentralQueue => Scheduler::CentralQueue,
            SchedulerName::WorkStealing => Scheduler::WorkStealing,
        }
    }
}

/// A precision of the sweeps.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum PrecisionName {
    /// 64 bits, eight contacts at a time.
    Double,
    /// 32 bits, sixteen contacts at a time.
    Single,
}

impl From<PrecisionName> for Precision {
    fn from(name: PrecisionName) -> Precision {
        match name {
            PrecisionName::Double => Precision::Double,
            PrecisionName::Single => Precision::Single,
        }
    }
}

/// An instruction set that the kernels are compiled for.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum InstructionSetName {
    /// Whatever the build's target has.
    Generic,
    /// 256-bit registers.
    Avx2,
    /// 512-bit registers.
    Avx512,
}

impl From<InstructionSetName> for InstructionSet {
    fn from(name: InstructionSetName) -> InstructionSet {
        match name {
            InstructionSetName::Generic => InstructionSet::Generic,
            InstructionSetName::Avx2 => InstructionSet::Avx2,
            InstructionSetName::Avx512 => InstructionSet::Avx512,
        }
    }
}

/// A code that can be compared.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum CodeName {
    /// Makadam.
    Makadam,
    /// YADE.
    Yade,
    /// LIGGGHTS.
    Liggghts,
}

/// Arguments of `makadam compare`.
#[derive(Debug, Args)]
pub struct CompareArguments {
    /// A folder under reference-scenes/, or a path to a TOML file.
    pub scene: String,
    /// Number of seeds, counted from 1; as many as are recorded, or 3, if absent.
    #[arg(long, value_parser = clap::value_parser!(u64).range(1..=1000))]
    pub seeds: Option<u64>,
    /// Codes to compare.
    #[arg(long, value_enum, value_delimiter = ',', default_values = ["makadam", "yade", "liggghts"])]
    pub codes: Vec<CodeName>,
    /// Run YADE and LIGGGHTS here and now instead of reading recorded numbers.
    #[arg(long)]
    pub live: bool,
    /// Time step of YADE and LIGGGHTS over the Rayleigh step.
    #[arg(long, default_value_t = 0.1, value_parser = rayleigh_fraction)]
    pub rayleigh_fraction: f64,
    /// Wall time after which a run of YADE or LIGGGHTS is stopped, s.
    #[arg(long, default_value_t = 7200.0, value_parser = positive)]
    pub time_limit: f64,
    /// Write numbers of YADE and LIGGGHTS as the scene's recorded references; only seeds that are not recorded yet, of
    /// the same scene, version and time step, are measured from raw recordings or run.
    #[arg(long)]
    pub record: bool,
    /// Measure or run all seeds anew and replace what is recorded; with --record only.
    #[arg(long, requires = "record")]
    pub again: bool,
    /// Factor on every Young's modulus; with --record only.
    #[arg(long, default_value_t = 1.0, value_parser = positive, requires = "record")]
    pub stiffness_factor: f64,
    /// Folder of raw recordings, read and filled by --record; in the user's cache, if absent.
    #[arg(long, requires = "record")]
    pub recordings: Option<PathBuf>,
    /// Threads for the runs of Makadam.
    #[arg(long, value_parser = clap::value_parser!(u16).range(1..))]
    pub threads: Option<u16>,
    /// Folder to write comparison.json and comparison.csv into.
    #[arg(short, long)]
    pub output: Option<PathBuf>,
    /// Print the comparison as JSON.
    #[arg(long)]
    pub json: bool,
}

/// How much is judged.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum Tier {
    /// Packing, drum, drum with caps and heap, in minutes.
    Quick,
}

/// Arguments of `makadam qualify`.
#[derive(Debug, Args)]
pub struct QualifyArguments {
    /// How much is judged.
    #[arg(long, value_enum, default_value = "quick")]
    pub tier: Tier,
    /// Insist on running YADE and LIGGGHTS beside the recorded numbers.
    #[arg(long)]
    pub live: bool,
    /// Wall time after which a run of YADE or LIGGGHTS is stopped, s.
    #[arg(long, default_value_t = 900.0, value_parser = positive)]
    pub time_limit: f64,
    /// Threads for the runs of Makadam.
    #[arg(long, value_parser = clap::value_parser!(u16).range(1..))]
    pub threads: Option<u16>,
    /// Folder of the report; results/qualification, if absent.
    #[arg(short, long)]
    pub output: Option<PathBuf>,
    /// Print the qualification as JSON.
    #[arg(long)]
    pub json: bool,
}

/// Arguments of `makadam scaling`.
#[derive(Debug, Args)]
pub struct ScalingArguments {
    /// A folder under reference-scenes/, or a path to a TOML file.
    pub scene: String,
    /// Seed of the initial positions; the scene's, if absent.
    #[arg(long)]
    pub seed: Option<u64>,
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
    /// Folder to write into; results/scaling/SCENE, if absent.
    #[arg(short, long)]
    pub output: Option<PathBuf>,
    /// Print the study as JSON.
    #[arg(long)]
    pub json: bool,
}

/// Arguments of `makadam convergence`.
#[derive(Debug, Args)]
pub struct ConvergenceArguments {
    /// A folder under reference-scenes/, or a path to a TOML file.
    pub scene: String,
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
    /// Seed of the initial positions; the scene's, if absent.
    #[arg(long)]
    pub seed: Option<u64>,
    /// Threads that share the work. Residuals do not depend on it.
    #[arg(long, default_value_t = 1, value_parser = clap::value_parser!(u16).range(1..=1024))]
    pub threads: u16,
    /// Write the table beside the scene too, in a folder named after processor and instruction set.
    #[arg(long)]
    pub record: bool,
    /// Folder to write into; results/convergence/SCENE, if absent.
    #[arg(short, long)]
    pub output: Option<PathBuf>,
    /// Print the study as JSON.
    #[arg(long)]
    pub json: bool,
}

/// Arguments of `makadam tradeoff`.
#[derive(Debug, Args)]
pub struct TradeoffArguments {
    /// A folder under reference-scenes/, or a path to a TOML file.
    pub scene: String,
    /// Few configurations, at the scene's stiffness alone: an answer in about ten minutes for drum or packing.
    #[arg(long)]
    pub quick: bool,
    /// Number of seeds, counted from 1; 3, if absent.
    #[arg(long, value_parser = clap::value_parser!(u64).range(1..=1000))]
    pub seeds: Option<u64>,
    /// Codes to run; the converged references are Makadam's in any case.
    #[arg(long, value_enum, value_delimiter = ',', default_values = ["makadam", "yade", "liggghts"])]
    pub codes: Vec<CodeName>,
    /// Factors on every Young's modulus; 0.5, 1, 10 and 100, if absent, or 1 with --quick. 1 is always run.
    #[arg(long, value_delimiter = ',', value_parser = positive)]
    pub stiffness_factors: Option<Vec<f64>>,
    /// Tolerated deviation of an observable from the reference; can be given several times. An angle of repose has
    /// 0.5 degrees and packing_fraction 0.002 unless given here.
    #[arg(long, value_name = "OBSERVABLE=VALUE", value_parser = bound)]
    pub bound: Vec<BoundArgument>,
    /// Wall time beyond which a run is cut short and its wall time extrapolated, s; 900, if absent, or 60 with --quick.
    #[arg(long, value_parser = positive)]
    pub time_limit: Option<f64>,
    /// Folder to write into, and to take finished runs from; results/tradeoff/SCENE, if absent.
    #[arg(short, long)]
    pub output: Option<PathBuf>,
    /// Print the study as JSON.
    #[arg(long)]
    pub json: bool,
}

/// A tolerated deviation of an observable.
#[derive(Clone, Debug, PartialEq)]
pub struct BoundArgument {
    /// Name of the observable.
    pub observable: String,
    /// Largest absolute deviation, in the observable's unit.
    pub value: f64,
}

/// Arguments of `makadam roofline`.
#[derive(Debug, Args)]
pub struct RooflineArguments {
    /// Folders under reference-scenes/, or paths to TOML files; the drums whose flowing states are prepared, if absent.
    pub scenes: Vec<String>,
    /// Instruction set of the kernels; the widest that this processor has, if absent.
    #[arg(long, value_enum)]
    pub isa: Option<InstructionSetName>,
    /// Simulated time before the measurement where a scene prepares no flowing state, s.
    #[arg(long, default_value_t = 1.5, value_parser = positive)]
    pub settle: f64,
    /// Folder to write into; results/roofline, if absent.
    #[arg(short, long)]
    pub output: Option<PathBuf>,
    /// Print the study as JSON.
    #[arg(long)]
    pub json: bool,
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
    #[arg(long)]
    pub list: bool,
    /// Codes to run.
    #[arg(long, value_enum, value_delimiter = ',', default_values = ["makadam"])]
    pub codes: Vec<CodeName>,
    /// Wall time after which a run is stopped, s; 600, if absent, or 60 with --quick.
    #[arg(long, value_parser = positive)]
    pub time_limit: Option<f64>,
    /// Runs side by side; as many as there are cores, if absent.
    #[arg(long, value_parser = clap::value_parser!(u16).range(1..))]
    pub threads: Option<u16>,
    /// Folder to write into; results/stability, if absent.
    #[arg(short, long)]
    pub output: Option<PathBuf>,
    /// Print the study as JSON.
    #[arg(long)]
    pub json: bool,
}

/// Arguments of `makadam effects`.
#[derive(Debug, Args)]
pub struct EffectsArguments {
    /// A folder under reference-scenes/, or a path to a TOML file.
    pub scene: String,
    /// Seed of the initial positions, the first one with --ablate; the scene's, if absent.
    #[arg(long)]
    pub seed: Option<u64>,
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
    #[arg(long, default_value_t = 3600.0, value_parser = positive)]
    pub time_limit: f64,
    /// Runs of --ablate side by side; as many as there are cores, if absent.
    #[arg(long, value_parser = clap::value_parser!(u16).range(1..=1024))]
    pub threads: Option<u16>,
    /// Folder to write into; results/effects/SCENE, if absent.
    #[arg(short, long)]
    pub output: Option<PathBuf>,
    /// Print the study as JSON.
    #[arg(long)]
    pub json: bool,
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
    #[arg(long)]
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
    /// Runs side by side; as many as there are cores, if absent.
    #[arg(long, value_parser = clap::value_parser!(u16).range(1..=1024))]
    pub threads: Option<u16>,
    /// Folder to write into, a folder a law, and to take finished runs from; results/laws, if absent.
    #[arg(short, long)]
    pub output: Option<PathBuf>,
    /// Print the study as JSON.
    #[arg(long)]
    pub json: bool,
}

/// One of the methods' names.
fn method() -> PossibleValuesParser {
    PossibleValuesParser::new(SolverMethod::ALL.map(SolverMethod::name))
}

fn positive(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(value) if value.is_finite() && value > 0.0 => Ok(value),
        _ => Err("give a number above 0".into()),
    }
}

fn seconds(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(value) if (0.0..=1e9).contains(&value) => Ok(value),
        _ => Err("give a number of seconds from 0 to 1e9".into()),
    }
}

fn rayleigh_fraction(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(value) if value > 0.0 && value <= 0.5 => Ok(value),
        _ => Err("give a number above 0 and at most 0.5; beyond it the peers lose their restitution".into()),
    }
}

fn bound(text: &str) -> Result<BoundArgument, String> {
    let (observable, value) =
        text.split_once('=').ok_or("give an observable and a value, such as packing_fraction=0.002")?;
    Ok(BoundArgument { observable: observable.trim().replace('-', "_"), value: positive(value.trim())? })
}
