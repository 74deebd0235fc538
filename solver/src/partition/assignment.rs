//! Packing: assigns contacts to lane groups of eight contacts that share no body.

use super::{ByBodies, TaskGroups};
use crate::effects::EffectSet;
use crate::groups::{PairGroup, Sources, WallGroup, with_pairs};
use crate::lanes::{Kernel, LANES, Lanes, TaskSlots, prefetch_lines, prefetch_places};
use std::ops::Range;

/// Number of groups that are open for contacts at a time.
const WINDOW: u32 = 64;

/// Smallest number of candidates of a task for which groups that share a body are separated; smaller tasks would consist mostly of padding.
const SPACED_FROM: usize = 192;

/// Groups that already contain a body: a mask, its lower half first, counted from group `since`.
///
/// The record is read and written as one word of eight bytes and one of four. With two words of eight bytes, the
/// compiler would read both together, and the load would wait for two stores.
#[derive(Clone, Copy, Debug, Default)]
#[repr(C, align(16))]
pub(crate) struct Taken {
    mask: [u32; 2],
    since: u32,
}

impl Taken {
    /// Returns the mask of the same groups, counted from group `start`. The recent groups of a body follow no pattern,
    /// so this function must not branch.
    #[inline(always)]
    fn seen_from(&self, start: u32) -> u64 {
        let (mask, age) = (u64::from(self.mask[0]) | u64::from(self.mask[1]) << 32, start.wrapping_sub(self.since));
        (mask >> (age % WINDOW)) & u64::from(age < WINDOW).wrapping_neg()
    }
}

/// Group number from which on a step restarts the numbering.
const LAST: u32 = u32::MAX / 2;
/// Number of the first group: close to the last number, so that every run, including tests, restarts the numbering once.
const FIRST: u32 = LAST - 10_000;

/// Groups of each body, from task to task and from step to step. Group numbers increase, so that no entry needs a reset.
#[derive(Clone, Debug, Default)]
pub(crate) struct TakenGroups {
    of_body: Vec<Taken>,
    /// Number above all assigned group numbers.
    next: u32,
}

impl TakenGroups {
    /// Starts a step with n bodies.
    pub fn start(&mut self, bodies: usize) {
        if self.next == 0 {
            self.next = FIRST;
        } else if self.next > LAST {
            self.of_body.fill(Taken::default());
            self.next = WINDOW;
        }
        self.of_body.resize(bodies, Taken::default());
    }

    /// Returns the groups of each body, the number of the first group of tasks that share no body, and the variable
    /// `next` for the results of [`LaneAssigner::next`] of these tasks.
    pub fn stage(&mut self) -> (ByBodies<'_, Taken>, u32, &mut u32) {
        (ByBodies::of(&mut self.of_body), self.next, &mut self.next)
    }

    pub fn memory_bytes(&self) -> usize {
        self.of_body.capacity() * size_of::<Taken>()
    }
}

/// Packs contacts first-fit into the groups of a window.
///
/// A group that directly follows another group with a shared body must wait until the other has written that body.
/// First-fit alone would put the contacts of a grain, which are consecutive, into adjacent groups; groups next to one
/// with the body are therefore also excluded.
pub(crate) struct LaneAssigner<'a> {
    taken: TaskSlots<'a, Taken>,
    window: Window,
    /// Number of the task's first group.
    base: u32,
    /// True if groups that share a body are separated.
    spaced: bool,
    /// Lanes filled in each group of the window, by group number modulo the window.
    filled: [u8; WINDOW as usize],
}

/// Groups that are open for contacts.
#[derive(Clone, Copy)]
struct Window {
    /// Number of the first group.
    start: u32,
    /// Groups that still have a free lane.
    open: u64,
}

