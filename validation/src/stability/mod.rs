//! Hard cases: a catalogue of scenes that break simulators, each with the right outcome, its source and a measured verdict.
//!
//! ```text
//! catalogue -> Case -> run in a code -> Evidence (frames) -> judge -> Finding -> Verdict -> table, Markdown, JSON
//! ```
//!
//! Every code is measured by the same figures from its frames. A run that fails is an outcome like any other.

mod campaign;
mod carry_out;
mod case;
mod catalogue;
mod evidence;
mod known;
mod markdown;
mod outcome;
mod table;

pub use campaign::Campaign;
pub use carry_out::StabilityError;
pub use case::{Case, Judge};
pub use catalogue::catalogue;
pub use evidence::Evidence;
pub use known::{KNOWN_EXCEPTIONS, known_exception};
pub use markdown::markdown;
pub use outcome::{CaseResult, Outcome, Study, Verdict};
pub use table::{table, telling};
