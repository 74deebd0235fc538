//! `makadam run`: one simulation and its files.

mod folder;
mod measured;
mod progress;
mod session;
mod summary;
mod writer;

use super::arguments::{OutputArguments, SceneArguments, accuracy, one_of, seconds};
use super::beforehand::{begin, tell_findings};
use super::export::export_frames;
use super::{Console, Failure, ranks};
use crate::forecast::{chosen, outside_of_accuracy};
use clap::Args;
use folder::{CheckpointFile, Task, task};
use makadam::Simulation;
use makadam::checkpoint::CheckpointError;
use makadam::lanes::InstructionSet;
use makadam::scene::{Accuracy, Precision};
use makadam::schedule::Scheduler;
use makadam_frames::execution::{Execution, threads_for};
use makadam_frames::output::{FolderLock, RunFiles, file_stem};
use makadam_frames::plan::MeasuredScene;
use makadam_frames::provenance::Provenance;
use makadam_frames::run_frames::RunFrames;
use progress::{Plan, Progress};
use session::Session;
use std::path::Path;
use std::process::ExitCode;
use std::time::Duration;

#[derive(Debug, Args)]
pub(super) struct RunArguments {
    #[command(flatten)]
    pub scene: SceneArguments,
    /// Number of threads; if absent, all cores, but at most one thread per 1,000 grains. The result does not depend on it.
    #[arg(long, value_parser = clap::value_parser!(u16).range(1..=1024))]
    pub threads: Option<u16>,
    /// Scheduler that distributes the work over threads. The result does not depend on it.
    #[arg(long, default_value = "work-stealing", value_parser = one_of(Scheduler::ALL, Scheduler::name))]
    pub scheduler: Scheduler,
    /// Instruction set of the kernels; if absent, the widest of this processor. The result does not depend on it.
    #[arg(long, value_parser = one_of(InstructionSet::ALL, InstructionSet::name))]
    pub isa: Option<InstructionSet>,
    /// Distance of prefetched bodies in a sweep, in lane groups; 0 leaves prefetching to the processor. If absent, 0 in scenes that fit into
    /// the cache, and 4 in others.
    #[arg(long, value_parser = clap::value_parser!(u16).range(..=1024))]
    pub prefetch: Option<u16>,
    /// Target accuracy, which replaces the scene's step and stopping rule: a fraction such as 1%, or deviations such as
    /// angle=0.5,packing_fraction=0.002 (also friction_mobilisation, overlap; units: degrees, none, none, mean radii).
    #[arg(long, value_parser = accuracy)]
    pub accuracy: Option<Accuracy>,
    /// Precision of the sweeps; if absent, the scene's. The result depends on it.
    #[arg(long, value_parser = one_of([Precision::Double, Precision::Single], precision_name))]
    pub precision: Option<Precision>,
    /// Number of steps, instead of the scene's duration.
    #[arg(long)]
    pub steps: Option<u64>,
    /// Print the energy and momentum budget with its closure error; costs about a sixth of a step's time.
    #[arg(long)]
    pub ledger: bool,
    /// Continue an unfinished run from its checkpoint, if present; the result is the same to the last bit. A finished run is
    /// left unchanged.
    #[arg(long, conflicts_with = "restart")]
    pub resume: bool,
    /// Start again in the folder of an earlier run: removes its frames, tables and checkpoint, and nothing else.
    #[arg(long)]
    pub restart: bool,
    /// Wall time between checkpoints, s; 0 writes one after every step.
    #[arg(long, value_name = "SECONDS", default_value_t = 60.0, value_parser = seconds)]
    pub checkpoint_interval: f64,
    #[command(flatten)]
    pub output: OutputArguments,
}

fn precision_name(precision: Precision) -> &'static str {
    match precision {
        Precision::Double => "double",
        Precision::Single => "single",
    }
}

