//! Grains whose path in a step leads through a wall: they are stopped there, after the solve and before anything moves.
//!
//! A solve knows the contacts at the start of a step, and what grains meet that fly on as they are. A grain that another one pushes, that
//! leaves one wall for the next within the step, or that a load presses through a thin wall goes where the solve has not looked. So with
//! the velocities of the solve the path of a grain's centre `x + s h u`, 0 <= s <= 1, as seen from each face of the walls, must not come
//! nearer to the face than a level,
//!
//! ```text
//! level = 9/10 min(r, d)    where the path is longer than r/2         d: distance from the centre to the face at the start
//! level = 1/10 d            elsewhere, if d < r/2
//! ```
//!
//! A shorter path from farther off cannot cross. A grain that does come nearer takes an impulse of Newton's and Coulomb's impact from the
//! face that it comes to first, in the one-contact solution, and its new path is looked at again. Prescribed walls take no notice;
//! driven ones take the opposite impulse at once. No other grain feels it before the next step.

use super::ledger::WallImpulse;
use crate::Simulation;
use crate::detect::{Row, for_each_on_the_way};
use crate::effects::friction::slip_speed;
use crate::effects::restitution::{at_speed, impact_on_the_way};
use crate::schedule::{Each, Phase, Team};
use crate::wall::{Impact, PlacedFace, Pose, SHORT_WAY, WallsAt};
use crate::world::{Body, Sphere, World, by_chunk, chunk, chunk_of, chunks};
use nalgebra::Vector3;
use std::sync::atomic::{AtomicBool, Ordering::Relaxed};

type Vector = Vector3<f64>;

/// Level of a long path over the distance at the start, or over the radius.
const LONG_LEVEL: f64 = 0.9;

/// Level of a short path over the distance at the start.
const SHORT_LEVEL: f64 = 0.1;

/// Share of the distance to a face by which a grain that is pressed against it may come nearer in a step.
const PRESSED: f64 = 0.5;

/// Impacts of a grain in one step, after which it is held where it is.
const MOST_STRIKES: usize = 16;

/// Times that all grains are looked at again because driven walls have taken impulses; then these take no notice, either.
const ROUNDS: usize = 8;

/// One over the moment of inertia of a solid sphere, over that of its mass at the radius.
const INVERSE_INERTIA: f64 = 2.5;

/// A grain that crossed a wall although everything was done to hold it: walls that close on each other leave it no place.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Crossing {
    /// Id of the grain.
    pub grain: u32,
    /// Number of the wall in the scene.
    pub wall: u32,
}

/// An impact that a solve did not know of.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Strike {
    /// Place of the grain.
    pub place: u32,
    /// Number of the face.
    pub surface: u32,
    /// Unit normal towards the wall.
    pub normal: Vector,
    /// Normal impulse, N s.
    pub along: f64,
    /// Tangential impulse on the wall, N s.
    pub tangential: Vector,
}

/// What is kept from step to step.
#[derive(Clone, Debug, Default)]
pub(crate) struct Swept {
    /// Impacts of the last step.
    pub strikes: Vec<Strike>,
    /// The speed of faces at which all grains of the last step were slow, m/s; none where some were swift, or it is not known.
    slow_at: Option<f64>,
    /// The first grain that could not be held.
    crossing: Option<Crossing>,
    poses: Vec<Pose>,
    /// Which grains of each chunk are looked at.
    look: Vec<Look>,
    /// Places of the grains of each chunk that meet something.
    met: Vec<Vec<u32>>,
}

/// Which grains of a chunk may cross a wall.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
enum Look {
    /// None.
    #[default]
    None,
    /// Those that are swift.
    Swift,
    /// Any: some are pressed deep into walls.
    All,
}

