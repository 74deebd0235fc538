//! Packing: contacts into lane groups whose eight contacts share no body.

use super::{Constraint, Layout, PairGroup, WallGroup};
use crate::world::LANES;

/// A contact of two grains on its way into a lane group.
#[derive(Clone, Copy, Debug)]
pub(crate) struct PairEntry {
    pub first: u32,
    pub second: u32,
    pub constraint: Constraint,
}

/// A wall contact on its way into a lane group.
#[derive(Clone, Copy, Debug)]
pub(crate) struct WallEntry {
    pub body: u32,
    pub wall_velocity: [f64; 3],
    pub constraint: Constraint,
}

/// Number of groups that are open for contacts at a time.
const WINDOW: u64 = 64;

/// Packs contacts first-fit into groups, looking at a window of open groups.
///
/// Each body remembers in which open groups it already is, as a mask relative to the window's start. The numbers of
/// groups grow without end, so that nothing must be reset between tasks or steps.
#[derive(Clone, Debug)]
pub(crate) struct Packer {
    taken: Vec<(u64, u64)>,
    /// Number of the window's first group.
    start: u64,
    /// Number of groups opened since the window's start.
    opened: u64,
    /// Groups of the window that still have a free lane.
    open: u64,
    /// Lanes filled in each group of the window, by group number modulo the window.
    filled: [u8; WINDOW as usize],
}

impl Default for Packer {
    fn default() -> Packer {
        Packer { taken: Vec::new(), start: 0, opened: 0, open: 0, filled: [0; WINDOW as usize] }
    }
}

impl Packer {
    pub fn resize(&mut self, bodies: usize) {
        self.taken.resize(bodies, (0, 0));
    }

    /// Closes all open groups: the next contact opens a new one.
    fn close(&mut self) {
        self.start += self.opened;
        self.opened = 0;
        self.open = 0;
    }

    #[inline]
    fn mask_of(&self, body: u32) -> u64 {
        let (mask, since) = self.taken[body as usize];
        let age = self.start - since;
        if age < WINDOW { mask >> age } else { 0 }
    }

    /// Finds the group and lane for a contact of these bodies: (place in the window, lane).
    #[inline]
    fn place<const N: usize>(&mut self, bodies: [u32; N]) -> (u64, usize) {
        let masks = bodies.map(|body| self.mask_of(body));
        let mut free = self.open & !masks.iter().fold(0, |all, mask| all | mask);
        if free == 0 {
            if self.opened == WINDOW {
                self.advance();
                return self.place(bodies);
            }
            free = 1 << self.opened;
            self.filled[((self.start + self.opened) % WINDOW) as usize] = 0;
            self.open |= free;
            self.opened += 1;
        }
        let place = u64::from(free.trailing_zeros());
        for (body, mask) in bodies.into_iter().zip(masks) {
            self.taken[body as usize] = (mask | 1 << place, self.start);
        }
        let filled = &mut self.filled[((self.start + place) % WINDOW) as usize];
        let lane = *filled as usize;
        *filled += 1;
        if lane + 1 == LANES {
            self.open &= !(1 << place);
        }
        (place, lane)
    }

    /// Moves the window past its full groups, or past its first group if that still has room.
    fn advance(&mut self) {
        let full = u64::from((self.open | 1 << (WINDOW - 1)).trailing_zeros()).max(1);
        self.start += full;
        self.opened -= full;
        self.open >>= full;
    }

    /// Packs a task's contacts of pairs behind the groups that the layout has.
    pub fn pack_pairs(&mut self, entries: &[PairEntry], grains: u32, layout: &mut Layout) {
        self.close();
        let before = self.start;
        let base = layout.pairs.len();
        for entry in entries {
            let (place, lane) = self.place([entry.first, entry.second]);
            let at = base + (self.start - before + place) as usize;
            if at == layout.pairs.len() {
                layout.pairs.push(PairGroup::padding(grains));
            }
            let group = &mut layout.pairs[at];
            group.first[lane] = entry.first;
            group.second[lane] = entry.second;
            group.contacts.set(lane, &entry.constraint);
        }
        layout.contacts += entries.len();
    }

    /// Packs a task's wall contacts behind the groups that the layout has.
    pub fn pack_walls(&mut self, entries: &[WallEntry], grains: u32, layout: &mut Layout) {
        self.close();
        let before = self.start;
        let base = layout.walls.len();
        for entry in entries {
            let (place, lane) = self.place([entry.body]);
            let at = base + (self.start - before + place) as usize;
            if at == layout.walls.len() {
                layout.walls.push(WallGroup::padding(grains));
            }
            let group = &mut layout.walls[at];
            group.body[lane] = entry.body;
            for axis in 0..3 {
                group.wall_velocity[axis].0[lane] = entry.wall_velocity[axis];
            }
            group.contacts.set(lane, &entry.constraint);
        }
        layout.contacts += entries.len();
    }
}
