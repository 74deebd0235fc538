//! The candidate list: pairs and grain-wall pairs that may touch before it is rebuilt, sorted by task.

use super::CellGrid;
use crate::partition::BoxGrid;
use crate::world::World;
use nalgebra::Vector3;

/// Two grains that may touch; the first has the smaller id.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct PairCandidate {
    /// First grain.
    pub first: u32,
    /// Second grain.
    pub second: u32,
}

/// A grain and a surface that may touch.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct WallCandidate {
    /// Grain.
    pub body: u32,
    /// Number of the surface in the world.
    pub surface: u32,
}

/// Impulse that a candidate bore in the last step, N s; the tangential part is a world vector.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Impulse {
    /// Normal impulse.
    pub normal: f64,
    /// Tangential impulse on the second body or on the wall.
    pub tangential: [f64; 3],
}

/// Candidates and the impulses remembered for them.
#[derive(Clone, Debug, Default)]
pub struct Candidates {
    /// Pairs of grains, task after task.
    pub pairs: Vec<PairCandidate>,
    /// Grains and surfaces, task after task.
    pub walls: Vec<WallCandidate>,
    /// Impulse of each pair.
    pub pair_impulses: Vec<Impulse>,
    /// Impulse of each grain and surface.
    pub wall_impulses: Vec<Impulse>,
    /// First pair of each task; one more entry than tasks.
    pub pair_tasks: Vec<u32>,
    /// First wall candidate of each task; one more entry than tasks.
    pub wall_tasks: Vec<u32>,
    /// Number of times that the list was built.
    pub rebuilds: u64,
    reference: Vec<Vector3<f64>>,
    built_at: f64,
    grid: CellGrid,
    found: Vec<(u32, PairCandidate)>,
    found_walls: Vec<(u32, WallCandidate)>,
    box_of: Vec<[u16; 3]>,
    remembered: Remembered,
}

/// Impulses carried over a rebuild, grouped by grain.
#[derive(Clone, Debug, Default)]
struct Remembered {
    start: Vec<u32>,
    entries: Vec<(u32, Impulse)>,
}

impl Candidates {
    /// Whether grains, or a grain and a wall, may have come closer by more than `skin` (m) since the list was built.
    pub fn are_stale(&self, world: &World, skin: f64) -> bool {
        if self.reference.len() != world.grains() || self.rebuilds == 0 {
            return true;
        }
        let mut largest = 0.0_f64;
        for (now, then) in world.positions.iter().zip(&self.reference) {
            largest = largest.max((now - then).norm_squared());
        }
        let shift = largest.sqrt();
        let reach = (world.domain.1 - world.domain.0).norm();
        let wall_shift = world
            .surfaces
            .iter()
            .map(|surface| surface.largest_shift(self.built_at, world.time, reach))
            .fold(0.0, f64::max);
        shift + shift.max(wall_shift) > skin
    }

    /// Builds the list anew, keeping the impulses of candidates that stay.
    pub fn rebuild(&mut self, world: &World, boxes: &BoxGrid, skin: f64) {
        let (largest, _) = world.largest_and_mean_radius();
        self.reference.clone_from(&world.positions);
        self.built_at = world.time;
        self.rebuilds += 1;
        self.box_of.clear();
        self.box_of.extend(world.positions.iter().map(|position| boxes.of(position)));

        self.grid.sort(&world.positions, &world.domain, 2.0 * largest + skin);
        self.found.clear();
        let (found, box_of) = (&mut self.found, &self.box_of);
        self.grid.for_each_pair(|a, b| {
            let (first, second) = (a.min(b), a.max(b));
            let (i, j) = (first as usize, second as usize);
            let reach = world.bodies[i].radius + world.bodies[j].radius + skin;
            if (world.positions[j] - world.positions[i]).norm_squared() < reach * reach {
                found.push((boxes.task(box_of[i], box_of[j]) as u32, PairCandidate { first, second }));
            }
        });
        let pair_key = |pair: &PairCandidate| (pair.first, pair.second);
        self.remembered.collect(world.grains(), &self.pairs, &self.pair_impulses, pair_key);
        sort_by_task(&self.found, boxes.tasks(), &mut self.pairs, &mut self.pair_tasks);
        self.remembered.recall(&self.pairs, &mut self.pair_impulses, pair_key);

        self.find_walls(world, boxes, skin);
        let wall_key = |wall: &WallCandidate| (wall.body, wall.surface);
        self.remembered.collect(world.grains(), &self.walls, &self.wall_impulses, wall_key);
        sort_by_task(&self.found_walls, boxes.tasks(), &mut self.walls, &mut self.wall_tasks);
        self.remembered.recall(&self.walls, &mut self.wall_impulses, wall_key);
    }

