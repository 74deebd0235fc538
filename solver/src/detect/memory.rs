//! Impulses carried over from one candidate list to the next.

use crate::groups::ImpactMemory;
use crate::lanes::{TaskSlots, prefetch_places};
use crate::partition::{ByBlocks, ByBodies, ByCandidates, Plan, PlannedTask, Ranks, TaskShares};
use crate::schedule::{Phase, Team};
use bytemuck::{Pod, Zeroable};
use std::ops::Range;

/// Impulses and impacts of the contacts of an old list, grouped by the new index of their first grain.
#[derive(Clone, Debug, Default)]
pub(super) struct Remembered {
    start: Vec<u32>,
    /// Partners of the entries: those of this list, then those of other ranks.
    partners: Vec<u32>,
    memory: Memory,
    /// Index of the first entry from other ranks of each grain, and the end; empty without such entries.
    others: Vec<u32>,
}

/// Entry on its way to another rank.
#[derive(Clone, Copy, Pod, Zeroable)]
#[repr(C)]
struct Entry {
    impulse: [f64; 4],
    torque: [f64; 3],
    impact: ImpactMemory,
    first: u32,
    partner: u32,
}

/// Old list: key of each candidate (new index of its first grain, any key for its partner), the possibly active candidates of a
/// task, their memory, and the plan of tasks. Tasks of a stage share no first grain.
pub(super) struct OldList<'a, K, T> {
    pub key: K,
    pub of_task: T,
    pub memory: &'a Memory,
    pub plan: &'a Plan,
}

