//! A scene over values of some of its keys: every combination, several seeds each, one table.
//!
//! ```text
//! --over KEY=a,b,c ─> points (combinations) x seeds ─> runs side by side, kept ─> means over seeds ─> terminal, CSV, JSON
//! ```

mod folder;
mod study;
mod table;

pub use folder::{DOCUMENT, take};
pub use study::{Failed, ParameterError, Plan, Point, Range, Run, Study};
