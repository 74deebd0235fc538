//! Impulses carried over from one candidate list to the next.

use super::Impulse;
use crate::schedule::{Disjoint, Phase, Team};
use std::ops::Range;

/// Non-zero impulses of an old list, grouped by their first grain's new place.
#[derive(Clone, Debug, Default)]
pub(super) struct Remembered {
    start: Vec<u32>,
    entries: Vec<(u32, Impulse)>,
}

/// An old list: what each candidate is known by (new place of its first grain, anything for its partner), its impulse, and
/// the tasks of each stage as ranges of candidates. Tasks of a stage share no first grain.
pub(super) struct OldList<'a, K> {
    pub key: K,
    pub impulses: &'a [Impulse],
    pub stages: &'a [Vec<Range<u32>>],
}

impl Remembered {
    /// Groups the impulses of an old list.
    pub fn collect<K: Fn(usize) -> (u32, u32) + Sync>(&mut self, grains: usize, old: &OldList<'_, K>, team: &Team) {
        self.start.clear();
        self.start.resize(grains + 1, 0);
        let live = |range: &Range<u32>| {
            (range.start as usize..range.end as usize).filter(|&candidate| old.impulses[candidate].normal > 0.0)
        };
        let counts = Disjoint::new(&mut self.start[1..]);
        for tasks in old.stages {
            team.each(Phase::Detect, tasks.len(), |task| {
                for candidate in live(&tasks[task]) {
                    // SAFETY: tasks of a stage share no first grain.
                    *unsafe { counts.at((old.key)(candidate).0 as usize) } += 1;
                }
            });
        }
        team.alone(Phase::Detect, || {
            for grain in 0..grains {
                self.start[grain + 1] += self.start[grain];
            }
            self.entries.resize(self.start[grains] as usize, (0, Impulse::default()));
        });
        let (starts, entries) = (Disjoint::new(&mut self.start), Disjoint::new(&mut self.entries));
        for tasks in old.stages {
            team.each(Phase::Detect, tasks.len(), |task| {
                for candidate in live(&tasks[task]) {
                    let (first, partner) = (old.key)(candidate);
                    // SAFETY: as above; a grain's entries are its own.
                    unsafe {
                        let place = starts.at(first as usize);
                        *entries.at(*place as usize) = (partner, old.impulses[candidate]);
                        *place += 1;
                    }
                }
            });
        }
        // Filling moved each start to its end: shift back.
        self.start.copy_within(0..grains, 1);
        self.start[0] = 0;
    }

    /// The impulse of a candidate; zero if it had none.
    #[inline]
    pub fn recall(&self, (first, partner): (u32, u32)) -> Impulse {
        let own = &self.entries[self.start[first as usize] as usize..self.start[first as usize + 1] as usize];
        own.iter().find(|entry| entry.0 == partner).map_or_else(Impulse::default, |entry| entry.1)
    }

    pub fn memory_bytes(&self) -> usize {
        self.start.capacity() * size_of::<u32>() + self.entries.capacity() * size_of::<(u32, Impulse)>()
    }
}
