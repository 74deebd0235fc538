//! `makadam run`: one simulation, and everything it leaves on disk.

use super::arguments::RunArguments;
use super::{Console, Failure, begin, json, load};
use crate::execution::{Execution, cores};
use crate::observables;
use crate::output::{
    FrameWriter, JSON_VERSION, Measured, PhaseTimes, RunSummary, SolveSummary, TimeTable, create_folder, write_whole,
};
use crate::peers::frame_is_due;
use crate::prepared::{file_stem, steps_in};
use crate::provenance::{Provenance, VERSION, peak_bytes};
use crate::recording::Recording;
use makadam::lanes::InstructionSet;
use makadam::scene::Scene;
use makadam::snapshot::Snapshot;
use makadam::solve::StopReason;
use makadam::{Simulation, StepReport};
use std::collections::BTreeMap;
use std::path::PathBuf;
use std::process::ExitCode;
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

/// Simulates a scene.
pub(super) fn run(arguments: &RunArguments, console: &Console) -> Result<ExitCode, Failure> {
    let (file, mut scene) = load(&arguments.scene)?;
    if let Some(accuracy) = arguments.accuracy {
        scene.ask(accuracy);
    }
    let seed = arguments.seed.unwrap_or(scene.seed);
    let output = arguments.output.clone().unwrap_or_else(|| PathBuf::from("results").join(file_stem(&scene.name)));
    let execution = Execution {
        scheduler: arguments.scheduler.into(),
        threads: arguments.threads.map_or_else(cores, usize::from),
        instruction_set: arguments.isa.map_or_else(InstructionSet::detect, InstructionSet::from),
        prefetch: usize::from(arguments.prefetch),
    };
    let (mut simulation, _) = begin(&scene, seed, &file, &execution, console)?;
    if let Some(precision) = arguments.precision {
        scene.solver.precision = precision.into();
        simulation.use_precision(scene.solver.precision);
    }
    let provenance = Provenance::of_run(&scene, &file, seed, &execution);
    create_folder(&output)?;
    let mut session = Session {
        started: simulation.time(),
        contact_sweeps_before: simulation.contact_sweeps(),
        phases_before: phases(&simulation),
        steps: 0,
        wall: Duration::ZERO,
        output_time: Duration::ZERO,
        last: None,
        worst_normal_rms: 0.0,
        solves: Solves::default(),
        frames: FrameWriter::create(&output)?,
        table: TimeTable::new(&output.join("observables.csv"), &COLUMNS),
        kept: Vec::new(),
        scene: &scene,
        seed,
        simulation,
    };
    let steps = arguments.steps.unwrap_or_else(|| steps_in(scene.duration, session.simulation.time_step()));
    let played = session.play(steps, console);
    let summary = session.summary(provenance, &output, &played);
    let text = json(&summary);
    let written = write_whole(&output.join("run.json"), text.as_bytes());
    console.result(&if arguments.json { text } else { describe(&summary) })?;
    played?;
    written?;
    Ok(ExitCode::SUCCESS)
}

/// A run under way.
struct Session<'a> {
    scene: &'a Scene,
    seed: u64,
    simulation: Simulation,
    started: f64,
    contact_sweeps_before: u64,
    phases_before: [f64; 4],
    steps: u64,
    wall: Duration,
    output_time: Duration,
    last: Option<StepReport>,
    worst_normal_rms: f64,
    solves: Solves,
    frames: FrameWriter,
    table: TimeTable,
    /// Frames that are measured at the end.
    kept: Vec<Snapshot>,
}

/// What the solves of a run took.
#[derive(Default)]
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