impl<'a> LaneAssigner<'a> {
    /// Creates an assigner for one task. `base` must exceed, by at least the window, the number of any group of the
    /// same bodies in earlier tasks.
    pub fn new(taken: TaskSlots<'a, Taken>, base: u32, candidates: usize) -> LaneAssigner<'a> {
        LaneAssigner {
            taken,
            window: Window { start: base, open: u64::MAX },
            base,
            spaced: candidates >= SPACED_FROM,
            filled: [0; WINDOW as usize],
        }
    }

    /// Prefetches the entries of contiguous bodies.
    #[inline(always)]
    pub fn fetch(&self, bodies: Range<usize>) {
        prefetch_lines(self.taken.as_ptr().wrapping_add(bodies.start), bodies.len() * size_of::<Taken>());
    }

    /// Prefetches the entries of scattered bodies.
    #[inline(always)]
    pub fn fetch_each(&self, bodies: &[u32]) {
        prefetch_places(self.taken.as_ptr(), bodies);
    }

    /// Returns the smallest group number for a subsequent assigner.
    pub fn next(&self) -> u32 {
        self.window.start + 2 * WINDOW
    }

    /// Finds the group and lane of a contact between bodies of the task; the group index is relative to the first group of the task.
    #[inline(always)]
    pub fn place<const N: usize>(&mut self, bodies: [u32; N]) -> (usize, usize) {
        let (mut window, taken) = (self.window, self.taken);
        let taken_from = |start| bodies.map(|body| taken.with_trusted(body, |taken| taken.seen_from(start)));
        let mut masks = taken_from(window.start);
        let mut free = window.open & !shared(masks, self.spaced);
        while free == 0 {
            window = window.advance(&mut self.filled);
            masks = taken_from(window.start);
            free = window.open & !shared(masks, self.spaced);
        }
        let place = free.trailing_zeros();
        for (body, mask) in bodies.into_iter().zip(masks) {
            let mask = mask | 1 << place;
            self.taken.with_trusted(body, |taken| {
                taken.mask = [mask as u32, (mask >> 32) as u32];
                taken.since = window.start;
            });
        }
        let filled = &mut self.filled[((window.start + place) % WINDOW) as usize];
        let lane = *filled as usize;
        // The count of a full group becomes that of the next group that enters the window.
        *filled = (*filled + 1) % LANES as u8;
        window.open &= !(u64::from(lane + 1 == LANES) << place);
        self.window = window;
        ((window.start - self.base + place) as usize, lane)
    }
}

/// Returns the groups that are excluded for a contact.
#[inline(always)]
fn shared<const N: usize>(masks: [u64; N], spaced: bool) -> u64 {
    let shared = masks.iter().fold(0, |all, mask| all | mask);
    if !spaced {
        return shared;
    }
    let near = shared | shared << 1 | shared >> 1;
    near | near << 1 | near >> 1
}

impl Window {
    /// Advances the window past its full groups, or past its first group if that group still has a free lane.
    #[cold]
    #[inline(never)]
    fn advance(self, filled: &mut [u8; WINDOW as usize]) -> Window {
        filled[(self.start % WINDOW) as usize] = 0;
        let full = (self.open | 1 << (WINDOW - 1)).trailing_zeros().max(1);
        Window { start: self.start + full, open: self.open >> full | u64::MAX << (WINDOW - full) }
    }
}

impl TaskGroups {
    /// Puts a contact between two bodies into a lane of an assigner, and creates groups up to this one.
    #[inline(always)]
    pub(crate) fn put_pair(&mut self, at: (usize, usize), [first, second]: [u32; 2], candidate: u32, dummies: u32) {
        let (group, lane) = at;
        if group >= self.pairs.len() {
            self.open_pairs(group + 1, dummies);
        }
        self.pairs_used = self.pairs_used.max(group + 1);
        debug_assert!(lane < LANES && self.pair_sources.len() == self.pairs.len());
        // SAFETY: the groups up to this one exist, with their sources; lanes of an assigner are below the number of lanes.
        unsafe {
            with_pairs!(&mut self.pairs, pairs => {
                let group = pairs.get_unchecked_mut(group);
                *group.first.get_unchecked_mut(lane) = first;
                *group.second.get_unchecked_mut(lane) = second;
            });
            self.pair_sources.get_unchecked_mut(group).set(lane, candidate);
        }
    }

    #[cold]
    #[inline(never)]
    fn open_pairs(&mut self, count: usize, dummies: u32) {
        with_pairs!(&mut self.pairs, pairs => while pairs.len() < count {
            make_room(pairs, &mut self.pair_sources);
            pairs.push(PairGroup::padding(dummies));
            self.pair_sources.push(Sources::NONE);
        });
    }

    /// Puts a contact of a body with a wall into a lane, and creates groups up to this one.
    pub(crate) fn put_wall(&mut self, at: (usize, usize), body: u32, candidate: u32, dummies: u32) {
        let (group, lane) = at;
        while self.walls.len() <= group {
            make_room(&mut self.walls, &mut self.wall_sources);
            self.walls.push(WallGroup::padding(dummies));
            self.wall_sources.push(Sources::NONE);
        }
        self.walls_used = self.walls_used.max(group + 1);
        self.walls[group].body[lane] = body;
        self.wall_sources[group].set(lane, candidate);
    }

    /// Returns the present number of groups of wall contacts.
    pub(crate) fn wall_groups(&self) -> usize {
        self.walls_used
    }

    /// Returns true if the pairs were packed from the candidate list with this number.
    pub(crate) fn are_assigned_from(&self, list: u64) -> bool {
        self.assigned_from == list
    }

    /// Starts the packing of pairs from the candidate list with this number, above 0, with the existing groups, all empty.
    pub(crate) fn restart_pairs(&mut self, list: u64, dummies: u32, effects: EffectSet) {
        (self.pairs_used, self.pair_contacts, self.assigned_from) = (0, 0, list);
        self.pair_waits.clear();
        self.pairs.suit(effects.tangential(), effects.spring());
        self.pair_sources.truncate(self.pairs.len());
        with_pairs!(&mut self.pairs, pairs => pairs.iter_mut().for_each(|group| group.clear(dummies)));
        self.pair_sources.fill(Sources::NONE);
    }

