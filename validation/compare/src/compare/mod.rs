//! Comparison of several codes on one scene: runs, recorded references, rows with verdicts.

mod comparison;
mod record;
mod reference;
mod rows;
mod runs;
mod simulate;

pub use comparison::{CodeSummary, Comparison, FinalState, Row, Source, Timing, distinct};
pub use record::{FEW_SEEDS, RecordError, record};
pub use reference::{Reference, ReferenceError};
pub use rows::{comparison, live_checks};
pub use runs::{CodeRuns, Harvest, MeasuredRun, noticed};
pub use simulate::{Announce, LIVE_FRACTION, Runs, Share, Simulated};
