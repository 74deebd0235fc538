//! Study: rows of a measurement and its replays, findings, tables.

use super::figures::figures;
use super::measure::{Measurement, Plan, Timing, WARM_UP};
use super::replay::{Bandwidth, Costs, Machine, ReplayedRow, cache_bytes, clock, curves};
use makadam::Simulation;
use makadam::lanes::InstructionSet;
use makadam::partition::Portion;
use makadam::schedule::Scheduler;
use makadam_compare::study::{
    Answer, Cell, Document, DocumentError, File, Report, Section, Table, cells, json, table as csv,
};
use makadam_frames::execution::{MeasureError, cores};
use makadam_frames::output::JSON_VERSION;
use makadam_frames::provenance::Provenance;
use makadam_measure::statistics::{mean, median};
use makadam_view::draw::figure::Figure;
use makadam_view::draw::numbers::{count, plural, short_time as time, two_digits};
use serde::Serialize;

/// One measured configuration. Times are medians over the repetitions; speed-ups are medians of the ratios to the serial
/// run of the same instruction set and portion in the same round.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[expect(missing_docs, reason = "validation/docs/json.md describes the fields of documents")]
pub struct MeasuredRow {
    pub instruction_set: InstructionSet,
    pub scheduler: Scheduler,
    pub threads: usize,
    /// Portion of work that a thread takes at a time.
    pub portion: Portion,
    pub step_seconds: f64,
    pub step_seconds_least: f64,
    pub step_seconds_most: f64,
    pub sweep_seconds: f64,
    pub speedup: f64,
    pub sweep_speedup: f64,
    pub nanoseconds_per_contact_sweep: Option<f64>,
    /// Time per traced step, measured, s.
    pub traced_seconds: f64,
    /// Time per traced step, replayed from the serial trace, s.
    pub replayed_seconds: Option<f64>,
    /// Replayed over measured, minus one, %.
    pub deviation_percent: Option<f64>,
    pub state_hash: String,
}

/// Properties of machine and scene common to all configurations.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[expect(missing_docs, reason = "validation/docs/json.md describes the fields of documents")]
pub struct MachineRow {
    /// Cores that the process may use.
    pub cores: usize,
    pub cache_bytes: u64,
    /// Memory bandwidth to one thread, bytes/s.
    pub bandwidth_one_thread: f64,
    /// Memory bandwidth to a thread on each core, bytes/s.
    pub bandwidth_all_threads: f64,
    pub particles: usize,
    pub contacts: f64,
    /// Memory of the simulation itself, bytes.
    pub simulation_bytes: usize,
    /// Memory traffic of a contact sweep without cache hits, bytes; absent without contacts.
    pub bytes_per_contact_sweep: Option<f64>,
}

/// Output of `makadam lab scaling --json` and content of `scaling.json`; documented in `validation/docs/json.md`.
#[derive(Clone, Debug, Serialize)]
#[expect(missing_docs, reason = "validation/docs/json.md describes the fields of documents")]
pub struct Study {
    pub version: u32,
    pub command: String,
    pub scene: String,
    pub start_seconds: f64,
    /// Properties of machine and scene.
    #[serde(flatten)]
    pub machine: MachineRow,
    pub contact_sweeps: f64,
    #[serde(flatten)]
    pub plan: Plan,
    pub warm_up_steps: u64,
    /// True if all configurations ended in the same state, bit for bit.
    pub same_bits: bool,
    pub differing: Vec<String>,
    pub measured: Vec<MeasuredRow>,
    /// Machines of the replay.
    pub machines: Vec<Machine>,
    pub replayed: Vec<ReplayedRow>,
    /// Findings, one sentence each.
    pub findings: Vec<String>,
    pub provenance: Provenance,
}

impl Study {
    /// Measures and replays a plan from the state of a simulation. `tell` receives messages, `progress` the completed fraction.
    ///
    /// # Errors
    /// [`MeasureError`] if the machine cannot run the plan, or on an interruption.
    pub fn measure(
        scene: &str,
        simulation: Simulation,
        plan: Plan,
        provenance: Provenance,
        tell: &dyn Fn(&str),
        progress: &dyn Fn(f64),
    ) -> Result<Study, MeasureError> {
        tell("measuring costs of scheduling and memory bandwidth");
        let costs = Costs::measure(cores())?;
        let bandwidth = Bandwidth::measure(cores())?;
        let measurement = plan.measure(&simulation, progress)?;
        drop(simulation);
        tell("replaying");
        let memory = (bandwidth.all_threads, bandwidth.threads);
        let machines = vec![Machine::here(costs, memory, cache_bytes()), Machine::xeon_phi_3120(&costs, clock())];
        Ok(Study::new(scene, plan, &measurement, bandwidth, machines, provenance))
    }

