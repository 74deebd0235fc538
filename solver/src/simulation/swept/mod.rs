//! Paths of a step that lead through a wall or another grain: they are stopped there, after the solve and before anything moves.
//!
//! A step knows the contacts at its start. With the velocities of the solve each grain moves on a straight line `x + s h v`, 0 <= s <= 1, which
//! may lead through what it did not touch then. No path that is shorter than half a radius can: what it leads into overlaps at the next step's
//! start and has not passed. Longer ones are swept, against walls ([`walls`]) and against the paths of other grains ([`pairs`]): what would
//! pass takes the impulse of an impact there, and new velocities are swept again until nothing passes any more. If that has no end,
//! because too many grains meet within a step, the run says so ([`Passage`], [`Crossing`]).
//!
//! Where no grain is so fast this costs a look at the speed of each.

mod pairs;
mod walls;

use crate::Simulation;
use crate::lanes::{Number, cross, dot, minus, plus, times};
use crate::schedule::{Each, Phase, Team};
use crate::wall::{Pose, SHORT_WAY};
use crate::world::{Body, INVERSE_INERTIA, Sphere, World, by_chunk, chunk, chunk_of, chunks};
use nalgebra::Vector3;
use pairs::Meeting;

type Vector = Vector3<f64>;

/// Level of a long path over the distance at the start, or over the radius.
const LONG_LEVEL: f64 = 0.9;

/// Times that grains which were struck are swept anew, after which the run is given up: grains that meet in a chain take one each.
const ROUNDS: usize = 32;

/// A grain that crossed a wall although everything was done to hold it: walls that close on each other leave it no place.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Crossing {
    /// Id of the grain.
    pub grain: u32,
    /// Number of the wall in the scene.
    pub wall: u32,
}

/// Two grains that may have passed through each other: too many met within a step to tell where each goes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Passage {
    /// Ids of the two.
    pub grains: [u32; 2],
}

/// Face or grain that a grain has struck.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Struck {
    /// A face of a wall, by its number.
    Face(u32),
    /// Another grain, by its place.
    Grain(u32),
}

/// An impact that a solve did not know of.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Strike {
    /// Place of the grain.
    pub place: u32,
    pub struck: Struck,
    /// Unit normal from the grain to what it has struck.
    pub normal: Vector,
    /// Normal impulse, N s.
    pub along: f64,
    /// Tangential impulse on what was struck, N s.
    pub tangential: Vector,
}

/// Impacts of the last step, and buffers.
#[derive(Clone, Debug, Default)]
pub(crate) struct Swept {
    /// Impacts of the last step.
    pub strikes: Vec<Strike>,
    /// The speed of faces at which all grains of the last step were slow, m/s; none where some were swift, or it is not known.
    slow_at: Option<f64>,
    /// The first grain that could not be held.
    crossing: Option<Crossing>,
    /// The first two grains that could not be kept apart.
    passage: Option<Passage>,
    /// Radius of the smallest grain, m.
    least_radius: f64,
    poses: Vec<Pose>,
    /// Which grains of each chunk are looked at.
    look: Vec<Look>,
    /// Speed of the fastest of each chunk, squared.
    fastest: Vec<f64>,
    /// Places of the grains of each chunk that meet a wall.
    met: Vec<Vec<u32>>,
    /// Grains that meet each other, by the block of the first.
    meetings: Vec<Vec<Meeting>>,
}

/// Which grains of a chunk may cross a wall.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
enum Look {
    /// None.
    #[default]
    None,
    /// Swift grains.
    Swift,
    /// Any: some are pressed deep into walls.
    All,
}

/// Step and speed of walls, which decide which grains are swept.
#[derive(Clone, Copy)]
struct Pace {
    step: f64,
    /// Largest speed of a face, m/s.
    walls: f64,
}

impl Pace {
    fn of(world: &World, step: f64) -> Pace {
        let (low, high) = world.domain;
        let moving = world.walls.moving();
        let poses =
            moving.flat_map(|wall| [world.walls.pose_over(wall, world.time, step), world.pose_through(wall, step)]);
        let speeds = poses.map(|pose| pose.largest_speed(&((low + high) * 0.5), (high - low).norm()));
        Pace { step, walls: speeds.fold(0.0, f64::max) }
    }

    /// Reports whether a grain may move against a wall by more than its share of a radius.
    #[inline(always)]
    fn is_swift(&self, sphere: &Sphere, body: &Body) -> bool {
        let [x, y, z] = body.velocity;
        let limit = sphere.radius * (SHORT_WAY / self.step) - self.walls;
        limit <= 0.0 || x * x + y * y + z * z > limit * limit
    }

    /// Which of these grains must be looked at, and the speed of the fastest, squared.
    fn look(&self, spheres: &[Sphere], bodies: &[Body]) -> (Look, f64) {
        let (mut swift, mut fastest) = (false, 0.0_f64);
        for (sphere, body) in spheres.iter().zip(bodies) {
            swift |= self.is_swift(sphere, body);
            let [x, y, z] = body.velocity;
            fastest = (x * x + y * y + z * z).larger(fastest);
        }
        (if swift { Look::Swift } else { Look::None }, fastest)
    }
}

impl Swept {
    /// Nothing is known of the paths of a world's grains.
    pub fn new(world: &World) -> Swept {
        let radii = world.spheres[..world.grains()].iter().map(|sphere| sphere.radius);
        Swept { least_radius: radii.fold(f64::INFINITY, f64::min), ..Swept::default() }
    }

    /// No longer counts on grains being slow.
    pub fn forget_pace(&mut self) {
        self.slow_at = None;
    }

