//! Bytes of sweeps: what a contact takes in its lane group, and what sweeps over a step's contacts move.

use crate::effects::{EffectSet, Effects, with_effects};
use crate::groups::{PairGroup, TorqueLanes, WallGroup, WallTorqueLanes};
use crate::lanes::{Eight, LANES};

/// Arrays of impulses that a sweep writes: one along the normal, and three components of each other kind.
const NORMAL: usize = size_of::<Eight>();
/// See [`NORMAL`].
const VECTOR: usize = 3 * size_of::<Eight>();

/// What a sweep reads and writes, bytes.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct SweepBytes {
    /// All that it touches, each byte once: lane groups and a cache line a grain.
    pub touched: usize,
    /// What moves where nothing stays in a cache between sweeps: lane groups are read and their impulses written, each grain is read and
    /// written once, since a box's grains stay in the innermost cache while its contacts are relaxed. Padding lanes move too.
    pub moved: usize,
}

impl EffectSet {
    /// Bytes of a contact of two grains in its lane groups.
    pub fn bytes_of_contact(&self) -> usize {
        self.bytes_of_pairs() / LANES
    }

    /// Bytes of the lane groups of eight contacts of two grains.
    pub(crate) fn bytes_of_pairs(&self) -> usize {
        let torques = if self.torques() { size_of::<TorqueLanes>() } else { 0 };
        with_effects!(*self, E => size_of::<PairGroup<<E as Effects>::Tangential>>()) + torques
    }

    /// Bytes of the lane groups of eight contacts with walls, which have room for friction in any case.
    pub(crate) fn bytes_of_walls(&self) -> usize {
        size_of::<WallGroup>() + if self.torques() { size_of::<WallTorqueLanes>() } else { 0 }
    }

    /// Bytes of the impulses of eight contacts, which a sweep writes.
    pub(crate) fn bytes_written(&self) -> usize {
        NORMAL + usize::from(self.tangential()) * VECTOR + usize::from(self.torques()) * VECTOR
    }
}