/// What of a step decides which grains are looked at.
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

    /// Whether a grain may move against a wall by more than its share of a radius.
    #[inline(always)]
    fn is_swift(&self, sphere: &Sphere, body: &Body) -> bool {
        let [x, y, z] = body.velocity;
        let limit = sphere.radius * (SHORT_WAY / self.step) - self.walls;
        limit <= 0.0 || x * x + y * y + z * z > limit * limit
    }

    /// Which of these grains must be looked at.
    fn look(&self, spheres: &[Sphere], bodies: &[Body]) -> Look {
        match spheres.iter().zip(bodies).any(|(sphere, body)| self.is_swift(sphere, body)) {
            true => Look::Swift,
            false => Look::None,
        }
    }

    /// Lists the places of the grains of a row that meet something, of those that are looked at.
    fn find_impacts(&self, look: Look, row: Row<'_>, walls: &WallsAt<'_>, met: &mut Vec<u32>) {
        met.clear();
        if look == Look::None {
            return;
        }
        for_each_on_the_way(row, walls, self.step, |(place, sphere, body), (surface, face)| {
            let looked_at = look == Look::All || self.is_swift(sphere, body);
            if looked_at && PathImpact::of(sphere, &body.velocity.into(), surface, face, self.step).is_some() {
                met.push(place as u32);
            }
        });
        met.sort_unstable();
        met.dedup();
    }
}

/// What a grain comes to first on its path.
struct PathImpact {
    /// Number of the face.
    surface: u32,
    at: Impact,
    /// Distance from the centre to the face at the start, m.
    distance: f64,
    /// Whether the path is longer than its share of the radius.
    long: bool,
}

impl PathImpact {
    /// Where the path of a grain at this velocity (m/s) comes too near to a face, if it does.
    fn of(sphere: &Sphere, velocity: &Vector, surface: u32, face: &PlacedFace<'_>, step: f64) -> Option<PathImpact> {
        let (centre, path) = (&sphere.centre, face.path(&sphere.centre, velocity, step));
        let (length, distance) = (path.norm(), face.distance(centre));
        // Behind a plane a grain is pushed back, however deep.
        if distance > length + sphere.radius || distance <= 0.0 {
            return None;
        }
        let long = length > SHORT_WAY * sphere.radius;
        let level = match long {
            true => LONG_LEVEL * distance.min(sphere.radius),
            false if distance < SHORT_WAY * sphere.radius => SHORT_LEVEL * distance,
            false => return None,
        };
        // Past a rim a path may come to a face that it did not come near before.
        let impact = face.time_of_impact(centre, &path, level).or_else(|| face.time_of_impact(centre, &path, 0.0));
        impact.map(|at| PathImpact { surface, at, distance, long })
    }
}

/// What a grain comes to first on the path that its velocity gives it; of faces that it comes to at once the first.
fn first_impact(world: &World, walls: &WallsAt<'_>, place: usize, step: f64) -> Option<PathImpact> {
    let (sphere, velocity) = (&world.spheres[place], Vector::from(world.bodies[place].velocity));
    let mut first: Option<PathImpact> = None;
    let radius = |pose: &Pose| pose.longest_path(&sphere.centre, &velocity, step) + sphere.radius;
    walls.for_each_near(&sphere.centre, radius, |surface, face| {
        let sooner = |impact: &PathImpact| {
            first.as_ref().is_none_or(|first| (impact.at.share, surface) < (first.at.share, first.surface))
        };
        if let Some(impact) = PathImpact::of(sphere, &velocity, surface, face, step).filter(sooner) {
            first = Some(impact);
        }
    });
    first
}

/// Whether the path of a grain at this velocity (m/s) crosses a face, and which is the first of them.
fn crossed(walls: &WallsAt<'_>, centre: &Vector, velocity: &Vector, step: f64) -> Option<u32> {
    let mut first: Option<u32> = None;
    let radius = |pose: &Pose| pose.longest_path(centre, velocity, step);
    walls.for_each_near(centre, radius, |surface, face| {
        let before = first.is_none_or(|first| surface < first);
        if before && face.time_of_impact(centre, &face.path(centre, velocity, step), 0.0).is_some() {
            first = Some(surface);
        }
    });
    first
}

impl Swept {
    /// No longer counts on grains being slow.
    pub fn forget_pace(&mut self) {
        self.slow_at = None;
    }

    /// Keeps in mind what another one has seen.
    pub fn remember_crossing(&mut self, other: &Swept) {
        self.crossing = other.crossing;
    }
}

