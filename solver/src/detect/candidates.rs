//! Candidate list: grain pairs and grain-wall pairs that may come into contact before the next rebuild, sorted by task.

use super::CellGrid;
use super::drift::{Drift, Moved};
use super::memory::{AngularImpulse, ContactImpulses, Impulse, MemoryOfTask};
use super::memory::{OldList, Remembered, resize};
use super::reach::{Row, for_each_on_the_way};
use super::search::{Found, PairSearch, WallSearch};
use crate::groups::ImpactMemory;
use crate::lanes::{Available, LANES};
use crate::partition::{BoxGrid, ByCandidates, DIRECTIONS, DRIVEN_STAGE, Layout, Plan, PlannedTask, Ranks};
use crate::schedule::{Disjoint, Each, Phase, Team};
use crate::surface::NearPart;
use crate::wall::Pose;
use crate::world::{GONE, Moves, World, chunk, chunks};
use nalgebra::Vector3;
use serde::{Deserialize, Serialize};
use std::ops::Range;
use std::sync::Mutex;

/// Skin of the list for walls over its skin for grains. Grains drift together, but not with the walls.
const WALL_SKINS: f64 = 4.0;

/// Number of pair blocks whose impulses are located before the first of them are read.
const BLOCKS: usize = 8;

/// Body indices of two grains that may come into contact; the first grain has the smaller id.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(C)]
pub struct PairCandidate {
    /// First grain.
    pub first: u32,
    /// Second grain.
    pub second: u32,
}

/// Body index of a grain, and a surface that may come into contact; for a mesh, a slot for a contact: see `wall/contacts.rs`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[repr(C)]
pub struct WallCandidate {
    /// Grain.
    pub body: u32,
    /// Number of the surface in the world.
    pub surface: u32,
}

/// Candidates and their stored impulses.
#[derive(Clone, Debug)]
pub struct Candidates {
    /// Pairs of grains, ordered by task.
    pub pairs: Vec<PairCandidate>,
    /// Grains and surfaces, ordered by task.
    pub walls: Vec<WallCandidate>,
    /// Faces near the grains at meshes, in parts by wall candidate; empty without meshes.
    near: Vec<NearPart>,
    /// Impulses of the last step.
    pub impulses: ContactImpulses,
    /// Number of times that the list was built.
    pub rebuilds: u64,
    torques: bool,
    skin: f64,
    /// Gap below which candidates matter before contact, m.
    range: f64,
    step: f64,
    grid: CellGrid,
    largest_diameter: f64,
    reference: Vec<Vector3<f64>>,
    built_at: f64,
    /// See [`Candidates::beyond`].
    beyond: Vec<(u32, u32)>,
    drift: Drift,
    buffers: Buffers,
}

/// Pairs without impulses, for reading while a step writes the impulses and the faces of slots.
#[derive(Clone, Copy)]
pub(crate) struct CandidateList<'a> {
    /// Pairs of grains, ordered by task.
    pub pairs: &'a [PairCandidate],
    /// Number of times that the list was built.
    pub rebuilds: u64,
    grid: &'a CellGrid,
}

impl CandidateList<'_> {
    /// Body indices of the grains of a box, as of the last build.
    pub fn grains_of_box(&self, number: usize) -> Range<usize> {
        self.grid.grains_of_box(number)
    }
}

/// Buffers of a rebuild.
#[derive(Clone, Debug, Default)]
struct Buffers {
    new_places: Vec<u32>,
    found: Vec<Found>,
    pair_starts: Vec<u32>,
    wall_starts: Vec<u32>,
    poses: Vec<Pose>,
    remembered_pairs: Remembered,
    remembered_walls: Remembered,
}

impl Candidates {
    /// Creates an empty list for boxes that were chosen for the given number of grains; `skin` in m, `step` in s; `torques` if
    /// contacts transmit torques.
    pub fn new(boxes: &BoxGrid, world: &World, grains: usize, skin: f64, step: f64, torques: bool) -> Candidates {
        let (largest_radius, _) = world.largest_and_mean_radius();
        let range = world.range_of_cohesion();
        let skin = skin + range;
        Candidates {
            pairs: Vec::new(),
            walls: Vec::new(),
            near: Vec::new(),
            impulses: ContactImpulses::default(),
            torques,
            rebuilds: 0,
            skin,
            range,
            step,
            grid: CellGrid::new(boxes, grains, 2.0 * largest_radius + skin),
            largest_diameter: 2.0 * largest_radius,
            reference: Vec::new(),
            built_at: 0.0,
            beyond: Vec::new(),
            drift: Drift::default(),
            buffers: Buffers::default(),
        }
    }