    /// Derives rows, replays and findings from a measurement. This machine is the first of the machines; models are replayed with the
    /// widest instruction set alone.
    pub fn new(
        scene: &str,
        plan: Plan,
        measurement: &Measurement,
        bandwidth: Bandwidth,
        machines: Vec<Machine>,
        provenance: Provenance,
    ) -> Study {
        let mut replayed = Vec::new();
        for machine in &machines {
            let is_replayed = |set| machine.name == Machine::HERE || Some(&set) == plan.instruction_sets.last();
            let own = measurement.traces.iter().filter(|traces| is_replayed(traces.configuration.instruction_set));
            replayed.extend(own.flat_map(|traces| curves(machine, traces, measurement, &plan.threads)));
        }
        let differing = differing(measurement);
        let &Measurement { particles, contacts, contact_sweeps, simulation_bytes, sweep_bytes, .. } = measurement;
        let mut study = Study {
            version: JSON_VERSION,
            command: "scaling".into(),
            scene: scene.into(),
            start_seconds: measurement.start_seconds,
            machine: MachineRow {
                cores: bandwidth.threads,
                cache_bytes: machines.first().map_or(0, |here| here.cache_bytes),
                bandwidth_one_thread: bandwidth.one_thread,
                bandwidth_all_threads: bandwidth.all_threads,
                particles,
                contacts,
                simulation_bytes,
                bytes_per_contact_sweep: (contacts > 0.0).then(|| sweep_bytes.moved as f64 / contacts),
            },
            contact_sweeps,
            warm_up_steps: WARM_UP,
            same_bits: differing.is_empty(),
            differing,
            measured: measurement.timings.iter().map(|timing| measured_row(timing, measurement, &replayed)).collect(),
            plan,
            machines,
            replayed,
            findings: Vec::new(),
            provenance,
        };
        study.findings = findings(&study);
        study
    }

    /// Returns the widest measured instruction set.
    pub fn widest(&self) -> Option<InstructionSet> {
        self.measured.last().map(|row| row.instruction_set)
    }

    /// Rows of one curve with the widest instruction set, by number of workers.
    pub(super) fn curve<'a>(
        &'a self,
        machine: &'a Machine,
        way: (Scheduler, Portion),
        set: Option<InstructionSet>,
    ) -> impl Iterator<Item = &'a ReplayedRow> {
        self.replayed.iter().filter(move |row| {
            row.machine == machine.name && (row.scheduler, row.portion) == way && Some(row.instruction_set) == set
        })
    }
}

fn differing(measurement: &Measurement) -> Vec<String> {
    let first = measurement.timings.iter().find_map(|timing| timing.hashes.first());
    let differs = |timing: &&Timing| timing.hashes.iter().any(|hash| Some(hash) != first);
    let names = measurement.timings.iter().filter(differs).map(|timing| {
        let own = timing.configuration;
        let (set, scheduler) = (own.instruction_set.name(), own.scheduler.name());
        format!("{set}, {scheduler}, threads: {}, {}", own.threads, own.portion.name())
    });
    names.collect()
}