impl Session<'_> {
    /// Takes the steps, with a frame at the start, at every interval and at the end; after an interruption too.
    fn play(&mut self, steps: u64, console: &Console) -> Result<(), Failure> {
        let bar = console.bar(&self.scene.name);
        let (step_seconds, interval) = (self.simulation.time_step(), self.scene.measure.interval);
        self.frame()?;
        while self.steps < steps {
            let clock = Instant::now();
            let report = self.simulation.step();
            self.wall += clock.elapsed();
            self.steps += 1;
            self.worst_normal_rms = self.worst_normal_rms.max(report.solve.residuals.normal.rms);
            self.solves.add(&report);
            self.last = Some(report);
            let interrupted = crate::interrupt::requested();
            if interrupted || self.steps == steps || frame_is_due(self.steps, step_seconds, interval) {
                self.frame()?;
            }
            bar.set(self.steps as f64 / steps as f64);
            bar.say(format!("{:.2} s, {} contacts", self.simulation.time() - self.started, report.contacts));
            if interrupted {
                return Err(Failure::Interrupted("in the output folder".into()));
            }
        }
        Ok(())
    }

    /// Writes a frame and a row of the table.
    fn frame(&mut self) -> Result<(), Failure> {
        let clock = Instant::now();
        let frame = self.simulation.snapshot();
        let finite = |values: &[f64; 3]| values.iter().all(|value| value.is_finite());
        if let Some(lost) = frame.particles.iter().find(|p| !finite(&p.position) || !finite(&p.velocity)) {
            return Err(Failure::Running(format!(
                "grain {} has no finite position or velocity after step {}: the scene diverged; lower solver.step",
                lost.id, self.steps
            )));
        }
        self.frames.write(&frame)?;
        let energy = self.simulation.energy();
        let (sweeps, residual) = self
            .last
            .map_or((f64::NAN, f64::NAN), |last| (f64::from(last.solve.sweeps), last.solve.residuals.normal.rms));
        let values = [
            frame.time,
            self.steps as f64,
            frame.contacts.len() as f64,
            energy.kinetic,
            energy.potential,
            energy.elastic,
            sweeps,
            residual,
        ];
        let known = COLUMNS.iter().map(ToString::to_string).zip(values).filter(|(_, value)| value.is_finite());
        let measured = instant(self.scene, &frame).into_iter().filter(|(name, _)| !COLUMNS.contains(&name.as_str()));
        let row: Vec<(String, f64)> = known.chain(measured).collect();
        self.table.push(row)?;
        let measured = self.scene.measure.from.is_some_and(|from| frame.time - self.started >= from - 1e-9);
        if !measured {
            self.kept.clear();
        }
        self.kept.push(frame);
        self.output_time += clock.elapsed();
        Ok(())
    }

    fn summary(
        &mut self,
        provenance: Provenance,
        output: &std::path::Path,
        played: &Result<(), Failure>,
    ) -> RunSummary {
        let simulation = &self.simulation;
        let [detect, constrain, sweep, integrate] = {
            let (now, before) = (phases(simulation), self.phases_before);
            std::array::from_fn(|phase| now[phase] - before[phase])
        };
        let contact_sweeps = simulation.contact_sweeps() - self.contact_sweeps_before;
        let some = contact_sweeps > 0;
        let last = self.kept.last();
        let particles = last.map_or(0, |frame| frame.particles.len());
        let contacts = last.map_or(0, |frame| frame.contacts.len());
        let bytes = simulation.memory_bytes() as u64;
        RunSummary {
            version: JSON_VERSION,
            command: "run".into(),
            scene: self.scene.name.clone(),
            complete: played.is_ok(),
            failure: played.as_ref().err().map(ToString::to_string),
            state_hash: format!("{:016x}", simulation.state_hash()),
            steps: self.steps,
            time_step: simulation.time_step(),
            simulated_seconds: simulation.time() - self.started,
            wall_seconds: (self.wall + self.output_time).as_secs_f64(),
            particles,
            contacts,
            contact_sweeps,
            nanoseconds_per_contact_sweep: some.then(|| 1e9 * sweep / contact_sweeps as f64),
            contact_sweeps_per_second: some.then(|| contact_sweeps as f64 / sweep),
            phase_seconds: PhaseTimes { detect, constrain, sweep, integrate, output: self.output_time.as_secs_f64() },
            peak_bytes: peak_bytes(),
            simulation_bytes: bytes,
            bytes_per_particle: bytes as f64 / particles.max(1) as f64,
            residuals: self.last.map(|report| SolveSummary {
                sweeps: report.solve.sweeps,
                mean_sweeps: self.solves.sweeps as f64 / self.solves.count.max(1) as f64,
                most_sweeps: self.solves.most,
                unconverged: self.solves.unconverged,
                stop_reason: report.solve.reason,
                last: report.solve.residuals,
                worst_normal_rms: self.worst_normal_rms,
            }),
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
            wall_seconds: self.wall.as_secs_f64(),
            simulated_seconds: self.simulation.time() - self.started,
            frames: std::mem::take(&mut self.kept),
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

/// A value to six significant digits.
fn significant(value: f64) -> String {
    let rounded: f64 = format!("{value:.5e}").parse().unwrap_or(value);
    if rounded == 0.0 || (1e-4..1e7).contains(&rounded.abs()) { format!("{rounded}") } else { format!("{rounded:e}") }
}

/// The summary for people.
fn describe(summary: &RunSummary) -> String {
    let ended = if summary.complete { "" } else { " (not complete)" };
    let mut text = format!(
        "{}: {} grains, {} steps of {:e} s, {:.4} s simulated in {:.2} s of wall time{ended}\n",
        summary.scene,
        summary.particles,
        summary.steps,
        summary.time_step,
        summary.simulated_seconds,
        summary.wall_seconds
    );
    text += &format!("state hash       {}\n", summary.state_hash);
    if let (Some(rate), Some(cost)) = (summary.contact_sweeps_per_second, summary.nanoseconds_per_contact_sweep) {
        text += &format!(
            "contact sweeps   {} ({:.1} million a second, {cost:.1} ns each)\n",
            summary.contact_sweeps,
            rate / 1e6
        );
    }
    let phases = &summary.phase_seconds;
    let shares = [
        ("detect", phases.detect),
        ("constrain", phases.constrain),
        ("sweep", phases.sweep),
        ("integrate", phases.integrate),
        ("output", phases.output),
    ];
    let total: f64 = shares.iter().map(|(_, seconds)| seconds).sum();
    let shares = shares.map(|(name, seconds)| format!("{name} {:.1}%", 100.0 * seconds / total.max(1e-300)));
    text += &format!("time by phase    {}\n", shares.join(", "));
    text += &format!(
        "memory           {:.0} bytes a particle in the simulation, {:.1} MB at the peak of the process\n",
        summary.bytes_per_particle,
        summary.peak_bytes as f64 / 1e6
    );
    if let Some(solve) = &summary.residuals {
        text += &format!(
            "solves           {:.1} sweeps on average, {} at most{}\n",
            solve.mean_sweeps,
            solve.most_sweeps,
            match solve.unconverged {
                0 => String::new(),
                some => format!("; {some} ended before their residual was as small as asked for"),
            }
        );
        text += &format!(
            "residual         {:.2e} m/s normal (root mean square, last solve), {:.2e} m/s at worst\n",
            solve.last.normal.rms, solve.worst_normal_rms
        );
    }
    for (name, measured) in &summary.observables {
        let error = measured.standard_error.map_or(String::new(), |error| format!(" +- {error:.2}"));
        text += &format!("{name:<36} {}{error} {}\n", significant(measured.value), measured.unit);
    }
    text + &format!("frames, observables.csv and run.json: {}", summary.output)
}
