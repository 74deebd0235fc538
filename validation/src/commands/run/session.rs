//! A run under way: steps, frames, what is watched, and the checkpoints that it can be continued from.
//!
//! What stands in the output folder is written in an order that no kill and no cut of power can turn into a lie. The summary says
//! `complete: false` before anything else of the run is there, and `complete: true` after all else is on the disk; a checkpoint
//! takes the place of the one before after the frames and rows that it speaks of are on the disk.

use super::account::Account;
use super::kept::{Kept, Place};
use super::measured::MeasuredFrames;
use super::measuring::{instant, measure};
use super::plan::Plan;
use super::progress::Progress;
use crate::commands::{Console, Failure, json};
use crate::output::{FrameWriter, RunFiles, RunSummary, TimeTable, WriteError, write_durably};
use crate::stepping::frame_is_due;
use makadam::Simulation;
use makadam::checkpoint::sync_folder;
use makadam::scene::Reaction;
use makadam::snapshot::Snapshot;
use makadam::solve::StopReason;
use makadam::watch::{Alarm, Watchdog};
use std::time::Instant;

/// First columns of `observables.csv`; what is measured of each frame follows.
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

/// Steps from one state that is held ready, in case of trouble, to the next.
const HELD_EVERY: u64 = 512;

/// What `run.json` says from the beginning of a run to its end.
const UNDER_WAY: &str = "the run is under way, or was killed: then --resume goes on from its last checkpoint";

/// What a run writes to.
struct Outputs {
    frames: FrameWriter,
    table: TimeTable,
    measured: MeasuredFrames,
    place: Place,
}

/// What is done with the state after a step.
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

/// A run under way.
pub(super) struct Session<'a> {
    plan: Plan<'a>,
    simulation: Simulation,
    progress: Progress,
    frames: FrameWriter,
    table: TimeTable,
    measured: MeasuredFrames,
    watchdog: Watchdog,
    place: Place,
    /// A sealed checkpoint from before anything was noticed; empty before there is one.
    held: Vec<u8>,
    phases_before: [f64; 4],
}

