//! The report of a qualification: one self-contained page to read, the same as data, and the rows as CSV.
//!
//! ```text
//! Qualification ─> verdict ─┐
//! Comparison ─> tables      ├─> page ──> report.html
//! StudySection ─> table     │
//!            ─> plots       │   ──────> report.json, rows.csv, junit.xml, badge.svg
//!            ─> pictures    ┘
//!            ─> drawn ────────────────> differences.csv, series.csv, forces.csv, grains.csv, and a file a law
//! ```
//!
//! The page loads nothing, runs no script, follows light and dark, and prints. Its tables and figures show what the
//! comparison says and compute no verdict of their own.

mod against;
mod badge;
mod drawn;
mod forces;
mod forest;
mod junit;
mod on_record;
mod outlines;
mod page;
mod pictures;
mod place;
pub mod published;
mod qualification;
mod rows;
mod schema;
mod series;
mod speed;
mod studies;
mod tables;
mod terminal;
mod words;
mod write;

pub use against::Changes;
pub use on_record::{AnyTestOnRecord, Lost, TestOnRecord};
pub use place::{is_in, may_hold_comparison, may_hold_qualification};
pub use qualification::{Qualification, Standing, Verdict};
pub use schema::schema;
pub use speed::speed_sentence;
pub use studies::{StudyCount, StudyOutcome, StudySection, StudyTest, StudyTestOnRecord};
pub use terminal::comparison_table;
pub use write::{REPORT_VERSION, ReportDocument, ReportPaths, read, write};
