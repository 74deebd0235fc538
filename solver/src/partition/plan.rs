//! The plan of tasks: which there are, stage by stage, and which candidates belong to each.

use super::STAGES;
use std::ops::Range;

/// A task that has candidates.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct PlannedTask {
    /// Its number: stage times boxes plus box.
    pub number: u32,
    /// The box that it belongs to, the lowest of those that its bodies are in.
    pub home: u32,
    /// Its pairs of grains, in the list of candidates.
    pub pairs: Range<u32>,
    /// Its grains and surfaces, in the list of candidates.
    pub walls: Range<u32>,
}

/// Tasks in the order of their stages and boxes. Made anew with each candidate list.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Plan {
    tasks: Vec<PlannedTask>,
    /// Where each stage begins in `tasks`; the last entry is where the last one ends.
    stages: [usize; STAGES + 1],
}

impl Plan {
    /// Takes in which candidates belong to which task: `pair_starts` has an entry a task and one more, `wall_starts` one a
    /// box and one more, because wall contacts belong to interiors.
    pub(crate) fn set(&mut self, pair_starts: &[u32], wall_starts: &[u32]) {
        self.tasks.clear();
        let boxes = (wall_starts.len() - 1).max(1);
        for stage in 0..STAGES {
            self.stages[stage] = self.tasks.len();
            for home in 0..wall_starts.len() - 1 {
                let number = stage * boxes + home;
                let pairs = pair_starts[number]..pair_starts[number + 1];
                let walls = if stage == 0 { wall_starts[home]..wall_starts[home + 1] } else { 0..0 };
                if !pairs.is_empty() || !walls.is_empty() {
                    self.tasks.push(PlannedTask { number: number as u32, home: home as u32, pairs, walls });
                }
            }
        }
        self.stages[STAGES] = self.tasks.len();
    }

    /// A plan of one task that holds all candidates.
    pub(crate) fn single(pairs: u32, walls: u32) -> Plan {
        let mut stages = [1; STAGES + 1];
        stages[0] = 0;
        Plan { tasks: vec![PlannedTask { number: 0, home: 0, pairs: 0..pairs, walls: 0..walls }], stages }
    }

    /// All tasks.
    pub fn tasks(&self) -> &[PlannedTask] {
        &self.tasks
    }

    /// Tasks of a stage: no body takes part in two of them.
    pub fn stage(&self, stage: usize) -> &[PlannedTask] {
        &self.tasks[self.stage_range(stage)]
    }

    /// Places of a stage's tasks among all.
    pub(crate) fn stage_range(&self, stage: usize) -> Range<usize> {
        self.stages[stage]..self.stages[stage + 1]
    }

    pub(super) fn memory_bytes(&self) -> usize {
        self.tasks.capacity() * size_of::<PlannedTask>()
    }
}
