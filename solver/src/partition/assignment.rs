//! Packing: contacts into lane groups whose eight contacts share no body.

use super::{ByBodies, TaskGroups};
use crate::effects::EffectSet;
use crate::groups::{PairGroup, Sources, WallGroup, with_pairs};
use crate::lanes::{Kernel, LANES, Lanes, TaskSlots, prefetch_lines, prefetch_places};
use std::ops::Range;

/// Number of groups that may take contacts at a time.
const WINDOW: u32 = 64;

/// Tasks of at least so many candidates keep groups that share a body apart; smaller ones would be mostly padding.
const SPACED_FROM: usize = 192;

/// Groups in which a body already is: a mask, its lower half first, that counts from group `since`.
///
/// Read and written as one word of eight bytes and one of four: were both of eight, the compiler would read the two together,
/// which has to wait for two writes.
#[derive(Clone, Copy, Debug, Default)]
#[repr(C, align(16))]
pub(crate) struct Taken {
    mask: [u32; 2],
    since: u32,
}

impl Taken {
    /// Mask of the same groups, counted from group `start`. Recent occurrence of a body follows no pattern, so this must
    /// not branch.
    #[inline(always)]
    fn seen_from(&self, start: u32) -> u64 {
        let (mask, age) = (u64::from(self.mask[0]) | u64::from(self.mask[1]) << 32, start.wrapping_sub(self.since));
        (mask >> (age % WINDOW)) & u64::from(age < WINDOW).wrapping_neg()
    }
}

/// Number of a group from which on a step starts the numbers again.
const LAST: u32 = u32::MAX / 2;
/// Number of the first group: so close to the last one that every run, those of the tests included, starts the numbers again once.
const FIRST: u32 = LAST - 10_000;

/// Groups of each body, from task to task and from step to step. Numbers of groups grow, so that nothing must be forgotten.
#[derive(Clone, Debug, Default)]
pub(crate) struct TakenGroups {
    of_body: Vec<Taken>,
    /// A number beyond all that were given to a group.
    next: u32,
}

impl TakenGroups {
    /// Starts a step with so many bodies.
    pub fn start(&mut self, bodies: usize) {
        if self.next == 0 {
            self.next = FIRST;
        } else if self.next > LAST {
            self.of_body.fill(Taken::default());
            self.next = WINDOW;
        }
        self.of_body.resize(bodies, Taken::default());
    }

    /// Groups of each body, and the number of the first group of tasks that share no body; the result of [`LaneAssigner::next`] for each of
    /// these is left in `next`.
    pub fn stage(&mut self) -> (ByBodies<'_, Taken>, u32, &mut u32) {
        (ByBodies::of(&mut self.of_body), self.next, &mut self.next)
    }

    pub fn memory_bytes(&self) -> usize {
        self.of_body.capacity() * size_of::<Taken>()
    }
}

/// Packs contacts first-fit into groups, looking at a window of groups.
///
/// A group that follows another one and shares a body with it must wait until the other has written it. First-fit alone
/// puts the contacts of a grain, which come one after another, into adjacent groups; so groups next to one that holds
/// the body are passed over too.
pub(crate) struct LaneAssigner<'a> {
    taken: TaskSlots<'a, Taken>,
    window: Window,
    /// Number of the task's first group.
    base: u32,
    /// True if groups that share a body are kept apart.
    spaced: bool,
    /// Lanes filled in each group of the window, by group number modulo the window.
    filled: [u8; WINDOW as usize],
}

/// The groups that contacts may go into.
#[derive(Clone, Copy)]
struct Window {
    /// Number of its first group.
    start: u32,
    /// Groups that still have a free lane.
    open: u64,
}

impl<'a> LaneAssigner<'a> {
    /// A assigner for one task. `base` must be larger by at least the window than the number of any group that earlier
    /// tasks put the same bodies into.
    pub fn new(taken: TaskSlots<'a, Taken>, base: u32, candidates: usize) -> LaneAssigner<'a> {
        LaneAssigner {
            taken,
            window: Window { start: base, open: u64::MAX },
            base,
            spaced: candidates >= SPACED_FROM,
            filled: [0; WINDOW as usize],
        }
    }

    /// Asks for what is known of bodies that lie together.
    #[inline(always)]
    pub fn fetch(&self, bodies: Range<usize>) {
        prefetch_lines(self.taken.as_ptr().wrapping_add(bodies.start), bodies.len() * size_of::<Taken>());
    }

    /// Asks for what is known of bodies here and there.
    #[inline(always)]
    pub fn fetch_each(&self, bodies: &[u32]) {
        prefetch_places(self.taken.as_ptr(), bodies);
    }

    /// The number from which a assigner may begin that comes after this one.
    pub fn next(&self) -> u32 {
        self.window.start + 2 * WINDOW
    }

    /// Finds the group and lane for a contact of these bodies, which are the task's; the group is counted from the task's first.
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
        // The place of a full group is empty again for the one that will enter the window.
        *filled = (*filled + 1) % LANES as u8;
        window.open &= !(u64::from(lane + 1 == LANES) << place);
        self.window = window;
        ((window.start - self.base + place) as usize, lane)
    }
}

/// Groups that a contact must not go into.
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
    /// The window past its full groups, or past its first group if that still has room.
    #[cold]
    #[inline(never)]
    fn advance(self, filled: &mut [u8; WINDOW as usize]) -> Window {
        filled[(self.start % WINDOW) as usize] = 0;
        let full = (self.open | 1 << (WINDOW - 1)).trailing_zeros().max(1);
        Window { start: self.start + full, open: self.open >> full | u64::MAX << (WINDOW - full) }
    }
}

