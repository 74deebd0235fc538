//! Hard cases: a catalogue of scenes that break simulators, each with the right outcome, its source and a measured verdict.
//!
//! ```text
//! catalogue -> Case -> run in a code -> Evidence (frames) -> judge -> Finding -> Verdict -> table, Markdown, JSON
//! ```
//!
//! Every code is measured by the same figures from its frames. A run that fails is an outcome like any other.

mod campaign;
mod case;
mod catalogue;
mod evidence;
mod table;

pub use campaign::{Campaign, StabilityError};
pub use case::{Case, CaseResult, Judge, KNOWN_EXCEPTIONS, Outcome, Study, Verdict, known_exception};
pub use catalogue::catalogue;
pub use evidence::Evidence;
pub use table::{markdown, table, telling};
