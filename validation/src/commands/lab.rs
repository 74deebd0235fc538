//! `makadam lab convergence`: convergence of each method on the problem of one step; `makadam lab scaling`: scaling of a scene's step,
//! measured on the available cores and replayed for more cores.

use super::arguments::{OutputArguments, SceneArguments, one_of, positive};
use super::beforehand::{begin, flowing, refuse_time_budget, refuse_without_folder, settle};
use super::{Console, Failure, problem};
use clap::{Args, Subcommand};
use makadam::lanes::InstructionSet;
use makadam::scene::SolverMethod;
use makadam::schedule::Scheduler;
use makadam_compare::prepared::Start;
use makadam_compare::study::Document;
use makadam_frames::execution::{Execution, cores};
use makadam_frames::output::record_folder;
use makadam_frames::provenance::Provenance;
use makadam_studies::convergence::{self, Effort};
use makadam_studies::scaling;
use std::path::Path;
use std::process::ExitCode;

#[derive(Debug, Args)]
pub(super) struct LabArguments {
    /// Study to run.
    #[command(subcommand)]
    study: Lab,
}

#[derive(Debug, Subcommand)]
enum Lab {
    /// Measure how each method converges on the problem of one step: residual against iterations and wall time.
    Convergence(ConvergenceArguments),
    /// Measure how a scene's step scales with threads, and replay it on more cores than this machine has.
    Scaling(ScalingArguments),
    /// Write the contact problem of one step to a file, and solve it with every available solver.
    Problem(problem::ProblemArguments),
}

pub(super) fn lab(arguments: &LabArguments, console: &Console) -> Result<ExitCode, Failure> {
    match &arguments.study {
        Lab::Convergence(arguments) => convergence(arguments, console),
        Lab::Scaling(arguments) => scaling(arguments, console),
        Lab::Problem(arguments) => problem::problem(arguments, console),
    }
}

#[derive(Debug, Args)]
struct ConvergenceArguments {
    #[command(flatten)]
    pub scene: SceneArguments,
    /// Iterations of each method.
    #[arg(long, default_value_t = 200, value_parser = clap::value_parser!(u32).range(1..=100_000))]
    pub iterations: u32,
    /// Number of times that each method solves the problem, in turn; each iteration counts with its shortest time.
    #[arg(long, default_value_t = 3, value_parser = clap::value_parser!(u32).range(1..=1000))]
    pub repetitions: u32,
    /// Methods, named as in scenes; if absent, all.
    #[arg(long, value_delimiter = ',', value_parser = SolverMethod::ALL.map(SolverMethod::name))]
    pub methods: Option<Vec<String>>,
    /// Simulated time before the problem is extracted, s. If absent: zero if the scene prepares a flowing state, else the time until
    /// its measurement (measure.from), or its whole duration.
    #[arg(long, value_parser = positive)]
    pub settle: Option<f64>,
    /// Number of threads. Residuals do not depend on it.
    #[arg(long, default_value_t = 1, value_parser = clap::value_parser!(u16).range(1..=1024))]
    pub threads: u16,
    /// Write the table also next to the scene, in a folder named after processor and instruction set.
    #[arg(long)]
    pub record: bool,
    #[command(flatten)]
    pub output: OutputArguments,
}

fn convergence(arguments: &ConvergenceArguments, console: &Console) -> Result<ExitCode, Failure> {
    let (file, scene, seed) = arguments.scene.load()?;
    if arguments.record {
        refuse_without_folder(&file)?;
    }
    let wanted = convergence::methods(&scene, arguments.methods.as_deref());
    let threads = usize::from(arguments.threads);
    let scheduler = if threads > 1 { Scheduler::WorkStealing } else { Scheduler::Serial };
    let execution = Execution { scheduler, threads, ..Execution::serial() };
    let provenance = Provenance::of_run(&scene, &file, seed, &execution);
    // Refused before the preparation of a flowing state, which may take minutes.
    if arguments.methods.is_some() {
        let precision = scene.solver.precision;
        wanted
            .iter()
            .try_for_each(|method| scene.goes_with(*method, precision))
            .map_err(|error| Failure::Usage(format!("{}: {error}; leave that method out of --methods", scene.name)))?;
    }
    let (mut simulation, start) = begin(&scene, seed, &file, &execution, console)?;
    let own = (start == Start::Fresh).then(|| scene.measure.from.unwrap_or(scene.duration));
    if let Some(seconds) = arguments.settle.or(own) {
        settle(&mut simulation, seconds, console)?;
    }
    if simulation.clone().step().contacts == 0 {
        return Err(Failure::Usage(format!(
            "{} has no contacts at {} s, so there is no problem to solve; give another time with --settle",
            scene.name,
            simulation.time()
        )));
    }
    let bar = console.bar(&scene.name);
    let effort = Effort { iterations: arguments.iterations, repetitions: arguments.repetitions };
    let study = convergence::measure(&scene, &simulation, wanted, effort, provenance, &|method, fraction| {
        bar.say(method.name().into());
        bar.set(fraction);
    });
    drop(bar);
    let study = study.map_err(|_| Failure::interrupted("none, the methods were not finished"))?;
    console.publish(&study, &arguments.output.folder_of("convergence", &scene), arguments.output.json)?;
    if arguments.record {
        record(&study, &file, &study.provenance, Some(execution.instruction_set), None, console)?;
    }
    Ok(ExitCode::SUCCESS)
}

