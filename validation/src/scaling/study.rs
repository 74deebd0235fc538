//! A scaling study: rows made of a measurement, and replays of its traces on models of machines.

use super::costs::{Bandwidth, median};
use super::machine::{MOST_WORKERS, Machine, worker_counts};
use super::measure::{Measurement, Plan, Timing, Traces, WARM_UP};
use super::replay::{Replayed, Traffic, replay};
use super::rows::{Check, MeasuredRow, ReplayedRow, TaskRow};
use crate::output::JSON_VERSION;
use crate::provenance::Provenance;
use makadam::schedule::{Phase, Region, Scheduler};
use makadam::sweep::InstructionSet;
use rayon::prelude::*;
use serde::Serialize;

/// What `makadam scaling --json` prints and `scaling.json` holds; its documentation is `validation/docs/json.md`.
#[derive(Clone, Debug, Serialize)]
pub struct Study {
    /// [`JSON_VERSION`].
    pub version: u32,
    /// Always "scaling".
    pub command: String,
    /// Name of the scene.
    pub scene: String,
    /// Simulated time of the state that everything starts from, s.
    pub start_seconds: f64,
    /// Number of grains.
    pub particles: usize,
    /// Contacts of a step, mean over the timed steps.
    pub contacts: f64,
    /// Contact sweeps of a step, mean over the timed steps.
    pub contact_sweeps: f64,
    /// Timed steps of each repetition.
    pub steps: u64,
    /// The first so many of them were traced and replayed.
    pub traced_steps: u64,
    /// Steps before them that were not timed.
    pub warm_up_steps: u64,
    /// How often everything was measured.
    pub repetitions: usize,
    /// Cores that this process may use.
    pub cores: usize,
    /// Memory that the simulation itself holds, bytes.
    pub simulation_bytes: usize,
    /// Memory traffic of a contact sweep that finds nothing in a cache, bytes; absent without contacts.
    pub bytes_per_contact_sweep: Option<f64>,
    /// What the memory delivers, measured.
    pub bandwidth: Bandwidth,
    /// Whether every configuration ended in the same state, bit for bit.
    pub same_bits: bool,
    /// What ended in another state than the first configuration, in words.
    pub differing: Vec<String>,
    /// Measured configurations.
    pub measured: Vec<MeasuredRow>,
    /// Machines of the replay.
    pub machines: Vec<Machine>,
    /// Replayed configurations.
    pub replayed: Vec<ReplayedRow>,
    /// Replay against measurement.
    pub checks: Vec<Check>,
    /// Durations of tasks.
    pub tasks: Vec<TaskRow>,
    /// What was found, in sentences.
    pub findings: Vec<String>,
    /// Where it came from.
    pub provenance: Provenance,
}

/// What a study is made of, besides the measurement.
pub struct Setting {
    /// Name of the scene.
    pub scene: String,
    /// Simulated time of the state that everything starts from, s.
    pub started: f64,
    /// Cores that this process may use.
    pub cores: usize,
    /// What the memory delivers, measured.
    pub bandwidth: Bandwidth,
    /// This machine first, then others; those are replayed from the widest instruction set alone.
    pub machines: Vec<Machine>,
    /// Where it came from.
    pub provenance: Provenance,
}

impl Study {
    /// Makes rows, replays and sentences of a measurement.
    pub fn new(plan: &Plan, measurement: &Measurement, setting: Setting) -> Study {
        let measured = measured_rows(measurement);
        let replayed: Vec<ReplayedRow> = setting
            .machines
            .par_iter()
            .enumerate()
            .flat_map(|(place, machine)| {
                let traces = &measurement.traces;
                let chosen = if place == 0 { &traces[..] } else { &traces[traces.len().saturating_sub(1)..] };
                curves(machine, chosen, measurement, &plan.threads)
            })
            .collect();
        let checks = setting.machines.first().map_or(Vec::new(), |here| checks(plan, measurement, here, &replayed));
        let mut study = Study {
            version: JSON_VERSION,
            command: "scaling".into(),
            scene: setting.scene,
            start_seconds: setting.started,
            particles: measurement.particles,
            contacts: measurement.contacts,
            contact_sweeps: measurement.contact_sweeps,
            steps: plan.steps,
            traced_steps: plan.traced_steps,
            warm_up_steps: WARM_UP,
            repetitions: plan.repetitions,
            cores: setting.cores,
            simulation_bytes: measurement.simulation_bytes,
            bytes_per_contact_sweep: (measurement.contacts > 0.0)
                .then(|| measurement.bytes_per_sweep / measurement.contacts),
            bandwidth: setting.bandwidth,
            same_bits: false,
            differing: differing(measurement),
            measured,
            machines: setting.machines,
            replayed,
            checks,
            tasks: measurement.traces.iter().flat_map(task_rows).collect(),
            findings: Vec::new(),
            provenance: setting.provenance,
        };
        study.same_bits = study.differing.is_empty();
        study.findings = super::findings::findings(&study);
        study
    }

