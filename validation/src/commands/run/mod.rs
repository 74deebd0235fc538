//! `makadam run`: one simulation, and everything it leaves on disk.

mod budget;
mod describe;
mod kept;
mod measured;
mod session;

use super::arguments::RunArguments;
use super::beforehand::tell_findings;
use super::{Console, Failure, begin, json, load};
use crate::execution::{Execution, cores};
use crate::output::{create_folder, write_whole};
use crate::prepared::{file_stem, steps_in};
use crate::provenance::Provenance;
use describe::describe;
use kept::Place;
use makadam::Simulation;
use makadam::lanes::InstructionSet;
use makadam::scene::Scene;
use session::Session;
use std::path::PathBuf;
use std::process::ExitCode;
use std::time::Duration;

/// Simulates a scene.
pub(super) fn run(arguments: &RunArguments, console: &Console) -> Result<ExitCode, Failure> {
    let (file, mut scene) = load(&arguments.scene)?;
    if let Some(accuracy) = arguments.accuracy {
        scene.ask(accuracy);
    }
    if arguments.time_budget.is_some() {
        scene.ask(budget::COARSEST);
    }
    let findings = tell_findings(&scene, &file, console);
    let start = scene.clone();
    if let Some(precision) = arguments.precision {
        scene.solver.precision = precision.into();
        // Said before a flow is prepared for minutes.
        if !scene.accepts(&scene.solver) {
            return Err(Failure::Usage(format!(
                "--precision single: {} has contacts that resist turning, driven walls or a method other than gauss-seidel, \
                 which go with double precision alone; leave it out",
                scene.name
            )));
        }
    }
    let seed = arguments.seed.unwrap_or(scene.seed);
    let output = arguments.output.clone().unwrap_or_else(|| PathBuf::from("results").join(file_stem(&scene.name)));
    let execution = Execution {
        scheduler: arguments.scheduler.into(),
        threads: arguments.threads.map_or_else(cores, usize::from),
        instruction_set: arguments.isa.map_or_else(InstructionSet::detect, InstructionSet::from),
        prefetch: arguments.prefetch.map(usize::from),
        ..Execution::serial()
    };
    let interval = Duration::from_secs_f64(arguments.checkpoint_interval);
    let place = Place::inside(&output);
    if place.is_taken() && !arguments.resume && !arguments.restart {
        return Err(Failure::Usage(format!(
            "{} is left of a run that did not end: --resume goes on from there, --restart throws it away, --output writes \
             elsewhere",
            place.file().display()
        )));
    }
    let mut session = if arguments.resume && place.is_taken() {
        let kept = place.read(&scene, seed)?;
        let mut simulation = Simulation::resume(&scene, &kept.simulation, place.file())
            .map_err(|error| Failure::Running(error.to_string()))?;
        execution.apply(&mut simulation)?;
        console.note(&format!("going on from step {} of {}", simulation.steps_taken(), place.file().display()));
        Session::go_on(&scene, seed, simulation, kept.progress, &output, interval)?
    } else {
        // A flowing start is the same for all precisions.
        let (mut simulation, _) = begin(&start, seed, &file, &execution, console)?;
        simulation.use_precision(scene.solver.precision).map_err(|error| Failure::Usage(error.to_string()))?;
        if arguments.ledger {
            simulation.open_ledger();
        }
        create_folder(&output)?;
        place.clear();
        Session::begin(&scene, seed, simulation, &output, interval)?
    };
    let provenance = |scene: &Scene| Provenance::of_run(scene, &file, seed, &execution);
    let steps = |scene: &Scene| arguments.steps.unwrap_or_else(|| steps_in(scene.duration, scene.solver.step));
    let played = session.play(steps(&scene), console);
    let mut summary = session.summary(provenance(&scene), &output, &played)?;
    let mut played = played;
    let finer = arguments.time_budget.filter(|_| played.is_ok()).and_then(|budget| {
        let left = budget - summary.wall_seconds;
        budget::finer(&scene, summary.wall_seconds, left)
    });
    if let Some(finer) = finer {
        console.note(&format!(
            "a step of {:e} s took {:.1} s; there is time for one of {:e} s",
            scene.solver.step, summary.wall_seconds, finer.solver.step
        ));
        let (mut simulation, _) = begin(&finer, seed, &file, &execution, console)?;
        if arguments.ledger {
            simulation.open_ledger();
        }
        let mut again = Session::begin(&finer, seed, simulation, &output, interval)?;
        played = again.play(steps(&finer), console);
        summary = again.summary(provenance(&finer), &output, &played)?;
    }
    summary.findings = findings;
    let text = json(&summary);
    let written = write_whole(&output.join("run.json"), text.as_bytes());
    console.result(&if arguments.json { text } else { describe(&summary) })?;
    played?;
    written?;
    Ok(ExitCode::SUCCESS)
}