    /// Keeps in mind what another one has seen.
    pub fn remember_failures(&mut self, other: &Swept) {
        (self.crossing, self.passage) = (other.crossing, other.passage);
    }
}

impl Simulation {
    /// The first grain that crossed a wall although everything was done to hold it, if there is one: what follows is invalid.
    pub fn crossing(&self) -> Option<Crossing> {
        self.swept.crossing
    }

    /// The first two grains that may have passed through each other, if there are any: what follows is invalid.
    pub fn passage(&self) -> Option<Passage> {
        self.swept.passage
    }

    /// Reports whether some grain may be too fast for the step that comes, so that it may meet a wall that no list knows.
    pub(crate) fn may_be_swift(&self) -> bool {
        let walls = || Pace::of(&self.world, self.settings.step).walls;
        self.swept.slow_at.is_none_or(|known| walls() > known)
    }

    /// Stops grains at what they would pass within the step, before any has moved.
    pub(crate) fn stop_ahead(&mut self, team: &Team) {
        let Simulation { world, swept, layout, settings, .. } = self;
        let (pace, grains) = (Pace::of(world, settings.step), world.grains());
        swept.strikes.clear();
        swept.look.clear();
        swept.look.resize(chunks(grains), Look::None);
        swept.fastest.resize(chunks(grains), 0.0);
        let shares = (Each::of(&mut swept.look), Each::of(&mut swept.fastest));
        team.each_with(Phase::Integrate, chunks(grains), shares, |number, (look, fastest)| {
            let places = chunk(number, grains);
            (*look, *fastest) = pace.look(&world.spheres[places.clone()], &world.bodies[places]);
        });
        let swift = swept.look.contains(&Look::Swift);
        swept.slow_at = (!swift).then_some(pace.walls);
        let mut deep = false;
        for (_, task) in layout.tasks().filter(|(_, task)| task.deep_walls) {
            deep = true;
            for (group, sources) in task.walls.iter().zip(&task.wall_sources) {
                for (lane, _) in sources.occupied() {
                    swept.look[chunk_of(group.body[lane] as usize)] = Look::All;
                }
            }
        }
        if swift || deep {
            self.stop_at_walls(pace, team);
        }
        if !self.may_pass_grains() {
            return;
        }
        for round in 0..=ROUNDS {
            if !self.stop_at_grains(round == ROUNDS, team) {
                return;
            }
            // What was struck may be swift now.
            let slow = self.swept.look.iter_mut().filter(|look| **look == Look::None);
            slow.for_each(|look| *look = Look::Swift);
            self.stop_at_walls(pace, team);
        }
    }

    /// Reports whether some grain moves by more than half the smallest radius: if none does, no path from one to another is longer than that.
    fn may_pass_grains(&self) -> bool {
        let Simulation { world, swept, settings, .. } = self;
        // Walls may have struck some meanwhile.
        let struck =
            swept.strikes.iter().map(|one| Vector::from(world.bodies[one.place as usize].velocity).norm_squared());
        let limit = SHORT_WAY * swept.least_radius / settings.step;
        swept.fastest.iter().copied().chain(struck).any(|square| square > limit * limit)
    }

    /// Moves the grains by a step.
    pub(crate) fn move_grains(&mut self, team: &Team) {
        let (h, grains) = (self.settings.step, self.world.grains());
        let World { spheres, bodies, .. } = &mut self.world;
        team.each_with(Phase::Integrate, chunks(grains), by_chunk(&mut spheres[..grains]), |number, spheres| {
            for (sphere, body) in spheres.iter_mut().zip(&bodies[chunk(number, grains)]) {
                sphere.centre += Vector::from(body.velocity) * h;
            }
        });
    }
}

/// Tangential impulse of an impact that slips at a velocity (m/s), given the impulse that would stop a unit of it (kg) and the most that
/// friction bears (N s).
fn friction(slip: Vector, sticking: f64, most: f64) -> Vector {
    match slip.norm() * sticking {
        wanted if wanted > most => slip * (most / slip.norm()),
        _ => slip * sticking,
    }
}

/// An impulse between two grains outside of the solve, as the ledger takes it.
struct PairImpulse {
    /// Places of the two.
    places: [usize; 2],
    /// Unit normal from the first to the second.
    normal: Vector,
    /// Velocity of the second's surface less that of the first's, before and after, m/s.
    relative: [Vector; 2],
    /// The impulse on the first, N s.
    impulse: Vector,
}

impl Simulation {
    /// Takes account of an impulse between two grains once the ledger has noted the solve, and before they have moved.
    fn book_pair_impulse(&mut self, one: &PairImpulse) {
        let (normal, impulse) = (one.normal.into(), <[f64; 3]>::from(one.impulse));
        let mean = times(plus(one.relative[0].into(), one.relative[1].into()), 0.5);
        let along = dot(normal, impulse);
        let Simulation { world, ledger, .. } = self;
        let Some(ledger) = ledger else { return };
        ledger.lose_in_impact(along * dot(normal, mean), dot(minus(impulse, times(normal, along)), mean));
        // The two take it where they meet, and have it where they are at the start of the step.
        let ([i, j], on_second) = (one.places, times(impulse, -1.0));
        let arm: [f64; 3] = world.arm(i, j).into();
        let spun = times(cross(normal, impulse), world.spheres[i].radius + world.spheres[j].radius);
        let apart = (world.spheres[j].centre - world.spheres[i].centre - world.arm(i, j)).into();
        ledger.turn_in_impact(plus(spun, cross(arm, on_second)), cross(apart, on_second));
    }
}