    /// The widest instruction set that was measured.
    pub fn widest(&self) -> Option<InstructionSet> {
        self.measured.last().map(|row| row.instruction_set)
    }
}

/// The name of an instruction set, scheduler or phase, as it stands in files.
pub(super) fn word(value: impl Serialize) -> String {
    match serde_json::to_value(value) {
        Ok(serde_json::Value::String(word)) => word,
        _ => String::new(),
    }
}

fn mean(values: &[f64]) -> f64 {
    values.iter().sum::<f64>() / values.len().max(1) as f64
}

fn differing(measurement: &Measurement) -> Vec<String> {
    let first = measurement.timings.iter().find_map(|timing| timing.hashes.first());
    let differs = |timing: &&Timing| timing.hashes.iter().any(|hash| Some(hash) != first);
    let mut differing: Vec<String> = (measurement.timings.iter().filter(differs))
        .map(|timing| {
            let configuration = timing.configuration;
            let (set, scheduler) = (word(configuration.instruction_set), word(configuration.scheduler));
            format!("{set}, {scheduler}, threads: {}", configuration.threads)
        })
        .collect();
    if !measurement.traces_same_bits {
        differing.push("the traced steps".into());
    }
    differing
}

fn measured_rows(measurement: &Measurement) -> Vec<MeasuredRow> {
    let of = |timing: &Timing, sweeps: bool| -> Vec<f64> {
        timing.repetitions.iter().map(|times| mean(if sweeps { &times.sweeps } else { &times.steps })).collect()
    };
    let ratios = |serial: &[f64], own: &[f64]| median(serial.iter().zip(own).map(|(serial, own)| serial / own));
    let rows = measurement.timings.iter().map(|timing| {
        let configuration = timing.configuration;
        let serial = measurement.timings.iter().find(|other| {
            other.configuration.scheduler == Scheduler::Serial
                && other.configuration.instruction_set == configuration.instruction_set
        });
        let serial = serial.unwrap_or(timing);
        let (steps, sweeps) = (of(timing, false), of(timing, true));
        let sweep_seconds = median(sweeps.iter().copied());
        MeasuredRow {
            instruction_set: configuration.instruction_set,
            scheduler: configuration.scheduler,
            threads: configuration.threads,
            step_seconds: median(steps.iter().copied()),
            step_seconds_least: steps.iter().copied().fold(f64::INFINITY, f64::min),
            step_seconds_most: steps.iter().copied().fold(0.0, f64::max),
            sweep_seconds,
            speedup: ratios(&of(serial, false), &steps),
            sweep_speedup: ratios(&of(serial, true), &sweeps),
            nanoseconds_per_contact_sweep: (measurement.contact_sweeps > 0.0)
                .then(|| 1e9 * sweep_seconds / measurement.contact_sweeps),
            state_hash: format!("{:016x}", timing.hashes.last().copied().unwrap_or_default()),
        }
    });
    rows.collect()
}

/// Replays the traces of some instruction sets on a machine, by scheduler and number of workers.
fn curves(machine: &Machine, traces: &[Traces], measurement: &Measurement, threads: &[usize]) -> Vec<ReplayedRow> {
    let mut jobs = Vec::new();
    for traces in traces {
        jobs.push((traces, Scheduler::Serial, 1));
        for scheduler in [Scheduler::CentralQueue, Scheduler::WorkStealing] {
            let counts = worker_counts(machine.most_workers(), threads);
            jobs.extend(counts.into_iter().map(|workers| (traces, scheduler, workers)));
        }
    }
    let replays: Vec<Replayed> = jobs
        .par_iter()
        .map(|&(traces, scheduler, workers)| {
            let traffic = traffic(machine, traces, measurement);
            mean_replay(traces, scheduler, machine, traffic, workers)
        })
        .collect();
    let rows = jobs.iter().zip(&replays).map(|(&(traces, scheduler, workers), own)| {
        let is_serial = |job: &&(&Traces, Scheduler, usize)| {
            job.1 == Scheduler::Serial && job.0.instruction_set == traces.instruction_set
        };
        let serial = jobs.iter().zip(&replays).find(|(job, _)| is_serial(job)).map_or(own, |(_, serial)| serial);
        ReplayedRow {
            source: "replayed".into(),
            machine: machine.name.clone(),
            instruction_set: traces.instruction_set,
            scheduler,
            workers,
            step_seconds: own.seconds,
            sweep_seconds: own.sweep_seconds,
            speedup: serial.seconds / own.seconds,
            sweep_speedup: serial.sweep_seconds / own.sweep_seconds,
            waiting_share: own.waiting / (own.seconds * workers as f64),
        }
    });
    rows.collect()
}

/// Mean over the traced steps.
fn mean_replay(
    traces: &Traces,
    scheduler: Scheduler,
    machine: &Machine,
    traffic: Option<Traffic>,
    workers: usize,
) -> Replayed {
    let mut sum = Replayed::default();
    for step in &traces.steps {
        let own = replay(&step.regions, scheduler, machine, traffic, workers);
        sum.seconds += own.seconds;
        sum.sweep_seconds += own.sweep_seconds;
        sum.waiting += own.waiting;
    }
    let steps = traces.steps.len().max(1) as f64;
    Replayed { seconds: sum.seconds / steps, sweep_seconds: sum.sweep_seconds / steps, waiting: sum.waiting / steps }
}

