//! What the studies have in common.

mod finding;

pub use finding::Finding;
