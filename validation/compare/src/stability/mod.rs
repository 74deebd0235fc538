//! Stress tests: scenes that break simulators, each with the expected outcome, its source and a measured verdict.
//!
//! ```text
//! catalogue -> Case -> run in a code -> Evidence (frames) -> judge -> Finding -> Verdict -> report
//! ```
//!
//! The figures of every code are measured from its frames in the same way. A run that fails is an outcome like any other.

mod campaign;
mod case;
mod catalogue;
mod evidence;
mod study;

pub use campaign::Campaign;
pub use case::{Case, Outcome, Verdict, known_exception};
pub use catalogue::catalogue;
pub(crate) use evidence::Evidence;
pub(crate) use study::{CaseResult, Study};
