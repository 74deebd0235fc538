//! A run under way: steps, frames, what is watched, and the checkpoints that it can be continued from.

use super::kept::{Kept, Place};
use crate::commands::{Console, Failure};
use crate::observables;
use crate::output::{
    AlarmSummary, FrameWriter, JSON_VERSION, Measured, PhaseTimes, RunSummary, SolveSummary, TimeTable,
};
use crate::peers::frame_is_due;
use crate::provenance::{Provenance, VERSION, peak_bytes};
use crate::recording::Recording;
use makadam::scene::{Reaction, Scene};
use makadam::snapshot::Snapshot;
use makadam::solve::StopReason;
use makadam::watch::{Alarm, Watchdog};
use makadam::{Simulation, StepReport};
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use std::path::Path;
use std::time::{Duration, Instant};

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

/// A run under way.
pub(super) struct Session<'a> {
    scene: &'a Scene,
    seed: u64,
    simulation: Simulation,
    progress: Progress,
    frames: FrameWriter,
    table: TimeTable,
    /// Frames that are measured at the end, with their numbers.
    kept: Vec<(usize, Snapshot)>,
    watchdog: Watchdog,
    place: Place,
    /// Wall time from one checkpoint to the next.
    interval: Duration,
    held: Held,
    phases_before: [f64; 4],
}

/// A checkpoint from before anything was noticed, held in memory.
#[derive(Default)]
struct Held {
    sealed: Vec<u8>,
    /// The frame that it speaks of, where only the last one is measured.
    frame: Option<(usize, Snapshot)>,
}

/// A run's account of itself: what its summary needs and a simulation does not know.
#[derive(Clone, Default, Serialize, Deserialize)]
pub(super) struct Progress {
    /// Simulated time at the start, s.
    started: f64,
    contact_sweeps_before: u64,
    /// Wall time of the phases before the run was continued, s.
    phases: [f64; 4],
    steps: u64,
    wall: Duration,
    output_time: Duration,
    last: Option<StepReport>,
    worst_normal_rms: f64,
    solves: Solves,
    /// Simulated times of the frames on disk, s.
    frames: Vec<f64>,
    columns: Vec<String>,
    rows: Vec<Vec<Option<f64>>>,
    /// Numbers of the frames that are measured at the end.
    kept: Vec<usize>,
    /// Steps at which the run was continued.
    continued_at: Vec<u64>,
    alarms: BTreeMap<String, AlarmCount>,
}

/// Alarms of one kind.
#[derive(Clone, Default, Serialize, Deserialize)]
struct AlarmCount {
    first: String,
    count: u64,
    grave: bool,
}

/// What the solves of a run took.
#[derive(Clone, Default, Serialize, Deserialize)]
struct Solves {
    count: u64,
    sweeps: u64,
    most: u32,
    unconverged: u64,
}

impl Solves {
    fn add(&mut self, report: &StepReport) {
        self.count += u64::from(report.solve.reason != StopReason::NoContacts);
        self.sweeps += u64::from(report.solve.sweeps);
        self.most = self.most.max(report.solve.sweeps);
        self.unconverged += u64::from(report.solve.reason == StopReason::MaxSweeps);
    }
}