    /// Enables or disables the storage of angular impulses, initially zero.
    pub(crate) fn bear_torques(&mut self, torques: bool) {
        self.torques = torques;
        self.impulses.pairs.resize(self.pairs.len(), torques);
        self.impulses.walls.resize(self.walls.len(), torques);
    }

    /// Returns the centres of the grains in memory order (m) and the simulated time (s) at the last build; `None` without a list.
    pub(crate) fn built_from(&self) -> Option<(&[Vector3<f64>], f64)> {
        (self.rebuilds > 0).then_some((&self.reference, self.built_at))
    }

    /// Returns the number of grains that the boxes were chosen for.
    pub(crate) fn boxes_for(&self) -> usize {
        self.grid.chosen_for()
    }

    /// Moves the list to the new places of the grains, after grains of a world have come and gone, and forgets the impulses of
    /// those that are gone; a rebuild must follow. Chooses new boxes if the number of grains has doubled or halved since.
    pub(crate) fn change(&mut self, moves: &Moves, world: &World) {
        let moved = |place: &mut u32| {
            let to = moves.places[*place as usize];
            *place = if to == GONE { 0 } else { to };
            to != GONE
        };
        for (candidate, pair) in self.pairs.iter_mut().enumerate() {
            if !(moved(&mut pair.first) & moved(&mut pair.second)) {
                self.impulses.pairs.set(candidate, Impulse::default(), ImpactMemory::default(), [0.0; 3]);
            }
        }
        for (candidate, wall) in self.walls.iter_mut().enumerate() {
            if !moved(&mut wall.body) {
                self.impulses.walls.set(candidate, Impulse::default(), ImpactMemory::default(), [0.0; 3]);
            }
        }
        let (grains, before) = (world.grains(), self.boxes_for());
        if grains > 2 * before || 2 * grains < before {
            let (largest, _) = world.largest_and_mean_radius();
            let boxes = BoxGrid::new(&world.domain, &world.period, grains, largest, self.skin);
            self.grid = CellGrid::new(&boxes, grains, 2.0 * largest + self.skin);
        }
    }

    /// Returns the largest possible number of boxes of the domain for this number of grains.
    pub(crate) fn most_boxes(&self) -> usize {
        self.grid.boxes().most()
    }

    /// Splits into the pairs, the wall candidates with the faces near them, and the impulses of both.
    pub(crate) fn split(
        &mut self,
    ) -> (CandidateList<'_>, (&mut [WallCandidate], &mut [NearPart]), &mut ContactImpulses) {
        let Candidates { pairs, walls, near, rebuilds, grid, impulses, .. } = self;
        (CandidateList { pairs, rebuilds: *rebuilds, grid }, (walls, near), impulses)
    }

    /// Returns true if a grain may have come into contact with a grain or a wall outside the list; each of `ranks` checks its boxes.
    pub(crate) fn are_stale(&mut self, world: &World, ranks: Option<&Ranks>, team: &Team) -> bool {
        if self.rebuilds == 0 || self.reference.len() != world.grains() {
            return true;
        }
        let diagonal = (world.domain.1 - world.domain.0).norm();
        let wall_shift = world.walls.largest_shift(self.built_at, world.time, diagonal);
        let spheres = &world.spheres[..world.grains()];
        let far = self.grid.patch_width() - self.largest_diameter;
        let (skin, range) = (self.skin, self.range);
        let is_too_far = |moved: Moved| {
            moved.approach > skin - range
                || 2.0 * moved.shift > far
                || moved.shift + wall_shift > WALL_SKINS * skin - range
        };
        match ranks {
            None => self.drift.is_too_far(&self.grid, spheres, &self.reference, team, |_| true, is_too_far),
            Some(ranks) => {
                let owns = |number: usize| ranks.owns(number);
                ranks.any(self.drift.is_too_far(&self.grid, spheres, &self.reference, team, owns, is_too_far))
            }
        }
    }

