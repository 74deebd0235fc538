//! The sweep against what the machine can do at best: a roofline.
//!
//! ```text
//! multiply and add in registers ──> peak ─────┐
//! update in place, by working set ──> slopes ─┼─> roofs ──┐
//! kernel over counting numbers ──> operations ┐           ├─> study ─> figure, page, CSV
//! layout of a flowing state ──> bytes ────────┼─> points ─┘
//! repeated sweeps ──> contact sweeps a second ┘
//! ```
//!
//! Everything that is drawn was measured in the same run, but for the counts of operations and bytes.

mod figure;
mod machine;
mod page;
mod point;
mod study;
mod terminal;

pub use machine::{Level, Roofs};
pub use point::{Kernel, Point};
pub use study::Study;
pub use terminal::table;
