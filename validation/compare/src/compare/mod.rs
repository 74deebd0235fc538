//! Comparison of several codes on one scene: runs, recorded references, rows with verdicts.

mod code_runs;
mod comparison;
mod measured_run;
mod record;
mod reference;
mod registered;
mod rows;
mod simulate;

pub use code_runs::CodeRuns;
pub use comparison::{CodeSummary, Comparison, FinalState, Row, Source, Timing};
pub use measured_run::{Harvest, MeasuredRun, noticed};
pub use record::{FEW_SEEDS, RecordError, Recorder};
pub(crate) use reference::{Missing, Wanted};
pub use reference::{Reference, ReferenceError};
pub use rows::comparison;
pub use rows::live_checks;
pub use simulate::{Announce, Runs, Share};
pub use simulate::{LIVE_FRACTION, Simulated};
