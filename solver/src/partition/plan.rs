//! The plan of tasks: which there are, stage by stage, and which candidates belong to each.

use super::{STAGES, TaskShares};
use crate::lanes::{LANES, lanes_of};
use crate::schedule::{Phase, Team};
use serde::{Deserialize, Serialize};
use std::ops::Range;

/// Task granularity. It changes no bit.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Portion {
    /// Tasks of one stage that follow each other, as many as keep a thread busy for some microseconds.
    #[default]
    Batches,
    /// One task, however small: what one box has in one stage.
    Boxes,
}

impl Portion {
    /// Its name, as tables have it.
    pub fn name(self) -> &'static str {
        match self {
            Portion::Batches => "batches",
            Portion::Boxes => "boxes",
        }
    }
}

/// A task that has candidates.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct PlannedTask {
    /// Number of its lane groups: box times stages plus stage.
    pub number: u32,
    /// The box that it belongs to, the lowest of those that its bodies are in.
    pub home: u32,
    /// Its pairs of grains, in the list of candidates.
    pub pairs: Range<u32>,
    /// Number of the first of its blocks of eight pairs, the last of which may be smaller; counted over all tasks.
    pub first_block: u32,
    /// Its grains and surfaces, in the list of candidates.
    pub walls: Range<u32>,
}

impl PlannedTask {
    /// Returns true if its pairs are of grains of one box.
    pub(crate) fn is_interior(&self) -> bool {
        (self.number as usize).is_multiple_of(STAGES)
    }

    /// Its blocks of eight pairs.
    pub(crate) fn blocks(&self) -> Range<usize> {
        let first = self.first_block as usize;
        first..first + self.pairs.len().div_ceil(LANES)
    }

    /// The pairs that a mask a block names, by their place in the list of candidates, which grows.
    pub(crate) fn named<'a>(&self, blocks: &'a [u8]) -> impl Iterator<Item = usize> + use<'a> {
        let start = self.pairs.start as usize;
        let blocks = blocks[self.blocks()].iter().enumerate();
        blocks.flat_map(move |(block, &mask)| lanes_of(mask).map(move |lane| start + block * LANES + lane))
    }
}

/// Tasks in the order of their stages and boxes. Made anew with each candidate list.
///
/// Faces, edges and corners have few contacts. So that handing out work costs less than the work, threads are given
/// batches: tasks of one stage that follow each other, together with as many candidates as keep a thread busy for some
/// microseconds. Larger ones would leave threads idle: all edges of a direction, or all corners, of half a million grains are
/// less than a hundredth of a sweep.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Plan {
    tasks: Vec<PlannedTask>,
    /// First index of each stage in `tasks`; the last entry is the end of the last one.
    stages: [usize; STAGES + 1],
    /// Places in `tasks` of each batch.
    batches: Vec<Range<usize>>,
    /// First index of each stage in `batches`.
    batch_stages: [usize; STAGES + 1],
    /// True if there are batches of more than one task.
    portion: Portion,
}

/// Candidates that fill a batch.
const BATCH: u32 = 256;
/// Fixed cost of a task, in candidates: an edge or a corner has so few contacts that most lanes are empty.
const TASK: u32 = 12;

impl Plan {
    /// Takes in which candidates belong to which task: `pair_starts` has an entry a task and one more, `wall_starts` one a
    /// box and one more, because wall contacts belong to interiors.
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

    /// Task granularity.
    pub(crate) fn portion(&self) -> Portion {
        self.portion
    }

    /// Hands out tasks in other portions from now on.
    pub(crate) fn set_portion(&mut self, portion: Portion) {
        self.portion = portion;
        self.batch();
    }

    /// Cuts each stage into batches.
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

    /// A plan of one task that holds all candidates.
    pub(crate) fn single(pairs: u32, walls: u32) -> Plan {
        let mut stages = [1; STAGES + 1];
        stages[0] = 0;
        let tasks = vec![PlannedTask { number: 0, home: 0, pairs: 0..pairs, first_block: 0, walls: 0..walls }];
        let mut plan = Plan { tasks, stages, ..Plan::default() };
        plan.batch();
        plan
    }

    /// Number of blocks of all tasks.
    pub(crate) fn blocks(&self) -> usize {
        self.tasks.last().map_or(0, |task| task.blocks().end)
    }

    /// All tasks.
    pub fn tasks(&self) -> &[PlannedTask] {
        &self.tasks
    }

    /// Tasks of a stage: no body takes part in two of them.
    pub fn stage(&self, stage: usize) -> &[PlannedTask] {
        &self.tasks[self.stage_range(stage)]
    }

    /// Runs `work` for each task, given its place among all and its share, stage after stage: the one loop over stages. Tasks of a stage share no
    /// body and run at the same time and in any order; a stage is over before the next one begins, so that what a task writes of its
    /// bodies is there for all of the next stage, and what is exchanged between stages has its place at `before`, which is called with
    /// the number of each stage ahead of it.
    pub(crate) fn run_stages<S: TaskShares>(
        &self,
        team: &Team,
        phase: Phase,
        mut before: impl FnMut(usize),
        shares: S,
        work: impl Fn(usize, &PlannedTask, S::Share) + Sync,
    ) {
        for stage in 0..STAGES {
            before(stage);
            // SAFETY: each task of the stage is run once, and no other stage's meanwhile.
            let run = |place, task: &PlannedTask| work(place, task, unsafe { shares.share(place, task) });
            self.run(team, phase, self.batches_of(stage), &run);
        }
    }

    /// Runs `work` for each task, given its place among all and its share, tasks of all stages at the same time and in any order: for work that
    /// writes no body.
    pub(crate) fn run_all<S: TaskShares>(
        &self,
        team: &Team,
        phase: Phase,
        shares: S,
        work: impl Fn(usize, &PlannedTask, S::Share) + Sync,
    ) {
        assert!(!S::IN_STAGES, "tasks of different stages share bodies");
        // SAFETY: each task is run once, and these shares are apart for all tasks.
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

    /// Batches of a stage, as places among all tasks.
    fn batches_of(&self, stage: usize) -> &[Range<usize>] {
        &self.batches[self.batch_stages[stage]..self.batch_stages[stage + 1]]
    }

    /// Places of a stage's tasks among all.
    pub(crate) fn stage_range(&self, stage: usize) -> Range<usize> {
        self.stages[stage]..self.stages[stage + 1]
    }

    pub(super) fn memory_bytes(&self) -> usize {
        self.tasks.capacity() * size_of::<PlannedTask>() + self.batches.capacity() * size_of::<Range<usize>>()
    }
}
