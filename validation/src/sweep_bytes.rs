//! Bytes of a sweep over all contacts, for the roofline and for the replay.

use makadam::groups::{PairGroups, WallGroup};
use makadam::lanes::Eight;
use makadam::partition::{Layout, TaskGroups};
use makadam::world::Body;

/// Arrays of a lane group that a sweep writes: the normal impulse and, where there is friction, three components of the
/// tangential one.
fn arrays_written(task: &TaskGroups) -> usize {
    match task.pairs {
        PairGroups::Smooth(_) => 1,
        PairGroups::Frictional(_) => 4,
    }
}

/// What a sweep reads and writes, bytes.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct SweepBytes {
    /// All that it touches, each byte once: lane groups and a cache line a grain.
    pub touched: usize,
    /// What moves where nothing stays in a cache between sweeps: lane groups are read and their impulses written, each grain is read and
    /// written once, since a box's grains stay in the innermost cache while its contacts are relaxed. Padding lanes move too.
    pub moved: usize,
}

impl SweepBytes {
    /// Of a step's contacts, between so many grains.
    pub fn of(layout: &Layout, grains: usize) -> SweepBytes {
        let grains = grains * size_of::<Body>();
        let (mut groups, mut written) = (0, 0);
        for (_, task) in layout.tasks() {
            groups += task.pairs.len() * task.pairs.bytes_of_group() + task.walls.len() * size_of::<WallGroup>();
            written += (task.pairs.len() + task.walls.len()) * arrays_written(task) * size_of::<Eight>();
        }
        SweepBytes { touched: groups + grains, moved: groups + written + 2 * grains }
    }
}
