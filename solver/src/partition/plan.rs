//! Plan of tasks: the tasks of each stage, and the candidates of each task.

use super::{Between, STAGES, TaskShares};
use crate::lanes::{LANES, lanes_of};
use crate::schedule::{Phase, Team};
use serde::{Deserialize, Serialize};
use std::ops::Range;

/// Task granularity. The results have the same bits for each granularity.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Portion {
    /// Consecutive tasks of one stage, enough to occupy a thread for some microseconds.
    #[default]
    Batches,
    /// One task of any size: the work of one box in one stage.
    Boxes,
}

impl Portion {
    /// Returns the name in tables.
    pub fn name(self) -> &'static str {
        match self {
            Portion::Batches => "batches",
            Portion::Boxes => "boxes",
        }
    }
}

/// Task with candidates.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct PlannedTask {
    /// Index of its lane groups: box times stages plus stage.
    pub number: u32,
    /// Box that owns the task, the lowest box of its bodies.
    pub home: u32,
    /// Pairs of grains, as a range of the candidate list.
    pub pairs: Range<u32>,
    /// Index of the first of its blocks of eight pairs, counted over all tasks; the last block may be smaller.
    pub first_block: u32,
    /// Grains and surfaces, as a range of the candidate list.
    pub walls: Range<u32>,
}

impl PlannedTask {
    /// Returns true if the pairs are of grains in one box.
    pub(crate) fn is_interior(&self) -> bool {
        (self.number as usize).is_multiple_of(STAGES)
    }

    /// Returns its blocks of eight pairs.
    pub(crate) fn blocks(&self) -> Range<usize> {
        let first = self.first_block as usize;
        first..first + self.pairs.len().div_ceil(LANES)
    }

    /// Returns the pairs selected by one mask per block, as increasing indices in the candidate list.
    pub(crate) fn named<'a>(&self, blocks: &'a [u8]) -> impl Iterator<Item = usize> + use<'a> {
        let start = self.pairs.start as usize;
        let blocks = blocks[self.blocks()].iter().enumerate();
        blocks.flat_map(move |(block, &mask)| lanes_of(mask).map(move |lane| start + block * LANES + lane))
    }
}

/// Tasks in the order of their stages and boxes, rebuilt with each candidate list.
///
/// Faces, edges and corners have few contacts. To limit the scheduling overhead, threads receive batches: consecutive
/// tasks of one stage with enough candidates to occupy a thread for some microseconds. Larger batches would leave
/// threads idle: all edges of a direction, or all corners, of half a million grains are less than a hundredth of a
/// sweep.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Plan {
    tasks: Vec<PlannedTask>,
    /// First index of each stage in `tasks`; the last entry is the end of the last stage.
    stages: [usize; STAGES + 1],
    /// Range in `tasks` of each batch.
    batches: Vec<Range<usize>>,
    /// First index of each stage in `batches`.
    batch_stages: [usize; STAGES + 1],
    /// Granularity of the batches.
    portion: Portion,
}

/// Number of candidates that fill a batch.
const BATCH: u32 = 256;
/// Fixed cost of a task, in candidates: an edge or a corner has so few contacts that most lanes are empty.
const TASK: u32 = 12;

impl Plan {
    /// Sets the candidates of each task: `pair_starts` has one entry per task and one more, `wall_starts` one per box
    /// and one more, because wall contacts belong to interiors.
    pub(crate) fn set(&mut self, pair_starts: &[u32], wall_starts: &[u32]) {
        assert!(pair_starts.is_sorted() && wall_starts.is_sorted(), "tasks share candidates");
        self.tasks.clear();
        let boxes = (wall_starts.len() - 1).max(1);
        for stage in 0..STAGES {
            self.stages[stage] = self.tasks.len();
            for home in 0..wall_starts.len() - 1 {
                let number = stage * boxes + home;
                let pairs = pair_starts[number]..pair_starts[number + 1];
                let walls = if stage == 0 { wall_starts[home]..wall_starts[home + 1] } else { 0..0 };
                if !pairs.is_empty() || !walls.is_empty() {
                    let first_block = self.blocks() as u32;
                    self.tasks.push(PlannedTask {
                        number: (home * STAGES + stage) as u32,
                        home: home as u32,
                        pairs,
                        first_block,
                        walls,
                    });
                }
            }
        }
        self.stages[STAGES] = self.tasks.len();
        self.batch();
    }

    /// Returns the task granularity.
    pub(crate) fn portion(&self) -> Portion {
        self.portion
    }

    /// Sets the task granularity from now on.
    pub(crate) fn set_portion(&mut self, portion: Portion) {
        self.portion = portion;
        self.batch();
    }

