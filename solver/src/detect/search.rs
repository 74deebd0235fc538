//! Search of one box: pairs of grains, and grains and faces of walls, that may come into contact before the next rebuild.

use super::grid::{CellGrid, Neighbourhood};
use super::reach::{Crowd, Row};
use super::{PairCandidate, WallCandidate};
use crate::lanes::{Kernel, LANES, Lanes, Slots, dot, minus};
use crate::partition::{DIRECTIONS, SAME_BOX};
use crate::wall::{PlacedFace, Pose, Walls, WallsAt};
use crate::world::{Body, Sphere, World};
use std::ops::Range;

/// Pairs found in a box; its buffers are reused.
#[derive(Clone, Debug, Default)]
pub(super) struct Found {
    /// Pairs.
    pub pairs: Vec<PairCandidate>,
    /// Direction of the box of each pair's second grain.
    pub directions: Vec<u8>,
    /// Number of pairs by direction.
    pub counts: [u32; DIRECTIONS],
    /// First index of the pairs of each direction in the list.
    pub targets: [u32; DIRECTIONS],
    /// Grains and faces, in the order of faces and grains.
    pub walls: Vec<WallCandidate>,
    /// Extra candidates among them, not near each other: the grain reaches the face within the step.
    pub beyond: Vec<WallCandidate>,
}

impl Found {
    /// Removes all pairs and walls.
    pub fn clear(&mut self) {
        self.pairs.clear();
        self.directions.clear();
        self.counts = [0; DIRECTIONS];
        self.walls.clear();
        self.beyond.clear();
    }

    /// Removes the pairs in other directions than those of a condition, and the walls if it does not hold for the box itself.
    pub fn keep(&mut self, is_kept: impl Fn(usize) -> bool) {
        let is_kept: [bool; DIRECTIONS] = std::array::from_fn(is_kept);
        let mut directions = self.directions.iter();
        self.pairs.retain(|_| directions.next().is_some_and(|&direction| is_kept[direction as usize]));
        self.directions.retain(|&direction| is_kept[direction as usize]);
        for (count, _) in self.counts.iter_mut().zip(is_kept).filter(|(_, is_kept)| !is_kept) {
            *count = 0;
        }
        if !is_kept[SAME_BOX] {
            self.walls.clear();
            self.beyond.clear();
        }
    }

    /// Adds grains and faces that are not near each other.
    pub fn add_beyond<'a>(&mut self, beyond: impl Iterator<Item = &'a WallCandidate>) {
        self.beyond.extend(beyond);
        self.walls.extend(&self.beyond);
        self.walls.sort_unstable_by_key(|one| (one.surface, one.body));
        self.walls.dedup();
    }

    /// Replaces each candidate of a mesh by its slots.
    pub fn add_slots(&mut self, walls: &Walls) {
        let slots = |one: &WallCandidate| walls.slots_of(one.surface);
        let all = self.walls.iter().map(slots).sum();
        let (listed, mut end) = (self.walls.len(), all);
        if all == listed {
            return;
        }
        self.walls.resize(all, WallCandidate { body: 0, surface: 0 });
        // From the end, so that no candidate is overwritten before it is read.
        for place in (0..listed).rev() {
            let one = self.walls[place];
            let first = end - slots(&one);
            self.walls[first..end].fill(one);
            end = first;
        }
    }

    pub fn memory_bytes(&self) -> usize {
        size_of::<Found>()
            + self.pairs.capacity() * size_of::<PairCandidate>()
            + self.directions.capacity()
            + (self.walls.capacity() + self.beyond.capacity()) * size_of::<WallCandidate>()
    }
}

/// Finds the candidate faces of walls for the grains of a box.
///
/// If requested, grains too fast for the step also find the faces on their path within the step.
pub(super) struct WallSearch<'a> {
    pub world: &'a World,
    pub walls: WallsAt<'a>,
    /// Skin of faces, m.
    pub skin: f64,
    /// Time step, s.
    pub step: f64,
    /// True if the search includes faces that grains reach within the step.
    pub look_ahead: bool,
}

