//! All reports below a folder: found, put in order, each held against the one of its kind before it, and listed on one page.
//!
//! ```text
//! folder ─> find ─> report.json each ─> Index ─> index.html
//!                                         └────> terminal, JSON
//! ```

mod find;
mod index;
mod page;

pub use find::{DEEPEST, FindError, Found, find};
pub use index::{Change, Entry, Index, Unreadable};
