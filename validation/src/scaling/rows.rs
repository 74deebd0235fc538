//! The rows of a scaling study: what was measured, what was replayed, how far apart the two are, how long tasks take.

use makadam::lanes::InstructionSet;
use makadam::partition::Portion;
use makadam::schedule::{Phase, Scheduler};
use serde::Serialize;

/// One measured configuration. Times are medians over the repetitions; speed-ups are medians of the ratios to the serial
/// run of the same instruction set and portion in the same round.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct MeasuredRow {
    /// Instruction set of the sweeps.
    pub instruction_set: InstructionSet,
    /// Scheduler.
    pub scheduler: Scheduler,
    /// Threads.
    pub threads: usize,
    /// What a thread is given at a time.
    pub portion: Portion,
    /// Wall time a step, s.
    pub step_seconds: f64,
    /// The fastest repetition, s.
    pub step_seconds_least: f64,
    /// The slowest repetition, s.
    pub step_seconds_most: f64,
    /// Wall time of a step's sweeps, s.
    pub sweep_seconds: f64,
    /// Speed-up of whole steps.
    pub speedup: f64,
    /// Speed-up of the sweeps.
    pub sweep_speedup: f64,
    /// Time of the sweeps over contact sweeps, ns; absent if there were none.
    pub nanoseconds_per_contact_sweep: Option<f64>,
    /// Hash of the state after the last step, 16 hexadecimal digits.
    pub state_hash: String,
}

/// One replayed number of workers.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ReplayedRow {
    /// Always "replayed".
    pub source: String,
    /// Name of the machine.
    pub machine: String,
    /// Instruction set of the trace.
    pub instruction_set: InstructionSet,
    /// Scheduler.
    pub scheduler: Scheduler,
    /// Workers.
    pub workers: usize,
    /// What a worker is given at a time.
    pub portion: Portion,
    /// Time a step, s.
    pub step_seconds: f64,
    /// Time of a step's sweeps, s.
    pub sweep_seconds: f64,
    /// Speed-up of whole steps over the serial replay on the same machine.
    pub speedup: f64,
    /// Speed-up of the sweeps over the serial replay on the same machine.
    pub sweep_speedup: f64,
    /// Share of the workers' time that they wait for the queue's lock.
    pub waiting_share: f64,
}

/// A prediction beside its measurement, over the traced steps.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Check {
    /// Instruction set of the sweeps.
    pub instruction_set: InstructionSet,
    /// Scheduler.
    pub scheduler: Scheduler,
    /// Threads.
    pub threads: usize,
    /// What a thread is given at a time.
    pub portion: Portion,
    /// Measured wall time a step, s.
    pub measured_seconds: f64,
    /// Time a step, replayed from the serial trace, s.
    pub replayed_seconds: f64,
    /// Replayed over measured, less one, %.
    pub deviation_percent: f64,
    /// Time of all tasks over that in the serial trace of the same portion: what threads do to each other's caches and memory.
    pub task_time_ratio: f64,
    /// Time a step, replayed from tasks as long as they were in this configuration, s.
    pub replayed_from_own_tasks_seconds: f64,
    /// That over measured, less one, %.
    pub own_tasks_deviation_percent: f64,
}

/// What the machine and the scene bring to every configuration.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct MachineRow {
    /// Cores that the process may use.
    pub cores: usize,
    /// Size of the last-level cache as the system tells it, bytes.
    pub cache_bytes: u64,
    /// Memory bandwidth to one thread, bytes/s.
    pub bandwidth_one_thread: f64,
    /// Memory bandwidth to a thread on each core, bytes/s.
    pub bandwidth_all_threads: f64,
    /// Grains.
    pub particles: usize,
    /// Contacts, mean over the timed steps.
    pub contacts: f64,
    /// Memory that the simulation itself holds, bytes.
    pub simulation_bytes: usize,
    /// Memory traffic of a contact sweep that finds nothing in a cache, bytes; absent without contacts.
    pub bytes_per_contact_sweep: Option<f64>,
}

/// Durations of the tasks of one kind of region, in seconds, over the traced steps.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct TaskRow {
    /// Instruction set of the trace.
    pub instruction_set: InstructionSet,
    /// What a thread is given at a time; the table's tasks are these.
    pub portion: Portion,
    /// Phase of the step.
    pub phase: Phase,
    /// Stage of a sweep, from 1; absent elsewhere.
    pub stage: Option<usize>,
    /// Regions a step.
    pub regions: f64,
    /// Tasks a region, in the mean.
    pub tasks: f64,
    /// Tasks of the region that has most; 1 where the work is serial.
    pub most_tasks: usize,
    /// Share of the step's traced time.
    pub share: f64,
    /// Mean.
    pub mean: f64,
    /// Shortest.
    pub least: f64,
    /// A tenth are shorter.
    pub tenth: f64,
    /// Half are shorter.
    pub median: f64,
    /// A tenth are longer.
    pub ninetieth: f64,
    /// Longest.
    pub most: f64,
}
