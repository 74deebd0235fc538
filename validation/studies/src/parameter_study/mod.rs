//! A scene over values of some of its keys: every combination, several seeds each, one table.
//!
//! ```text
//! --over KEY=a,b,c ─> points (combinations) x seeds ─> runs side by side, stored ─> means over seeds ─> report, CSV, JSON
//! ```

mod folder;
mod report;
mod study;

pub use folder::take;
pub use study::{Failed, ParameterError, Plan, Point, Range, Study};
