//! Run in progress: steps, frames, watchdog, and the checkpoints for its resumption.
//!
//! The output folder is consistent after a kill or a power failure at any time. The summary says `complete: false` before any other file of
//! the run exists, and `complete: true` after all others are on the disk. A checkpoint replaces the previous one after the frames and rows
//! that it describes are on the disk.

use super::folder::{Checkpoint, CheckpointFile};
use super::measured::{MeasuredFrames, Measurements};
use super::progress::{Plan, Progress};
use super::summary::RunSummary;
use super::writer::{FrameToWrite, Marks, MarksToCome, Outputs, Writer};
use crate::commands::{Console, Failure, json};
use makadam::Simulation;
use makadam::scene::Reaction;
use makadam::snapshot::{Passages, Snapshot};
use makadam::solve::StopReason;
use makadam::watch::{Alarm, Trouble, Watchdog};
use makadam_frames::output::{RunFiles, TimeTable, WriteError, create_folder, write_durably};
use makadam_frames::run_frames::StoreWriter;
use makadam_frames::stepping::due_after;
use std::time::Instant;

/// First columns of `observables.csv`; the observables of a frame follow.
const COLUMNS: [&str; 8] = [
    "time",
    "step",
    "contacts",
    "kinetic_energy",
    "potential_energy",
    "elastic_energy",
    "sweeps",
    "residual_normal_rms",
];

/// Columns after them in a scene in which grains come or go: grains present, grains (and kg) that have come and gone.
const FLOW_COLUMNS: [&str; 5] = ["grains", "grains_in", "mass_in", "grains_out", "mass_out"];

/// Column after them in a scene with stages: number of the stage, from 0.
const STAGE_COLUMN: &str = "stage";

/// Steps between states stored for a stop by the watchdog.
const HELD_EVERY: u64 = 512;

/// Failure in `run.json` until the run ends.
const UNDER_WAY: &str = "the run is under way, or was killed: then --resume goes on from its last checkpoint";

/// Reason for no measurements before the end.
const NOT_ENDED: &str = "the run is not at its end";

/// Progress at the stored state without a violation.
struct Held {
    progress: Progress,
    marks: MarksToCome,
}

#[derive(Clone, Copy)]
struct Due {
    measured: bool,
    written: bool,
}

impl Due {
    fn any(self) -> bool {
        self.measured || self.written
    }
}

/// Run in progress.
pub(super) struct Session<'a> {
    plan: Plan<'a>,
    simulation: Simulation,
    progress: Progress,
    writer: Writer,
    watchdog: Watchdog,
    checkpoint: CheckpointFile,
    held: Option<Held>,
    phases_before: [f64; 4],
}

