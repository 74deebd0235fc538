//! Scaling of a step with threads: measured on the available cores, replayed on modelled ones.
//!
//! ```text
//! prepared state ─> measure ─> step times ──────────────────────> measured rows ─┐
//!                          └─> serial traces ─> replay on P cores ─> replayed rows ─┼─> figures, page, CSV
//!          costs of scheduling, memory ─> machine ──┘     deviations <─────────────┘
//! ```
//!
//! Rows, files, figures and sentences name replayed numbers as such.

mod figures;
mod measure;
mod replay;
mod study;

pub use measure::{Measurement, Plan, Timing, Traces};
pub use replay::{Bandwidth, Costs, Machine, Replayed, ReplayedRow, replay};
pub use study::{MachineRow, MeasuredRow, Study};
