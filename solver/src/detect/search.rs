//! The search of one box: pairs of grains and grains at walls that are within reach.

use super::grid::{CellGrid, Neighbourhood};
use super::{PairCandidate, WallCandidate};
use crate::lanes::{Kernel, LANES, Lanes, Slots, dot, minus};
use crate::partition::{DIRECTIONS, SAME_BOX};
use crate::world::{Pose, World};
use nalgebra::Vector3;

/// What a box found; its buffers are kept from one search to the next.
#[derive(Clone, Debug, Default)]
pub(super) struct Found {
    /// Pairs.
    pub pairs: Vec<PairCandidate>,
    /// Direction of the box of each pair's second grain.
    pub directions: Vec<u8>,
    /// Number of pairs by direction.
    pub counts: [u32; DIRECTIONS],
    /// Where the pairs of each direction go in the list.
    pub targets: [u32; DIRECTIONS],
    /// Grains and surfaces.
    pub walls: Vec<WallCandidate>,
}

/// How far grains look for walls.
#[derive(Clone, Copy, Debug)]
pub(super) struct WallReach {
    /// Beyond touch, m.
    pub skin: f64,
    /// Time step, s.
    pub step: f64,
}

impl Found {
    pub fn memory_bytes(&self) -> usize {
        size_of::<Found>()
            + self.pairs.capacity() * size_of::<PairCandidate>()
            + self.directions.capacity()
            + self.walls.capacity() * size_of::<WallCandidate>()
    }

    /// Finds the surfaces within reach of the grains of a box.
    ///
    /// A grain too fast for the step also finds what it meets within the step.
    pub fn search_walls(&mut self, world: &World, grid: &CellGrid, poses: &[Pose], number: usize, reach: WallReach) {
        let WallReach { skin, step } = reach;
        self.walls.clear();
        let places = grid.grains_of_box(number);
        if places.is_empty() {
            return;
        }
        // Whole boxes are far from most surfaces.
        let spheres = &world.spheres[places.clone()];
        let first = world.wrapped(&spheres[0].centre);
        let (mut low, mut high, mut radius) = (first, first, 0.0_f64);
        for sphere in spheres {
            let centre = world.wrapped(&sphere.centre);
            low = low.inf(&centre);
            high = high.sup(&centre);
            radius = radius.max(sphere.radius);
        }
        let (centre, half): (Vector3<f64>, _) = ((low + high) * 0.5, (high - low).norm() * 0.5);
        let bodies = &world.bodies[places.clone()];
        let fastest = bodies.iter().map(|body| Vector3::from(body.velocity).norm()).fold(0.0, f64::max);
        for (surface, pose) in poses.iter().enumerate() {
            let way = (fastest + pose.largest_speed(pose.pivot_distance(&centre) + half)) * step;
            let ahead = if way > radius { way } else { 0.0 };
            if !pose.may_be_within(&centre, (half + radius + skin + ahead) * (1.0 + 1e-9)) {
                continue;
            }
            for ((grain, sphere), body) in places.clone().zip(spheres).zip(bodies) {
                let meets = || pose.met_on_the_way(sphere, &body.velocity.into(), step).is_some();
                if pose.distance(&sphere.centre) < sphere.radius + skin || (ahead > 0.0 && meets()) {
                    self.walls.push(WallCandidate { body: grain as u32, surface: surface as u32 });
                }
            }
        }
    }
}

/// Makes room for an eighth more pairs: doubling would waste memory that large scenes need.
#[cold]
#[inline(never)]
fn make_room(pairs: &mut Vec<PairCandidate>, directions: &mut Vec<u8>) {
    pairs.reserve_exact(pairs.len() / 8 + 32);
    directions.reserve_exact(pairs.capacity() - directions.len());
}

/// Finds the pairs of a box: eight neighbours of a grain at a time.
pub(super) struct PairSearch<'a, const PERIODIC: bool> {
    pub world: &'a World,
    pub grid: &'a CellGrid,
    pub number: usize,
    pub skin: f64,
    pub found: &'a mut Found,
}

impl<const PERIODIC: bool> Kernel for PairSearch<'_, PERIODIC> {
    type Output = ();

    #[inline(always)]
    fn run<L: Lanes>(self) {
        let World { spheres, ids, period, .. } = self.world;
        let Found { pairs, directions, counts, .. } = self.found;
        pairs.clear();
        directions.clear();
        *counts = [0; DIRECTIONS];
        let records = Slots::of(spheres);
        let surroundings = self.grid.surroundings(self.number);
        let mut neighbourhood = Neighbourhood::default();
        for cell in 0..self.grid.cells_of_box() {
            self.grid.neighbourhood(&surroundings, cell, &mut neighbourhood);
            for grain in neighbourhood.home.clone() {
                let own = &spheres[grain];
                let centre = [own.centre.x, own.centre.y, own.centre.z].map(L::splat);
                let own_reach = L::splat(own.radius + self.skin);
                let own_cell = (grain + 1..neighbourhood.home.end, SAME_BOX);
                for (run, direction) in std::iter::once(&own_cell).chain(neighbourhood.runs()) {
                    for start in run.clone().step_by(LANES) {
                        let count = (run.end - start).min(LANES);
                        let places = std::array::from_fn(|lane| (start + lane.min(count - 1)) as u32);
                        let [x, y, z, radius]: [L; 4] = records.load_quads(&places);
                        let arm = minus([x, y, z], centre);
                        let arm = if PERIODIC { period.shortest(arm) } else { arm };
                        let reach = own_reach + radius;
                        let mut near = L::bits(dot(arm, arm).below(reach * reach)) & ((1 << count) - 1);
                        while near != 0 {
                            let other = start + near.trailing_zeros() as usize;
                            near &= near - 1;
                            // The grain with the smaller id comes first, wherever the two lie in memory.
                            let (first, second) = if ids[grain] < ids[other] { (grain, other) } else { (other, grain) };
                            let pair = PairCandidate { first: first as u32, second: second as u32 };
                            if pairs.len() == pairs.capacity() {
                                make_room(pairs, directions);
                            }
                            pairs.push(pair);
                            directions.push(*direction as u8);
                            counts[*direction] += 1;
                        }
                    }
                }
            }
        }
    }
}