impl<'a> Session<'a> {
    /// A run that begins.
    pub fn begin(
        scene: &'a Scene,
        seed: u64,
        simulation: Simulation,
        output: &Path,
        interval: Duration,
    ) -> Result<Session<'a>, Failure> {
        let progress = Progress {
            started: simulation.time(),
            contact_sweeps_before: simulation.contact_sweeps(),
            ..Progress::default()
        };
        Ok(Session {
            watchdog: Watchdog::new(&scene.watch, &simulation),
            phases_before: phases(&simulation),
            frames: FrameWriter::create(output)?,
            table: TimeTable::new(&output.join("observables.csv"), &COLUMNS),
            kept: Vec::new(),
            place: Place::inside(output),
            held: Held::default(),
            scene,
            seed,
            simulation,
            progress,
            interval,
        })
    }

    /// A run that goes on.
    pub fn go_on(
        scene: &'a Scene,
        seed: u64,
        simulation: Simulation,
        mut progress: Progress,
        output: &Path,
        interval: Duration,
    ) -> Result<Session<'a>, Failure> {
        let numbers = progress.kept.clone();
        let kept = numbers.iter().copied().zip(Place::inside(output).frames(&numbers)?).collect();
        progress.continued_at.push(progress.steps);
        let mut session = Session::begin(scene, seed, simulation, output, interval)?;
        session.frames.go_on(&progress.frames);
        session.table.go_on(&progress.columns, &progress.rows);
        Ok(Session { kept, progress, ..session })
    }

    /// Takes the steps, with a frame at the start, at every interval and at the end; after an interruption too.
    pub fn play(&mut self, steps: u64, console: &Console) -> Result<(), Failure> {
        let bar = console.bar(&self.scene.name);
        let (step_seconds, interval) = (self.simulation.time_step(), self.scene.measure.interval);
        if self.progress.steps == 0 && self.progress.frames.is_empty() {
            self.frame()?;
        }
        let mut written = Instant::now();
        while self.progress.steps < steps {
            let clock = Instant::now();
            let report = self.simulation.step();
            self.progress.wall += clock.elapsed();
            self.progress.steps += 1;
            self.note(report);
            let interrupted = crate::interrupt::requested();
            let last = self.progress.steps == steps;
            let framed = last || frame_is_due(self.progress.steps, step_seconds, interval);
            let mut alarms = self.watchdog.observe(&self.simulation, &report);
            // What is measured or left behind is looked at too.
            if last || interrupted {
                alarms.extend(self.watchdog.last(&self.simulation));
            } else if framed {
                alarms.extend(self.watchdog.look(&self.simulation));
            }
            self.heed(&alarms, console)?;
            if framed {
                self.frame()?;
            }
            if interrupted || (!last && written.elapsed() >= self.interval) {
                self.write_checkpoint()?;
                written = Instant::now();
            }
            bar.set(self.progress.steps as f64 / steps as f64);
            bar.say(format!("{:.2} s, {} contacts", self.simulation.time() - self.progress.started, report.contacts));
            if interrupted && !last {
                return Err(Failure::Interrupted("in the output folder; --resume goes on from there".into()));
            }
        }
        self.place.clear();
        Ok(())
    }

    fn note(&mut self, report: StepReport) {
        let progress = &mut self.progress;
        progress.worst_normal_rms = progress.worst_normal_rms.max(report.solve.residuals.normal.rms);
        progress.solves.add(&report);
        progress.last = Some(report);
    }

    /// Heeds what was noticed; holds a state from before it ready.
    fn heed(&mut self, alarms: &[Alarm], console: &Console) -> Result<(), Failure> {
        for alarm in alarms {
            let known = self.progress.alarms.entry(alarm.trouble.kind().into()).or_default();
            known.count += 1;
            if known.count == 1 {
                known.first = alarm.to_string();
                known.grave = alarm.trouble.is_grave();
                console.warn(&known.first);
            }
        }
        if let Some(alarm) = alarms.iter().find(|alarm| alarm.reaction == Reaction::Stop) {
            let mut left = String::new();
            if !self.held.sealed.is_empty() {
                let frames: Vec<_> =
                    self.held.frame.iter().chain(&self.kept).map(|(number, frame)| (*number, frame)).collect();
                self.place.write(&self.held.sealed, &frames)?;
                left = format!("; the state before is in {}", self.place.file().display());
            }
            return Err(Failure::Running(format!("{alarm}{left}")));
        }
        let every = u64::from(self.scene.watch.every);
        // A look has just found nothing wrong.
        if alarms.is_empty() && every > 0 && self.progress.steps.is_multiple_of(every * HELD_EVERY.div_ceil(every)) {
            let frame = self.kept.last().filter(|_| self.kept.len() == 1).cloned();
            self.held = Held { sealed: self.checkpoint(), frame };
        }
        Ok(())
    }

    fn checkpoint(&self) -> Vec<u8> {
        let (columns, rows) = self.table.contents();
        let mut progress = self.progress.clone();
        (progress.columns, progress.rows) = (columns.to_vec(), rows.to_vec());
        progress.frames = self.frames.times().to_vec();
        progress.kept = self.kept.iter().map(|(number, _)| *number).collect();
        progress.phases = self.phases();
        Kept::seal(self.scene, self.seed, self.simulation.checkpoint(), progress)
    }

    fn write_checkpoint(&mut self) -> Result<(), Failure> {
        let clock = Instant::now();
        let kept: Vec<_> = self.kept.iter().map(|(number, frame)| (*number, frame)).collect();
        self.place.write(&self.checkpoint(), &kept)?;
        self.progress.output_time += clock.elapsed();
        Ok(())
    }

    /// Wall time of the phases over the whole run, s.
    fn phases(&self) -> [f64; 4] {
        let now = phases(&self.simulation);
        std::array::from_fn(|phase| self.progress.phases[phase] + now[phase] - self.phases_before[phase])
    }

    /// Writes a frame and a row of the table.
    fn frame(&mut self) -> Result<(), Failure> {
        let clock = Instant::now();
        let frame = self.simulation.snapshot();
        if let Some(grain) = self.simulation.not_finite() {
            return Err(Failure::Running(format!(
                "grain {grain} has no finite position or velocity after step {}: the scene diverged; lower solver.step",
                self.progress.steps
            )));
        }
        let number = self.frames.count();
        self.frames.write(&frame)?;
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
        let measured = instant(self.scene, &frame).into_iter().filter(|(name, _)| !COLUMNS.contains(&name.as_str()));
        let driven = frame.driven_walls.iter().flat_map(|driven| {
            let name = &self.scene.wall[driven.wall as usize].name;
            [(format!("{name}_displacement"), driven.displacement), (format!("{name}_rate"), driven.rate)]
        });
        let row: Vec<(String, f64)> = known.chain(measured).chain(driven).collect();
        self.table.push(row)?;
        let measured = self.scene.measure.from.is_some_and(|from| frame.time - self.progress.started >= from - 1e-9);
        if !measured {
            self.kept.clear();
        }
        self.kept.push((number, frame));
        self.progress.output_time += clock.elapsed();
        Ok(())
    }

    /// What the run came to.
    pub fn summary(&mut self, provenance: Provenance, output: &Path, played: &Result<(), Failure>) -> RunSummary {
        let simulation = &self.simulation;
        let [detect, constrain, sweep, integrate] = self.phases();
        let contact_sweeps = simulation.contact_sweeps() - self.progress.contact_sweeps_before;
        let some = contact_sweeps > 0;
        let last = self.kept.last();
        let particles = last.map_or(0, |(_, frame)| frame.particles.len());
        let contacts = last.map_or(0, |(_, frame)| frame.contacts.len());
        let bytes = simulation.memory_bytes() as u64;
        RunSummary {
            version: JSON_VERSION,
            command: "run".into(),
            scene: self.scene.name.clone(),
            complete: played.is_ok(),
            continued_at: self.progress.continued_at.clone(),
            alarms: self
                .progress
                .alarms
                .values()
                .map(|a| AlarmSummary { first: a.first.clone(), count: a.count, grave: a.grave })
                .collect(),
            failure: played.as_ref().err().map(ToString::to_string),
            state_hash: format!("{:016x}", simulation.state_hash()),
            steps: self.progress.steps,
            time_step: simulation.time_step(),
            simulated_seconds: simulation.time() - self.progress.started,
            wall_seconds: (self.progress.wall + self.progress.output_time).as_secs_f64(),
            particles,
            contacts,
            contact_sweeps,
            nanoseconds_per_contact_sweep: some.then(|| 1e9 * sweep / contact_sweeps as f64),
            contact_sweeps_per_second: some.then(|| contact_sweeps as f64 / sweep),
            phase_seconds: PhaseTimes {
                detect,
                constrain,
                sweep,
                integrate,
                output: self.progress.output_time.as_secs_f64(),
            },
            peak_bytes: peak_bytes(),
            simulation_bytes: bytes,
            bytes_per_particle: bytes as f64 / particles.max(1) as f64,
            residuals: self.progress.last.map(|report| SolveSummary {
                sweeps: report.solve.sweeps,
                mean_sweeps: self.progress.solves.sweeps as f64 / self.progress.solves.count.max(1) as f64,
                most_sweeps: self.progress.solves.most,
                unconverged: self.progress.solves.unconverged,
                stop_reason: report.solve.reason,
                last: report.solve.residuals,
                worst_normal_rms: self.progress.worst_normal_rms,
            }),
            balance: simulation.balance(),
            observables: self.measured(),
            output: output.display().to_string(),
            frames: self.frames.count(),
            provenance,
        }
    }

    /// Observables over the frames that the scene names, or those of them that were reached.
    fn measured(&mut self) -> BTreeMap<String, Measured> {
        let recording = Recording {
            scene: self.scene.name.clone(),
            code: "Makadam".into(),
            version: VERSION.into(),
            seed: self.seed,
            time_step: self.simulation.time_step(),
            rayleigh_fraction: None,
            stiffness_factor: 1.0,
            threads: self.simulation.team().threads(),
            wall_seconds: self.progress.wall.as_secs_f64(),
            simulated_seconds: self.simulation.time() - self.progress.started,
            frames: std::mem::take(&mut self.kept).into_iter().map(|(_, frame)| frame).collect(),
        };
        let measured = observables::measure(self.scene, &recording).into_iter();
        measured
            .filter(|m| m.value.is_finite())
            .map(|m| (m.observable, Measured { value: m.value, standard_error: m.standard_error, unit: m.unit }))
            .collect()
    }
}

/// What can be measured of one frame alone.
fn instant(scene: &Scene, frame: &Snapshot) -> Vec<(String, f64)> {
    let mut scene = scene.clone();
    scene.measure.from = None;
    let recording = Recording {
        scene: scene.name.clone(),
        code: "Makadam".into(),
        version: VERSION.into(),
        seed: 0,
        time_step: scene.solver.step,
        rayleigh_fraction: None,
        stiffness_factor: 1.0,
        threads: 1,
        wall_seconds: 0.0,
        simulated_seconds: frame.time,
        frames: vec![frame.clone()],
    };
    let measured = observables::measure(&scene, &recording).into_iter();
    measured.filter(|m| m.value.is_finite()).map(|m| (m.observable, m.value)).collect()
}

fn phases(simulation: &Simulation) -> [f64; 4] {
    let phases = simulation.phase_seconds();
    [phases.detect, phases.constrain, phases.sweep, phases.integrate]
}
