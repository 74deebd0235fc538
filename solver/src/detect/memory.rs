//! Impulses carried over from one candidate list to the next.

use super::{AngularImpulse, Impulse};
use crate::groups::ImpactMemory;
use crate::lanes::prefetch_places;
use crate::partition::{ByBodies, Plan, PlannedTask};
use crate::schedule::{Phase, Team};

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

    /// Where the impulses of a candidate are, if it had any; they are asked for.
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