    /// Returns true if a grain that is too fast for the step has a wall on its path that is not in the list. With `ranks`, the list has
    /// the grains of this rank alone.
    pub(crate) fn miss_a_wall(&self, world: &World, ranks: Option<&Ranks>, team: &Team) -> bool {
        let poses: Vec<Pose> = world.walls.poses_over(world.time, self.step).collect();
        let (walls, met) = (world.walls.placed(&poses), Mutex::new(Vec::new()));
        team.each(Phase::Detect, chunks(world.grains()), |number| {
            let mut own = Vec::new();
            let row = Row::of(world, chunk(number, world.grains()));
            for_each_on_the_way(row, &walls, self.step, |(place, sphere, body), (surface, face)| {
                if face.is_swept(&sphere.centre, sphere.radius, &body.velocity.into(), self.step) {
                    own.push((place as u32, world.walls.listed(surface)));
                }
            });
            met.lock().expect("no task panics while it looks").extend(own);
        });
        let mut met = met.into_inner().expect("no task panics while it looks");
        if met.is_empty() {
            return false;
        }
        if let Some(ranks) = ranks {
            let boxes_of = self.boxes_of_grains();
            met.retain(|&(place, _)| ranks.owns(boxes_of[place as usize] as usize));
        }
        met.sort_unstable();
        met.dedup();
        let mut known: Vec<(u32, u32)> =
            self.walls.iter().map(|wall| (wall.body, world.walls.listed(wall.surface))).collect();
        known.retain(|wall| met.binary_search(wall).is_ok());
        // A grain near a mesh has several candidates.
        known.dedup();
        known.len() < met.len()
    }

    /// Sorts the grains by boxes and cells, rebuilds the list and plans its tasks. Impulses of persistent candidates are carried
    /// over.
    pub fn rebuild(&mut self, world: &mut World, layout: &mut Layout, set: Available, team: &Team) {
        self.build(world, layout, set, team, None);
    }

    /// Rebuilds a stored list, given the grains and walls at its build and its [extra](Candidates::beyond) candidates. Returns
    /// `None` if these are not valid candidates.
    pub(crate) fn restore(
        &mut self,
        world: &mut World,
        layout: &mut Layout,
        set: Available,
        team: &Team,
        beyond: &[(u32, u32)],
    ) -> Option<()> {
        let known = beyond
            .iter()
            .all(|&(id, surface)| (id as usize) < world.grains() && (surface as usize) < world.walls.faces());
        known.then(|| self.build(world, layout, set, team, Some(beyond)))
    }

    /// Returns the extra candidates, which were not near each other at the build: grains too fast for the step reach these
    /// surfaces within the step. Sorted by grain id and surface number.
    pub(crate) fn beyond(&self) -> &[(u32, u32)] {
        &self.beyond
    }

    fn build(
        &mut self,
        world: &mut World,
        layout: &mut Layout,
        set: Available,
        team: &Team,
        beyond: Option<&[(u32, u32)]>,
    ) {
        let order = self.grid.sort(world, team);
        world.reorder(order, team);
        let new_places = &mut self.buffers.new_places;
        team.alone(Phase::Detect, || {
            new_places.resize(order.len(), 0);
            for (new, &old) in order.iter().enumerate() {
                new_places[old as usize] = new as u32;
            }
        });
        world.add_dummies(self.grid.boxes().boxes());
        self.remember(world.grains(), &layout.plan, team);
        let mut ranks = layout.ranks.take();
        if let Some(ranks) = &mut ranks {
            ranks.divide(self.grid.boxes(), |number| self.grid.grains_of_box(number).len());
            self.pass_on_impulses(ranks);
        }
        self.search(world, set, team, beyond, ranks.as_ref());
        layout.replan(self.grid.boxes().tasks(), |plan| self.plan(plan, team));
        self.fill(world, &layout.plan, team);
        if let Some(ranks) = &mut ranks {
            self.link(ranks, &layout.plan, world);
        }
        layout.ranks = ranks;
        team.alone(Phase::Detect, || {
            self.reference.clear();
            self.reference.extend(world.spheres[..world.grains()].iter().map(|sphere| sphere.centre));
        });
        world.walls.enter_list();
        self.built_at = world.time;
        self.rebuilds += 1;
    }