fn measured_row(timing: &Timing, measurement: &Measurement, replayed: &[ReplayedRow]) -> MeasuredRow {
    let configuration = timing.configuration;
    let serial = measurement.timings.iter().find(|other| other.configuration.is_serial_of(&configuration));
    let serial = serial.unwrap_or(timing);
    let means = |repetitions: &[Vec<f64>]| repetitions.iter().map(|times| mean(times)).collect::<Vec<f64>>();
    let [steps, sweeps] = [&timing.steps, &timing.sweeps].map(|times| means(times));
    let [serial_steps, serial_sweeps] = [&serial.steps, &serial.sweeps].map(|times| means(times));
    let ratio = |serial: &[f64], own: &[f64]| median(serial.iter().zip(own).map(|(serial, own)| serial / own));
    let sweep_seconds = median(sweeps.iter().copied());
    let of_step = |step: usize| median(timing.steps.iter().map(|times| times[step]));
    let traced_steps = measurement.traces.first().map_or(0, |traces| traces.steps.len());
    let traced_seconds = mean(&(0..traced_steps).map(of_step).collect::<Vec<_>>());
    let is_own = |row: &&ReplayedRow| {
        row.machine == Machine::HERE
            && (row.instruction_set, row.portion) == (configuration.instruction_set, configuration.portion)
            && (row.scheduler, row.workers) == (configuration.scheduler, configuration.threads)
    };
    let replayed_seconds = replayed.iter().find(is_own).map(|row| row.step_seconds);
    MeasuredRow {
        instruction_set: configuration.instruction_set,
        scheduler: configuration.scheduler,
        threads: configuration.threads,
        portion: configuration.portion,
        step_seconds: median(steps.iter().copied()),
        step_seconds_least: steps.iter().copied().fold(f64::INFINITY, f64::min),
        step_seconds_most: steps.iter().copied().fold(0.0, f64::max),
        sweep_seconds,
        speedup: ratio(&serial_steps, &steps),
        sweep_speedup: ratio(&serial_sweeps, &sweeps),
        nanoseconds_per_contact_sweep: (measurement.contact_sweeps > 0.0)
            .then(|| 1e9 * sweep_seconds / measurement.contact_sweeps),
        traced_seconds,
        replayed_seconds,
        deviation_percent: replayed_seconds.map(|seconds| 100.0 * (seconds / traced_seconds - 1.0)),
        state_hash: format!("{:016x}", timing.hashes.last().copied().unwrap_or_default()),
    }
}

/// Lowest speed-up per thread at which a curve is called linear.
const LINEAR_SHARE: f64 = 0.8;

fn findings(study: &Study) -> Vec<String> {
    let mut findings = vec![match study.same_bits {
        true => format!(
            "All {} configurations and the traced steps ended in the same state, bit for bit.",
            study.measured.len()
        ),
        false => format!(
            "Not all configurations gave the same bits; different from the first: {}.",
            study.differing.join("; ")
        ),
    }];
    let worst = |least: usize| {
        let rows = study.measured.iter().filter(|row| row.threads >= least);
        rows.filter_map(|row| row.deviation_percent).map(f64::abs).reduce(f64::max)
    };
    if let Some(all) = worst(1) {
        let several =
            worst(2).map_or(String::new(), |worst| format!(", on more than one thread by at most {worst:.1}%"));
        let count = study.measured.len();
        findings.push(format!("The replay misses the {count} measured configurations by at most {all:.1}%{several}."));
    }
    for machine in &study.machines {
        let linear = [Scheduler::CentralQueue, Scheduler::WorkStealing].map(|scheduler| {
            let rows = study.curve(machine, (scheduler, Portion::Batches), study.widest());
            let linear = rows.take_while(|row| row.sweep_speedup >= LINEAR_SHARE * row.workers as f64).last();
            linear.map_or(0, |row| row.workers)
        });
        findings.push(format!(
            "Replayed on {}, the speed-up of the sweeps is at least {:.0}% of the number of threads up to {} (central queue) and \
             {} (work stealing) threads.",
            site(machine, " with more cores"),
            100.0 * LINEAR_SHARE,
            linear[0],
            linear[1]
        ));
    }
    findings
}

/// Largest measured speed-up of a step with the widest instruction set.
fn answer(study: &Study) -> Answer {
    let own = study.measured.iter().filter(|row| Some(row.instruction_set) == study.widest());
    let best = own.max_by(|one, other| one.speedup.total_cmp(&other.speedup));
    let best = best.expect("each instruction set is measured on one thread");
    Answer {
        class: if study.same_bits { "agree" } else { "disagree" },
        word: format!("{} times as fast on {}.", two_digits(best.speedup), plural(best.threads, "thread")),
        sentence: format!(
            "A step takes {} ({}, {}); its sweeps are {} times as fast. {}",
            time(best.step_seconds),
            best.scheduler.name().replace('-', " "),
            best.instruction_set.name(),
            two_digits(best.sweep_speedup),
            study.findings[0],
        ),
    }
}

/// Returns the name of a machine for sentences.
pub(super) fn site(machine: &Machine, more: &str) -> String {
    if machine.name == Machine::HERE { format!("this machine{more}") } else { format!("the model {}", machine.name) }
}

