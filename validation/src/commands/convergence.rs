//! `makadam convergence`: how each method converges on the problem of one step.

use super::arguments::ConvergenceArguments;
use super::{Console, Failure, begin, can_record, json, load, settle};
use crate::convergence::{self, Curve, LeftOut, Problem, Study};
use crate::execution::Execution;
use crate::output::record_folder;
use crate::plan::Scene;
use crate::prepared::{Start, file_stem};
use crate::provenance::Provenance;
use makadam::scene::{Precision, SolverMethod, SolverSettings};
use makadam::schedule::Scheduler;
use std::path::PathBuf;
use std::process::ExitCode;

/// Solves one problem with every method, writes and says what was found.
pub(super) fn convergence(arguments: &ConvergenceArguments, console: &Console) -> Result<ExitCode, Failure> {
    let (file, scene) = load(&arguments.scene)?;
    if arguments.record {
        can_record(&file)?;
    }
    let seed = arguments.seed.unwrap_or(scene.seed);
    let wanted = methods(&scene, arguments.methods.as_deref());
    let threads = usize::from(arguments.threads);
    let scheduler = if threads > 1 { Scheduler::WorkStealing } else { Scheduler::Serial };
    let execution = Execution { scheduler, threads, ..Execution::serial() };
    let provenance = Provenance::of_run(&scene, &file, seed, &execution);
    // Told before the minutes that a flowing state may take.
    if arguments.methods.is_some()
        && let Some(unsuitable) = wanted.iter().find(|method| !scene.accepts(&with(&scene, **method)))
    {
        let scene_words = match scene.solver.precision {
            Precision::Single => "single precision goes",
            Precision::Double => "its torques or driven walls go",
        };
        return Err(Failure::Usage(format!(
            "{} cannot be solved with {}: {scene_words} with gauss-seidel alone; leave that method out of --methods",
            scene.name,
            unsuitable.name()
        )));
    }
    let (mut simulation, start) = begin(&scene, seed, &file, &execution, console)?;
    let settling = match start {
        Start::Fresh => Some(scene.measure.from.unwrap_or(scene.duration)),
        Start::Prepared(_) | Start::Remade(..) => None,
    };
    if let Some(seconds) = arguments.settle.or(settling) {
        settle(&mut simulation, seconds, console)?;
    }
    let mut left_out = Vec::new();
    let mut methods = Vec::new();
    for method in wanted {
        match simulation.suits(method) {
            Ok(()) => methods.push(method),
            Err(unsuitable) => left_out.push(LeftOut { method: unsuitable.method, reason: unsuitable.reason }),
        }
    }
    let problem = Problem::next(&scene, &simulation);
    if problem.contacts == 0 {
        return Err(Failure::Usage(format!(
            "{} has no contacts at {} s, so there is no problem to solve; give another time with --settle",
            scene.name, problem.start_seconds
        )));
    }
    let bar = console.bar(&scene.name);
    let mut solves = vec![Vec::new(); methods.len()];
    // In turn, so that what interferes for a while falls on all methods.
    for repetition in 0..arguments.repetitions as usize {
        for (place, &method) in methods.iter().enumerate() {
            let share = place as f64 / methods.len() as f64;
            bar.say(method.name().into());
            bar.set((repetition as f64 + share) / f64::from(arguments.repetitions));
            solves[place].push(simulation.convergence(method, arguments.iterations).expect("it suits"));
            if crate::interrupt::requested() {
                return Err(Failure::Interrupted("nothing: the methods were not finished".into()));
            }
        }
    }
    drop(bar);
    let unit = problem.residual_unit;
    let curves = methods.into_iter().zip(solves).map(|(method, solves)| Curve::new(method, solves, unit)).collect();
    let study = Study::new(problem, [arguments.iterations, arguments.repetitions], curves, left_out, provenance);

    let folder = arguments
        .output
        .clone()
        .unwrap_or_else(|| PathBuf::from("results").join("convergence").join(file_stem(&scene.name)));
    let page = convergence::write(&study, &folder)?;
    console.result(&match arguments.json {
        true => json(&study),
        false => format!("{}\npage: {}", convergence::table(&study), page.display()),
    })?;
    if arguments.record {
        let processor = &study.provenance.build.processor;
        let folder = record_folder("convergence", &file, processor, Some(execution.instruction_set));
        convergence::write_tables(&study, &folder)?;
        console.note(&format!("table: {}", folder.display()));
    }
    Ok(ExitCode::SUCCESS)
}

/// The scene's settings with another method.
fn with(scene: &Scene, method: SolverMethod) -> SolverSettings {
    SolverSettings { method, ..scene.solver.clone() }
}

/// The methods of these names, each once; the scene's own method has its parameters, others have the defaults.
fn methods(scene: &Scene, names: Option<&[String]>) -> Vec<SolverMethod> {
    let own = scene.solver.method;
    let wanted = |method: &SolverMethod| names.is_none_or(|names| names.iter().any(|name| name == method.name()));
    let all = SolverMethod::ALL.into_iter().filter(wanted);
    all.map(|method| if method.name() == own.name() { own } else { method }).collect()
}