    /// Stores the impulses of the old list by the grains' new indices.
    fn remember(&mut self, grains: usize, plan: &Plan, team: &Team) {
        let Buffers { new_places, remembered_pairs, remembered_walls, .. } = &mut self.buffers;
        let (pairs, walls, places) = (&self.pairs, &self.walls, &*new_places);
        let key = |candidate: usize| {
            let PairCandidate { first, second } = pairs[candidate];
            (places[first as usize], places[second as usize])
        };
        let of_task = |task: &PlannedTask| task.named(&self.impulses.borne);
        let memory = &self.impulses.pairs;
        remembered_pairs.collect(grains, &OldList { key, of_task, memory, plan }, team);
        let key = |candidate: usize| (places[walls[candidate].body as usize], walls[candidate].surface);
        let of_task = |task: &PlannedTask| task.walls.start as usize..task.walls.end as usize;
        let memory = &self.impulses.walls;
        remembered_walls.collect(grains, &OldList { key, of_task, memory, plan }, team);
    }

    /// Searches the pairs and walls of each box. Walls on the paths of fast grains depend on velocities: the search includes
    /// them, unless those of a stored list are given.
    fn search(
        &mut self,
        world: &World,
        set: Available,
        team: &Team,
        beyond: Option<&[(u32, u32)]>,
        ranks: Option<&Ranks>,
    ) {
        let look_ahead = beyond.is_none();
        let mut given = Vec::new();
        if let Some(beyond) = beyond.filter(|beyond| !beyond.is_empty()) {
            let mut place_of = vec![0; world.grains()];
            (0..).zip(&world.ids).for_each(|(place, &id)| place_of[id as usize] = place);
            given.extend(beyond.iter().map(|&(id, surface)| WallCandidate { body: place_of[id as usize], surface }));
        }
        let Buffers { found, poses, .. } = &mut self.buffers;
        poses.clear();
        poses.extend(world.walls.poses_over(world.time, self.step));
        let boxes = self.grid.boxes().boxes();
        found.resize_with(boxes, Found::default);
        let (grid, skin) = (&self.grid, self.skin);
        let (wall_skin, step, walls) = (WALL_SKINS * skin, self.step, world.walls.placed(poses));
        team.each_with(Phase::Detect, boxes, Each::of(found), |number, found| {
            let places = grid.grains_of_box(number);
            let is_wanted = |direction: usize| {
                ranks.is_none_or(|ranks| grid.boxes().home(number, direction).is_some_and(|home| ranks.owns(home)))
            };
            if !(0..DIRECTIONS).any(is_wanted) {
                return found.clear();
            }
            WallSearch { world, walls, skin: wall_skin, step, look_ahead }.run(places.clone(), found);
            if !look_ahead {
                found.add_beyond(given.iter().filter(|one| places.contains(&(one.body as usize))));
            }
            found.add_slots(&world.walls);
            match world.period.any() {
                true => set.run(PairSearch::<true> { world, grid, number, skin, found }),
                false => set.run(PairSearch::<false> { world, grid, number, skin, found }),
            }
            if ranks.is_some() {
                found.keep(is_wanted);
            }
        });
        self.beyond.clear();
        let beyond = self.buffers.found.iter().flat_map(|found| &found.beyond);
        self.beyond.extend(beyond.map(|one| (world.ids[one.body as usize], one.surface)));
        self.beyond.sort_unstable();
    }

    /// Number of the box of each grain, as of the last build.
    fn boxes_of_grains(&self) -> Vec<u32> {
        let boxes = 0..self.grid.boxes().boxes();
        boxes.flat_map(|number| self.grid.grains_of_box(number).map(move |_| number as u32)).collect()
    }

    /// Sends the impulses of the old list to the ranks that have their contacts from now on.
    fn pass_on_impulses(&mut self, ranks: &mut Ranks) {
        // After a change of stage, every rank has all impulses.
        if std::mem::take(&mut ranks.complete) {
            return;
        }
        let (box_of, grid) = (self.boxes_of_grains(), self.grid.boxes());
        let box_of = |place: u32| box_of[place as usize] as usize;
        // Contacts of a box amid boxes of this rank stay here.
        let is_amid = |number: usize| grid.around(number).iter().flatten().all(|&beside| ranks.owns(beside));
        let stays: Vec<bool> = (0..grid.boxes()).map(is_amid).collect();
        // Around a short period, two boxes are neighbours in several directions.
        let of_pair = |[first, second]: [u32; 2], give: &mut dyn FnMut(usize)| {
            if stays[box_of(first)] {
                return;
            }
            for (direction, beside) in grid.around(box_of(first)).into_iter().enumerate() {
                if beside == Some(box_of(second)) {
                    grid.home(box_of(first), direction).into_iter().for_each(|home| give(ranks.owner(home)));
                }
            }
        };
        let Buffers { remembered_pairs, remembered_walls, .. } = &mut self.buffers;
        remembered_pairs.pass_on(ranks, self.torques, of_pair);
        remembered_walls.pass_on(ranks, self.torques, |[first, _], give| give(ranks.owner(box_of(first))));
    }