impl Simulation {
    /// The first grain that crossed a wall although everything was done to hold it, if there is one: what follows is worthless.
    pub fn crossing(&self) -> Option<Crossing> {
        self.swept.crossing
    }

    /// Whether some grain may be too fast for the step that comes, so that it may meet a wall that no list knows.
    pub(crate) fn may_be_swift(&self) -> bool {
        let walls = || Pace::of(&self.world, self.settings.step).walls;
        self.swept.slow_at.is_none_or(|known| walls() > known)
    }

    /// Stops grains at walls before any has moved, where that cannot wait: somebody wants to know of all impulses, driven walls may
    /// change their minds, or grains are pressed deep into walls. Whether it was done.
    pub(crate) fn stop_ahead(&mut self, team: &Team) -> bool {
        self.swept.strikes.clear();
        let deep = self.layout.tasks().any(|(_, task)| task.deep_walls);
        if !deep && self.ledger.is_none() && self.world.drives.is_empty() {
            return false;
        }
        let Simulation { world, swept, layout, settings, .. } = self;
        let (pace, grains) = (Pace::of(world, settings.step), world.grains());
        swept.look.clear();
        swept.look.extend((0..chunks(grains)).map(|number| {
            let places = chunk(number, grains);
            pace.look(&world.spheres[places.clone()], &world.bodies[places])
        }));
        swept.slow_at = (!swept.look.contains(&Look::Swift)).then_some(pace.walls);
        for (_, task) in layout.tasks().filter(|(_, task)| task.deep_walls) {
            for (group, sources) in task.walls.iter().zip(&task.wall_sources) {
                for (lane, _) in sources.occupied() {
                    swept.look[chunk_of(group.body[lane] as usize)] = Look::All;
                }
            }
        }
        self.stop_at_walls(pace, team);
        true
    }

    /// Moves the grains by a step; unless that was done ahead, stops those at walls that are too fast for it.
    pub(crate) fn move_grains(&mut self, stopped: bool, team: &Team) {
        let (h, grains) = (self.settings.step, self.world.grains());
        let pace = (!stopped).then(|| Pace::of(&self.world, h));
        if !stopped {
            self.place_walls();
        }
        let Simulation { world, swept, .. } = self;
        let World { spheres, bodies, walls, period, domain, .. } = world;
        let Swept { poses, look, met, .. } = swept;
        let walls = walls.placed(poses);
        look.clear();
        look.resize(chunks(grains), Look::None);
        met.resize_with(chunks(grains), Vec::new);
        let swift = AtomicBool::new(false);
        let shares = (by_chunk(&mut spheres[..grains]), (Each::of(look), Each::of(met)));
        // What meets nothing moves at once, while it is at hand.
        team.each_with(Phase::Integrate, chunks(grains), shares, |number, (spheres, (look, met))| {
            let places = chunk(number, grains);
            let bodies = &bodies[places.clone()];
            if let Some(pace) = pace {
                *look = pace.look(spheres, bodies);
                swift.fetch_or(*look == Look::Swift, Relaxed);
                let row = Row { first: places.start, spheres, bodies, period, low: &domain.0 };
                pace.find_impacts(*look, row, &walls, met);
                if !met.is_empty() {
                    return;
                }
                *look = Look::None;
            }
            move_by(spheres, bodies, h);
        });
        let Some(pace) = pace else { return };
        self.swept.slow_at = (!swift.into_inner()).then_some(pace.walls);
        let waiting: Vec<usize> =
            (0..chunks(grains)).filter(|&number| self.swept.look[number] == Look::Swift).collect();
        if waiting.is_empty() {
            return;
        }
        self.stop_at_walls(pace, team);
        let World { spheres, bodies, .. } = &mut self.world;
        for places in waiting.into_iter().map(|number| chunk(number, grains)) {
            move_by(&mut spheres[places.clone()], &bodies[places], h);
        }
    }

    /// Keeps how the walls go through the step.
    fn place_walls(&mut self) {
        let (world, poses) = (&self.world, &mut self.swept.poses);
        poses.clear();
        poses.extend((0..world.walls.count() as u32).map(|wall| world.pose_through(wall, self.settings.step)));
    }

