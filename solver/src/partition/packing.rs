//! Packing: contacts into lane groups whose eight contacts share no body.

use super::{PairGroup, Sources, TaskGroups, WallGroup};
use crate::detect::{PairCandidate, WallCandidate};
use crate::effects::EffectSet;
use crate::lanes::LANES;
use crate::schedule::Disjoint;

/// Number of groups that are open for contacts at a time.
const WINDOW: u64 = 64;

/// Tasks of at least so many candidates keep groups that share a body apart; smaller ones would be mostly padding.
const SPACED_FROM: usize = 192;

/// Groups in which a body already is: a mask that counts from group `since`.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Taken {
    mask: u64,
    since: u64,
}

/// Packs contacts first-fit into groups, looking at a window of open groups.
///
/// Each body remembers in which open groups it already is. Numbers of groups grow from task to task and from step to step,
/// so that nothing must be reset.
///
/// A group that follows another one and shares a body with it must wait until the other has written it. First-fit alone
/// puts the contacts of a grain, which come one after another, into adjacent groups; so groups next to one that holds
/// the body are passed over too.
pub(crate) struct Packer<'a> {
    taken: &'a Disjoint<'a, Taken>,
    /// Number of the window's first group.
    start: u64,
    /// Number of the task's first group.
    base: u64,
    /// Number of groups opened since the window's start.
    opened: u64,
    /// Groups of the window that still have a free lane.
    open: u64,
    /// Whether groups that share a body are kept apart.
    spaced: bool,
    /// Lanes filled in each group of the window, by group number modulo the window.
    filled: [u8; WINDOW as usize],
}

impl<'a> Packer<'a> {
    /// A packer for one task. `base` must be larger by at least the window than the number of any group that earlier
    /// tasks put the same bodies into.
    pub fn new(taken: &'a Disjoint<'a, Taken>, base: u64, candidates: usize) -> Packer<'a> {
        let spaced = candidates >= SPACED_FROM;
        Packer { taken, start: base, base, opened: 0, open: 0, spaced, filled: [0; WINDOW as usize] }
    }

    /// Groups that hold one of the bodies.
    ///
    /// # Safety
    /// No other task may use these bodies.
    #[inline]
    unsafe fn groups_of<const N: usize>(&self, bodies: [u32; N]) -> [u64; N] {
        bodies.map(|body| {
            // SAFETY: the caller's promise.
            let taken = unsafe { self.taken.at(body as usize) };
            let age = self.start - taken.since;
            // Whether a body was met lately follows no pattern, so this must not branch.
            (taken.mask >> (age % WINDOW)) & u64::from(age < WINDOW).wrapping_neg()
        })
    }

    /// Finds the group and lane for a contact of these bodies; the group is counted from the task's first.
    ///
    /// # Safety
    /// No other task may use these bodies meanwhile.
    #[inline(always)]
    pub unsafe fn place<const N: usize>(&mut self, bodies: [u32; N]) -> (usize, usize) {
        // SAFETY: the caller's promise.
        let mut masks = unsafe { self.groups_of(bodies) };
        let mut free = self.open & !self.shared(masks);
        while free == 0 {
            free = self.open_group(self.shared(masks));
            if free == 0 {
                self.advance();
                // SAFETY: as above.
                masks = unsafe { self.groups_of(bodies) };
                free = self.open & !self.shared(masks);
            }
        }
        let place = u64::from(free.trailing_zeros());
        for (body, mask) in bodies.into_iter().zip(masks) {
            // SAFETY: as above.
            unsafe { *self.taken.at(body as usize) = Taken { mask: mask | 1 << place, since: self.start } };
        }
        let filled = &mut self.filled[((self.start + place) % WINDOW) as usize];
        let lane = *filled as usize;
        *filled += 1;
        self.open &= !(u64::from(lane + 1 == LANES) << place);
        ((self.start - self.base + place) as usize, lane)
    }

    /// Groups that a contact must not go into.
    #[inline(always)]
    fn shared<const N: usize>(&self, masks: [u64; N]) -> u64 {
        let shared = masks.iter().fold(0, |all, mask| all | mask);
        if !self.spaced {
            return shared;
        }
        let near = shared | shared << 1 | shared >> 1;
        near | near << 1 | near >> 1
    }

    /// Opens groups until one lies outside `shared` or the window is full; that one as a mask.
    #[cold]
    #[inline(never)]
    fn open_group(&mut self, shared: u64) -> u64 {
        while self.opened < WINDOW {
            let next = 1 << self.opened;
            self.filled[((self.start + self.opened) % WINDOW) as usize] = 0;
            self.open |= next;
            self.opened += 1;
            if next & !shared != 0 {
                return next;
            }
        }
        0
    }

    /// Moves the window past its full groups, or past its first group if that still has room.
    fn advance(&mut self) {
        let full = u64::from((self.open | 1 << (WINDOW - 1)).trailing_zeros()).max(1);
        self.start += full;
        self.opened -= full;
        self.open >>= full;
    }
}

