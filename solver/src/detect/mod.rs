//! Detection of potential contacts: a counting-sorted cell grid, and a candidate list that is valid for many steps.
//!
//! Candidates lie within contact distance plus a skin. They stay valid until neighbouring grains (or a grain and a wall) may have
//! approached by more than the skin; gap and normal are recomputed in each step. Impulses are stored per candidate, so that warm
//! starting needs no matching except at a rebuild. A rebuild also sorts the grains by boxes and cells, so that neighbours in
//! space are neighbours in memory.

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