    /// Divides each stage into batches.
    fn batch(&mut self) {
        self.batches.clear();
        let full = match self.portion {
            Portion::Batches => BATCH,
            Portion::Boxes => 0,
        };
        for stage in 0..STAGES {
            self.batch_stages[stage] = self.batches.len();
            let places = self.stage_range(stage);
            let (mut start, mut candidates) = (places.start, 0);
            for place in places.clone() {
                let task = &self.tasks[place];
                candidates += TASK + task.pairs.end - task.pairs.start + task.walls.end - task.walls.start;
                if candidates >= full || place + 1 == places.end {
                    self.batches.push(start..place + 1);
                    (start, candidates) = (place + 1, 0);
                }
            }
        }
        self.batch_stages[STAGES] = self.batches.len();
    }

    /// Creates a plan of one task with all candidates.
    pub(crate) fn single(pairs: u32, walls: u32) -> Plan {
        let mut stages = [1; STAGES + 1];
        stages[0] = 0;
        let tasks = vec![PlannedTask { number: 0, home: 0, pairs: 0..pairs, first_block: 0, walls: 0..walls }];
        let mut plan = Plan { tasks, stages, ..Plan::default() };
        plan.batch();
        plan
    }

    /// Leaves out the tasks of other boxes than those of a condition.
    pub(crate) fn keep(&mut self, is_kept: impl Fn(usize) -> bool) {
        for stage in 0..STAGES {
            self.stages[stage] =
                self.tasks[..self.stages[stage]].iter().filter(|task| is_kept(task.home as usize)).count();
        }
        self.tasks.retain(|task| is_kept(task.home as usize));
        self.stages[STAGES] = self.tasks.len();
        self.batch();
    }

    /// Returns the number of blocks of all tasks.
    pub(crate) fn blocks(&self) -> usize {
        self.tasks.last().map_or(0, |task| task.blocks().end)
    }

    /// Returns all tasks.
    pub fn tasks(&self) -> &[PlannedTask] {
        &self.tasks
    }

    /// Returns the tasks of a stage: no two tasks share a body.
    pub fn stage(&self, stage: usize) -> &[PlannedTask] {
        &self.tasks[self.stage_range(stage)]
    }

    /// Runs `work` for each task, with its index and its part of the data, stage after stage: the only loop over
    /// stages. Tasks of a stage share no body and run concurrently in any order. A stage is complete before the next
    /// one begins, so that all writes to bodies are visible in the next stage. `before` is called with the number of
    /// each stage and the data before that stage, for exchange between stages.
    pub(crate) fn run_stages<S: TaskShares>(
        &self,
        team: &Team,
        phase: Phase,
        mut before: impl FnMut(usize, &S, &Between),
        shares: S,
        work: impl Fn(usize, &PlannedTask, S::Share) + Sync,
    ) {
        for stage in 0..STAGES {
            // SAFETY: tasks run below alone.
            before(stage, &shares, &unsafe { Between::stages() });
            // SAFETY: each task of the stage runs once, and no task of another stage runs meanwhile.
            let run = |place, task: &PlannedTask| work(place, task, unsafe { shares.share(place, task) });
            self.run(team, phase, self.batches_of(stage), &run);
        }
    }

    /// Runs `work` for each task, with its index and its part of the data, concurrently for tasks of all stages in any
    /// order: for work that writes no body.
    pub(crate) fn run_all<S: TaskShares>(
        &self,
        team: &Team,
        phase: Phase,
        shares: S,
        work: impl Fn(usize, &PlannedTask, S::Share) + Sync,
    ) {
        assert!(!S::IN_STAGES, "tasks of different stages share bodies");
        // SAFETY: each task runs once, and these parts are disjoint for all tasks.
        let run = |place, task: &PlannedTask| work(place, task, unsafe { shares.share(place, task) });
        self.run(team, phase, &self.batches, &run);
    }

    fn run(&self, team: &Team, phase: Phase, batches: &[Range<usize>], work: &(impl Fn(usize, &PlannedTask) + Sync)) {
        team.each(phase, batches.len(), |batch| {
            for place in batches[batch].clone() {
                work(place, &self.tasks[place]);
            }
        });
    }

    /// Returns the batches of a stage, as ranges of task indices.
    fn batches_of(&self, stage: usize) -> &[Range<usize>] {
        &self.batches[self.batch_stages[stage]..self.batch_stages[stage + 1]]
    }

    /// Returns the range of task indices of a stage.
    pub(crate) fn stage_range(&self, stage: usize) -> Range<usize> {
        self.stages[stage]..self.stages[stage + 1]
    }

    pub(super) fn memory_bytes(&self) -> usize {
        self.tasks.capacity() * size_of::<PlannedTask>() + self.batches.capacity() * size_of::<Range<usize>>()
    }
}