const LIMITS: [&str; 6] = [
    "Times are medians over the repetitions. A speed-up is the median of the ratios to the serial run of the same instruction set in the \
     same round. A thread takes a batch of tasks at a time, or, with the widest instruction set, also the tasks of one box in one stage.",
    "Replayed numbers were computed from durations of traced tasks on one thread and measured nowhere. Costs of scheduling are measured \
     apart from the solver; nothing is fitted.",
    "The thesis, on a Xeon Phi 3120 with its own tasks, found the sweeps of the central queue linear up to about 25 threads and those of \
     work stealing beyond 40. The model of that machine consists of published figures and stated assumptions.",
    "A replay does not know that a task may find its data in another core's cache, that cores share power and caches, or that other \
     programs run: it is nearer to a bound than to a forecast.",
    "Memory traffic is counted for sweeps alone, and only where their data do not fit into the last-level cache.",
    "The lock of the queue costs the same for any number of workers, and thieves find the fullest deque at once.",
];

impl Document for Study {
    const NAME: &'static str = "scaling";

    fn tables(&self) -> Result<Vec<File>, DocumentError> {
        Ok(vec![
            csv("machine", std::slice::from_ref(&self.machine))?,
            csv("measured", &self.measured)?,
            csv("replayed", &self.replayed)?,
            json("provenance", &self.provenance)?,
        ])
    }

    fn figures(&self) -> Vec<Figure> {
        figures(self)
    }

    fn report(&self) -> Report {
        let MachineRow { cores, particles, contacts, bytes_per_contact_sweep, .. } = &self.machine;
        let gigabytes = |bytes: f64| two_digits(bytes / 1e9);
        let mut memory = format!(
            "Memory: {} GB/s to one thread, {} GB/s to {}.",
            gigabytes(self.machine.bandwidth_one_thread),
            gigabytes(self.machine.bandwidth_all_threads),
            cores
        );
        if let Some(bytes) = bytes_per_contact_sweep {
            memory += &format!(" A contact sweep moves {} bytes outside caches.", two_digits(*bytes));
        }
        Report {
            kind: "Makadam, measured and replayed",
            title: format!("Scaling of the scene {}", self.scene),
            facts: vec![
                format!("{} grains", count(*particles)),
                format!("{} contacts", count(contacts.round() as usize)),
                self.provenance.build.processor.clone(),
                format!("cores {cores}"),
                format!("{} steps, {} repetitions", self.plan.steps, self.plan.repetitions),
                format!("version {}", self.provenance.build.version),
                self.provenance.time.clone(),
            ],
            answer: answer(self),
            // The first finding is part of the answer.
            findings: self.findings.iter().skip(1).cloned().collect(),
            sections: vec![Section::new("Measured", memory, measured(self))],
            notes: Vec::new(),
            limits: self
                .machines
                .iter()
                .map(|machine| machine.description.clone())
                .chain(LIMITS.map(String::from))
                .collect(),
            provenance: self.provenance.pairs(),
            files: "scaling.json, machine.csv, measured.csv and replayed.csv",
        }
    }
}

/// A table of rows by configuration; a group begins with each serial row.
fn measured(study: &Study) -> Table {
    let mut table = Table::new(
        &["instruction set", "scheduler", "of"],
        &["threads", "a step", "speed-up", "sweeps", "speed-up", "ns", "replay"],
    )
    .on_a_page(&[
        "time per step",
        "speed-up",
        "of it sweeps",
        "speed-up of the sweeps",
        "contact sweep (ns)",
        "replay, deviation of its time",
    ]);
    for row in &study.measured {
        let range = format!("{} to {}", time(row.step_seconds_least), time(row.step_seconds_most));
        let cells = cells![
            row.instruction_set.name(),
            row.scheduler.name(),
            row.portion.name(),
            row.threads,
            Cell::from(time(row.step_seconds)).above(Some(range)),
            format!("{:.2}", row.speedup),
            time(row.sweep_seconds),
            format!("{:.2}", row.sweep_speedup),
            row.nanoseconds_per_contact_sweep.map(two_digits),
            row.deviation_percent.map(|percent| format!("{percent:+.1}%").replace('-', "−")),
        ];
        if row.scheduler == Scheduler::Serial { table.first_row(cells) } else { table.row(cells) }
    }
    table
}