    pub(crate) fn memory_bytes(&self) -> usize {
        self.pairs.capacity() * size_of::<PairCandidate>()
            + self.walls.capacity() * size_of::<WallCandidate>()
            + (self.pair_impulses.capacity() + self.wall_impulses.capacity()) * size_of::<Impulse>()
            + self.found.capacity() * size_of::<(u32, PairCandidate)>()
            + self.found_walls.capacity() * size_of::<(u32, WallCandidate)>()
            + self.reference.capacity() * size_of::<Vector3<f64>>()
            + self.box_of.capacity() * size_of::<[u16; 3]>()
            + self.remembered.entries.capacity() * size_of::<(u32, Impulse)>()
            + (self.remembered.start.capacity() + self.pair_tasks.capacity() + self.wall_tasks.capacity())
                * size_of::<u32>()
            + self.grid.memory_bytes()
    }

    fn find_walls(&mut self, world: &World, boxes: &BoxGrid, skin: f64) {
        self.found_walls.clear();
        for (number, surface) in world.surfaces.iter().enumerate() {
            let pose = surface.at(world.time);
            for (grain, position) in world.positions.iter().enumerate() {
                if pose.nearest(position).0 < world.bodies[grain].radius + skin {
                    let here = self.box_of[grain];
                    let candidate = WallCandidate { body: grain as u32, surface: number as u32 };
                    self.found_walls.push((boxes.task(here, here) as u32, candidate));
                }
            }
        }
    }
}

/// Counting sort by task; keeps the order within a task.
fn sort_by_task<T: Copy>(found: &[(u32, T)], tasks: usize, sorted: &mut Vec<T>, start: &mut Vec<u32>) {
    start.clear();
    start.resize(tasks + 1, 0);
    for (task, _) in found {
        start[*task as usize + 1] += 1;
    }
    for task in 0..tasks {
        start[task + 1] += start[task];
    }
    sorted.clear();
    let Some((_, any)) = found.first() else {
        return;
    };
    sorted.resize(found.len(), *any);
    for (task, item) in found {
        let place = &mut start[*task as usize];
        sorted[*place as usize] = *item;
        *place += 1;
    }
    for task in (1..=tasks).rev() {
        start[task] = start[task - 1];
    }
    start[0] = 0;
}

impl Remembered {
    /// Groups the non-zero impulses of the old list by their first grain.
    fn collect<T>(&mut self, grains: usize, old: &[T], impulses: &[Impulse], key: impl Fn(&T) -> (u32, u32)) {
        self.start.clear();
        self.start.resize(grains + 1, 0);
        let live = || old.iter().zip(impulses).filter(|(_, impulse)| impulse.normal > 0.0);
        for (candidate, _) in live() {
            self.start[key(candidate).0 as usize + 1] += 1;
        }
        for grain in 0..grains {
            self.start[grain + 1] += self.start[grain];
        }
        self.entries.clear();
        self.entries.resize(self.start[grains] as usize, (0, Impulse::default()));
        for (candidate, impulse) in live() {
            let (first, second) = key(candidate);
            let place = &mut self.start[first as usize];
            self.entries[*place as usize] = (second, *impulse);
            *place += 1;
        }
        for grain in (1..=grains).rev() {
            self.start[grain] = self.start[grain - 1];
        }
        self.start[0] = 0;
    }

    /// Gives the new list its impulses back.
    fn recall<T>(&self, new: &[T], impulses: &mut Vec<Impulse>, key: impl Fn(&T) -> (u32, u32)) {
        impulses.clear();
        impulses.extend(new.iter().map(|candidate| {
            let (first, second) = key(candidate);
            let own = &self.entries[self.start[first as usize] as usize..self.start[first as usize + 1] as usize];
            own.iter().find(|entry| entry.0 == second).map_or_else(Impulse::default, |entry| entry.1)
        }));
    }
}
