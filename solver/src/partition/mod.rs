//! Order in which contacts are relaxed: boxes, conflict-free stages, lane groups.
//!
//! Space is divided into boxes with a width of eight diameters. A contact between two grains of one box belongs to the interior of the box,
//! a contact across a face, edge or corner to that face, edge or corner. Tasks of one stage, of any number, share no body:
//!
//! ```text
//! stage 0        1   2   3   4    5    6    7
//!       interior f_x f_y f_z e_xy e_yz e_zx corner
//! ```
//!
//! No contact moves a wall, so a wall contact belongs to the interior of its grain's box. Dynamic walls are the
//! exception: their contacts are relaxed one by one after all stages. Within a task, contacts are packed into lane
//! groups of eight that share no body. The order depends on the scene alone, never on threads or machine.

mod assignment;
mod boxes;
mod plan;
mod ranks;
mod shares;
mod single;

pub(crate) use assignment::{FindWaits, PREVIOUS, SECOND_PREVIOUS, overlapped};
pub(crate) use assignment::{LaneAssigner, Taken, TakenGroups};
pub use boxes::{BoxGrid, STAGES};
pub(crate) use boxes::{DIRECTIONS, SAME_BOX};
pub use plan::{Plan, PlannedTask, Portion};
pub(crate) use ranks::{DRIVEN_STAGE, Ranks};
pub(crate) use shares::{Between, ByBlocks, ByBodies, ByCandidates, ByNumber, ByPlace, ByStarts, TaskShares};
pub(crate) use single::{SingleBody, SingleCopy, SingleGroups, SinglePairGroup};

use crate::effects::resistance::TorqueLanes;
use crate::groups::{ImpactLanes, PairGroup, PairGroups, Sources, WallGroup, WallTorqueLanes};
use crate::lanes::{Eight, LANES, PREFETCH};
use crate::world::Body;

/// Lane groups of one task: the data of sweeps other than bodies.
#[derive(Clone, Debug, Default)]
pub struct TaskGroups {
    /// Groups of contacts between two grains.
    pub pairs: PairGroups,
    /// Candidates of the contacts in `pairs`.
    pub pair_sources: Vec<Sources>,
    /// Marks of each group of pairs that shares a body with a group before it, `PREVIOUS` or `SECOND_PREVIOUS`; empty if not
    /// determined, and then every group may.
    pub pair_waits: Vec<u8>,
    /// Groups of contacts with walls.
    pub walls: Vec<WallGroup>,
    /// Candidates of the contacts in `walls`.
    pub wall_sources: Vec<Sources>,
    /// Impacts of the pairs, one entry per group.
    pub pair_impacts: Vec<ImpactLanes>,
    /// Impacts of the contacts with walls, one entry per group.
    pub wall_impacts: Vec<ImpactLanes>,
    /// Torques of the pairs, one entry per group; empty for contacts without torques.
    pub pair_torques: Vec<TorqueLanes>,
    /// Torques of the contacts with walls, one entry per group; empty for contacts without torques.
    pub wall_torques: Vec<WallTorqueLanes>,
    /// Cohesive impulses of the pairs, N s; empty without cohesion.
    pub pair_pulls: Vec<Eight>,
    /// Cohesive impulses between grains and walls, N s.
    pub wall_pulls: Vec<Eight>,
    /// Drifts of the contacts with walls, m/s, included in the velocities of their walls; empty if no wall rotates.
    pub wall_drifts: Vec<[Eight; 3]>,
    /// Number of groups with dynamic walls, at the end of `walls`: lane sweeps do not relax these groups.
    pub driven_walls: usize,
    /// True if at least one grain is so deep in a wall that the grain may cross it at any speed.
    pub(crate) deep_walls: bool,
    /// Bit mask of the pairs of candidates in contact: one byte per eight pairs.
    pub(crate) touching: Vec<u8>,
    pub(crate) pair_contacts: usize,
    pub(crate) wall_contacts: usize,
    /// Number of the candidate list of the packed pairs; 0 without such a list.
    assigned_from: u64,
    pairs_used: usize,
    walls_used: usize,
}

/// Bytes that remain in a core's private cache from sweep to sweep: the second level of processors with AVX-512.
const CACHE: usize = 1 << 20;

/// All contacts of a step, laid out for relaxation.
#[derive(Clone, Debug, Default)]
pub struct Layout {
    /// Tasks with candidates, stage after stage, replaced by `Layout::replan`.
    pub plan: Plan,
    /// Lane groups of every possible task by its number ([`PlannedTask::number`]), at least of every planned task.
    /// Groups of a box are contiguous, so that a box with an unchanged number reuses its memory.
    pub groups: Vec<TaskGroups>,
    /// Number of boxes in the plan; earlier plans may have had more.
    pub(crate) boxes: usize,
    /// Contacts with dynamic walls, in the order of relaxation.
    pub driven: Vec<DrivenContact>,
    /// Number of contacts without padding lanes, on all ranks.
    pub contacts: usize,
    /// Ranks of the run, if there are several: the plan holds the tasks of this one.
    pub(crate) ranks: Option<Ranks>,
}

/// Position of a contact with a dynamic wall in the layout, and its direction of motion.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DrivenContact {
    /// Index of the task.
    pub task: u32,
    /// Index of the group among the task's groups of wall contacts.
    pub group: u32,
    /// Lane of the contact.
    pub lane: u32,
    /// Index of the drive.
    pub drive: u32,
    /// Jacobian of the contact point on the wall, its velocity over the drive's rate: dimensionless, or m.
    pub jacobian: [f64; 3],
    /// Drift of the point on a rotating wall, m/s: the velocity of the point is the rate times the Jacobian, plus this drift.
    pub drift: [f64; 3],
}

impl TaskGroups {
    /// Returns the number of contacts without padding lanes.
    pub fn contacts(&self) -> usize {
        self.pair_contacts + self.wall_contacts
    }

    /// Returns the groups of contacts with fixed and kinematic walls.
    #[inline(always)]
    pub fn prescribed_walls(&self) -> usize {
        self.walls.len() - self.driven_walls
    }
}

impl Layout {
    /// Creates an empty layout for n tasks.
    pub fn new(tasks: usize) -> Layout {
        Layout { groups: vec![TaskGroups::default(); tasks], boxes: tasks / STAGES, ..Layout::default() }
    }

    /// Installs a plan of tasks with numbers below `tasks`: each task has its lane groups from then on, without
    /// contacts until they are laid out.
    pub(crate) fn replan(&mut self, tasks: usize, plan: impl FnOnce(&mut Plan)) {
        plan(&mut self.plan);
        self.boxes = tasks / STAGES;
        if tasks > self.groups.len() {
            self.groups.resize_with(tasks, TaskGroups::default);
        }
    }

    /// Returns the stage and the lane groups of the tasks that have groups, in the order of their stages.
    pub fn tasks(&self) -> impl Iterator<Item = (usize, &TaskGroups)> {
        let stages = (0..STAGES).flat_map(|stage| self.plan.stage(stage).iter().map(move |task| (stage, task)));
        stages.map(|(stage, task)| (stage, &self.groups[task.number as usize]))
    }

    /// Returns the fraction of occupied lanes, 0 to 1.
    pub fn lane_occupancy(&self) -> f64 {
        let groups: usize = self.tasks().map(|(_, task)| task.pairs.len() + task.walls.len()).sum();
        self.contacts as f64 / (LANES * groups).max(1) as f64
    }

    /// Returns the prefetch distance in lane groups for a sweep over n bodies: zero if all data are in the cache.
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