    /// Links a plan of this rank's tasks to those of the other ranks.
    fn link(&self, ranks: &mut Ranks, plan: &Plan, world: &World) {
        let bodies_of = |stage: usize, task: &PlannedTask, visit: &mut dyn FnMut(u32)| {
            let walls = &self.walls[task.walls.start as usize..task.walls.end as usize];
            if stage == DRIVEN_STAGE {
                let driven = walls.iter().filter(|wall| world.drive_of(wall.surface).is_some());
                return driven.for_each(|wall| visit(wall.body));
            }
            walls.iter().for_each(|wall| visit(wall.body));
            for PairCandidate { first, second } in &self.pairs[task.pairs.start as usize..task.pairs.end as usize] {
                visit(*first);
                visit(*second);
            }
        };
        ranks.link(plan, self.grid.boxes(), |number| self.grid.grains_of_box(number), bodies_of);
    }

    /// Divides a complete list among ranks: the plan keeps the tasks of this rank.
    pub(crate) fn divide(&self, layout: &mut Layout, world: &World) {
        let Layout { plan, ranks: Some(ranks), .. } = layout else { return };
        if self.rebuilds == 0 {
            return;
        }
        ranks.divide(self.grid.boxes(), |number| self.grid.grains_of_box(number).len());
        plan.keep(|home| ranks.owns(home));
        ranks.complete = false;
        self.link(ranks, plan, world);
    }

    /// Counts the candidates of each task and computes their offsets in the list.
    fn plan(&mut self, plan: &mut Plan, team: &Team) {
        let (boxes, grid) = (self.grid.boxes(), &self.grid);
        let Buffers { found, pair_starts, wall_starts, .. } = &mut self.buffers;
        team.alone(Phase::Detect, || {
            pair_starts.clear();
            pair_starts.resize(boxes.tasks() + 1, 0);
            wall_starts.clear();
            wall_starts.push(0);
            for (number, found) in found.iter().enumerate() {
                for direction in (0..DIRECTIONS).filter(|&direction| found.counts[direction] > 0) {
                    let task = grid.task(number, direction);
                    pair_starts[task + 1] += found.counts[direction];
                }
                wall_starts.push(wall_starts[number] + found.walls.len() as u32);
            }
            for task in 0..boxes.tasks() {
                pair_starts[task + 1] += pair_starts[task];
            }
            plan.set(pair_starts, wall_starts);
            // From here on, the starts advance as candidates are stored.
            for (number, found) in found.iter_mut().enumerate() {
                for direction in (0..DIRECTIONS).filter(|&direction| found.counts[direction] > 0) {
                    let task = grid.task(number, direction);
                    found.targets[direction] = pair_starts[task];
                    pair_starts[task] += found.counts[direction];
                }
            }
        });
    }

