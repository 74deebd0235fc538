//! Which grains and walls may touch: a counting-sorted cell grid, and a candidate list that lives for many steps.
//!
//! Candidates reach a skin further than contact. They stay valid until neighbouring grains (or a grain and a wall) can have
//! come closer by more than the skin; gap and normal are computed anew in each step. Impulses are remembered a candidate, so
//! that warm starting needs no matching but when the list is rebuilt. With the list grains are put in the order of boxes
//! and cells anew, so that what is near in space is near in memory.

mod candidates;
mod drift;
mod grid;
mod memory;
mod reach;
mod search;

pub(crate) use candidates::CandidateList;
pub use candidates::{Candidates, PairCandidate, WallCandidate};
pub use grid::CellGrid;
pub(crate) use memory::MemoryOfTask;
pub use memory::{AngularImpulse, ContactImpulses, Impulse, Memory};
pub(crate) use reach::{Row, for_each_on_the_way};