impl TaskGroups {
    /// Puts a contact of two bodies into a lane that a assigner found; groups are opened up to its own.
    #[inline(always)]
    pub(crate) fn put_pair(&mut self, at: (usize, usize), [first, second]: [u32; 2], candidate: u32, dummies: u32) {
        let (group, lane) = at;
        if group >= self.pairs.len() {
            self.open_pairs(group + 1, dummies);
        }
        self.pairs_used = self.pairs_used.max(group + 1);
        debug_assert!(lane < LANES && self.pair_sources.len() == self.pairs.len());
        // SAFETY: groups were opened up to this one, and their sources with them; a assigner's lanes are below the number of lanes.
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

    /// Puts a contact of a body with a wall into a lane; groups are opened up to its own.
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

    /// Number of groups of wall contacts so far.
    pub(crate) fn wall_groups(&self) -> usize {
        self.walls_used
    }

    /// Returns true if the pairs are those that a candidate list of this number had packed.
    pub(crate) fn are_assigned_from(&self, list: u64) -> bool {
        self.assigned_from == list
    }

    /// Starts to pack pairs of a candidate list of this number, above 0, with the groups that there are, all of them empty.
    pub(crate) fn restart_pairs(&mut self, list: u64, dummies: u32, effects: EffectSet) {
        (self.pairs_used, self.pair_contacts, self.assigned_from) = (0, 0, list);
        self.pair_waits.clear();
        self.pairs.suit(effects.tangential(), effects.spring());
        self.pair_sources.truncate(self.pairs.len());
        with_pairs!(&mut self.pairs, pairs => pairs.iter_mut().for_each(|group| group.clear(dummies)));
        self.pair_sources.fill(Sources::NONE);
    }

    /// Starts to pack contacts with walls anew.
    pub(crate) fn restart_walls(&mut self, dummies: u32) {
        (self.walls_used, self.driven_walls, self.wall_contacts, self.deep_walls) = (0, 0, 0, false);
        for (group, sources) in self.walls.iter_mut().zip(&mut self.wall_sources) {
            group.clear(dummies);
            *sources = Sources::NONE;
        }
    }

    /// Drops all groups; those to come suit the effects. Memory stays, unless friction comes or goes.
    pub(crate) fn empty(&mut self, effects: EffectSet) {
        self.pairs.suit(effects.tangential(), effects.spring());
        (self.pairs_used, self.walls_used, self.driven_walls) = (0, 0, 0);
        (self.pair_contacts, self.wall_contacts, self.assigned_from) = (0, 0, 0);
        self.pair_waits.clear();
        self.finish(effects, false);
    }

    /// Drops the groups that this step does not need, and gives each of the others room for what the scene calls for besides;
    /// memory stays. `drifts` where some wall turns.
    pub(crate) fn finish(&mut self, effects: EffectSet, drifts: bool) {
        self.pairs.truncate(self.pairs_used);
        self.pair_sources.truncate(self.pairs_used);
        self.walls.truncate(self.walls_used);
        self.wall_sources.truncate(self.walls_used);
        // As much room as the groups have, so that it grows no oftener.
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

/// Makes a list so long, with room for so many.
fn grow<T: Clone + Default>(list: &mut Vec<T>, length: usize, room: usize) {
    list.truncate(length);
    list.reserve_exact(room - list.len());
    list.resize(length, T::default());
}

/// Makes room for an eighth more groups where there is none: doubling would waste memory that large scenes need.
fn make_room<G>(groups: &mut Vec<G>, sources: &mut Vec<Sources>) {
    if groups.len() == groups.capacity() {
        groups.reserve_exact(groups.len() / 8 + 2);
        sources.reserve_exact(groups.capacity() - sources.len());
    }
}

/// Returns true if sweeps have several lane groups on their way at a time. Contacts that bear torques need the bodies themselves for that, and
/// without friction a group's chain of operations is too short to gain.
pub(crate) const fn overlapped<L: Lanes>(friction: bool, torques: bool) -> bool {
    L::OVERLAPPED && friction && !torques
}

/// Finds the groups of pairs of a task that share a body with the one before them, where sweeps have to know.
pub(crate) struct FindWaits<'a> {
    pub groups: &'a mut TaskGroups,
    pub effects: EffectSet,
    /// Places from here on are those of dummies.
    pub grains: u32,
}

impl Kernel for FindWaits<'_> {
    type Output = ();

    #[inline(always)]
    fn run<L: Lanes>(self) {
        let TaskGroups { pairs, pair_waits, .. } = self.groups;
        // What was packed for an earlier step waits as it did then.
        if pair_waits.len() == pairs.len() || !overlapped::<L>(self.effects.tangential(), self.effects.torques()) {
            return;
        }
        // As much room as the groups have, so that it grows no oftener.
        pair_waits.reserve_exact(pairs.capacity());
        pair_waits.push(false);
        with_pairs!(pairs, pairs => for both in pairs.windows(2) {
            // Padding lanes do not count: no impulse moves their bodies.
            let [one, other] = [&both[0], &both[1]].map(|group| [&group.first, &group.second]);
            pair_waits.push(L::share_places(one, other, self.grains));
        });
    }
}