#[derive(Debug, Args)]
struct ScalingArguments {
    #[command(flatten)]
    pub scene: SceneArguments,
    /// Numbers of threads to measure; if absent, 1, 2, 4, ... and all cores.
    #[arg(long, value_delimiter = ',', value_parser = clap::value_parser!(u16).range(1..=256))]
    pub threads_list: Option<Vec<u16>>,
    /// Instruction sets to measure; if absent, all of this processor.
    #[arg(long, value_delimiter = ',', value_parser = one_of(InstructionSet::ALL, InstructionSet::name))]
    pub isa: Option<Vec<InstructionSet>>,
    /// Simulated time before the measurement, if the scene prepares no flowing state, s.
    #[arg(long, default_value_t = 0.5, value_parser = positive)]
    pub settle: f64,
    /// Timed steps of each repetition.
    #[arg(long, default_value_t = 20, value_parser = clap::value_parser!(u64).range(1..))]
    pub steps: u64,
    /// Number of repetitions of all measurements, in turn.
    #[arg(long, default_value_t = 5, value_parser = clap::value_parser!(u64).range(1..=1000))]
    pub repetitions: u64,
    /// Write the tables also next to the scene, in a folder named after processor, instruction set and number of cores.
    #[arg(long)]
    pub record: bool,
    #[command(flatten)]
    pub output: OutputArguments,
}

fn scaling(arguments: &ScalingArguments, console: &Console) -> Result<ExitCode, Failure> {
    let (file, scene, seed) = arguments.scene.load()?;
    if arguments.record {
        refuse_without_folder(&file)?;
    }
    refuse_time_budget(&scene)?;
    let cores = cores();
    let plan = plan(arguments, cores);
    let most = plan.threads.iter().copied().max().unwrap_or(1);
    if most > cores {
        console.warn(&format!("more threads than the {cores} available cores: such times are not meaningful"));
    }
    let instruction_set = plan.instruction_sets.last().copied().unwrap_or_else(InstructionSet::detect);
    let execution =
        Execution { scheduler: Scheduler::WorkStealing, threads: most, instruction_set, ..Execution::serial() };
    let provenance = Provenance::of_run(&scene, &file, seed, &execution);
    let simulation = flowing(&scene, seed, &file, &execution, arguments.settle, console)?;
    let study = {
        let bar = console.bar(&scene.name);
        let report = |message: &str| console.detail(message);
        scaling::Study::measure(&scene.name, simulation, plan, provenance, &report, &|fraction| bar.set(fraction))?
    };
    console.publish(&study, &arguments.output.folder_of("scaling", &scene), arguments.output.json)?;
    if arguments.record {
        record(&study, &file, &study.provenance, study.widest(), Some(study.machine.cores), console)?;
    }
    match study.same_bits {
        true => Ok(ExitCode::SUCCESS),
        false => Err(Failure::Running(format!("not the same bits: {}", study.differing.join("; ")))),
    }
}

/// Number of timed steps, from the first, that are traced and replayed.
const TRACED_STEPS: u64 = 10;

/// Returns the measured configurations: by default 1, 2, 4, ... threads and all cores, with every instruction set.
fn plan(arguments: &ScalingArguments, cores: usize) -> scaling::Plan {
    let mut threads: Vec<usize> = match &arguments.threads_list {
        Some(list) => list.iter().map(|&threads| usize::from(threads)).collect(),
        None => (0..).map(|k| 1 << k).take_while(|&threads| threads < cores).chain([cores]).collect(),
    };
    threads.sort_unstable();
    threads.dedup();
    let is_measured =
        |set: &InstructionSet| arguments.isa.as_ref().map_or_else(|| set.is_available(), |list| list.contains(set));
    scaling::Plan {
        // Narrowest first: the last one represents all of them.
        instruction_sets: InstructionSet::ALL.into_iter().filter(is_measured).collect(),
        threads,
        steps: arguments.steps,
        traced_steps: arguments.steps.min(TRACED_STEPS),
        repetitions: arguments.repetitions as usize,
    }
}

/// Writes the tables of a study next to its scene, in a folder named after the machine.
fn record<D: Document>(
    study: &D,
    scene_file: &Path,
    provenance: &Provenance,
    set: Option<InstructionSet>,
    cores: Option<usize>,
    console: &Console,
) -> Result<(), Failure> {
    let folder = record_folder(D::NAME, scene_file, &provenance.build.processor, set, cores);
    study.write_tables(&folder)?;
    console.note(&format!("tables: {}", folder.display()));
    Ok(())
}
