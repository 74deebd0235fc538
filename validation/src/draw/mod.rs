//! Drawing of numbers, tables and figures, common to all pages and the terminal.
//!
//! ```text
//! values ─> Axis ─> Plot ─> Drawing (SVG) ─> Figure ─> page, file
//! rows   ─> numbers, names ─> columns ─> terminal
//! ```

pub(crate) mod axis;
mod columns;
pub(crate) mod figure;
mod labels;
pub(crate) mod names;
pub(crate) mod numbers;
pub(crate) mod plot;
pub(crate) mod svg;

pub(crate) use columns::{columns, values, wrapped};