impl TaskGroups {
    /// Puts a contact of two grains into a lane; groups are opened up to its own.
    #[inline(always)]
    pub(crate) fn put_pair(&mut self, at: (usize, usize), pair: PairCandidate, candidate: u32, dummies: u32) {
        let (group, lane) = at;
        if group >= self.pairs_used {
            self.open_pairs(group + 1, dummies);
        }
        self.pairs[group].first[lane] = pair.first;
        self.pairs[group].second[lane] = pair.second;
        self.pair_sources[group].set(lane, candidate);
    }

    #[cold]
    #[inline(never)]
    fn open_pairs(&mut self, count: usize, dummies: u32) {
        while self.pairs_used < count {
            match self.pairs.get_mut(self.pairs_used) {
                Some(old) => {
                    old.clear(dummies);
                    self.pair_sources[self.pairs_used] = Sources::NONE;
                }
                None => {
                    make_room(&mut self.pairs, &mut self.pair_sources);
                    self.pairs.push(PairGroup::padding(dummies));
                    self.pair_sources.push(Sources::NONE);
                }
            }
            self.pairs_used += 1;
        }
    }

    /// Puts a wall contact into a lane; groups are opened up to its own.
    pub(crate) fn put_wall(&mut self, at: (usize, usize), wall: WallCandidate, candidate: u32, dummies: u32) {
        let (group, lane) = at;
        while self.walls_used <= group {
            match self.walls.get_mut(self.walls_used) {
                Some(old) => {
                    old.clear(dummies);
                    self.wall_sources[self.walls_used] = Sources::NONE;
                }
                None => {
                    make_room(&mut self.walls, &mut self.wall_sources);
                    self.walls.push(WallGroup::padding(dummies));
                    self.wall_sources.push(Sources::NONE);
                }
            }
            self.walls_used += 1;
        }
        self.walls[group].body[lane] = wall.body;
        self.wall_sources[group].set(lane, candidate);
    }

    /// Number of groups of wall contacts so far.
    pub(crate) fn wall_groups(&self) -> usize {
        self.walls_used
    }

    /// Starts to lay out a step anew.
    pub(crate) fn restart(&mut self) {
        (self.pairs_used, self.walls_used, self.driven_walls, self.contacts) = (0, 0, 0, 0);
        self.pair_waits.clear();
    }

    /// Drops the groups that this step does not need, and gives each of the others room for what the scene calls for besides;
    /// memory stays.
    pub(crate) fn finish(&mut self, effects: EffectSet) {
        self.pairs.truncate(self.pairs_used);
        self.pair_sources.truncate(self.pairs_used);
        self.walls.truncate(self.walls_used);
        self.wall_sources.truncate(self.walls_used);
        if effects.torques() {
            // As much room as the groups have, so that it grows no oftener.
            grow(&mut self.pair_torques, self.pairs_used, self.pairs.capacity());
            grow(&mut self.wall_torques, self.walls_used, self.walls.capacity());
        }
        if effects.cohesion() {
            grow(&mut self.pair_pulls, self.pairs_used, self.pairs.capacity());
            grow(&mut self.wall_pulls, self.walls_used, self.walls.capacity());
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
