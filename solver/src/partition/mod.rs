//! Where contacts are relaxed and in which order: boxes, conflict-free stages, lane groups.
//!
//! Space is cut into boxes eight diameters wide. A contact of two grains of one box belongs to the box's interior, one
//! across a face, edge or corner to that face, edge or corner. Tasks of one stage share no body, whatever their number:
//!
//! ```text
//! stage 0        1   2   3   4    5    6    7
//!       interior f_x f_y f_z e_xy e_yz e_zx corner
//! ```
//!
//! Walls are fixed, so a wall contact belongs to the interior of its grain's box. Inside a task contacts are packed into
//! lane groups of eight that share no body. All of this depends on the scene alone, never on threads or machine.

mod boxes;
mod groups;
mod packing;

pub use boxes::{BoxGrid, STAGES};
pub(crate) use groups::Constraint;
pub use groups::{ContactLanes, PairGroup, WallGroup};
pub(crate) use packing::{Packer, PairEntry, WallEntry};

/// Lane groups of one task: ranges in the groups of pairs and of walls.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Task {
    /// Stage, 0 to 7.
    pub stage: u8,
    /// Groups of pairs.
    pub pairs: std::ops::Range<usize>,
    /// Groups of wall contacts.
    pub walls: std::ops::Range<usize>,
}

/// All contacts of a step, laid out for relaxation.
#[derive(Clone, Debug, Default)]
pub struct Layout {
    /// Groups of contacts of two grains, task after task.
    pub pairs: Vec<PairGroup>,
    /// Groups of contacts with walls, task after task.
    pub walls: Vec<WallGroup>,
    /// Tasks in the order of their stages.
    pub tasks: Vec<Task>,
    /// Number of contacts, padding lanes left out.
    pub contacts: usize,
}

impl Layout {
    /// Share of lanes that hold a contact, 0 to 1.
    pub fn lane_occupancy(&self) -> f64 {
        self.contacts as f64 / (crate::world::LANES * (self.pairs.len() + self.walls.len())).max(1) as f64
    }

    pub(crate) fn memory_bytes(&self) -> usize {
        self.pairs.capacity() * size_of::<PairGroup>()
            + self.walls.capacity() * size_of::<WallGroup>()
            + self.tasks.capacity() * size_of::<Task>()
    }

    pub(crate) fn clear(&mut self) {
        self.pairs.clear();
        self.walls.clear();
        self.tasks.clear();
        self.contacts = 0;
    }
}
