//! The study: rows of a measurement and its replays, findings, tables.

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
    pub state_hash: String,
}

/// A replay compared with its measurement, over the traced steps.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[expect(missing_docs, reason = "validation/docs/json.md describes the fields of documents")]
pub struct Check {
    pub instruction_set: InstructionSet,
    pub scheduler: Scheduler,
    pub threads: usize,
    pub portion: Portion,
    pub measured_seconds: f64,
    /// Time per step, replayed from the serial trace, s.
    pub replayed_seconds: f64,
    /// Replayed over measured, minus one, %.
    pub deviation_percent: f64,
}

/// Properties of machine and scene that all configurations share.
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
    /// Memory that the simulation itself holds, bytes.
    pub simulation_bytes: usize,
    /// Memory traffic of a contact sweep that finds nothing in a cache, bytes; absent without contacts.
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
    pub bandwidth: Bandwidth,
    /// True if all configurations ended in the same state, bit for bit.
    pub same_bits: bool,
    pub differing: Vec<String>,
    pub measured: Vec<MeasuredRow>,
    /// Machines of the replay.
    pub machines: Vec<Machine>,
    pub replayed: Vec<ReplayedRow>,
    pub checks: Vec<Check>,
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
            bandwidth,
            same_bits: differing.is_empty(),
            differing,
            measured: measurement.timings.iter().map(|timing| measured_row(timing, measurement)).collect(),
            checks: checks(&plan, measurement, &replayed),
            plan,
            machines,
            replayed,
            findings: Vec::new(),
            provenance,
        };
        study.findings = findings(&study);
        study
    }

    /// The widest instruction set that was measured.
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

fn measured_row(timing: &Timing, measurement: &Measurement) -> MeasuredRow {
    let configuration = timing.configuration;
    let serial = measurement.timings.iter().find(|other| other.configuration.is_serial_of(&configuration));
    let serial = serial.unwrap_or(timing);
    let means = |repetitions: &[Vec<f64>]| repetitions.iter().map(|times| mean(times)).collect::<Vec<f64>>();
    let [steps, sweeps] = [&timing.steps, &timing.sweeps].map(|times| means(times));
    let [serial_steps, serial_sweeps] = [&serial.steps, &serial.sweeps].map(|times| means(times));
    let ratio = |serial: &[f64], own: &[f64]| median(serial.iter().zip(own).map(|(serial, own)| serial / own));
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
        speedup: ratio(&serial_steps, &steps),
        sweep_speedup: ratio(&serial_sweeps, &sweeps),
        nanoseconds_per_contact_sweep: (measurement.contact_sweeps > 0.0)
            .then(|| 1e9 * sweep_seconds / measurement.contact_sweeps),
        state_hash: format!("{:016x}", timing.hashes.last().copied().unwrap_or_default()),
    }
}

/// Compares the replay on this machine with the measured times of the same steps.
fn checks(plan: &Plan, measurement: &Measurement, replayed: &[ReplayedRow]) -> Vec<Check> {
    let checks = measurement.timings.iter().filter_map(|timing| {
        let own = timing.configuration;
        let row = replayed.iter().find(|row| {
            row.machine == Machine::HERE
                && (row.instruction_set, row.portion) == (own.instruction_set, own.portion)
                && (row.scheduler, row.workers) == (own.scheduler, own.threads)
        })?;
        let of_step = |step: usize| median(timing.steps.iter().map(|times| times[step]));
        let measured_seconds = mean(&(0..plan.traced_steps as usize).map(of_step).collect::<Vec<_>>());
        Some(Check {
            instruction_set: own.instruction_set,
            scheduler: own.scheduler,
            threads: own.threads,
            portion: own.portion,
            measured_seconds,
            replayed_seconds: row.step_seconds,
            deviation_percent: 100.0 * (row.step_seconds / measured_seconds - 1.0),
        })
    });
    checks.collect()
}

