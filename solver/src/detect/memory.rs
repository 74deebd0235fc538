//! Impulses carried over from one candidate list to the next.

use crate::groups::ImpactMemory;
use crate::lanes::{TaskSlots, prefetch_places};
use crate::partition::{ByBlocks, ByBodies, ByCandidates, Plan, PlannedTask};
use crate::schedule::{Phase, Team};
use bytemuck::{Pod, Zeroable};

/// Impulses and impacts of the contacts of an old list, grouped by their first grain's new place.
#[derive(Clone, Debug, Default)]
pub(super) struct Remembered {
    start: Vec<u32>,
    partners: Vec<u32>,
    impulses: Vec<Impulse>,
    impacts: Vec<ImpactMemory>,
    /// Empty where contacts bear no torques.
    torques: Vec<AngularImpulse>,
}

/// An old list: what each candidate is known by (new place of its first grain, anything for its partner), the candidates of a
/// task that may have borne an impulse, the impulses, and the plan of tasks.
/// Tasks of a stage share no first grain.
pub(super) struct OldList<'a, K, T> {
    pub key: K,
    pub of_task: T,
    pub impulses: &'a [Impulse],
    pub impacts: &'a [ImpactMemory],
    /// Empty where contacts bear no torques.
    pub torques: &'a [AngularImpulse],
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
        let is_live = |candidate: &usize| old.impulses[*candidate].normal > 0.0 || old.impacts[*candidate].touches();
        let live = |task: &PlannedTask| (old.of_task)(task).filter(is_live);
        let counts = ByBodies::of(&mut self.start[1..]);
        old.plan.run_stages(
            team,
            Phase::Detect,
            |_| {},
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
            resize(&mut self.impulses, self.start[grains] as usize, Impulse::default());
            resize(&mut self.impacts, self.start[grains] as usize, ImpactMemory::default());
            let torques = if old.torques.is_empty() { 0 } else { self.start[grains] as usize };
            resize(&mut self.torques, torques, AngularImpulse::default());
        });
        // A grain's entries are its own, as the grain is its task's.
        let grouped = [&mut self.start, &mut self.partners].map(|numbers| ByBodies::of(numbers));
        let impacts = ByBodies::of(&mut self.impacts);
        let borne = (ByBodies::of(&mut self.impulses), impacts, ByBodies::of(&mut self.torques));
        old.plan.run_stages(
            team,
            Phase::Detect,
            |_| {},
            (grouped, borne),
            |_, task, ([starts, partners], (impulses, impacts, torques))| {
                for candidate in live(task) {
                    let (first, partner) = (old.key)(candidate);
                    let entry = starts.get(first);
                    partners.set(entry, partner);
                    impulses.set(entry, old.impulses[candidate]);
                    impacts.set(entry, old.impacts[candidate]);
                    if let Some(torque) = old.torques.get(candidate) {
                        torques.set(entry, *torque);
                    }
                    starts.set(first, entry + 1);
                }
            },
        );
        // Filling moved each start to its end: shift back.
        self.start.copy_within(0..grains, 1);
        self.start[0] = 0;
    }

    /// Finds the impulses of a candidate, if it had any, and prefetches them.
    #[inline]
    pub fn find(&self, (first, partner): (u32, u32)) -> Option<u32> {
        let start = self.start[first as usize] as usize;
        let own = &self.partners[start..self.start[first as usize + 1] as usize];
        let place = start + own.iter().position(|&known| known == partner)?;
        prefetch_places(self.impulses.as_ptr(), &[place as u32]);
        Some(place as u32)
    }

    /// The impulses and the impact that were found at a place.
    #[inline]
    pub fn recall(&self, place: u32) -> (Impulse, ImpactMemory, AngularImpulse) {
        let place = place as usize;
        (self.impulses[place], self.impacts[place], self.torques.get(place).copied().unwrap_or_default())
    }

    pub fn memory_bytes(&self) -> usize {
        (self.start.capacity() + self.partners.capacity()) * size_of::<u32>()
            + self.impulses.capacity() * size_of::<Impulse>()
            + self.impacts.capacity() * size_of::<ImpactMemory>()
            + self.torques.capacity() * size_of::<AngularImpulse>()
    }
}

/// Resizes a vector whose length wavers: with a sixteenth to spare where it must grow, not twice the memory.
pub(super) fn resize<T: Clone>(vector: &mut Vec<T>, length: usize, value: T) {
    if length > vector.capacity() {
        vector.reserve_exact(length + length / 16 - vector.len());
    }
    vector.resize(length, value);
}

