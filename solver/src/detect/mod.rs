//! Which grains and walls may touch: a counting-sorted cell grid, and a candidate list that lives for many steps.
//!
//! Candidates reach a skin further than contact. They stay valid until grains (or a grain and a wall) can have come
//! closer by more than the skin; gap and normal are computed anew in each step. Impulses are remembered a candidate, so
//! that warm starting needs no matching but when the list is rebuilt.

mod candidates;
mod grid;

pub use candidates::{Candidates, Impulse, PairCandidate, WallCandidate};
pub use grid::CellGrid;
