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

/// One replayed configuration.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[expect(missing_docs, reason = "validation/docs/json.md describes the fields of documents")]
pub struct ReplayedRow {
    /// Always "replayed".
    pub source: String,
    pub machine: String,
    pub instruction_set: InstructionSet,
    pub scheduler: Scheduler,
    pub workers: usize,
    pub portion: Portion,
    pub step_seconds: f64,
    pub sweep_seconds: f64,
    /// Speed-up of whole steps over the serial replay on the same machine.
    pub speedup: f64,
    pub sweep_speedup: f64,
    /// Fraction of the workers' time spent waiting for the queue's lock.
    pub waiting_share: f64,
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