impl<'a> Session<'a> {
    /// Begins a run; removes the checkpoint of an earlier run in the folder first, then its other files.
    pub fn begin(plan: Plan<'a>, simulation: Simulation) -> Result<Session<'a>, Failure> {
        let progress = Progress {
            started: simulation.time(),
            contact_sweeps_before: simulation.contact_sweeps(),
            ..Progress::default()
        };
        let checkpoint = CheckpointFile::inside(&plan.output);
        checkpoint.withdraw()?;
        announce(&plan, &simulation, &progress)?;
        RunFiles::inside(&plan.output).remove()?;
        create_folder(&plan.output)?;
        let frames = StoreWriter::create(&plan.output.join(RunFiles::FRAMES), plan.scene)?;
        let flow = if plan.scene.flows() { &FLOW_COLUMNS[..] } else { &[] };
        let stage = if plan.scene.stage.is_empty() { &[][..] } else { &[STAGE_COLUMN] };
        let columns = [&COLUMNS[..], flow, stage].concat();
        let table = TimeTable::create(&plan.output.join(RunFiles::TABLE), &columns)?;
        let measured = MeasuredFrames::begin(&plan.output, plan.scene)?;
        let outputs = Outputs { folder: plan.output.clone(), frames, table, measured };
        Ok(Session::new(plan, simulation, progress, checkpoint, outputs))
    }

    /// Resumes a run.
    pub fn resume(plan: Plan<'a>, simulation: Simulation, mut progress: Progress) -> Result<Session<'a>, Failure> {
        let checkpoint = CheckpointFile::inside(&plan.output);
        let frames = StoreWriter::resume(&plan.output.join(RunFiles::FRAMES), progress.frames)?;
        let mark = std::mem::take(&mut progress.measured);
        let measured = MeasuredFrames::resume(&plan.output, plan.scene, mark, &frames)?;
        let table = TimeTable::go_on(&plan.output.join(RunFiles::TABLE), progress.table.clone())?;
        progress.continued_at.push(progress.steps);
        announce(&plan, &simulation, &progress)?;
        let outputs = Outputs { folder: plan.output.clone(), frames, table, measured };
        Ok(Session::new(plan, simulation, progress, checkpoint, outputs))
    }

    fn new(
        plan: Plan<'a>,
        simulation: Simulation,
        progress: Progress,
        checkpoint: CheckpointFile,
        outputs: Outputs,
    ) -> Session<'a> {
        Session {
            watchdog: Watchdog::new(&plan.scene.watch, &simulation),
            phases_before: phases(&simulation),
            held: None,
            writer: Writer::start(plan.scene.clone(), outputs),
            plan,
            simulation,
            progress,
            checkpoint,
        }
    }

    /// Executes the steps to the end of the last stage, with a frame at the start, at every interval and at the end of each stage.
    pub fn play(&mut self, last_step: u64, console: &Console) -> Result<(), Failure> {
        self.simulation.set_interrupt(makadam_frames::interrupt::handle());
        let bar = console.bar(&self.plan.scene.name);
        let scene = self.plan.scene;
        let due = |simulation: &Simulation, steps: u64| {
            let ends = steps == 0 || steps == last_step || simulation.has_ended();
            let is_due = |interval: f64| ends || due_after(simulation, steps, interval);
            let stage = simulation.stage().map(|stage| stage.number as usize);
            Due { measured: is_due(scene.measure.interval), written: is_due(scene.output_interval_in(stage)) }
        };
        if self.progress.framed_at.is_none() {
            self.frame(due(&self.simulation, 0))?;
        }
        let mut written = Instant::now();
        while self.progress.steps < last_step && !self.simulation.has_ended() {
            let clock = Instant::now();
            let report = self.simulation.step();
            self.progress.wall += clock.elapsed();
            if report.solve.reason == StopReason::Interrupted {
                // The step was not executed: the state is as before it.
                self.write_checkpoint()?;
                return Err(self.interrupted());
            }
            self.progress.steps += 1;
            self.progress.note(report);
            let interrupted = makadam_frames::interrupt::requested();
            let last = self.progress.steps == last_step || self.simulation.has_ended();
            let due = due(&self.simulation, self.progress.steps);
            let mut alarms = self.watchdog.observe(&self.simulation, &report);
            if let Some(late) = alarms.iter().find(|alarm| matches!(alarm.trouble, Trouble::Overdue { .. })) {
                self.write_checkpoint()?;
                self.progress.count(late);
                let state = self.checkpoint.path().display();
                return Err(Failure::Running(format!(
                    "{late}; the state is in {state}: --resume goes on with another at_most"
                )));
            }
            // States of frames are checked too.
            if last || interrupted {
                alarms.extend(self.watchdog.last(&self.simulation));
            } else if due.any() {
                alarms.extend(self.watchdog.look(&self.simulation));
            }
            self.react(&alarms, console)?;
            if due.any() {
                self.frame(due)?;
            }
            if !last && (interrupted || written.elapsed() >= self.plan.interval) {
                self.write_checkpoint()?;
                written = Instant::now();
            }
            bar.set(self.progress.steps as f64 / last_step as f64);
            bar.say(format!("{:.2} s, {} contacts", self.simulation.time() - self.progress.started, report.contacts));
            if interrupted && !last {
                return Err(self.interrupted());
            }
        }
        Ok(())
    }

    fn interrupted(&self) -> Failure {
        Failure::interrupted(&format!("in {}; --resume goes on from there", self.plan.output.display()))
    }

    /// Reports violations and stops at fatal ones; stores a state without violations.
    fn react(&mut self, alarms: &[Alarm], console: &Console) -> Result<(), Failure> {
        for alarm in alarms {
            if let Some(first) = self.progress.count(alarm) {
                console.warn(first);
            }
        }
        if let Some(alarm) = alarms.iter().find(|alarm| alarm.reaction == Reaction::Stop) {
            let mut left = String::new();
            if let Some(held) = self.held.take() {
                self.writer.sync()?;
                let marks = held.marks.wait().expect("all before the marks is written");
                self.checkpoint.write(&self.seal(self.checkpoint.take_held()?, held.progress, marks))?;
                left = format!(
                    "; the state before is in {}: --resume goes on from there with another [watch], but what else the scene says \
                     must stay, and a change of it wants --restart",
                    self.checkpoint.path().display()
                );
            }
            return Err(Failure::Running(format!("{alarm}{left}")));
        }
        let every = u64::from(self.plan.scene.watch.every);
        // The preceding check found no violation.
        if alarms.is_empty() && every > 0 && self.progress.steps.is_multiple_of(every * HELD_EVERY.div_ceil(every)) {
            self.checkpoint.hold(&self.simulation.checkpoint())?;
            self.held = Some(Held { progress: self.progress_now(), marks: self.writer.ask_for_marks()? });
        }
        Ok(())
    }

    fn progress_now(&self) -> Progress {
        Progress { phases: self.phases(), ..self.progress.clone() }
    }

    fn seal(&self, simulation: Vec<u8>, progress: Progress, marks: Marks) -> Vec<u8> {
        Checkpoint::seal(self.plan.scene, self.plan.seed, simulation, marks.put_into(progress))
    }

    fn write_checkpoint(&mut self) -> Result<(), Failure> {
        let clock = Instant::now();
        let marks = self.writer.sync()?;
        self.checkpoint.write(&self.seal(self.simulation.checkpoint(), self.progress_now(), marks))?;
        self.progress.output_time += clock.elapsed();
        Ok(())
    }

    /// Returns the wall time of the phases over the whole run, s.
    fn phases(&self) -> [f64; 4] {
        let now = phases(&self.simulation);
        std::array::from_fn(|phase| self.progress.phases[phase] + now[phase] - self.phases_before[phase])
    }

    /// Passes a frame to the writer.
    fn frame(&mut self, due: Due) -> Result<(), Failure> {
        let clock = Instant::now();
        self.writer.wait_for_room()?;
        let frame = self.simulation.snapshot();
        if let Some(grain) = self.simulation.not_finite() {
            return Err(Failure::Running(format!(
                "grain {grain} has no finite position or velocity after step {}: the scene diverged; lower solver.step",
                self.progress.steps
            )));
        }
        let row = due.measured.then(|| self.row(&frame));
        if due.measured {
            self.simulation.restart_wall_means();
        }
        self.progress.contacts = frame.contacts.len();
        self.progress.framed_at = Some(self.progress.steps);
        self.writer.write(FrameToWrite { frame, written: due.written, row })?;
        self.progress.output_time += clock.elapsed();
        Ok(())
    }

    fn row(&self, frame: &Snapshot) -> Vec<(String, f64)> {
        let energy = self.watchdog.energy(&self.simulation);
        let (sweeps, residual) = self
            .progress
            .last
            .map_or((f64::NAN, f64::NAN), |last| (f64::from(last.solve.sweeps), last.solve.residuals.normal.rms));
        let values = [
            frame.time,
            self.progress.steps as f64,
            frame.contacts.len() as f64,
            energy.kinetic,
            energy.potential,
            energy.elastic,
            sweeps,
            residual,
        ];
        let [came, went] = frame.passed;
        let grains = frame.particles.len() as f64;
        let flow = [grains, came.grains as f64, came.mass, went.grains as f64, went.mass];
        let flow = FLOW_COLUMNS.iter().zip(flow).filter(|_| self.plan.scene.flows());
        let stage = frame.stage.map(|stage| (&STAGE_COLUMN, f64::from(stage.number)));
        let cells = COLUMNS.iter().zip(values).chain(flow).chain(stage).map(|(name, value)| (name.to_string(), value));
        let gauges = self.plan.scene.gauge.iter().zip(&frame.gauges);
        cells.chain(gauges.flat_map(|(gauge, passed)| passages(&gauge.name, passed))).collect()
    }

    /// Ends the run: writes waiting frames and the summary to the disk, and removes the checkpoint of a complete run.
    pub fn finish(self, played: Result<(), Failure>) -> (RunSummary, Result<(), Failure>) {
        let clock = Instant::now();
        let phases = self.phases();
        let Session { plan, simulation, mut progress, writer, checkpoint, .. } = self;
        checkpoint.release();
        let (mut outputs, written) = writer.end();
        let (ended, took) = (played.and(written), simulation.time() - progress.started);
        // Frames are flushed while they are measured.
        let (flushed, measured) = std::thread::scope(|scope| {
            let flushed = scope.spawn(|| outputs.frames.sync());
            let measured = Measurements::of(plan.scene, &outputs.measured, &outputs.frames, ended.is_ok(), took);
            (flushed.join().expect("flushing does not panic"), measured)
        });
        let ended = ended.and_then(|()| Ok(flushed.and_then(|()| outputs.sync())?));
        let (measured, ended) = match measured {
            Ok(measured) => (measured, ended),
            // An earlier failure is reported first.
            Err(failure) => (Measurements::none(NOT_ENDED.into()), ended.and(Err(failure))),
        };
        progress.output_time += clock.elapsed();
        (progress.phases, progress.frames) = (phases, outputs.frames.mark());
        let failure = ended.as_ref().err().map(ToString::to_string);
        let mut summary = RunSummary::new(&plan, &simulation, &progress, measured, failure);
        let file = plan.output.join(RunFiles::SUMMARY);
        let written = write_durably(&file, json(&summary).as_bytes());
        let ended = ended.and_then(|()| {
            written?;
            // A checkpoint that cannot be removed is out of date by the summary.
            checkpoint.clear();
            outputs.measured.clear();
            Ok(())
        });
        if let Err(failure) = &ended {
            (summary.complete, summary.failure) = (false, Some(failure.to_string()));
        }
        (summary, ended)
    }
}

/// Returns the cells of a gauge: what has passed it forward and backward.
fn passages(gauge: &str, passed: &[Passages; 2]) -> Vec<(String, f64)> {
    let cells = ["forward", "backward"].into_iter().zip(passed).flat_map(|(way, passed)| {
        let Passages { grains, mass, momentum: [x, y, z] } = *passed;
        let values =
            [("grains", grains as f64), ("mass", mass), ("momentum_x", x), ("momentum_y", y), ("momentum_z", z)];
        values.map(|(name, value)| (format!("{name}_{way}({gauge})"), value))
    });
    cells.collect()
}

/// Writes the summary of an incomplete run to the disk.
fn announce(plan: &Plan<'_>, simulation: &Simulation, progress: &Progress) -> Result<(), WriteError> {
    let measured = Measurements::none(NOT_ENDED.into());
    let summary = RunSummary::new(plan, simulation, progress, measured, Some(UNDER_WAY.into()));
    write_durably(&plan.output.join(RunFiles::SUMMARY), json(&summary).as_bytes())
}

fn phases(simulation: &Simulation) -> [f64; 4] {
    let phases = simulation.phase_seconds();
    [phases.detect, phases.constrain, phases.sweep, phases.integrate]
}
