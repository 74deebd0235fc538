//! Continuous collision detection: stops paths of a step at walls and other grains, after the solve and before bodies move.
//!
//! A step knows the contacts at its start. With the velocities of the solve each grain moves on a straight line `x + s h v`, 0 <=
//! s <= 1, which may cross a body without contact at the start. Paths shorter than half a radius cannot cross: the next step
//! starts with an overlap. Longer paths are swept against walls ([`walls`]) and against the paths of other grains ([`pairs`]): a
//! crossing grain receives the impulse of an impact, and new velocities are swept again until no path crosses. If too many grains
//! collide within a step for this to end, the run reports the failure ([`Passage`], [`Crossing`]).
//!
//! Without fast grains the cost is one check of each grain's speed.

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

/// Level of a long path, as a fraction of the distance at the start or of the radius.
const LONG_LEVEL: f64 = 0.9;

/// Maximum number of sweeps over struck grains, after which the run is given up: a chain of impacts takes one sweep per grain.
const ROUNDS: usize = 32;

/// Grain that crossed a wall in spite of all impacts: walls that close on each other leave no free space.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Crossing {
    /// Permanent number of the grain.
    pub grain: u64,
    /// Number of the wall in the scene.
    pub wall: u32,
}

/// Pair of grains that may have passed through each other: too many impacts within a step to resolve.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Passage {
    /// Permanent numbers of the two grains.
    pub grains: [u64; 2],
}

/// Face or grain struck by a grain.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Struck {
    /// Face of a wall, by its number.
    Face(u32),
    /// Another grain, by its body index.
    Grain(u32),
}

/// Impact outside of the solve.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Strike {
    /// Body index of the grain.
    pub place: u32,
    pub struck: Struck,
    /// Unit normal from the grain to the struck body.
    pub normal: Vector,
    /// Normal impulse, N s.
    pub along: f64,
    /// Tangential impulse on the struck body, N s.
    pub tangential: Vector,
}

/// Impacts of the last step, and buffers.
#[derive(Clone, Debug, Default)]
pub(crate) struct Swept {
    /// Impacts of the last step.
    pub strikes: Vec<Strike>,
    /// Speed of faces at which all grains of the last step were slow, m/s; `None` if some were fast, or if unknown.
    slow_at: Option<f64>,
    /// First grain that crossed a wall.
    pub crossing: Option<Crossing>,
    /// First two grains that may have passed through each other.
    pub passage: Option<Passage>,
    /// Radius of the smallest grain, m.
    least_radius: f64,
    poses: Vec<Pose>,
    /// Grains of each chunk to check.
    look: Vec<Look>,
    /// Largest speed of each chunk, squared.
    fastest: Vec<f64>,
    /// Body indices of the grains of each chunk that collide with a wall.
    met: Vec<Vec<u32>>,
    /// Pairs of colliding grains, by the block of the first.
    meetings: Vec<Vec<Meeting>>,
}

/// Grains of a chunk that may cross a wall.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
enum Look {
    /// No grains.
    #[default]
    None,
    /// Fast grains.
    Swift,
    /// All grains: some are pressed deep into walls.
    All,
}

/// Time step and wall speed, which decide which grains are swept.
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

    /// Returns true if a grain may move relative to a wall by more than the allowed fraction of a radius.
    #[inline(always)]
    fn is_swift(&self, sphere: &Sphere, body: &Body) -> bool {
        let [x, y, z] = body.velocity;
        let limit = sphere.radius * (SHORT_WAY / self.step) - self.walls;
        limit <= 0.0 || x * x + y * y + z * z > limit * limit
    }

    /// Returns which of these grains need a check, and the largest speed, squared.
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
    /// Starts without knowledge of the paths of a world's grains.
    pub fn new(world: &World) -> Swept {
        Swept { least_radius: world.smallest_radius(), ..Swept::default() }
    }

    /// Clears the assumption that grains are slow.
    pub fn forget_pace(&mut self) {
        self.slow_at = None;
    }
}

impl Simulation {
    crate::getters! {
        /// Returns the number of impacts of the last step that were resolved on the paths of grains, after the solve.
        pub impacts_on_paths: usize = |simulation| simulation.swept.strikes.len();
        /// Returns the first grain that crossed a wall, if any: later results are invalid.
        pub crossing: Option<Crossing> = |simulation| simulation.swept.crossing;
        /// Returns the first two grains that may have passed through each other, if any: later results are invalid.
        pub passage: Option<Passage> = |simulation| simulation.swept.passage;
    }

    /// Returns true if some grain may be too fast for the next step, so that it may collide with a wall outside the list.
    pub(crate) fn may_be_swift(&self) -> bool {
        let walls = || Pace::of(&self.world, self.settings.step).walls;
        self.swept.slow_at.is_none_or(|known| walls() > known)
    }

    /// Stops grains at bodies that they would cross within the step, before bodies move.
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
        if let Some(ranks) = layout.ranks.as_ref().filter(|ranks| ranks.any(deep)) {
            let own: Vec<bool> = swept.look.iter().map(|look| *look == Look::All).collect();
            for of_rank in ranks.everyone(&own) {
                let all = swept.look.iter_mut().zip(of_rank).filter(|(_, is_all)| *is_all);
                all.for_each(|(look, _)| *look = Look::All);
            }
            deep = true;
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
            // Struck grains may be fast now.
            let slow = self.swept.look.iter_mut().filter(|look| **look == Look::None);
            slow.for_each(|look| *look = Look::Swift);
            self.stop_at_walls(pace, team);
        }
    }

    /// Returns true if some grain moves by more than half the smallest radius; otherwise no relative path of two grains is longer than that radius.
    fn may_pass_grains(&self) -> bool {
        let Simulation { world, swept, settings, .. } = self;
        // Walls may have struck some grains meanwhile.
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

/// Tangential impulse of a sliding impact at a velocity (m/s), given the impulse that stops a unit of it (kg) and the friction
/// limit (N s).
fn friction(slip: Vector, sticking: f64, most: f64) -> Vector {
    match slip.norm() * sticking {
        wanted if wanted > most => slip * (most / slip.norm()),
        _ => slip * sticking,
    }
}

impl Simulation {
    /// Books an impulse between two grains after the ledger has booked the solve and before they move: their body indices, the unit normal
    /// from the first to the second, the velocity of the second surface minus that of the first before and after (m/s), and the impulse on
    /// the first (N s).
    fn book_pair_impulse(&mut self, [i, j]: [usize; 2], normal: Vector, relative: [Vector; 2], impulse: Vector) {
        let (normal, impulse) = (normal.into(), <[f64; 3]>::from(impulse));
        let mean = times(plus(relative[0].into(), relative[1].into()), 0.5);
        let along = dot(normal, impulse);
        let Simulation { world, ledger, .. } = self;
        let Some(ledger) = ledger else { return };
        let lost = [along * dot(normal, mean), dot(minus(impulse, times(normal, along)), mean)];
        // The impulse acts at the point of impact, but is booked at the positions at the start of the step.
        let on_second = times(impulse, -1.0);
        let arm: [f64; 3] = world.arm(i, j).into();
        let spun = times(cross(normal, impulse), world.spheres[i].radius + world.spheres[j].radius);
        let apart = (world.spheres[j].centre - world.spheres[i].centre - world.arm(i, j)).into();
        ledger.book_impact(lost, [plus(spun, cross(arm, on_second)), cross(apart, on_second)]);
    }
}
