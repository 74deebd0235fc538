//! Common parts of studies: one campaign that runs jobs and stores their results, one report with its renderers.
//!
//! ```text
//! jobs ─> run_jobs ─> RunCache ─> study ─> tables, figures ─> Report ─> Document ─> NAME.html, NAME.md, NAME.json, CSV, SVG
//!                                                                └─> terminal
//! ```

mod cache;
mod campaign;
mod document;
mod finding;
mod report;
pub mod table;

pub use cache::{Key, RunCache, damaged_runs, sealed, unseal};
pub use campaign::{RunError, run_jobs};
pub use document::{Document, DocumentError, File};
pub use document::{json, table, write_scenes, write_together};
pub use finding::Finding;
pub use report::Report;
pub use report::{Answer, Medium, Section, environment, style};
pub use table::{Cell, Table, cells};
