//! Common parts of studies: one campaign that runs jobs and stores their results, one report with its renderers.
//!
//! ```text
//! jobs ─> run_jobs ─> RunCache ─> study ─> tables, figures ─> Report ─> Document ─> NAME.html, NAME.md, NAME.json, CSV, SVG
//!                                                                └─> terminal
//! ```

mod campaign;
mod document;
mod report;
pub mod table;

pub use campaign::{Key, RunCache, RunError, run_jobs, sealed, unseal};
pub use document::{Document, DocumentError, File, json, table, write_scenes, write_together};
pub use report::{Answer, Finding, Medium, Report, Section, environment, style};
pub use table::{Cell, Table, cells};
