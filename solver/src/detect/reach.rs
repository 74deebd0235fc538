//! Bounding balls of blocks of grains: most grains are far from most walls. A face farther from the middle of a block than
//!
//! ```text
//! R + r + s + h (u + w)     R: half the diagonal of the block's centres, r: largest radius, s: skin, h: step,
//!                           u: largest speed of a grain, w: largest speed of the face within R of the middle
//! ```
//!
//! stays outside the skin of all grains of the block, for any direction of motion in the step.

use crate::laws::period::Period;
use crate::wall::{PlacedFace, WallsAt};
use crate::world::{Body, Sphere, World};
use nalgebra::Vector3;
use std::ops::Range;

type Vector = Vector3<f64>;

/// Grains of a block, which are adjacent in memory and so in space.
const BLOCK: usize = 64;

/// Largest rounding error of a distance, relative to the compared length.
const SLACK: f64 = 1e-9;

/// Consecutive grains in memory.
#[derive(Clone, Copy)]
pub(crate) struct Row<'a> {
    /// Body index of the first grain.
    pub first: usize,
    pub spheres: &'a [Sphere],
    pub bodies: &'a [Body],
    /// Periodic axes, and the lower corner of the domain, m.
    pub period: &'a Period,
    pub low: &'a Vector,
}

impl<'a> Row<'a> {
    pub fn of(world: &'a World, places: Range<usize>) -> Row<'a> {
        let (spheres, bodies) = (&world.spheres[places.clone()], &world.bodies[places.clone()]);
        Row { first: places.start, spheres, bodies, period: &world.period, low: &world.domain.0 }
    }

    fn blocks(self) -> impl Iterator<Item = Row<'a>> {
        let blocks = self.spheres.chunks(BLOCK).zip(self.bodies.chunks(BLOCK));
        (self.first..).step_by(BLOCK).zip(blocks).map(move |(first, (spheres, bodies))| Row {
            first,
            spheres,
            bodies,
            ..self
        })
    }

    /// Index, sphere and body of each grain.
    fn grains(&self) -> impl Iterator<Item = (usize, &'a Sphere, &'a Body)> + use<'a> {
        let grains = (self.first..).zip(self.spheres).zip(self.bodies);
        grains.map(|((place, sphere), body)| (place, sphere, body))
    }
}

/// Block of grains.
pub(super) struct Crowd<'a> {
    row: Row<'a>,
    /// Middle of a ball around their centres, and its radius, m.
    pub centre: Vector,
    pub half: f64,
    /// Largest radius, m.
    radius: f64,
    /// Largest speed, m/s.
    fastest: f64,
}

impl<'a> Crowd<'a> {
    /// Bounds the grains of a row with at least one grain.
    pub fn of(row: Row<'a>) -> Crowd<'a> {
        let wrapped = |sphere: &Sphere| row.period.wrapped(&sphere.centre, row.low);
        let first = wrapped(&row.spheres[0]);
        let (mut low, mut high, mut radius, mut fastest) = (first, first, 0.0_f64, 0.0_f64);
        for (_, sphere, body) in row.grains() {
            let centre = wrapped(sphere);
            low = low.inf(&centre);
            high = high.sup(&centre);
            radius = radius.max(sphere.radius);
            fastest = fastest.max(Vector::from(body.velocity).norm_squared());
        }
        let (centre, half) = ((low + high) * 0.5, (high - low).norm() * 0.5);
        Crowd { row, centre, half, radius, fastest: fastest.sqrt() }
    }

    /// Index, sphere and body of each grain.
    pub fn grains(&self) -> impl Iterator<Item = (usize, &'a Sphere, &'a Body)> + use<'a> {
        self.row.grains()
    }

    /// Largest approach of the grains to a face of a speed (m/s) within a step (s), m; zero if no grain is too fast for the step.
    pub fn ahead(&self, speed: f64, step: f64) -> f64 {
        let path = self.longest_path(speed, step);
        if path > self.radius { path } else { 0.0 }
    }

    fn longest_path(&self, speed: f64, step: f64) -> f64 {
        (self.fastest + speed) * step
    }

    /// Returns false if every grain is farther from a face than contact plus `beyond` (m).
    pub fn may_touch(&self, face: &PlacedFace<'_>, beyond: f64) -> bool {
        face.distance(&self.centre) < self.reach(beyond)
    }

    /// Distance (m) from the middle beyond which a face is farther from every grain than contact plus `beyond` (m).
    pub fn reach(&self, beyond: f64) -> f64 {
        (self.half + self.radius + beyond) * (1.0 + SLACK)
    }
}

/// Visits the grains of a row with every face that each may contact within a step (s), given the walls through the step, and
/// possibly with other faces. The order is arbitrary, and visits may repeat.
pub(crate) fn for_each_on_the_way<'a>(
    row: Row<'_>,
    walls: &WallsAt<'a>,
    step: f64,
    mut visit: impl FnMut((usize, &Sphere, &Body), (u32, &PlacedFace<'a>)),
) {
    for crowd in row.blocks().map(Crowd::of) {
        for (wall, pose, faces) in walls.each_wall() {
            if walls.has_index(wall) {
                let path = crowd.longest_path(pose.largest_speed(&crowd.centre, crowd.half), step);
                if !walls.any_near_of(wall, &crowd.centre, crowd.reach(path)) {
                    continue;
                }
                for grain in crowd.grains() {
                    let (_, Sphere { centre, radius }, body) = grain;
                    let reach = pose.longest_path(centre, &body.velocity.into(), step) + radius;
                    walls.for_each_near_of(wall, centre, reach, |number, face| visit(grain, (number, face)));
                }
                continue;
            }
            for number in faces {
                let face = walls.face(number);
                let path = crowd.longest_path(face.largest_speed(&crowd.centre, crowd.half), step);
                if crowd.may_touch(&face, path) {
                    crowd.grains().for_each(|grain| visit(grain, (number, &face)));
                }
            }
        }
    }
}