    /// Stops the grains that are looked at.
    fn stop_at_walls(&mut self, pace: Pace, team: &Team) {
        self.place_walls();
        for round in 0..=ROUNDS {
            self.find_impacts(pace, team);
            let met = std::mem::take(&mut self.swept.met);
            let mut pushed = false;
            for &place in met.iter().flatten() {
                pushed |= self.stop_grain(place as usize, round < ROUNDS);
            }
            self.swept.met = met;
            if !pushed {
                return;
            }
            // A driven wall that was hit goes elsewhere.
            self.swept.look.fill(Look::All);
        }
    }

    /// Looks for grains that meet something.
    fn find_impacts(&mut self, pace: Pace, team: &Team) {
        let Simulation { world, swept, .. } = self;
        let Swept { poses, look, met, .. } = swept;
        met.resize_with(look.len(), Vec::new);
        let walls = world.walls.placed(poses);
        team.each_with(Phase::Integrate, look.len(), Each::of(met), |number, met| {
            pace.find_impacts(look[number], Row::of(world, chunk(number, world.grains())), &walls, met);
        });
    }

    /// Gives a grain the impulses of what it meets until it meets nothing more; whether driven walls took any, which they do if they
    /// `yield`.
    fn stop_grain(&mut self, place: usize, yields: bool) -> bool {
        let (h, mut pushed) = (self.settings.step, false);
        for _ in 0..MOST_STRIKES {
            let walls = self.world.walls.placed(&self.swept.poses);
            let Some(met) = first_impact(&self.world, &walls, place, h) else { return pushed };
            let Some(driven) = self.strike(place, &met, yields) else { break };
            pushed |= driven;
        }
        self.hold(place);
        pushed
    }

    /// The impact of a grain on what it meets; absent if it does not approach. Whether the wall is a driven one.
    fn strike(&mut self, place: usize, met: &PathImpact, yields: bool) -> Option<bool> {
        let (h, normal) = (self.settings.step, met.at.normal);
        let world = &mut self.world;
        let (sphere, body) = (world.spheres[place], world.bodies[place]);
        let (velocity, spin) = (Vector::from(body.velocity), Vector::from(body.scaled_spin));
        let face = world.walls.placed(&self.swept.poses).face(met.surface);
        let point = sphere.centre + velocity * (met.at.share * h) + normal * sphere.radius;
        let wall_velocity = face.velocity_at(&point);
        let along = normal.dot(&(wall_velocity - velocity));
        let material = world.wall_material(place, met.surface);
        // What gravity gives within the step is no speed of impact, as in the solve.
        let falling = (normal.dot(&world.gravity) * h).max(0.0);
        let speed = (-along - falling).max(0.0);
        let restitution = at_speed(material.restitution, material.restitution_speed, speed);
        let scheme = self.constrainer.scheme();
        let bias = match met.long {
            true if met.distance > sphere.radius => {
                impact_on_the_way(scheme, (met.at.distance - sphere.radius).max(0.0), -speed, restitution)
            }
            true => Some(restitution * speed).filter(|bias| *bias > scheme.restitution_threshold).unwrap_or(0.0),
            false => -PRESSED * met.distance / h,
        };
        if bias <= along {
            return None;
        }
        let drive = world.drive_of(met.surface).filter(|_| yields);
        let (jacobian, yields) = drive.map_or((Vector::zeros(), 0.0), |drive| {
            (world.drives[drive].jacobian(&point), world.drives[drive].inverse_inertia)
        });
        let share = normal.dot(&jacobian);
        let borne = (bias - along) / (body.inverse_mass + yields * share * share);
        // Friction, at the velocity that the normal impulse has left.
        let slip = wall_velocity - jacobian * (yields * share * borne) - velocity
            + normal * (borne * body.inverse_mass)
            - spin.cross(&normal);
        let slip = slip - normal * normal.dot(&slip);
        let across = (jacobian.norm_squared() - share * share).max(0.0);
        let sliding = slip.norm() > slip_speed(world.field.largest(), h);
        let friction = if sliding { material.kinetic_friction } else { material.friction };
        let sticking = 1.0 / (body.inverse_mass * (1.0 + INVERSE_INERTIA) + yields * across);
        let tangential = match slip.norm() * sticking {
            most if most > friction * borne => slip * (friction * borne / slip.norm()),
            _ => slip * sticking,
        };
        let impulse = tangential - normal * borne;
        let before = wall_velocity - velocity - spin.cross(&normal);
        let body = &mut world.bodies[place];
        body.velocity = (velocity + impulse * body.inverse_mass).into();
        body.scaled_spin = (spin + normal.cross(&tangential) * (INVERSE_INERTIA * body.inverse_mass)).into();
        if let Some(drive) = drive {
            world.drives[drive].push(-jacobian.dot(&impulse));
            let wall = world.drives[drive].wall;
            self.swept.poses[wall as usize] = world.pose_through(wall, h);
        }
        let body = self.world.bodies[place];
        let after = wall_velocity - Vector::from(body.velocity) - Vector::from(body.scaled_spin).cross(&normal);
        let noted = (normal * sphere.radius, borne, -tangential);
        self.note_strike(place, met.surface, normal, noted, wall_velocity, [before, after]);
        Some(drive.is_some())
    }

