//! How a step scales with threads: measured as far as the cores go, replayed beyond.
//!
//! ```text
//! prepared state ─> measure ─> timings ─────────────────────────> rows ─┐
//!                          └─> traces ─> replay on P workers ───> rows ─┼─> findings, figures, page, CSV
//!             costs (queue, stealing), hardware ─> machine ────┘         │
//!                                    replay against measurement <───────┘
//! ```
//!
//! A replayed number is never called measured: rows, files, figures and sentences say which is which.

mod answer;
mod costs;
mod figures;
mod findings;
mod hardware;
mod machine;
mod measure;
mod page;
mod predict;
mod replay;
mod rows;
mod study;
mod tasks;
mod terminal;

pub use costs::Costs;
pub use hardware::{Bandwidth, cache_bytes, clock};
pub use machine::{MOST_WORKERS, Machine, worker_counts};
pub use measure::{Measurement, Plan, Times, Timing, Traces, WARM_UP};
pub use replay::{Replayed, Traffic, replay};
pub use rows::{Check, MachineRow, MeasuredRow, ReplayedRow, TaskRow};
pub use study::{Setting, Study};
pub use terminal::table;