pub(super) fn run(arguments: &RunArguments, console: &Console) -> Result<ExitCode, Failure> {
    let (file, mut scene, seed) = arguments.scene.load()?;
    if let Some(accuracy) = arguments.accuracy {
        scene.ask(accuracy);
        console.note(&format!("--accuracy chose {}", chosen(&scene)));
    }
    if let Some(note) = outside_of_accuracy(&scene) {
        console.note(&note);
    }
    let findings = tell_findings(&scene, &file, console);
    let mut start = scene.clone();
    if let Some(precision) = arguments.precision {
        scene.solver.precision = precision;
        // Refused before the preparation of a flow, which may take minutes.
        scene
            .goes_with(scene.solver.method, scene.solver.precision)
            .map_err(|error| Failure::Usage(format!("--precision single: {}: {error}; leave it out", scene.name)))?;
        // A flowing start is the same for all precisions; stages go on with the settings of their scene.
        if scene.prepare.is_none() {
            start.solver.precision = precision;
        }
    }
    let output = arguments.output.folder(&file_stem(&scene.name));
    let execution = Execution {
        scheduler: arguments.scheduler,
        // Which cores a rank may use is the launcher's affair.
        threads: match (arguments.threads, ranks::count()) {
            (Some(threads), _) => threads.into(),
            (None, 1) => threads_for(scene.most_grains()),
            (None, _) => 1,
        },
        instruction_set: arguments.isa.unwrap_or_else(InstructionSet::detect),
        prefetch: arguments.prefetch.map(usize::from),
        ..Execution::serial()
    };
    let last_step = arguments.steps.unwrap_or_else(|| scene.most_steps());
    let plan = || Plan {
        scene: &scene,
        seed,
        output: output.clone(),
        interval: Duration::from_secs_f64(arguments.checkpoint_interval),
        findings: findings.clone(),
        provenance: Provenance { ranks: ranks::count(), ..Provenance::of_run(&scene, &file, seed, &execution) },
    };
    let _lock = lock(&output, console)?;
    let mut session = match task(&output, &scene, seed, arguments, last_step)? {
        Task::Ended(record) => {
            // A process killed at its very end may leave the checkpoint, or incomplete exports.
            CheckpointFile::inside(&output).clear();
            console.note(&format!("nothing to do: {} holds this run, which has ended", output.display()));
            export_formats(&scene, &output, console)?;
            console.result(&if arguments.output.json { record.text } else { record.describe() })?;
            return Ok(ExitCode::SUCCESS);
        }
        Task::Resume => resume(arguments, last_step, plan(), &execution, console)?,
        Task::Begin => {
            if arguments.resume && RunFiles::inside(&output).any() {
                console.note(&format!("{} holds no checkpoint: beginning anew", output.display()));
            }
            let (mut simulation, _) = begin(&start, seed, &file, &execution, console)?;
            simulation.use_precision(scene.solver.precision).map_err(|error| Failure::Usage(error.to_string()))?;
            if arguments.ledger {
                simulation.open_ledger();
            }
            scene.record_walls(&mut simulation);
            ranks::divide(&mut simulation, &scene)?;
            Session::begin(plan(), simulation)?
        }
    };
    let played = session.play(last_step, console);
    let (summary, ended) = session.finish(played);
    let ended = ended.and_then(|()| export_formats(&scene, &output, console));
    console.document(&summary, arguments.output.json, || summary.text())?;
    ended?;
    Ok(ExitCode::SUCCESS)
}

/// Exports the frames of a complete run in the requested formats of its scene.
fn export_formats(scene: &MeasuredScene, output: &Path, console: &Console) -> Result<(), Failure> {
    scene.output.iter().flat_map(|output| &output.formats).try_for_each(|format| {
        let run = RunFrames::open(output)?;
        console.note(&export_frames(&run, *format, output, console)?);
        Ok(())
    })
}

/// Locks the output folder, and removes the temporary files of killed processes.
fn lock(output: &Path, console: &Console) -> Result<FolderLock, Failure> {
    let lock = FolderLock::take(output)?;
    if !lock.holds() {
        console.warn(&format!(
            "{}: the file system knows no locks; see to it that no other run writes there",
            output.display()
        ));
    }
    RunFiles::inside(output).remove_drafts()?;
    Ok(lock)
}

/// Resumes from the checkpoint in the output folder, if the arguments permit it.
fn resume<'s>(
    arguments: &RunArguments,
    last_step: u64,
    plan: Plan<'s>,
    execution: &Execution,
    console: &Console,
) -> Result<Session<'s>, Failure> {
    let file = CheckpointFile::inside(&plan.output);
    let shown = file.path().display();
    let checkpoint = file.read(plan.scene, plan.seed)?;
    let Progress { steps: taken, framed_at, .. } = checkpoint.progress;
    // The forces of a last frame are those of the previous step, which a checkpoint does not store.
    let least = if framed_at == Some(taken) { taken } else { taken + 1 };
    if last_step < least {
        return Err(Failure::Usage(format!(
            "{shown} is {taken} steps into the run, too far for one of {last_step}; it stays: give --steps {least} or more, or \
             --restart"
        )));
    }
    let mut simulation = Simulation::resume(plan.scene, &checkpoint.simulation).map_err(|error| {
        Failure::Running(match error {
            CheckpointError::Format { problem } => format!("{shown} {problem}; delete it and start anew"),
            other => other.to_string(),
        })
    })?;
    if arguments.ledger && simulation.balance().is_none() {
        return Err(Failure::Usage(format!(
            "{shown} is of a run without a ledger, which cannot be opened on the way: leave --ledger out, or give --restart"
        )));
    }
    execution.apply(&mut simulation)?;
    ranks::divide(&mut simulation, plan.scene)?;
    console.note(&format!("going on from step {} of {shown}", simulation.steps_taken()));
    Session::resume(plan, simulation, checkpoint.progress)
}