    /// Holds a grain that impacts did not stop, as between walls that it would cross more often than was looked at in a step: it goes as
    /// far as the first wall, or with this wall. If it crosses one all the same, that is noted.
    fn hold(&mut self, place: usize) {
        let walls = self.world.walls.placed(&self.swept.poses);
        let Some(met) = first_impact(&self.world, &walls, place, self.settings.step) else { return };
        let (h, world) = (self.settings.step, &self.world);
        let (centre, body) = (world.spheres[place].centre, world.bodies[place]);
        let velocity = Vector::from(body.velocity);
        let wall_velocity = walls.face(met.surface).carries(&centre, h);
        let short = velocity * (LONG_LEVEL * met.at.share);
        // With the wall, and a little away from it.
        let along = wall_velocity - met.at.normal * (SHORT_LEVEL * met.distance / h);
        let velocities = [short, along, wall_velocity];
        let tried = velocities.map(|velocity| (velocity, crossed(&walls, &centre, &velocity, h)));
        let (held, crossed) = tried.iter().find(|(_, crossed)| crossed.is_none()).copied().unwrap_or(tried[1]);
        if let Some(surface) = crossed {
            let wall = world.walls.wall_of(surface);
            self.swept.crossing.get_or_insert(Crossing { grain: world.ids[place], wall });
        }
        self.world.bodies[place].velocity = held.into();
        let (normal, impulse) = (met.at.normal, (velocity - held) / body.inverse_mass);
        // It acts on the centre, so that the spin stays.
        let (along, relative) = (normal.dot(&impulse), [wall_velocity - velocity, wall_velocity - held]);
        let noted = (Vector::zeros(), along, impulse - normal * along);
        self.note_strike(place, met.surface, normal, noted, wall_velocity, relative);
    }

    /// Notes an impact that a grain has just had, given the arm at which it acts on the grain (m) and the impulses on the wall, the wall's
    /// velocity at the contact, and this less that of the grain where it was hit, before the impact and after it.
    fn note_strike(
        &mut self,
        place: usize,
        surface: u32,
        normal: Vector,
        (arm, along, tangential): (Vector, f64, Vector),
        wall_velocity: Vector,
        [before, after]: [Vector; 2],
    ) {
        let body = &self.world.bodies[place];
        self.book_wall_impulse(&WallImpulse {
            mass: 1.0 / body.inverse_mass,
            normal: normal.into(),
            before: before.into(),
            after: after.into(),
            impulse: (-normal * along - tangential).into(),
            wall_velocity: wall_velocity.into(),
            centre: self.world.spheres[place].centre.into(),
            arm: arm.into(),
            shift: [0.0; 3],
        });
        self.swept.strikes.push(Strike { place: place as u32, surface, normal, along, tangential });
    }
}

/// Moves grains for a step of length `h` (s).
fn move_by(spheres: &mut [Sphere], bodies: &[Body], h: f64) {
    for (sphere, body) in spheres.iter_mut().zip(bodies) {
        sphere.centre += Vector::from(body.velocity) * h;
    }
}
