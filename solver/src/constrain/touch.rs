//! Selection of active candidates, and assignment of lanes.

use super::{Listed, StepContext};
use crate::detect::{Impulse, MemoryOfTask, PairCandidate, WallCandidate};
use crate::groups::ImpactMemory;
use crate::lanes::{Kernel, LANES, Lanes, PREFETCH, Slots, TaskSlots, dot, lanes_of, prefetch_places, prefetch_range};
use crate::partition::{LaneAssigner, PlannedTask, TaskGroups};
use crate::surface::{MOST_CONTACTS, Minimum, Near};
use crate::world::Sphere;
use nalgebra::Vector3;

/// Packs the active pairs of a task.
pub(super) struct AssignPairs<'a, const PERIODIC: bool> {
    pub context: &'a StepContext<'a>,
    pub task: &'a PlannedTask,
    pub dummies: u32,
    pub assigner: LaneAssigner<'a>,
    pub groups: &'a mut TaskGroups,
    pub impulses: TaskSlots<'a, Impulse>,
    pub known: TaskSlots<'a, ImpactMemory>,
    /// Bit mask of the task's pairs active in the last step, one byte per block.
    pub borne: &'a mut [u8],
}

impl<const PERIODIC: bool> Kernel for AssignPairs<'_, PERIODIC> {
    /// Next free group number.
    type Output = u32;

    #[inline(always)]
    fn run<L: Lanes>(self) -> u32 {
        let AssignPairs { context, task, dummies, mut assigner, groups, impulses, known, borne } = self;
        let start = task.pairs.start;
        let candidates = &context.candidates.pairs[start as usize..task.pairs.end as usize];
        // Interior grains are contiguous in memory; grains of faces, edges and corners are scattered.
        let interior = task.is_interior();
        if context.fetches && interior {
            let grains = context.candidates.grains_of_box(task.home as usize);
            prefetch_range(&context.world.spheres[grains.clone()]);
            assigner.fetch(grains);
        } else if context.fetches {
            (0..PREFETCH).for_each(|block| fetch(context, &assigner, candidates, block));
        }
        // First the arithmetic, which the processor can execute ahead; then the dependent branches.
        let mut touching = std::mem::take(&mut groups.touching);
        touching.clear();
        for (block, eight) in candidates.chunks(LANES).enumerate() {
            if context.fetches && !interior {
                fetch(context, &assigner, candidates, block + PREFETCH);
            }
            touching.push(touching_of::<L, PERIODIC>(context, eight));
        }
        let list = context.candidates.rebuilds;
        // If the same pairs are active as in the last step, the existing packing is still valid.
        if !groups.are_assigned_from(list) || *touching != *borne {
            groups.restart_pairs(list, dummies, context.effects);
            let candidates = Slots::of(candidates);
            for (batch, (touching, borne)) in touching.chunks(BATCH).zip(borne.chunks_mut(BATCH)).enumerate() {
                let mut listed = Named::default();
                for (block, (&mask, borne)) in touching.iter().zip(borne).enumerate() {
                    let first = (batch * BATCH + block) * LANES;
                    listed.append(first as u32, mask);
                    forget(impulses, known, start as usize + first, mask & !*borne);
                    *borne = mask;
                }
                for &number in listed.list() {
                    // The list contains only numbers below the number of candidates.
                    let pair = candidates.get_trusted(number);
                    let bodies = [pair.first, pair.second];
                    groups.put_pair(assigner.place(bodies), bodies, start + number, dummies);
                }
                groups.pair_contacts += listed.length;
            }
        }
        groups.touching = touching;
        assigner.next()
    }
}

/// Distance of a grain's centre to a wall, over its radius, below which a slow grain may cross the wall in a step.
const DEEP: f64 = crate::wall::SHORT_WAY;

/// Number of candidate blocks whose distances are computed before packing.
const BATCH: usize = 64;

/// Numbers of candidates, appended up to eight at a time.
struct Named {
    /// List, with space for one block at its end.
    numbers: [u32; (BATCH + 1) * LANES],
    length: usize,
}

