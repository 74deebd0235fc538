//! Which candidates touch, and the lane that each gets.

use super::Given;
use crate::detect::Impulse;
use crate::lanes::{Kernel, LANES, Lanes, PREFETCH, Quad, dot, prefetch};
use crate::partition::{Packer, PlannedTask, TaskGroups};
use crate::schedule::Disjoint;

/// Packs the pairs of a task that touch.
///
/// Whoever makes one promises that no other task uses the task's bodies and candidates meanwhile.
pub(super) struct PackPairs<'a, const PERIODIC: bool> {
    pub given: &'a Given<'a>,
    pub task: &'a PlannedTask,
    pub dummies: u32,
    pub packer: Packer<'a>,
    pub groups: &'a mut TaskGroups,
    pub impulses: &'a Disjoint<'a, Impulse>,
}

impl<const PERIODIC: bool> Kernel for PackPairs<'_, PERIODIC> {
    type Output = ();

    #[inline(always)]
    fn run<L: Lanes>(mut self) {
        let (start, end) = (self.task.pairs.start as usize, self.task.pairs.end as usize);
        for batch in (start..end).step_by(BATCH * LANES) {
            let blocks = (end - batch).div_ceil(LANES).min(BATCH);
            // First the arithmetic of a batch, which the processor can run ahead with; then what depends on its outcome. Which
            // candidates touch follows no pattern, so they are listed without a branch.
            let (mut touching, mut apart) = ([0; BATCH * LANES], [0; BATCH * LANES]);
            let (mut touches, mut others) = (0, 0);
            for number in 0..blocks {
                let block = batch + number * LANES;
                self.fetch(block + PREFETCH * LANES, end);
                let mask = self.touching::<L>(block, end) as usize;
                for lane in 0..(end - block).min(LANES) {
                    (touching[touches], apart[others]) = ((block + lane) as u32, (block + lane) as u32);
                    touches += mask >> lane & 1;
                    others += !mask >> lane & 1;
                }
            }
            self.pack(&touching[..touches]);
            self.forget(&apart[..others]);
        }
    }
}

/// Blocks of candidates whose distances are computed before they are packed.
const BATCH: usize = 64;

impl<const PERIODIC: bool> PackPairs<'_, PERIODIC> {
    /// Asks for the spheres of the eight candidates from `block` on.
    #[inline(always)]
    fn fetch(&self, block: usize, end: usize) {
        let spheres: *const Quad = self.given.world.spheres.as_ptr().cast();
        if block + LANES <= end {
            for pair in &self.given.candidates.pairs[block..block + LANES] {
                prefetch(spheres.wrapping_add(pair.first as usize).cast());
                prefetch(spheres.wrapping_add(pair.second as usize).cast());
            }
        }
    }

    /// Which of the eight candidates from `block` on touch, as bits; behind `end` bits mean nothing.
    #[inline(always)]
    fn touching<L: Lanes>(&self, block: usize, end: usize) -> u32 {
        let spheres: *const Quad = self.given.world.spheres.as_ptr().cast();
        let candidates = &self.given.candidates.pairs[block..(block + LANES).min(end)];
        let pair = |lane: usize| candidates[lane.min(candidates.len() - 1)];
        let first = std::array::from_fn(|lane| pair(lane).first);
        let second = std::array::from_fn(|lane| pair(lane).second);
        // SAFETY: candidates name grains.
        let [x, y, z, radii] = unsafe { L::load_differences::<1>(spheres, &first, &second) };
        let arm = if PERIODIC { self.given.world.period.shortest([x, y, z]) } else { [x, y, z] };
        let touch = radii + L::splat(self.given.constants.reach);
        L::bits(dot(arm, arm).below(touch * touch))
    }

    /// Finds lanes for candidates that touch.
    #[inline(always)]
    fn pack(&mut self, touching: &[u32]) {
        for &candidate in touching {
            let pair = self.given.candidates.pairs[candidate as usize];
            // SAFETY: the promise of whoever made this.
            let place = unsafe { self.packer.place([pair.first, pair.second]) };
            self.groups.put_pair(place, pair, candidate, self.dummies);
        }
        self.groups.contacts += touching.len();
    }

    /// Forgets what candidates bore that are apart.
    #[inline(always)]
    fn forget(&self, apart: &[u32]) {
        for &candidate in apart {
            // SAFETY: the promise of whoever made this.
            forget(unsafe { self.impulses.at(candidate as usize) });
        }
    }
}

/// A contact that has opened starts from nothing when it closes again.
#[inline(always)]
fn forget(impulse: &mut Impulse) {
    if impulse.normal != 0.0 {
        *impulse = Impulse::default();
    }
}

impl Given<'_> {
    /// Packs the contacts of a task that touch walls, those with driven walls or those with the others, behind the groups that are
    /// there.
    ///
    /// # Safety
    /// No other task may use the task's bodies and candidates meanwhile.
    pub(super) unsafe fn pack_walls(
        &self,
        task: &PlannedTask,
        dummies: u32,
        driven: bool,
        mut packer: Packer<'_>,
        groups: &mut TaskGroups,
        impulses: &Disjoint<'_, Impulse>,
    ) {
        let before = groups.wall_groups();
        for candidate in task.walls.start as usize..task.walls.end as usize {
            let wall = self.candidates.walls[candidate];
            if !self.world.drives.is_empty() && self.world.drive_of(wall.surface).is_some() != driven {
                continue;
            }
            let sphere = &self.world.spheres[wall.body as usize];
            let distance = self.poses[wall.surface as usize].distance(&sphere.centre);
            // SAFETY: the caller's promise.
            unsafe {
                if distance < sphere.radius + self.constants.reach || self.meets(&wall).is_some() {
                    let (group, lane) = packer.place([wall.body]);
                    groups.put_wall((before + group, lane), wall, candidate as u32, dummies);
                    groups.contacts += 1;
                } else {
                    forget(impulses.at(candidate));
                }
            }
        }
    }
}