impl Remembered {
    /// Groups the impulses of an old list.
    pub fn collect<K, T, C>(&mut self, grains: usize, old: &OldList<'_, K, T>, team: &Team)
    where
        K: Fn(usize) -> (u32, u32) + Sync,
        T: Fn(&PlannedTask) -> C + Sync,
        C: Iterator<Item = usize>,
    {
        self.start.clear();
        self.start.resize(grains + 1, 0);
        let Memory { impulses, impacts, torques } = old.memory;
        let is_live = |candidate: &usize| impulses[*candidate].normal > 0.0 || impacts[*candidate].touches();
        let live = |task: &PlannedTask| (old.of_task)(task).filter(is_live);
        let counts = ByBodies::of(&mut self.start[1..]);
        old.plan.run_stages(
            team,
            Phase::Detect,
            |_, _, _| {},
            counts,
            |_, task, counts| {
                for candidate in live(task) {
                    let (first, _) = (old.key)(candidate);
                    counts.set(first, counts.get(first) + 1);
                }
            },
        );
        team.alone(Phase::Detect, || {
            for grain in 0..grains {
                self.start[grain + 1] += self.start[grain];
            }
            resize(&mut self.partners, self.start[grains] as usize, 0);
            self.memory.resize(self.start[grains] as usize, !torques.is_empty());
        });
        // Each grain belongs to one task, and its entries belong to this grain.
        let grouped = [&mut self.start, &mut self.partners].map(|numbers| ByBodies::of(numbers));
        let Memory { impulses: to, impacts: impacts_to, torques: torques_to } = &mut self.memory;
        let borne = (ByBodies::of(to), ByBodies::of(impacts_to), ByBodies::of(torques_to));
        old.plan.run_stages(
            team,
            Phase::Detect,
            |_, _, _| {},
            (grouped, borne),
            |_, task, ([starts, partners], (to, impacts_to, torques_to))| {
                for candidate in live(task) {
                    let (first, partner) = (old.key)(candidate);
                    let entry = starts.get(first);
                    partners.set(entry, partner);
                    to.set(entry, impulses[candidate]);
                    impacts_to.set(entry, impacts[candidate]);
                    if let Some(torque) = torques.get(candidate) {
                        torques_to.set(entry, *torque);
                    }
                    starts.set(first, entry + 1);
                }
            },
        );
        // Filling moved each start to its end: shift back.
        self.start.copy_within(0..grains, 1);
        self.start[0] = 0;
        self.others.clear();
    }

    /// Exchanges entries between ranks: `ranks_of` calls a function for each rank that an entry is for, by its grain and its partner.
    /// `torques` is true if contacts transmit torques.
    pub fn pass_on(&mut self, ranks: &Ranks, torques: bool, ranks_of: impl Fn([u32; 2], &mut dyn FnMut(usize))) {
        let grains = self.start.len() - 1;
        let mut lists = vec![Vec::new(); ranks.count()];
        for first in 0..grains as u32 {
            for place in self.start[first as usize] as usize..self.start[first as usize + 1] as usize {
                let Memory { impulses, impacts, torques } = &self.memory;
                let Impulse { normal, tangential: [x, y, z] } = impulses[place];
                let (partner, impact) = (self.partners[place], impacts[place]);
                let torque = torques.get(place).map_or([0.0; 3], |torque| torque.0);
                let entry = Entry { impulse: [normal, x, y, z], torque, impact, first, partner };
                ranks_of([first, partner], &mut |rank| lists[rank].push(entry));
            }
        }
        lists[ranks.own()].clear();
        let mut others = ranks.trade(&lists);
        // The entries of a grain and its walls come from one rank, and keep their order.
        others.sort_by_key(|entry| entry.first);
        let own = self.partners.len();
        self.memory.resize(own + others.len(), torques);
        self.others.resize(grains + 1, own as u32);
        for (place, Entry { impulse: [normal, x, y, z], torque, impact, first, partner }) in (own..).zip(others) {
            self.partners.push(partner);
            self.memory.set(place, Impulse { normal, tangential: [x, y, z] }, impact, torque);
            self.others[first as usize + 1] = place as u32 + 1;
        }
        for grain in 0..grains {
            self.others[grain + 1] = self.others[grain + 1].max(self.others[grain]);
        }
    }

    /// Returns the indices of the entries of a grain from other ranks.
    fn others_of(&self, first: u32) -> Range<usize> {
        match self.others.get(first as usize..first as usize + 2) {
            Some(ends) => ends[0] as usize..ends[1] as usize,
            None => 0..0,
        }
    }

    /// Finds the impulses of a candidate, if any, and prefetches them.
    #[inline]
    pub fn find(&self, (first, partner): (u32, u32)) -> Option<u32> {
        let start = self.start[first as usize] as usize;
        let own = &self.partners[start..self.start[first as usize + 1] as usize];
        let place = match own.iter().position(|&known| known == partner) {
            Some(place) => start + place,
            None => self.others_of(first).find(|&place| self.partners[place] == partner)?,
        };
        prefetch_places(self.memory.impulses.as_ptr(), &[place as u32]);
        Some(place as u32)
    }

    /// Finds the impulses of a grain with the partner of this number, from 0, among its partners that pass a test; returns the partner, too.
    pub fn find_nth(&self, first: u32, test: impl Fn(u32) -> bool, number: usize) -> Option<(u32, u32)> {
        let own = self.start[first as usize] as usize..self.start[first as usize + 1] as usize;
        let entries = own.chain(self.others_of(first)).map(|place| (place as u32, self.partners[place]));
        entries.filter(|(_, partner)| test(*partner)).nth(number)
    }

    /// Returns the impulses and the impact at an index found by [`Self::find`].
    #[inline]
    pub fn recall(&self, place: u32) -> (Impulse, ImpactMemory, AngularImpulse) {
        let (place, Memory { impulses, impacts, torques }) = (place as usize, &self.memory);
        (impulses[place], impacts[place], torques.get(place).copied().unwrap_or_default())
    }

    pub fn memory_bytes(&self) -> usize {
        (self.start.capacity() + self.partners.capacity()) * size_of::<u32>() + self.memory.memory_bytes()
    }
}

/// Resizes a vector of fluctuating length: growth reserves a sixteenth, instead of doubling the memory.
pub(super) fn resize<T: Clone>(vector: &mut Vec<T>, length: usize, value: T) {
    if length > vector.capacity() {
        vector.reserve_exact(length + length / 16 - vector.len());
    }
    vector.resize(length, value);
}

/// Impulse of a candidate in the last step, N s; the tangential part is a world vector. Size: four numbers.
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
#[repr(C, align(32))]
pub struct Impulse {
    /// Normal impulse.
    pub normal: f64,
    /// Tangential impulse on the second body or on the wall.
    pub tangential: [f64; 3],
}

impl Impulse {
    /// Returns true if all bits are zero: a negative zero is not blank.
    pub(crate) fn is_blank(&self) -> bool {
        let [x, y, z] = self.tangential;
        [self.normal, x, y, z].iter().all(|component| component.to_bits() == 0)
    }
}

/// Angular impulse of a candidate in the last step, on its second side, N m s.
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
#[repr(C)]
pub struct AngularImpulse(pub [f64; 3]);

/// Impulses and impacts of the last step, by candidate of one kind, followed by a zero impulse and an empty impact.
#[derive(Clone, Debug, Default)]
pub struct Memory {
    /// Impulses.
    pub impulses: Vec<Impulse>,
    /// Impacts.
    pub impacts: Vec<ImpactMemory>,
    /// Angular impulses, if contacts transmit torques; otherwise empty. Meaningless if the normal impulse is zero.
    pub torques: Vec<AngularImpulse>,
}

/// Impulses, impacts and angular impulses of the candidates of one task.
#[derive(Clone, Copy, Debug)]
pub(crate) struct MemoryOfTask<'a> {
    pub impulses: TaskSlots<'a, Impulse>,
    pub impacts: TaskSlots<'a, ImpactMemory>,
    pub torques: TaskSlots<'a, AngularImpulse>,
}

