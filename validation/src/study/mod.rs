//! What the studies have in common.
//!
//! ```text
//! study ─> tables, figures ─> page ─> Document ─> NAME.html, NAME.json, CSV, SVG
//!                      └─> terminal, Markdown
//! ```

mod answer;
mod cache;
mod document;
mod finding;
mod page;
mod table;

pub(crate) use answer::Answer;
pub use cache::{Found, Key, RunCache, damaged_below, sealed, unseal};
pub use document::{Document, DocumentError, File};
pub(crate) use document::{drawn, json, table, write_together};
pub use finding::Finding;
pub(crate) use page::{environment, page, style};
pub(crate) use table::{Cell, Table, cells};
