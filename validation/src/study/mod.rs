//! What the studies have in common.
//!
//! ```text
//! study ─> tables, figures ─> Report ─> page ─> Document ─> NAME.html, NAME.json, CSV, SVG
//!                                 └─> terminal
//! ```

mod cache;
mod campaign;
mod document;
mod finding;
mod page;
mod report;
mod table;

pub use cache::{Found, Key, RunCache, damaged_below, sealed, unseal};
pub use campaign::run_jobs;
pub use document::{Document, DocumentError, File};
pub(crate) use document::{drawn, json, table, write_together};
pub use finding::Finding;
pub(crate) use page::{environment, page, style};
pub use report::Report;
pub(crate) use report::{Answer, Medium, Section};
pub(crate) use table::{Cell, Table, cells};
