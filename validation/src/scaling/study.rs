//! A scaling study: rows made of a measurement, and replays of its traces on models of machines.

use super::costs::Costs;
use super::hardware::{Bandwidth, cache_bytes, clock};
use super::machine::{MOST_WORKERS, Machine};
use super::measure::{Measurement, Plan, Timing, Traces, WARM_UP};
use super::predict::{checks, curves};
use super::rows::{Check, MachineRow, MeasuredRow, ReplayedRow, TaskRow};
use super::tasks::{mean, task_rows};
use crate::execution::{MeasureError, cores};
use crate::output::JSON_VERSION;
use crate::provenance::Provenance;
use crate::statistics::median;
use makadam::Simulation;
use makadam::lanes::InstructionSet;
use makadam::schedule::Scheduler;
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
    /// Measures and replays what a plan asks for from the state of a simulation. `memory`: what the memory delivers to any number
    /// of cores, bytes/s; if absent, what is measured is taken to grow with the cores. `tell` is told what is done, `progress` the
    /// share of the steps.
    ///
    /// # Errors
    /// [`MeasureError`] if the machine cannot step as asked, or the user asked to stop.
    pub fn measure(
        scene: &str,
        simulation: Simulation,
        plan: &Plan,
        memory: Option<f64>,
        provenance: Provenance,
        tell: &dyn Fn(&str),
        progress: &dyn Fn(f64),
    ) -> Result<Study, MeasureError> {
        let cores = cores();
        tell("measuring what handing out work costs, and the memory");
        let costs = Costs::measure(cores)?;
        if !costs.threads_met() {
            tell("a second thread is slow to wake here, or the machine is busy");
        }
        let bandwidth = Bandwidth::measure(cores)?;
        let started = simulation.time();
        let measurement = plan.measure(&simulation, progress)?;
        drop(simulation);
        tell("replaying");
        let memory = memory
            .map_or((bandwidth.all_threads, bandwidth.threads), |bytes_per_second| (bytes_per_second, MOST_WORKERS));
        let machines = vec![Machine::here(costs, memory, cache_bytes()), Machine::xeon_phi_3120(&costs, clock())];
        let setting = Setting { scene: scene.into(), started, cores, bandwidth, machines, provenance };
        Ok(Study::new(plan, &measurement, setting).with_findings())
    }

    /// Makes rows and replays of a measurement.
    pub fn new(plan: &Plan, measurement: &Measurement, setting: Setting) -> Study {
        let measured = measured_rows(measurement);
        let serial = |traces: &&Traces| traces.configuration.scheduler == Scheduler::Serial;
        let serial_traces: Vec<&Traces> = measurement.traces.iter().filter(serial).collect();
        let replayed: Vec<ReplayedRow> = setting
            .machines
            .par_iter()
            .enumerate()
            .flat_map(|(place, machine)| {
                let widest = plan.instruction_sets.last();
                let chosen = |traces: &&&Traces| place == 0 || Some(&traces.configuration.instruction_set) == widest;
                let traces: Vec<&Traces> = serial_traces.iter().filter(chosen).copied().collect();
                curves(machine, &traces, measurement, &plan.threads)
            })
            .collect();
        let differing = differing(measurement);
        let checks = setting.machines.first().map_or(Vec::new(), |here| checks(plan, measurement, here, &replayed));
        Study {
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
                .then(|| measurement.sweep_bytes.moved as f64 / measurement.contacts),
            bandwidth: setting.bandwidth,
            same_bits: differing.is_empty(),
            differing,
            measured,
            machines: setting.machines,
            replayed,
            checks,
            tasks: serial_traces.iter().copied().flat_map(task_rows).collect(),
            findings: Vec::new(),
            provenance: setting.provenance,
        }
    }

    /// The widest instruction set that was measured.
    pub fn widest(&self) -> Option<InstructionSet> {
        self.measured.last().map(|row| row.instruction_set)
    }

    /// What the machine and the scene bring to every configuration.
    pub fn machine(&self) -> MachineRow {
        MachineRow {
            cores: self.cores,
            cache_bytes: self.machines.first().map_or(0, |here| here.cache_bytes),
            bandwidth_one_thread: self.bandwidth.one_thread,
            bandwidth_all_threads: self.bandwidth.all_threads,
            particles: self.particles,
            contacts: self.contacts,
            simulation_bytes: self.simulation_bytes,
            bytes_per_contact_sweep: self.bytes_per_contact_sweep,
        }
    }
}

fn differing(measurement: &Measurement) -> Vec<String> {
    let first = measurement.timings.iter().find_map(|timing| timing.hashes.first());
    let differs = |timing: &&Timing| timing.hashes.iter().any(|hash| Some(hash) != first);
    let mut differing: Vec<String> = (measurement.timings.iter().filter(differs))
        .map(|timing| {
            let configuration = timing.configuration;
            let (set, scheduler) = (configuration.instruction_set.name(), configuration.scheduler.name());
            format!("{set}, {scheduler}, threads: {}, {}", configuration.threads, configuration.portion.name())
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
        let serial = measurement.timings.iter().find(|other| other.configuration.is_serial_of(&configuration));
        let serial = serial.unwrap_or(timing);
        let (steps, sweeps) = (of(timing, false), of(timing, true));
        let sweep_seconds = median(sweeps.iter().copied());
        MeasuredRow {
            instruction_set: configuration.instruction_set,
            scheduler: configuration.scheduler,
            threads: configuration.threads,
            portion: configuration.portion,
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