/// Lanes set in each mask, in ascending order.
const NAMED: [[u8; LANES]; 1 << LANES] = {
    let mut named = [[0; LANES]; 1 << LANES];
    let mut mask = 0;
    while mask < 1 << LANES {
        let (mut lane, mut count) = (0, 0);
        while lane < LANES {
            if mask >> lane & 1 == 1 {
                named[mask][count] = lane as u8;
                count += 1;
            }
            lane += 1;
        }
        mask += 1;
    }
    named
};

/// Number of lanes set in each mask.
const COUNTS: [u8; 1 << LANES] = {
    let mut counts = [0; 1 << LANES];
    let mut mask = 0;
    while mask < 1 << LANES {
        counts[mask] = mask.count_ones() as u8;
        mask += 1;
    }
    counts
};

impl Default for Named {
    fn default() -> Named {
        Named { numbers: [0; (BATCH + 1) * LANES], length: 0 }
    }
}

impl Named {
    /// Appends `start` plus each lane set in a mask of eight. The masks are unpredictable, so the code is free of branches.
    #[inline(always)]
    fn append(&mut self, start: u32, mask: u8) {
        let room = &mut self.numbers[self.length..self.length + LANES];
        for (number, lane) in room.iter_mut().zip(NAMED[mask as usize]) {
            *number = start + u32::from(lane);
        }
        self.length += COUNTS[mask as usize] as usize;
    }

    fn list(&self) -> &[u32] {
        &self.numbers[..self.length]
    }
}

/// Prefetches the data of the bodies of a block of candidates.
#[inline(always)]
fn fetch(context: &StepContext<'_>, assigner: &LaneAssigner<'_>, candidates: &[PairCandidate], block: usize) {
    for pair in candidates.iter().skip(block * LANES).take(LANES) {
        let bodies = [pair.first, pair.second];
        prefetch_places(context.spheres.as_ptr(), &bodies);
        assigner.fetch_each(&bodies);
    }
}

/// Bit mask of the active ones among up to eight candidates.
#[inline(always)]
fn touching_of<L: Lanes, const PERIODIC: bool>(context: &StepContext<'_>, block: &[PairCandidate]) -> u8 {
    match block.try_into() {
        Ok(block) => touching::<L, PERIODIC>(context, block),
        Err(_) => {
            let padded = std::array::from_fn(|lane| block[lane.min(block.len() - 1)]);
            touching::<L, PERIODIC>(context, &padded) & ((1 << block.len()) - 1)
        }
    }
}

/// Bit mask of the active ones among eight candidates.
#[inline(always)]
fn touching<L: Lanes, const PERIODIC: bool>(context: &StepContext<'_>, block: &[PairCandidate; LANES]) -> u8 {
    let (first, second) = (block.map(|pair| pair.first), block.map(|pair| pair.second));
    let [x, y, z, radii]: [L; 4] = context.spheres.load_differences(&first, &second);
    let arm = if PERIODIC { context.world.period.shortest([x, y, z]) } else { [x, y, z] };
    let touch = radii + L::splat(context.constants.contact_margin);
    L::bits(dot(arm, arm).below(touch * touch)) as u8
}

/// Clears the impulses and impacts of the candidates selected by a mask of eight: a contact that closes, for the first time or
/// again, starts from zero.
#[inline(always)]
fn forget(impulses: TaskSlots<'_, Impulse>, impacts: TaskSlots<'_, ImpactMemory>, first: usize, closing: u8) {
    for lane in lanes_of(closing) {
        impulses.set((first + lane) as u32, Impulse::default());
        impacts.set((first + lane) as u32, ImpactMemory::default());
    }
}

