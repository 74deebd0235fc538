//! Order in which contacts are relaxed: boxes, conflict-free stages, lane groups.
//!
//! Space is cut into boxes eight diameters wide. A contact of two grains of one box belongs to the box's interior, one
//! across a face, edge or corner to that face, edge or corner. Tasks of one stage share no body, whatever their number:
//!
//! ```text
//! stage 0        1   2   3   4    5    6    7
//!       interior f_x f_y f_z e_xy e_yz e_zx corner
//! ```
//!
//! No contact moves a wall, so a wall contact belongs to the interior of its grain's box; driven walls are the exception, whose
//! contacts come behind all stages, one by one. Inside a task contacts are packed into
//! lane groups of eight that share no body. All of this depends on the scene alone, never on threads or machine.

mod assignment;
mod boxes;
mod plan;
mod shares;
mod single;

pub(crate) use assignment::{FindWaits, overlapped};
pub(crate) use assignment::{LaneAssigner, Taken, TakenGroups};
pub use boxes::{BoxGrid, STAGES};
pub(crate) use boxes::{DIRECTIONS, SAME_BOX};
pub use plan::{Plan, PlannedTask, Portion};
pub(crate) use shares::{ByBlocks, ByBodies, ByCandidates, ByNumber, ByPlace, ByStarts, TaskShares};
pub(crate) use single::{SingleBody, SingleCopy, SingleGroups, SinglePairGroup};

use crate::effects::resistance::TorqueLanes;
use crate::groups::{ImpactLanes, PairGroup, PairGroups, Sources, WallGroup, WallTorqueLanes};
use crate::lanes::{Eight, LANES, PREFETCH};
use crate::world::Body;

/// Lane groups of one task; what sweeps read and write besides bodies.
#[derive(Clone, Debug, Default)]
pub struct TaskGroups {
    /// Groups of contacts of two grains.
    pub pairs: PairGroups,
    /// Candidates of their contacts.
    pub pair_sources: Vec<Sources>,
    /// True for each group of pairs that shares a body with the one before it; empty where that was not asked, and then it may.
    pub pair_waits: Vec<bool>,
    /// Groups of contacts with walls.
    pub walls: Vec<WallGroup>,
    /// Candidates of their contacts.
    pub wall_sources: Vec<Sources>,
    /// Impacts of the pairs, a group each.
    pub pair_impacts: Vec<ImpactLanes>,
    /// Impacts of the contacts with walls, a group each.
    pub wall_impacts: Vec<ImpactLanes>,
    /// Torques of the pairs, a group each; empty where contacts bear none.
    pub pair_torques: Vec<TorqueLanes>,
    /// Torques of the contacts with walls, a group each; empty where contacts bear none.
    pub wall_torques: Vec<WallTorqueLanes>,
    /// Impulses with which cohesion pulls the pairs together, N s; empty where there is none.
    pub pair_pulls: Vec<Eight>,
    /// Impulses with which cohesion pulls grains to walls, N s.
    pub wall_pulls: Vec<Eight>,
    /// Drifts of the contacts with walls, m/s, which their walls' velocities contain; empty where no wall turns.
    pub wall_drifts: Vec<[Eight; 3]>,
    /// Number of groups at the end of `walls` that are with driven walls: no sweep over lanes relaxes them.
    pub driven_walls: usize,
    /// True if some grain is pressed so deep into a wall that it may cross it however slow it is.
    pub(crate) deep_walls: bool,
    /// Which of the task's pairs of candidates touch, as bits: a byte for eight of them.
    pub(crate) touching: Vec<u8>,
    pub(crate) pair_contacts: usize,
    pub(crate) wall_contacts: usize,
    /// Number of the candidate list that the pairs were packed from; 0 if they were not.
    assigned_from: u64,
    pairs_used: usize,
    walls_used: usize,
}

/// Bytes that stay in a core's own cache from sweep to sweep: the second level of processors that have AVX-512.
const CACHE: usize = 1 << 20;

