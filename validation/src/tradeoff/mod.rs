//! What accuracy costs in time: a scene at many settings of every code, each placed as error against wall time.
//!
//! ```text
//! plan ─> campaign ─> one file a run ─> table ─> references, points ─┬─> fronts, fastest ─> findings
//!             ^              │                                       └─> figure, page, JSON, CSV
//!             └── what is there is not run again
//! ```
//!
//! The error of a setting is the deviation of an observable from a converged reference of Makadam at the same
//! stiffness, seed by seed: soft grains are other physics. The reference is the smallest step with the most sweeps;
//! three grids tell how far it may still be from the limit ([`Convergence`]).
//!
//! Runs are timed one after the other on one core, peers by the inputs from which they are fastest
//! ([`Purpose::Timing`](crate::peers::Purpose::Timing)). A time is the processor time of the stepping, without set-up and output: what
//! it takes on a core of its own, however busy the machine was.

mod campaign;
mod chance;
mod configuration;
mod convergence;
mod cost;
mod figures;
mod findings;
mod flat;
mod front;
mod kept;
mod page;
mod panel;
mod plan;
mod ranking;
#[cfg(test)]
mod recorded;
mod rows;
mod study;
mod table;
mod terminal;
mod variations;
mod words;

pub use campaign::{Campaign, CampaignError, Outcome, Progress};
pub use configuration::{Configuration, Knobs};
pub use convergence::Convergence;
pub use front::pareto_front;
pub use kept::{KeptRun, run_key};
pub use plan::{Plan, QUICK_TIME_LIMIT, Refinement, STIFFNESS_FACTORS, Scope};
pub use rows::{Bound, Deviation, Fastest, Point, Reference, Varied};
pub use study::{Study, Terms};
pub use terminal::table;