    /// Writes the list, and restores the impulses of persistent candidates.
    fn fill(&mut self, world: &World, plan: &Plan, team: &Team) {
        let count = |of: fn(&Found) -> usize| self.buffers.found.iter().map(of).sum();
        let (pairs, walls): (usize, usize) = (count(|found| found.pairs.len()), count(|found| found.walls.len()));
        resize(&mut self.pairs, pairs, PairCandidate { first: 0, second: 0 });
        resize(&mut self.walls, walls, WallCandidate { body: 0, surface: 0 });
        self.near.clear();
        resize(&mut self.near, if world.walls.any_mesh() { walls } else { 0 }, NearPart::default());
        self.bear_torques(self.torques);
        resize(&mut self.impulses.borne, plan.blocks(), 0);
        let Buffers { found, wall_starts, remembered_pairs, remembered_walls, .. } = &mut self.buffers;
        let (pair_parts, wall_parts) = (Disjoint::new(&mut self.pairs), Disjoint::new(&mut self.walls));
        team.each(Phase::Detect, found.len(), |number| {
            let found = &found[number];
            let mut targets = found.targets;
            for (&direction, &pair) in found.directions.iter().zip(&found.pairs) {
                let target = &mut targets[direction as usize];
                // SAFETY: each box has its own range of indices in the list.
                *unsafe { pair_parts.at(*target as usize) } = pair;
                *target += 1;
            }
            let start = wall_starts[number] as usize;
            // SAFETY: as above.
            unsafe { wall_parts.range(start..start + found.walls.len()) }.copy_from_slice(&found.walls);
        });
        let (pairs, walls) = (&self.pairs, ByCandidates::of(&mut self.walls));
        let torques = self.torques;
        plan.run_all(team, Phase::Detect, (self.impulses.shares(), walls), |_, task, ((impulses, borne), walls)| {
            let [pair_memory, wall_memory] = impulses.map(MemoryOfTask::from);
            let range = task.pairs.start as usize..task.pairs.end as usize;
            for ((first, pairs), borne) in range
                .clone()
                .step_by(BLOCKS * LANES)
                .zip(pairs[range].chunks(BLOCKS * LANES))
                .zip(borne.chunks_mut(BLOCKS))
            {
                // First locate the impulses of some pairs, then load them: the loads have a long latency.
                let (mut found, mut count) = ([(0, 0); BLOCKS * LANES], 0);
                borne.fill(0);
                for (place, pair) in pairs.iter().enumerate() {
                    if let Some(known) = remembered_pairs.find((pair.first, pair.second)) {
                        borne[place / LANES] |= 1 << (place % LANES);
                        found[count] = (first + place, known);
                        count += 1;
                    }
                }
                for &(candidate, known) in &found[..count] {
                    give(remembered_pairs.recall(known), candidate, &pair_memory, torques);
                }
            }
            let (mut slot, mut last) = (0, None);
            for candidate in task.walls.clone() {
                let wall = walls.get(candidate);
                slot = if last == Some(wall) { slot + 1 } else { 0 };
                last = Some(wall);
                let known = match world.walls.mesh_of(wall.surface) {
                    None => remembered_walls.find((wall.body, wall.surface)),
                    // The contacts of a grain with a mesh keep their order.
                    Some(mesh) => {
                        let of_mesh = |face| world.walls.mesh_of(face) == Some(mesh);
                        remembered_walls.find_nth(wall.body, of_mesh, slot).map(|(place, surface)| {
                            walls.set(candidate, WallCandidate { surface, ..wall });
                            place
                        })
                    }
                };
                let borne = known.map(|place| remembered_walls.recall(place)).unwrap_or_default();
                give(borne, candidate as usize, &wall_memory, torques);
            }
        });
    }

    /// Finds the active pairs after impulses were written outside of a step.
    pub(crate) fn find_borne(&mut self, plan: &Plan) {
        self.impulses.borne.clear();
        for task in plan.tasks() {
            let range = task.pairs.start as usize..task.pairs.end as usize;
            let memory = &self.impulses.pairs;
            self.impulses.borne.extend(range.clone().step_by(LANES).map(|block| {
                let known = (block..range.end.min(block + LANES)).map(|candidate| memory.is_known(candidate));
                known.enumerate().map(|(lane, known)| u8::from(known) << lane).sum::<u8>()
            }));
        }
    }

    pub(crate) fn memory_bytes(&self) -> usize {
        let buffers = &self.buffers;
        self.pairs.capacity() * size_of::<PairCandidate>()
            + self.walls.capacity() * size_of::<WallCandidate>()
            + self.near.capacity() * size_of::<NearPart>()
            + self.impulses.pairs.memory_bytes()
            + self.impulses.borne.capacity()
            + self.impulses.walls.memory_bytes()
            + self.reference.capacity() * size_of::<Vector3<f64>>()
            + self.beyond.capacity() * size_of::<(u32, u32)>()
            + self.grid.memory_bytes()
            + buffers.found.iter().map(Found::memory_bytes).sum::<usize>()
            + buffers.remembered_pairs.memory_bytes()
            + buffers.remembered_walls.memory_bytes()
            + self.drift.memory_bytes()
            + (buffers.new_places.capacity() + buffers.pair_starts.capacity() + buffers.wall_starts.capacity())
                * size_of::<u32>()
    }
}

/// Sets the previous impulse and the current impact of a candidate.
#[inline(always)]
fn give(
    (impulse, impact, torque): (Impulse, ImpactMemory, AngularImpulse),
    candidate: usize,
    memory: &MemoryOfTask<'_>,
    torques: bool,
) {
    memory.impulses.set(candidate as u32, impulse);
    memory.impacts.set(candidate as u32, impact);
    if torques {
        memory.torques.set(candidate as u32, torque);
    }
}