/// All contacts of a step, laid out for relaxation.
#[derive(Clone, Debug, Default)]
pub struct Layout {
    /// The tasks that have candidates, stage after stage. They are replaced by `Layout::replan`.
    pub plan: Plan,
    /// Lane groups of every task that can be, by its number ([`PlannedTask::number`]): of every planned one at least. Those of a box
    /// lie together, so that a box that keeps its number finds the memory that it had.
    pub groups: Vec<TaskGroups>,
    /// Number of boxes that the tasks of the plan are of; there may have been more.
    pub(crate) boxes: usize,
    /// The contacts with driven walls, in the order in which they are relaxed.
    pub driven: Vec<DrivenContact>,
    /// Number of contacts, padding lanes left out.
    pub contacts: usize,
}

/// Position of a contact with a driven wall in the layout, and its direction of motion.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DrivenContact {
    /// Number of its task.
    pub task: u32,
    /// Number of its group among the task's groups of wall contacts.
    pub group: u32,
    /// Its lane.
    pub lane: u32,
    /// Number of the drive.
    pub drive: u32,
    /// Jacobian of its point of the wall, the point's velocity over the drive's rate: no unit, or m.
    pub jacobian: [f64; 3],
    /// Drift of the point where the wall turns, m/s: its velocity is the rate times the Jacobian, and this.
    pub drift: [f64; 3],
}

impl TaskGroups {
    /// Number of contacts, padding lanes left out.
    pub fn contacts(&self) -> usize {
        self.pair_contacts + self.wall_contacts
    }

    /// Groups of contacts with walls that move as prescribed or not at all.
    #[inline(always)]
    pub fn prescribed_walls(&self) -> usize {
        self.walls.len() - self.driven_walls
    }
}

impl Layout {
    /// An empty layout for so many tasks.
    pub fn new(tasks: usize) -> Layout {
        Layout { groups: vec![TaskGroups::default(); tasks], boxes: tasks / STAGES, ..Layout::default() }
    }

    /// Takes a plan of tasks whose numbers lie below `tasks`: each has its lane groups from then on, without a contact until they are laid
    /// out.
    pub(crate) fn replan(&mut self, tasks: usize, plan: impl FnOnce(&mut Plan)) {
        plan(&mut self.plan);
        self.boxes = tasks / STAGES;
        if tasks > self.groups.len() {
            self.groups.resize_with(tasks, TaskGroups::default);
        }
    }

    /// Stage and lane groups of the tasks that have any, in the order of their stages.
    pub fn tasks(&self) -> impl Iterator<Item = (usize, &TaskGroups)> {
        let stages = (0..STAGES).flat_map(|stage| self.plan.stage(stage).iter().map(move |task| (stage, task)));
        stages.map(|(stage, task)| (stage, &self.groups[task.number as usize]))
    }

    /// Share of lanes that hold a contact, 0 to 1.
    pub fn lane_occupancy(&self) -> f64 {
        let groups: usize = self.tasks().map(|(_, task)| task.pairs.len() + task.walls.len()).sum();
        self.contacts as f64 / (LANES * groups).max(1) as f64
    }

    /// Lane groups ahead of which a sweep over so many bodies should fetch: none where it finds everything in the cache.
    pub(crate) fn prefetch(&self, bodies: usize) -> usize {
        let bytes = self.contacts * size_of::<PairGroup>() / LANES + bodies * size_of::<Body>();
        if bytes < CACHE { 0 } else { PREFETCH }
    }

    pub(crate) fn memory_bytes(&self) -> usize {
        let of_task = |task: &TaskGroups| {
            size_of::<TaskGroups>()
                + task.pairs.capacity() * task.pairs.bytes_of_group()
                + task.walls.capacity() * size_of::<WallGroup>()
                + task.pair_waits.capacity()
                + task.touching.capacity()
                + (task.pair_sources.capacity() + task.wall_sources.capacity()) * size_of::<Sources>()
                + (task.pair_impacts.capacity() + task.wall_impacts.capacity()) * size_of::<ImpactLanes>()
                + task.pair_torques.capacity() * size_of::<TorqueLanes>()
                + task.wall_torques.capacity() * size_of::<WallTorqueLanes>()
                + (task.pair_pulls.capacity() + task.wall_pulls.capacity()) * size_of::<Eight>()
                + task.wall_drifts.capacity() * size_of::<[Eight; 3]>()
        };
        let driven = self.driven.capacity() * size_of::<DrivenContact>();
        self.groups.iter().map(of_task).sum::<usize>() + self.plan.memory_bytes() + driven
    }
}