/// Speed-up over number of threads down to which a curve is called linear.
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
        let checks = study.checks.iter().filter(|check| check.threads >= least);
        checks.map(|check| check.deviation_percent.abs()).reduce(f64::max)
    };
    if let Some(all) = worst(1) {
        let several =
            worst(2).map_or(String::new(), |worst| format!(", on more than one thread by at most {worst:.1}%"));
        let count = study.checks.len();
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

/// The largest measured speed-up of a step on several threads, or one thread alone, with the widest instruction set.
fn answer(study: &Study) -> Answer {
    let own = || study.measured.iter().filter(|row| Some(row.instruction_set) == study.widest());
    let best = own().filter(|row| row.threads > 1).max_by(|one, other| one.speedup.total_cmp(&other.speedup));
    let best = best.or(own().next()).expect("each instruction set is measured on one thread");
    let serial = own().find(|row| row.scheduler == Scheduler::Serial && row.portion == best.portion).unwrap_or(best);
    let class = match (study.same_bits, best.speedup > 1.0) {
        (false, _) => "disagree",
        (true, true) => "agree",
        (true, false) => "undecided",
    };
    let prefix = if best.speedup > 1.0 { "" } else { "No gain: " };
    let threads = plural(best.threads, "thread");
    Answer {
        class,
        word: format!("{prefix}{} times as fast on {threads}.", two_digits(best.speedup)),
        sentence: format!(
            "A step takes {} instead of {} ({}, {}); its sweeps are {} times as fast. {}",
            time(best.step_seconds),
            time(serial.step_seconds),
            best.scheduler.name().replace('-', " "),
            best.instruction_set.name(),
            two_digits(best.sweep_speedup),
            study.findings[0],
        ),
    }
}

/// Name of a machine in sentences.
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
            csv("checks", &self.checks)?,
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
            gigabytes(self.bandwidth.one_thread),
            gigabytes(self.bandwidth.all_threads),
            self.bandwidth.threads
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
            sections: vec![
                Section::new("Measured", memory, measured(self)),
                Section::new("Replay compared with measurement", "", compared(self)),
            ],
            notes: Vec::new(),
            limits: self
                .machines
                .iter()
                .map(|machine| machine.description.clone())
                .chain(LIMITS.map(String::from))
                .collect(),
            provenance: self.provenance.pairs(),
            files: "scaling.json, machine.csv, measured.csv, replayed.csv and checks.csv",
        }
    }
}

/// A table of rows by configuration; a group begins with each serial row.
fn by_configuration(
    numbers: &[&str],
    rows: impl IntoIterator<Item = ((InstructionSet, Scheduler, Portion, usize), Vec<Cell>)>,
) -> Table {
    let mut table = Table::new(&["instruction set", "scheduler", "of"], &[&["threads"], numbers].concat());
    for ((set, scheduler, portion, threads), cells) in rows {
        let configuration = cells![set.name(), scheduler.name(), portion.name(), threads];
        let row = configuration.into_iter().chain(cells);
        if scheduler == Scheduler::Serial { table.first_row(row) } else { table.row(row) }
    }
    table
}

fn measured(study: &Study) -> Table {
    let rows = study.measured.iter().map(|row| {
        let range = format!("{} to {}", time(row.step_seconds_least), time(row.step_seconds_most));
        let cells = cells![
            Cell::from(time(row.step_seconds)).above(Some(range)),
            format!("{:.2}", row.speedup),
            time(row.sweep_seconds),
            format!("{:.2}", row.sweep_speedup),
            row.nanoseconds_per_contact_sweep.map(two_digits),
        ];
        ((row.instruction_set, row.scheduler, row.portion, row.threads), cells)
    });
    by_configuration(&["a step", "speed-up", "sweeps", "speed-up", "ns"], rows).on_a_page(&[
        "time per step",
        "speed-up",
        "of it sweeps",
        "speed-up of the sweeps",
        "contact sweep (ns)",
    ])
}

fn compared(study: &Study) -> Table {
    let rows = study.checks.iter().map(|check| {
        let deviation = format!("{:+.1}%", check.deviation_percent).replace('-', "−");
        let cells = cells![time(check.measured_seconds), time(check.replayed_seconds), deviation];
        ((check.instruction_set, check.scheduler, check.portion, check.threads), cells)
    });
    by_configuration(&["measured", "replayed", "deviation"], rows)
}