impl StepContext<'_> {
    /// Packs the active wall contacts of a task, either those with dynamic walls or all others, after the existing groups.
    /// Returns the next free group number.
    pub(super) fn assign_walls(
        &self,
        (task, listed): (&PlannedTask, Listed<'_>),
        driven: bool,
        mut assigner: LaneAssigner<'_>,
        groups: &mut TaskGroups,
        known: &MemoryOfTask<'_>,
    ) -> u32 {
        let dummies = self.world.dummies_of(task.home as usize);
        let before = groups.wall_groups();
        let mut put = |candidate: u32, body: u32, distance: f64| {
            let (group, lane) = assigner.place([body]);
            groups.put_wall((before + group, lane), body, candidate, dummies);
            groups.wall_contacts += 1;
            groups.deep_walls |= distance < DEEP * self.world.spheres[body as usize].radius;
        };
        let mut next = task.walls.start;
        while next < task.walls.end {
            let (candidate, wall) = (next, listed.walls.get(next));
            next += 1;
            if !self.world.drives.is_empty() && self.world.drive_of(wall.surface).is_some() != driven {
                continue;
            }
            if let Some(mesh) = self.walls.walls().mesh_of(wall.surface) {
                next = candidate + MOST_CONTACTS as u32;
                let slots = self.fill_slots(candidate, mesh, listed, known);
                for (candidate, contact) in (candidate..).zip(slots) {
                    if let Some(contact) = contact {
                        put(candidate, wall.body, contact.distance);
                    }
                }
                continue;
            }
            let Sphere { centre, radius } = &self.world.spheres[wall.body as usize];
            let [u, v, w, _] = self.world.before[wall.body as usize].0;
            let (state, reach) = ([centre, &Vector3::new(u, v, w)], [*radius, self.constants.contact_margin]);
            let (touches, distance) = self.walls.touches(wall.surface, state, reach, self.constants.scheme.step);
            if touches {
                put(candidate, wall.body, distance);
            } else if known.is_known(candidate) {
                known.forget(candidate);
            }
        }
        assigner.next()
    }

    /// Finds the contacts of a grain with a mesh, and writes them into its slots, of which `first` is the first.
    fn fill_slots(
        &self,
        first: u32,
        mesh: u32,
        listed: Listed<'_>,
        known: &MemoryOfTask<'_>,
    ) -> [Option<Minimum>; MOST_CONTACTS] {
        let wall = listed.walls.get(first);
        let Sphere { centre, radius } = &self.world.spheres[wall.body as usize];
        let [u, v, w, _] = self.world.before[wall.body as usize].0;
        let (state, reach) = ([centre, &Vector3::new(u, v, w)], [*radius, self.constants.contact_margin]);
        let mut near = Near::of(std::array::from_fn(|slot| listed.near.get(first + slot as u32)));
        let found = self.walls.mesh_contacts(mesh, state, reach, self.constants.scheme.step, &mut near);
        (first..).zip(near.parts()).for_each(|(candidate, part)| listed.near.set(candidate, part));
        let mut last = [None; MOST_CONTACTS];
        for (candidate, last) in (first..).zip(&mut last) {
            *last = known.is_known(candidate).then(|| listed.walls.get(candidate).surface);
        }
        let slots = match &found {
            Some(found) => self.walls.assign_slots(mesh, centre, found, &last),
            None => [None; MOST_CONTACTS],
        };
        let empty = self.walls.walls().listed(wall.surface);
        for (candidate, (contact, last)) in (first..).zip(slots.iter().zip(last)) {
            let (surface, continues) = contact.map_or((empty, false), |contact| (contact.face, contact.continues));
            if last.is_some() && !continues {
                known.forget(candidate);
            }
            listed.walls.set(candidate, WallCandidate { surface, ..wall });
        }
        slots
    }
}

impl MemoryOfTask<'_> {
    /// Returns true if a wall contact bore an impulse or was in an impact in the last step.
    #[inline(always)]
    fn is_known(&self, candidate: u32) -> bool {
        self.impulses.get(candidate).normal != 0.0 || self.impacts.get(candidate).touches()
    }

    /// Clears the memory of a wall contact.
    fn forget(&self, candidate: u32) {
        self.impulses.set(candidate, Impulse::default());
        self.impacts.set(candidate, ImpactMemory::default());
    }
}
