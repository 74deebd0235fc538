//! The same scene in several codes: runs, recorded references, rows with verdicts.

mod code_runs;
mod comparison;
mod kept;
mod measured_run;
mod noticed;
mod record;
mod reference;
mod registered;
mod rows;
mod simulate;

pub use code_runs::CodeRuns;
pub use comparison::{CodeSummary, Comparison, FinalState, Row, Source, Timing};
pub use kept::{KeptError, KeptRuns};
pub use measured_run::{Harvest, MeasuredRun};
pub use noticed::noticed;
pub use record::{FEW_SEEDS, RecordError, Recorded, Recorder};
pub use reference::{MergeError, Missing, Reference, ReferenceError, Wanted};
pub use rows::{LiveCheck, comparison, live_checks};
pub(crate) use simulate::LIVE_FRACTION;
pub use simulate::{Announce, Runs, Share, Simulated, Timed};
