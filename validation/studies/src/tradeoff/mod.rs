//! Accuracy against wall time: a scene at many settings of every code, each plotted as error against wall time.
//!
//! ```text
//! plan ─> campaign ─> one file per run ─> study: references, points ─> ranking: fronts, fastest ─> report, figures, JSON, CSV
//!             ^              │
//!             └── stored runs are not repeated
//! ```
//!
//! The error of a setting is the deviation of an observable from a converged reference of Makadam at the same
//! stiffness, seed by seed: soft grains have other physics. The reference is the smallest step with the most sweeps;
//! three grids bound its distance from the limit ([`Convergence`]).
//!
//! Runs are timed one after the other on one core, reference codes by the inputs from which they are fastest
//! ([`Purpose::Timing`](makadam_compare::codes::Purpose::Timing)). A time is the processor time of the stepping, without set-up and output. A
//! run of another code that exceeds the time limit is stopped, and its setting listed. The setting then has neither a time nor an error.

mod campaign;
mod figures;
mod plan;
mod report;
mod rows;
mod study;

pub use campaign::{Campaign, Outcome};
pub use plan::{Configuration, Knobs, Plan, Refinement};
pub use rows::{Bound, Convergence, Deviation, Fastest, Point, Reference};
pub use study::{Study, Terms, pareto_front};
