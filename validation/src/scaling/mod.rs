//! Scaling of a step with threads: measured on the available cores, replayed on modelled ones.
//!
//! ```text
//! prepared state ─> measure ─> step times ──────────────────────> measured rows ─┐
//!                          └─> serial traces ─> replay on P cores ─> replayed rows ─┼─> figures, page, CSV
//!          costs of scheduling, memory ─> machine ──┘     checks <─────────────────┘
//! ```
//!
//! Rows, files, figures and sentences name replayed numbers as such.

mod figures;
mod measure;
mod replay;
mod study;

pub use measure::{Bandwidth, Measurement, Plan, Times, Timing, Traces};
pub use replay::{Costs, Machine, Replayed, Traffic, replay};
pub use study::{Setting, Study};

use makadam::lanes::InstructionSet;
use makadam::partition::Portion;
use makadam::schedule::Scheduler;
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
    /// Portion of work that a thread takes at a time.
    pub portion: Portion,
    /// Wall time per step, s.
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

/// One replayed configuration.
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
    /// Portion of work that a worker takes at a time.
    pub portion: Portion,
    /// Time a step, s.
    pub step_seconds: f64,
    /// Time of a step's sweeps, s.
    pub sweep_seconds: f64,
    /// Speed-up of whole steps over the serial replay on the same machine.
    pub speedup: f64,
    /// Speed-up of the sweeps over the serial replay on the same machine.
    pub sweep_speedup: f64,
    /// Fraction of the workers' time spent waiting for the queue's lock.
    pub waiting_share: f64,
}

/// A replay compared with its measurement, over the traced steps.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Check {
    /// Instruction set of the sweeps.
    pub instruction_set: InstructionSet,
    /// Scheduler.
    pub scheduler: Scheduler,
    /// Threads.
    pub threads: usize,
    /// Portion of work that a thread takes at a time.
    pub portion: Portion,
    /// Measured wall time per step, s.
    pub measured_seconds: f64,
    /// Time per step, replayed from the serial trace, s.
    pub replayed_seconds: f64,
    /// Replayed over measured, minus one, %.
    pub deviation_percent: f64,
}

/// Properties of machine and scene that all configurations share.
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
