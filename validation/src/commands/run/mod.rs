//! `makadam run`: one simulation, and everything it leaves on disk.

mod account;
mod describe;
mod folder;
mod kept;
mod measured;
mod measuring;
mod plan;
mod progress;
mod session;
mod writer;

use super::arguments::RunArguments;
use super::beforehand::tell_findings;
use super::export::export_frames;
use super::{Console, Failure, begin, json};
use crate::execution::{Execution, threads_for};
use crate::export::Format;
use crate::forecast::chosen;
use crate::output::file_stem;
use crate::output::{FolderLock, LockError, RunFiles};
use crate::plan::Scene;
use crate::provenance::Provenance;
use crate::run_frames::RunFrames;
use crate::stepping::steps_in;
use describe::describe;
use folder::{Task, Wish, task};
use kept::Place;
use makadam::Simulation;
use makadam::checkpoint::CheckpointError;
use makadam::lanes::InstructionSet;
use makadam::scene::Finding;
use plan::Plan;
use progress::Progress;
use session::Session;
use std::path::Path;
use std::process::ExitCode;
use std::time::Duration;

/// Simulates a scene.
pub(super) fn run(arguments: &RunArguments, console: &Console) -> Result<ExitCode, Failure> {
    let (file, mut scene, seed) = arguments.scene.load()?;
    if let Some(accuracy) = arguments.accuracy {
        scene.ask(accuracy);
        console.note(&format!("--accuracy chose {}", chosen(&scene)));
    }
    let findings = tell_findings(&scene, &file, console);
    let start = scene.clone();
    if let Some(precision) = arguments.precision {
        scene.solver.precision = precision.into();
        // Said before a flow is prepared for minutes.
        scene
            .goes_with(scene.solver.method, scene.solver.precision)
            .map_err(|error| Failure::Usage(format!("--precision single: {}: {error}; leave it out", scene.name)))?;
    }
    let output = arguments.output.folder(&file_stem(&scene.name));
    let execution = Execution {
        scheduler: arguments.scheduler.into(),
        threads: arguments.threads.map_or_else(|| threads_for(scene.grain_count()), usize::from),
        instruction_set: arguments.isa.map_or_else(InstructionSet::detect, InstructionSet::from),
        prefetch: arguments.prefetch.map(usize::from),
        ..Execution::serial()
    };
    let asked = Asked { arguments, file: &file, seed, output: &output, execution: &execution, findings, console };
    let _lock = asked.take_folder()?;
    let steps = asked.steps(&scene);
    let wish = Wish { resume: arguments.resume, restart: arguments.restart, ledger: arguments.ledger, steps };
    let mut session = match task(&output, &scene, seed, wish)? {
        Task::Ended(record) => {
            // What a process that was killed at its very end has not removed.
            Place::inside(&output).clear();
            console.note(&format!("nothing to do: {} holds this run, which has ended", output.display()));
            // An earlier process may have ended during the exports.
            export_formats(&scene, &output, console)?;
            console.result(&if arguments.output.json { record.text } else { record.describe() })?;
            return Ok(ExitCode::SUCCESS);
        }
        Task::GoOn => asked.go_on(&scene, steps)?,
        Task::Begin => {
            if arguments.resume && RunFiles::inside(&output).any() {
                console.note(&format!("{} holds no checkpoint: beginning anew", output.display()));
            }
            // A flowing start is the same for all precisions.
            let (mut simulation, _) = begin(&start, seed, &file, &execution, console)?;
            simulation.use_precision(scene.solver.precision).map_err(|error| Failure::Usage(error.to_string()))?;
            if arguments.ledger {
                simulation.open_ledger();
            }
            Session::begin(asked.plan(&scene), simulation)?
        }
    };
    let played = session.play(steps, console);
    let (summary, ended) = session.finish(played);
    let ended = ended.and_then(|()| export_formats(&scene, &output, console));
    console.result(&if arguments.output.json { json(&summary) } else { describe(&summary) })?;
    ended?;
    Ok(ExitCode::SUCCESS)
}

/// Exports the frames of a complete run in the formats that its scene requests.
fn export_formats(scene: &Scene, output: &Path, console: &Console) -> Result<(), Failure> {
    scene.output.iter().flat_map(|output| &output.formats).try_for_each(|format| {
        let run = RunFrames::open(output)?;
        console.note(&export_frames(&run, Format::of(*format), output, console)?);
        Ok(())
    })
}

/// What was asked for.
struct Asked<'a> {
    arguments: &'a RunArguments,
    file: &'a Path,
    seed: u64,
    output: &'a Path,
    execution: &'a Execution,
    findings: Vec<Finding>,
    console: &'a Console,
}

impl<'a> Asked<'a> {
    /// Takes the output folder for this run alone and clears away what runs that were killed had not finished.
    fn take_folder(&self) -> Result<FolderLock, Failure> {
        let lock = FolderLock::take(self.output).map_err(|error| match error {
            LockError::Taken { .. } => Failure::Usage(error.to_string()),
            LockError::Write(error) => error.into(),
        })?;
        if !lock.holds() {
            self.console.warn(&format!(
                "{}: the file system knows no locks; see to it that no other run writes there",
                self.output.display()
            ));
        }
        RunFiles::inside(self.output).remove_drafts()?;
        Ok(lock)
    }

    fn steps(&self, scene: &Scene) -> u64 {
        self.arguments.steps.unwrap_or_else(|| steps_in(scene.duration, scene.solver.step))
    }

    fn plan<'s>(&self, scene: &'s Scene) -> Plan<'s> {
        Plan {
            scene,
            seed: self.seed,
            output: self.output.into(),
            interval: Duration::from_secs_f64(self.arguments.checkpoint_interval),
            findings: self.findings.clone(),
            provenance: Provenance::of_run(scene, self.file, self.seed, self.execution),
        }
    }

    /// Goes on from the checkpoint in the output folder; what is asked for must be possible from there.
    fn go_on<'s>(&self, scene: &'s Scene, steps: u64) -> Result<Session<'s>, Failure> {
        let place = Place::inside(self.output);
        let shown = place.file().display();
        let kept = place.read(scene, self.seed)?;
        let Progress { steps: taken, framed_at, .. } = kept.progress;
        // The forces of a last frame are those of the step before it, which a checkpoint does not hold.
        let least = if framed_at == Some(taken) { taken } else { taken + 1 };
        if steps < least {
            return Err(Failure::Usage(format!(
                "{shown} is {taken} steps into the run, too far for one of {steps}; it stays: give --steps {least} or more, or \
                 --restart"
            )));
        }
        let mut simulation = Simulation::resume(scene, &kept.simulation).map_err(|error| {
            Failure::Running(match error {
                CheckpointError::Format { problem } => format!("{shown} {problem}; delete it and start anew"),
                other => other.to_string(),
            })
        })?;
        if self.arguments.ledger && simulation.balance().is_none() {
            return Err(Failure::Usage(format!(
                "{shown} is of a run without a ledger, which cannot be opened on the way: leave --ledger out, or give --restart"
            )));
        }
        self.execution.apply(&mut simulation)?;
        self.console.note(&format!("going on from step {} of {shown}", simulation.steps_taken()));
        Session::go_on(self.plan(scene), simulation, kept.progress)
    }
}
