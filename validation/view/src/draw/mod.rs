//! Drawing of numbers, tables and figures, common to all pages and the terminal.
//!
//! ```text
//! values ─> Axis ─> Plot ─> Drawing (SVG) ─> Figure ─> page, file
//! rows   ─> numbers, names ─> columns ─> terminal
//! ```

pub(crate) mod axis;
mod columns;
pub mod figure;
mod labels;
pub mod names;
pub mod numbers;
pub mod plot;
pub mod svg;

pub use columns::{columns, values, wrapped};