/// The traffic of a running sweep: its bytes over its traced time. None where the machine's memory is not known to limit,
/// or the simulation fits into its last-level cache.
fn traffic(machine: &Machine, traces: &Traces, measurement: &Measurement) -> Option<Traffic> {
    let ceiling = machine.memory_bytes_per_second?;
    if measurement.simulation_bytes as u64 <= machine.cache_bytes {
        return None;
    }
    let sweeping = |region: &&Region| region.phase == Phase::Sweep;
    let regions = traces.steps.iter().flat_map(|step| &step.regions).filter(sweeping);
    let seconds: f64 = regions.map(|region| region.tasks.iter().sum::<f64>()).sum();
    let sweeps: u32 = traces.sweeps.iter().sum();
    let bytes = f64::from(sweeps) * measurement.bytes_per_sweep;
    (seconds > 0.0).then(|| Traffic { bytes_per_second: bytes / (seconds * machine.duration_factor), ceiling })
}

/// The replay on this machine beside what was measured, over the same steps.
fn checks(plan: &Plan, measurement: &Measurement, here: &Machine, replayed: &[ReplayedRow]) -> Vec<Check> {
    let traced = plan.traced_steps as usize;
    let checks = measurement.timings.iter().filter_map(|timing| {
        let own = timing.configuration;
        let row = replayed.iter().find(|row| {
            row.machine == here.name
                && row.instruction_set == own.instruction_set
                && row.scheduler == own.scheduler
                && row.workers == own.threads
        })?;
        let of_step =
            |step: usize| median(timing.repetitions.iter().filter_map(|times| times.steps.get(step)).copied());
        let measured_seconds = mean(&(0..traced).map(of_step).collect::<Vec<_>>());
        Some(Check {
            instruction_set: own.instruction_set,
            scheduler: own.scheduler,
            threads: own.threads,
            measured_seconds,
            replayed_seconds: row.step_seconds,
            deviation_percent: 100.0 * (row.step_seconds / measured_seconds - 1.0),
        })
    });
    checks.filter(|check| check.threads <= MOST_WORKERS).collect()
}

/// Durations of tasks, by phase, and by stage in sweeps.
fn task_rows(traces: &Traces) -> Vec<TaskRow> {
    let mut kinds: Vec<Kind> = Vec::new();
    for (step, &sweeps) in traces.steps.iter().zip(&traces.sweeps) {
        let in_sweeps = step.regions.iter().filter(|region| region.phase == Phase::Sweep).count();
        // Every sweep goes through the same stages.
        let stages = in_sweeps.checked_div(sweeps as usize).filter(|stages| stages * sweeps as usize == in_sweeps);
        let mut sweep_region = 0;
        for region in &step.regions {
            let mut stage = None;
            if region.phase == Phase::Sweep {
                stage = stages.map(|stages| sweep_region % stages + 1);
                sweep_region += 1;
            }
            let serial = stage.is_none() && region.tasks.len() < 2;
            let known = |kind: &Kind| (kind.phase, kind.stage, kind.serial) == (region.phase, stage, serial);
            let place = kinds.iter().position(known).unwrap_or_else(|| {
                kinds.push(Kind { phase: region.phase, stage, serial, regions: 0, most_tasks: 0, tasks: Vec::new() });
                kinds.len() - 1
            });
            let kind = &mut kinds[place];
            kind.regions += 1;
            kind.most_tasks = kind.most_tasks.max(region.tasks.len());
            kind.tasks.extend(&region.tasks);
        }
    }
    let total: f64 = kinds.iter().flat_map(|kind| &kind.tasks).sum();
    let rows = kinds.into_iter().filter(|kind| !kind.tasks.is_empty()).map(|mut kind| {
        kind.tasks.sort_by(f64::total_cmp);
        let tasks = &kind.tasks;
        let quantile = |share: f64| tasks[((tasks.len() - 1) as f64 * share).round() as usize];
        TaskRow {
            instruction_set: traces.instruction_set,
            phase: kind.phase,
            stage: kind.stage,
            regions: kind.regions as f64 / traces.steps.len() as f64,
            tasks: tasks.len() as f64 / kind.regions as f64,
            most_tasks: kind.most_tasks,
            share: tasks.iter().sum::<f64>() / total,
            mean: mean(tasks),
            least: quantile(0.0),
            tenth: quantile(0.1),
            median: quantile(0.5),
            ninetieth: quantile(0.9),
            most: quantile(1.0),
        }
    });
    rows.collect()
}

/// The regions of one kind, gathered over steps.
struct Kind {
    phase: Phase,
    stage: Option<usize>,
    serial: bool,
    regions: usize,
    most_tasks: usize,
    tasks: Vec<f64>,
}
