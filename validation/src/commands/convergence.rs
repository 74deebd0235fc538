//! `makadam lab convergence`: how each method converges on the problem of one step.

use super::arguments::ConvergenceArguments;
use super::{Console, Failure, begin, can_record, publish, settle};
use crate::convergence::{self, Effort, Problem, Study};
use crate::execution::Execution;
use crate::output::record_folder;
use crate::prepared::Start;
use crate::provenance::Provenance;
use crate::study::Document;
use makadam::schedule::Scheduler;
use std::process::ExitCode;

/// Solves one problem with every method, writes and says what was found.
pub(super) fn convergence(arguments: &ConvergenceArguments, console: &Console) -> Result<ExitCode, Failure> {
    let (file, scene, seed) = arguments.scene.load()?;
    if arguments.record {
        can_record(&file)?;
    }
    let wanted = convergence::methods(&scene, arguments.methods.as_deref());
    let threads = usize::from(arguments.threads);
    let scheduler = if threads > 1 { Scheduler::WorkStealing } else { Scheduler::Serial };
    let execution = Execution { scheduler, threads, ..Execution::serial() };
    let provenance = Provenance::of_run(&scene, &file, seed, &execution);
    // Told before the minutes that a flowing state may take.
    if arguments.methods.is_some() {
        let precision = scene.solver.precision;
        wanted
            .iter()
            .try_for_each(|method| scene.goes_with(*method, precision))
            .map_err(|error| Failure::Usage(format!("{}: {error}; leave that method out of --methods", scene.name)))?;
    }
    let (mut simulation, start) = begin(&scene, seed, &file, &execution, console)?;
    let settling = match start {
        Start::Fresh => Some(scene.measure.from.unwrap_or(scene.duration)),
        Start::Prepared(_) | Start::Remade(..) => None,
    };
    if let Some(seconds) = arguments.settle.or(settling) {
        settle(&mut simulation, seconds, console)?;
    }
    let (methods, left_out) = convergence::suitable(&simulation, wanted);
    let problem = Problem::next(&scene, &simulation);
    if problem.contacts == 0 {
        return Err(Failure::Usage(format!(
            "{} has no contacts at {} s, so there is no problem to solve; give another time with --settle",
            scene.name, problem.start_seconds
        )));
    }
    let bar = console.bar(&scene.name);
    let effort = Effort { iterations: arguments.iterations, repetitions: arguments.repetitions };
    let curves = convergence::solve(&simulation, &methods, effort, &|method, share| {
        bar.say(method.name().into());
        bar.set(share);
    });
    drop(bar);
    let curves = curves.map_err(|_| Failure::Interrupted("none, the methods were not finished".into()))?;
    let study = Study::new(problem, effort, curves, left_out, provenance);

    let folder = arguments.output.folder_of("convergence", &scene);
    publish(&study, &folder, arguments.output.json, console)?;
    if arguments.record {
        let processor = &study.provenance.build.processor;
        let folder = record_folder("convergence", &file, processor, Some(execution.instruction_set), None);
        study.write_tables(&folder)?;
        console.note(&format!("table: {}", folder.display()));
    }
    Ok(ExitCode::SUCCESS)
}