impl<'a> Session<'a> {
    /// A run that begins: what an earlier one has left in the folder is withdrawn first, then removed.
    pub fn begin(plan: Plan<'a>, simulation: Simulation) -> Result<Session<'a>, Failure> {
        let progress = Progress {
            started: simulation.time(),
            contact_sweeps_before: simulation.contact_sweeps(),
            ..Progress::default()
        };
        let place = Place::inside(&plan.output);
        // While the frames that it speaks of are there: nobody may go on from it once they are not.
        place.withdraw()?;
        announce(&plan, &simulation, &progress)?;
        RunFiles::inside(&plan.output).remove()?;
        let frames = FrameWriter::create(&plan.output, plan.scene)?;
        let table = TimeTable::create(&plan.output.join(RunFiles::TABLE), &COLUMNS)?;
        let measured = MeasuredFrames::begin(&plan.output);
        Ok(Session::new(plan, simulation, progress, Outputs { frames, table, measured, place }))
    }

    /// A run that goes on.
    pub fn go_on(plan: Plan<'a>, simulation: Simulation, mut progress: Progress) -> Result<Session<'a>, Failure> {
        let place = Place::inside(&plan.output);
        let measured = MeasuredFrames::go_on(&plan.output, std::mem::take(&mut progress.measured))?;
        let frames = FrameWriter::go_on(&plan.output, plan.scene, progress.frames)?;
        let table = TimeTable::go_on(&plan.output.join(RunFiles::TABLE), progress.table.clone())?;
        RunFiles::inside(&plan.output).remove_frames_from(frames.count())?;
        progress.continued_at.push(progress.steps);
        announce(&plan, &simulation, &progress)?;
        Ok(Session::new(plan, simulation, progress, Outputs { frames, table, measured, place }))
    }

    fn new(plan: Plan<'a>, simulation: Simulation, progress: Progress, outputs: Outputs) -> Session<'a> {
        let Outputs { frames, table, measured, place } = outputs;
        Session {
            watchdog: Watchdog::new(&plan.scene.watch, &simulation),
            phases_before: phases(&simulation),
            held: Vec::new(),
            plan,
            simulation,
            progress,
            frames,
            table,
            measured,
            place,
        }
    }

    /// Takes the steps, with a frame at the start, at every interval and at the end.
    pub fn play(&mut self, last_step: u64, console: &Console) -> Result<(), Failure> {
        self.simulation.heed(crate::interrupt::handle());
        let bar = console.bar(&self.plan.scene.name);
        let (step_seconds, scene) = (self.simulation.time_step(), self.plan.scene);
        let due = |steps: u64| Due {
            measured: steps == 0 || steps == last_step || frame_is_due(steps, step_seconds, scene.measure.interval),
            written: steps == 0 || steps == last_step || frame_is_due(steps, step_seconds, scene.output_interval()),
        };
        if self.progress.framed_at.is_none() {
            self.frame(due(0))?;
        }
        let mut written = Instant::now();
        while self.progress.steps < last_step {
            let clock = Instant::now();
            let report = self.simulation.step();
            self.progress.wall += clock.elapsed();
            if report.solve.reason == StopReason::Interrupted {
                // The step is not taken: all is as before it.
                self.write_checkpoint()?;
                return Err(self.interrupted());
            }
            self.progress.steps += 1;
            self.progress.note(report);
            let interrupted = crate::interrupt::requested();
            let last = self.progress.steps == last_step;
            let due = due(self.progress.steps);
            let mut alarms = self.watchdog.observe(&self.simulation, &report);
            // What is measured or left behind is looked at too.
            if last || interrupted {
                alarms.extend(self.watchdog.last(&self.simulation));
            } else if due.any() {
                alarms.extend(self.watchdog.look(&self.simulation));
            }
            self.heed(&alarms, console)?;
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
        Failure::Interrupted(match self.plan.go_on_with {
            Some(arguments) => format!("in {}; {arguments} goes on from there", self.plan.shown),
            None => format!("thrown away; the complete run before it is in {}", self.plan.shown),
        })
    }

    /// Heeds what was noticed; holds a state from before it ready.
    fn heed(&mut self, alarms: &[Alarm], console: &Console) -> Result<(), Failure> {
        for alarm in alarms {
            if let Some(first) = self.progress.count(alarm) {
                console.warn(first);
            }
        }
        if let Some(alarm) = alarms.iter().find(|alarm| alarm.reaction == Reaction::Stop) {
            let mut left = String::new();
            if self.plan.go_on_with.is_some() && !self.held.is_empty() {
                self.sync()?;
                self.place.write(&self.held)?;
                left = format!(
                    "; the state before is in {}: --resume goes on from there with another [watch], but what else the scene says \
                     must stay, and a change of it wants --restart",
                    self.place.file().display()
                );
            }
            return Err(Failure::Running(format!("{alarm}{left}")));
        }
        let every = u64::from(self.plan.scene.watch.every);
        // A look has just found nothing wrong.
        if alarms.is_empty() && every > 0 && self.progress.steps.is_multiple_of(every * HELD_EVERY.div_ceil(every)) {
            self.held = self.checkpoint();
        }
        Ok(())
    }

    fn checkpoint(&self) -> Vec<u8> {
        let progress = Progress {
            frames: self.frames.written(),
            table: self.table.written().clone(),
            measured: self.measured.mark(),
            phases: self.phases(),
            ..self.progress.clone()
        };
        Kept::seal(self.plan.scene, self.plan.seed, self.simulation.checkpoint(), progress)
    }

    fn write_checkpoint(&mut self) -> Result<(), Failure> {
        if self.plan.go_on_with.is_none() {
            return Ok(());
        }
        let clock = Instant::now();
        self.sync()?;
        self.place.write(&self.checkpoint())?;
        self.progress.output_time += clock.elapsed();
        Ok(())
    }

    /// Writes frames, collections and table to the disk.
    fn sync(&mut self) -> Result<(), WriteError> {
        self.frames.sync()?;
        self.table.sync()?;
        self.measured.sync()?;
        sync_folder(&self.plan.output).map_err(|source| WriteError::new(&self.plan.output, source))
    }

    /// Wall time of the phases over the whole run, s.
    fn phases(&self) -> [f64; 4] {
        let now = phases(&self.simulation);
        std::array::from_fn(|phase| self.progress.phases[phase] + now[phase] - self.phases_before[phase])
    }

    /// Writes a frame, or measures it and writes a row of the table, or both.
    fn frame(&mut self, due: Due) -> Result<(), Failure> {
        let clock = Instant::now();
        let frame = self.simulation.snapshot();
        if let Some(grain) = self.simulation.not_finite() {
            return Err(Failure::Running(format!(
                "grain {grain} has no finite position or velocity after step {}: the scene diverged; lower solver.step",
                self.progress.steps
            )));
        }
        if due.written {
            self.frames.write(&frame)?;
        }
        (self.progress.particles, self.progress.contacts) = (frame.particles.len(), frame.contacts.len());
        self.progress.framed_at = Some(self.progress.steps);
        if due.measured {
            self.measure_frame(frame)?;
        }
        self.progress.output_time += clock.elapsed();
        Ok(())
    }

    /// Measures a frame and writes a row of the table.
    fn measure_frame(&mut self, frame: Snapshot) -> Result<(), Failure> {
        let scene = self.plan.scene;
        let energy = self.simulation.energy();
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
        let known = COLUMNS.iter().map(ToString::to_string).zip(values).filter(|(_, value)| value.is_finite());
        let measured = instant(scene, &frame).into_iter().filter(|(name, _)| !COLUMNS.contains(&name.as_str()));
        let driven = frame.driven_walls.iter().flat_map(|driven| {
            let name = &scene.wall[driven.wall as usize].name;
            [(format!("{name}_displacement"), driven.displacement), (format!("{name}_rate"), driven.rate)]
        });
        let row: Vec<(String, f64)> = known.chain(measured).chain(driven).collect();
        self.table.push(row)?;
        self.measured.push(scene, frame)?;
        Ok(())
    }

    /// Ends the run: writes all that waits and the summary to the disk, and removes the checkpoint of a run that reached its last
    /// step.
    pub fn finish(mut self, played: Result<(), Failure>) -> (RunSummary, Result<(), Failure>) {
        let ended = played.and_then(|()| Ok(self.sync()?));
        let took = self.simulation.time() - self.progress.started;
        let measured = measure(self.plan.scene, &self.measured, ended.is_ok(), took);
        let (measured, ended) = match measured {
            Ok(measured) => (Some(measured), ended),
            // What failed before is told first.
            Err(failure) => (None, ended.and(Err(failure))),
        };
        let mut summary = self.account().summary(ended.as_ref().err().map(ToString::to_string));
        if let Some(measured) = measured {
            (summary.observables, summary.not_measured) = (measured.observables, measured.not_measured);
        }
        let file = self.plan.output.join(RunFiles::SUMMARY);
        let written = write_durably(&file, json(&summary).as_bytes());
        let ended = ended.and_then(|()| {
            written?;
            // What cannot be removed is found out of date by the summary beside it.
            self.place.clear();
            self.measured.clear();
            Ok(())
        });
        if let Err(failure) = &ended {
            (summary.complete, summary.failure) = (false, Some(failure.to_string()));
        }
        (summary, ended)
    }

    fn account(&self) -> Account<'_> {
        let mut account = Account::new(&self.plan, &self.simulation, &self.progress);
        (account.phases, account.frames) = (self.phases(), self.frames.count());
        account
    }
}

/// Writes a summary that says that the run is not complete, to the disk.
fn announce(plan: &Plan<'_>, simulation: &Simulation, progress: &Progress) -> Result<(), WriteError> {
    let summary = Account::new(plan, simulation, progress).summary(Some(UNDER_WAY.into()));
    write_durably(&plan.output.join(RunFiles::SUMMARY), json(&summary).as_bytes())
}

fn phases(simulation: &Simulation) -> [f64; 4] {
    let phases = simulation.phase_seconds();
    [phases.detect, phases.constrain, phases.sweep, phases.integrate]
}