/// Partition among concurrent tasks: each candidate belongs to one task.
type MemoryShares<'a> = (ByCandidates<'a, Impulse>, ByCandidates<'a, ImpactMemory>, ByCandidates<'a, AngularImpulse>);

impl Memory {
    /// Resizes for the given number of candidates, and for torques if contacts transmit torques.
    pub(crate) fn resize(&mut self, count: usize, torques: bool) {
        resize(&mut self.impulses, count + 1, Impulse::default());
        resize(&mut self.impacts, count + 1, ImpactMemory::default());
        (self.impulses[count], self.impacts[count]) = Default::default();
        resize(&mut self.torques, if torques { count } else { 0 }, AngularImpulse::default());
    }

    /// Sets impulse, impact and angular impulse (N m s) of a candidate; the last only if contacts transmit torques.
    pub(crate) fn set(&mut self, candidate: usize, impulse: Impulse, impact: ImpactMemory, torque: [f64; 3]) {
        (self.impulses[candidate], self.impacts[candidate]) = (impulse, impact);
        if let Some(place) = self.torques.get_mut(candidate) {
            *place = AngularImpulse(torque);
        }
    }

    /// Returns true if a candidate has an impulse with any bit set, or an impact.
    pub(crate) fn is_known(&self, candidate: usize) -> bool {
        !self.impulses[candidate].is_blank() || self.impacts[candidate].touches()
    }

    pub(crate) fn memory_bytes(&self) -> usize {
        self.impulses.capacity() * size_of::<Impulse>()
            + self.impacts.capacity() * size_of::<ImpactMemory>()
            + self.torques.capacity() * size_of::<AngularImpulse>()
    }

    fn shares(&mut self) -> MemoryShares<'_> {
        let Memory { impulses, impacts, torques } = self;
        (ByCandidates::of(impulses), ByCandidates::of(impacts), ByCandidates::of(torques))
    }
}

impl<'a> From<<MemoryShares<'a> as TaskShares>::Share> for MemoryOfTask<'a> {
    fn from((impulses, impacts, torques): <MemoryShares<'a> as TaskShares>::Share) -> MemoryOfTask<'a> {
        MemoryOfTask { impulses, impacts, torques }
    }
}

/// Impulses and impacts of all candidates in the last step.
#[derive(Clone, Debug)]
pub struct ContactImpulses {
    /// Memory of each active pair; meaningless for other pairs.
    pub pairs: Memory,
    /// Bit mask of active or possibly active pairs: contacts of the last step, and pairs with an impulse set since the list was
    /// built. One byte per block of a task's pairs.
    pub(crate) borne: Vec<u8>,
    /// Memory of each grain and surface.
    pub walls: Memory,
}

impl Default for ContactImpulses {
    fn default() -> ContactImpulses {
        let mut none = Memory::default();
        none.resize(0, false);
        ContactImpulses { pairs: none.clone(), borne: Vec::new(), walls: none }
    }
}

impl ContactImpulses {
    /// Partitions the memories of pairs and walls, and the masks of active pairs per block, by task.
    pub(crate) fn shares(&mut self) -> ([MemoryShares<'_>; 2], ByBlocks<'_, u8>) {
        ([self.pairs.shares(), self.walls.shares()], ByBlocks::of(&mut self.borne))
    }
}