impl WallSearch<'_> {
    /// Lists the candidates of the grains at these indices: face after face, and grain after grain.
    pub fn run(&self, places: Range<usize>, found: &mut Found) {
        found.walls.clear();
        found.beyond.clear();
        if places.is_empty() {
            return;
        }
        let crowd = Crowd::of(Row::of(self.world, places));
        for (wall, pose, faces) in self.walls.each_wall() {
            if self.walls.walls().is_mesh(wall) {
                self.search_mesh((wall, faces.start), pose, &crowd, found);
                continue;
            }
            if self.walls.has_index(wall) {
                self.search_index(wall, pose, &crowd, found);
                continue;
            }
            for surface in faces {
                let face = self.walls.face(surface);
                let ahead = self.ahead(&crowd, face.largest_speed(&crowd.centre, crowd.half));
                // Most faces are far from whole boxes.
                if !crowd.may_touch(&face, self.skin + ahead) {
                    continue;
                }
                for (grain, sphere, body) in crowd.grains() {
                    let candidate = WallCandidate { body: grain as u32, surface };
                    if face.distance(&sphere.centre) < sphere.radius + self.skin {
                        found.walls.push(candidate);
                    } else if ahead > 0.0 && self.is_swept(&face, sphere, body) {
                        found.walls.push(candidate);
                        found.beyond.push(candidate);
                    }
                }
            }
        }
    }

    /// Lists the candidates of a wall with a spatial index, which each grain queries for its own faces.
    fn search_index(&self, wall: u32, pose: &Pose, crowd: &Crowd<'_>, found: &mut Found) {
        let (start, beyond) = (found.walls.len(), found.beyond.len());
        let fast = self.ahead(crowd, pose.largest_speed(&crowd.centre, crowd.half)) > 0.0;
        for (grain, sphere, body) in crowd.grains() {
            let touch = sphere.radius + self.skin;
            let velocity = body.velocity.into();
            let path = if fast { pose.longest_path(&sphere.centre, &velocity, self.step) } else { 0.0 };
            let radius = touch.max(path + sphere.radius);
            self.walls.for_each_near_of(wall, &sphere.centre, radius, |surface, face| {
                let swept = || {
                    let ahead = self.ahead(crowd, face.largest_speed(&crowd.centre, crowd.half));
                    ahead > 0.0 && crowd.may_touch(face, self.skin + ahead) && self.is_swept(face, sphere, body)
                };
                let candidate = WallCandidate { body: grain as u32, surface };
                if face.distance(&sphere.centre) < touch {
                    found.walls.push(candidate);
                } else if fast && swept() {
                    found.walls.push(candidate);
                    found.beyond.push(candidate);
                }
            });
        }
        // Restore the order of a loop over all faces, and remove duplicate hits of the index.
        found.walls[start..].sort_unstable_by_key(|one| (one.surface, one.body));
        found.walls.dedup();
        found.beyond[beyond..].sort_unstable_by_key(|one| (one.surface, one.body));
        found.beyond.dedup();
    }

    /// Lists the grains near a mesh, each with the first face of the wall.
    fn search_mesh(&self, (wall, surface): (u32, u32), pose: &Pose, crowd: &Crowd<'_>, found: &mut Found) {
        let ahead = self.ahead(crowd, pose.largest_speed(&crowd.centre, crowd.half));
        if !self.walls.any_near_of(wall, &crowd.centre, crowd.reach(self.skin + ahead)) {
            return;
        }
        for (grain, sphere, body) in crowd.grains() {
            let candidate = WallCandidate { body: grain as u32, surface };
            if self.walls.any_near_of(wall, &sphere.centre, sphere.radius + self.skin) {
                found.walls.push(candidate);
            } else if ahead > 0.0 {
                let radius = pose.longest_path(&sphere.centre, &body.velocity.into(), self.step) + sphere.radius;
                let mut swept = false;
                self.walls.for_each_near_of(wall, &sphere.centre, radius, |_, face| {
                    swept |= self.is_swept(face, sphere, body);
                });
                if swept {
                    found.walls.push(candidate);
                    found.beyond.push(candidate);
                }
            }
        }
    }

    /// Path length of the grains towards a face of a speed (m/s) within a step, m; zero if no grain is too fast for the face.
    fn ahead(&self, crowd: &Crowd<'_>, speed: f64) -> f64 {
        if self.look_ahead { crowd.ahead(speed, self.step) } else { 0.0 }
    }

    fn is_swept(&self, face: &PlacedFace<'_>, sphere: &Sphere, body: &Body) -> bool {
        face.is_swept(&sphere.centre, sphere.radius, &body.velocity.into(), self.step)
    }
}

/// Reserves an eighth more pairs: doubling would waste memory that large scenes need.
#[cold]
#[inline(never)]
fn make_room(pairs: &mut Vec<PairCandidate>, directions: &mut Vec<u8>) {
    pairs.reserve_exact(pairs.len() / 8 + 32);
    directions.reserve_exact(pairs.capacity() - directions.len());
}

/// Finds the pairs of a box, eight neighbours of a grain at a time.
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
                let own_cutoff = L::splat(own.radius + self.skin);
                let own_cell = (grain + 1..neighbourhood.home.end, SAME_BOX);
                for (run, direction) in std::iter::once(&own_cell).chain(neighbourhood.runs()) {
                    for start in run.clone().step_by(LANES) {
                        let count = (run.end - start).min(LANES);
                        let places = std::array::from_fn(|lane| (start + lane.min(count - 1)) as u32);
                        let [x, y, z, radius]: [L; 4] = records.load_quads(&places);
                        let arm = minus([x, y, z], centre);
                        let arm = if PERIODIC { period.shortest(arm) } else { arm };
                        let cutoff = own_cutoff + radius;
                        let mut near = L::bits(dot(arm, arm).below(cutoff * cutoff)) & ((1 << count) - 1);
                        while near != 0 {
                            let other = start + near.trailing_zeros() as usize;
                            near &= near - 1;
                            // The grain with the smaller id comes first, in any memory order.
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