    /// Restarts the packing of contacts with walls.
    pub(crate) fn restart_walls(&mut self, dummies: u32) {
        (self.walls_used, self.driven_walls, self.wall_contacts, self.deep_walls) = (0, 0, 0, false);
        for (group, sources) in self.walls.iter_mut().zip(&mut self.wall_sources) {
            group.clear(dummies);
            *sources = Sources::NONE;
        }
    }

    /// Removes all groups and sets the layout for the effects. Memory remains allocated unless friction is switched.
    pub(crate) fn empty(&mut self, effects: EffectSet) {
        self.pairs.suit(effects.tangential(), effects.spring());
        (self.pairs_used, self.walls_used, self.driven_walls) = (0, 0, 0);
        (self.pair_contacts, self.wall_contacts, self.assigned_from) = (0, 0, 0);
        self.pair_waits.clear();
        self.finish(effects, false);
    }

    /// Removes the groups that this step does not need, and allocates the additional data of the scene's effects for
    /// the others; memory remains allocated. `drifts` is true if at least one wall rotates.
    pub(crate) fn finish(&mut self, effects: EffectSet, drifts: bool) {
        self.pairs.truncate(self.pairs_used);
        self.pair_sources.truncate(self.pairs_used);
        self.walls.truncate(self.walls_used);
        self.wall_sources.truncate(self.walls_used);
        // The same capacity as that of the groups avoids further reallocations.
        grow(&mut self.pair_impacts, self.pairs_used, self.pairs.capacity());
        grow(&mut self.wall_impacts, self.walls_used, self.walls.capacity());
        if effects.torques() {
            grow(&mut self.pair_torques, self.pairs_used, self.pairs.capacity());
            grow(&mut self.wall_torques, self.walls_used, self.walls.capacity());
        }
        if effects.cohesion() {
            grow(&mut self.pair_pulls, self.pairs_used, self.pairs.capacity());
            grow(&mut self.wall_pulls, self.walls_used, self.walls.capacity());
        }
        match drifts {
            true => grow(&mut self.wall_drifts, self.walls_used, self.walls.capacity()),
            false => self.wall_drifts.clear(),
        }
    }
}

/// Sets the length and the capacity of a list.
fn grow<T: Clone + Default>(list: &mut Vec<T>, length: usize, room: usize) {
    list.truncate(length);
    list.reserve_exact(room - list.len());
    list.resize(length, T::default());
}

/// Extends the capacity of full lists by an eighth: doubling would waste memory that large scenes need.
fn make_room<G>(groups: &mut Vec<G>, sources: &mut Vec<Sources>) {
    if groups.len() == groups.capacity() {
        groups.reserve_exact(groups.len() / 8 + 2);
        sources.reserve_exact(groups.capacity() - sources.len());
    }
}

/// Returns true if sweeps have several lane groups in flight at a time. Without friction the operation chain of a group
/// is too short for a gain.
pub(crate) const fn overlapped<L: Lanes>(friction: bool) -> bool {
    L::OVERLAPPED && friction
}

/// Mark of a group that shares a body with the previous group.
pub(crate) const PREVIOUS: u8 = 1;
/// Mark of a group that shares a body with the group before the previous group.
pub(crate) const SECOND_PREVIOUS: u8 = 2;

/// Finds the groups of pairs in a task that share a body with the preceding group, if sweeps need this information.
pub(crate) struct FindWaits<'a> {
    pub groups: &'a mut TaskGroups,
    pub effects: EffectSet,
    /// Slots from here on are those of padding bodies.
    pub grains: u32,
}

impl Kernel for FindWaits<'_> {
    type Output = ();

    #[inline(always)]
    fn run<L: Lanes>(self) {
        let TaskGroups { pairs, pair_waits, .. } = self.groups;
        // Groups from an earlier step have the same waits.
        if pair_waits.len() == pairs.len() || !overlapped::<L>(self.effects.tangential()) {
            return;
        }
        // The same capacity as that of the groups avoids further reallocations.
        pair_waits.reserve_exact(pairs.capacity());
        let in_flight = if self.effects.torques() { 2 } else { 1 };
        with_pairs!(pairs, pairs => for number in 0..pairs.len() {
            // Padding lanes do not count: no impulse moves their bodies.
            let mut waits = 0;
            for &(before, shared) in &[(1, PREVIOUS), (2, SECOND_PREVIOUS)][..in_flight] {
                if let Some(other) = number.checked_sub(before) {
                    let [one, other] = [&pairs[number], &pairs[other]].map(|group| [&group.first, &group.second]);
                    waits |= if L::share_places(one, other, self.grains) { shared } else { 0 };
                }
            }
            pair_waits.push(waits);
        });
    }
}
