//! The same scene in several codes: runs, recorded references, rows with verdicts.

mod comparison;

pub use comparison::{CodeSummary, Comparison, FinalState, ForceDistribution, Outcome, Row, Series, Source};