/// Impulse that a candidate bore in the last step, N s; the tangential part is a world vector. One quad.
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
#[repr(C, align(32))]
pub struct Impulse {
    /// Normal impulse.
    pub normal: f64,
    /// Tangential impulse on the second body or on the wall.
    pub tangential: [f64; 3],
}

impl Impulse {
    /// Returns true if it is zero to the last bit: a negative zero is none.
    pub(crate) fn is_blank(&self) -> bool {
        let [x, y, z] = self.tangential;
        [self.normal, x, y, z].iter().all(|component| component.to_bits() == 0)
    }
}

/// Angular impulse that a candidate bore in the last step, on its second side, N m s.
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
#[repr(C)]
pub struct AngularImpulse(pub [f64; 3]);

/// Impulse of each candidate in the last step.
#[derive(Clone, Debug)]
pub struct ContactImpulses {
    /// Impulse of each pair that bore any, and one of zero behind them all. Those of other pairs mean nothing.
    pub pairs: Vec<Impulse>,
    /// Which pairs bore an impulse, or may have: those that were contacts in the last step, and since the list was built those that
    /// were given one. Bits, a byte for each block of a task's pairs.
    pub(crate) borne: Vec<u8>,
    /// Impulse of each grain and surface, and one of zero behind them.
    pub walls: Vec<Impulse>,
    /// Impacts of the same pairs, and an empty one behind them.
    pub pair_impacts: Vec<ImpactMemory>,
    /// Impacts of each grain and surface, and an empty one behind them.
    pub wall_impacts: Vec<ImpactMemory>,
    /// Angular impulses of the same, where contacts bear torques; empty elsewhere. They mean nothing where the normal impulse
    /// is zero.
    pub pair_torques: Vec<AngularImpulse>,
    /// As `pair_torques`.
    pub wall_torques: Vec<AngularImpulse>,
}

impl Default for ContactImpulses {
    fn default() -> ContactImpulses {
        let (pairs, walls) = (vec![Impulse::default()], vec![Impulse::default()]);
        let [pair_impacts, wall_impacts] = [0, 1].map(|_| vec![ImpactMemory::default()]);
        let (borne, pair_torques, wall_torques) = (Vec::new(), Vec::new(), Vec::new());
        ContactImpulses { pairs, borne, walls, pair_impacts, wall_impacts, pair_torques, wall_torques }
    }
}

/// Impulses of the candidates of one task.
#[derive(Clone, Copy, Debug)]
pub(crate) struct ImpulsesOfTask<'a> {
    pub pairs: TaskSlots<'a, Impulse>,
    pub walls: TaskSlots<'a, Impulse>,
    pub pair_impacts: TaskSlots<'a, ImpactMemory>,
    pub wall_impacts: TaskSlots<'a, ImpactMemory>,
    pub pair_torques: TaskSlots<'a, AngularImpulse>,
    pub wall_torques: TaskSlots<'a, AngularImpulse>,
}

/// Partition among tasks that run at the same time: each candidate belongs to one task.
type ImpulseShares<'a> =
    ([ByCandidates<'a, Impulse>; 2], [ByCandidates<'a, ImpactMemory>; 2], [ByCandidates<'a, AngularImpulse>; 2]);

/// Shares of one task.
type OwnImpulses<'a> =
    ([TaskSlots<'a, Impulse>; 2], [TaskSlots<'a, ImpactMemory>; 2], [TaskSlots<'a, AngularImpulse>; 2]);

impl ContactImpulses {
    /// Impulses of the candidates of each task, and for each block of its pairs a mask of those that have one.
    pub(crate) fn shares(&mut self) -> (ImpulseShares<'_>, ByBlocks<'_, u8>) {
        let ContactImpulses { pairs, borne, walls, pair_impacts, wall_impacts, pair_torques, wall_torques } = self;
        let impulses = [pairs, walls].map(|impulses| ByCandidates::of(impulses));
        let impacts = [pair_impacts, wall_impacts].map(|impacts| ByCandidates::of(impacts));
        let torques = [pair_torques, wall_torques].map(|torques| ByCandidates::of(torques));
        ((impulses, impacts, torques), ByBlocks::of(borne))
    }
}

impl<'a> From<OwnImpulses<'a>> for ImpulsesOfTask<'a> {
    fn from((impulses, impacts, torques): OwnImpulses<'a>) -> ImpulsesOfTask<'a> {
        let ([pairs, walls], [pair_impacts, wall_impacts], [pair_torques, wall_torques]) = (impulses, impacts, torques);
        ImpulsesOfTask { pairs, walls, pair_impacts, wall_impacts, pair_torques, wall_torques }
    }
}
