//! `makadam lab convergence`: convergence of each method on the problem of one step.

use super::arguments::{OutputArguments, SceneArguments, positive};
use super::beforehand::{begin, refuse_without_folder, settle};
use super::{Console, Failure};
use clap::Args;
use makadam::scene::SolverMethod;
use makadam::schedule::Scheduler;
use makadam_compare::prepared::Start;
use makadam_compare::study::Document;
use makadam_frames::execution::Execution;
use makadam_frames::output::record_folder;
use makadam_frames::provenance::Provenance;
use makadam_studies::convergence::{self, Effort};
use std::process::ExitCode;

#[derive(Debug, Args)]
pub(super) struct ConvergenceArguments {
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
    #[command(flatten)]
    pub output: OutputArguments,
}

pub(super) fn convergence(arguments: &ConvergenceArguments, console: &Console) -> Result<ExitCode, Failure> {
    let (file, scene, seed) = arguments.scene.load()?;
    if arguments.record {
        refuse_without_folder(&file)?;
    }
    let wanted = convergence::methods(&scene, arguments.methods.as_deref());
    let threads = usize::from(arguments.threads);
    let scheduler = if threads > 1 { Scheduler::WorkStealing } else { Scheduler::Serial };
    let execution = Execution { scheduler, threads, ..Execution::serial() };
    let provenance = Provenance::of_run(&scene, &file, seed, &execution);
    // Refused before the minutes that a flowing state may take.
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
        let processor = &study.provenance.build.processor;
        let folder = record_folder("convergence", &file, processor, Some(execution.instruction_set), None);
        study.write_tables(&folder)?;
        console.note(&format!("table: {}", folder.display()));
    }
    Ok(ExitCode::SUCCESS)
}
