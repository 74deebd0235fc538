//! Grains with a path through a wall within a step.
//!
//! A solve knows the contacts at the start of a step, and the impacts of grains in free flight. It misses grains that other
//! grains push, that leave one wall for the next within the step, or that a load presses through a thin wall. So the path of a
//! grain's centre relative to each face of the walls must not come nearer to the face than a level,
//!
//! ```text
//! level = 9/10 min(r, d)    if the path is longer than r/2            d: distance from the centre to the face at the start
//! level = 1/10 d            otherwise, if d < r/2
//! ```
//!
//! A shorter path from a larger distance cannot cross. A grain that comes nearer receives an impulse of Newton's and Coulomb's
//! impact from the first face on its path, in the one-contact solution, and its new path is checked again. Kinematic walls do not
//! react; dynamic walls receive the opposite impulse at once. Other grains are affected only if they are in the path.

use super::{Crossing, INVERSE_INERTIA, LONG_LEVEL, Look, Pace, Strike, Struck, Swept, Vector, friction};
use crate::Simulation;
use crate::detect::{Row, for_each_on_the_way};
use crate::effects::friction::slip_speed;
use crate::effects::restitution::{at_speed, impact_on_the_way};
use crate::schedule::{Each, Phase, Team};
use crate::simulation::ledger::WallImpulse;
use crate::wall::{Impact, PlacedFace, Pose, SHORT_WAY, WallsAt};
use crate::world::{Sphere, World, chunk};

/// Level of a short path as a fraction of the distance at the start.
const SHORT_LEVEL: f64 = 0.1;

/// Largest approach of a pressed grain to a face in a step, as a fraction of the distance.
const PRESSED: f64 = 0.5;

/// Maximum number of impacts of a grain in one step; after these the grain is stopped at its position.
const MOST_STRIKES: usize = 16;

/// Maximum number of repeated checks of all grains after impulses on dynamic walls; later impulses leave these walls unchanged.
const ROUNDS: usize = 8;

impl Pace {
    /// Lists the body indices of the checked grains of a row with an impact.
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

/// First face on the path of a grain.
struct PathImpact {
    /// Number of the face.
    surface: u32,
    at: Impact,
    /// Distance from the centre to the face at the start, m.
    distance: f64,
    /// True if the path is longer than the allowed fraction of the radius.
    long: bool,
}

impl PathImpact {
    /// Finds the point on the path of a grain at this velocity (m/s) that is too close to a face.
    fn of(sphere: &Sphere, velocity: &Vector, surface: u32, face: &PlacedFace<'_>, step: f64) -> Option<PathImpact> {
        let (centre, path) = (&sphere.centre, face.path(&sphere.centre, velocity, step));
        let (length, distance) = (path.norm(), face.distance(centre));
        // Behind a plane a grain is pushed back at any depth.
        if distance > length + sphere.radius || distance <= 0.0 {
            return None;
        }
        let long = length > SHORT_WAY * sphere.radius;
        let level = match long {
            true => LONG_LEVEL * distance.min(sphere.radius),
            false if distance < SHORT_WAY * sphere.radius => SHORT_LEVEL * distance,
            false => return None,
        };
        // Past a rim, a path may reach a face that it did not approach before.
        let impact = face.time_of_impact(centre, &path, level).or_else(|| face.time_of_impact(centre, &path, 0.0));
        impact.map(|at| PathImpact { surface, at, distance, long })
    }
}

/// Returns the first face on the path of a grain at its velocity; of simultaneous impacts the first face in order.
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

/// Returns the first face that the path of a grain at this velocity (m/s) crosses.
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

impl Simulation {
    /// Stops the grains to check at walls.
    pub(super) fn stop_at_walls(&mut self, pace: Pace, team: &Team) {
        let (world, poses) = (&self.world, &mut self.swept.poses);
        poses.clear();
        poses.extend((0..world.walls.count() as u32).map(|wall| world.pose_through(wall, self.settings.step)));
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
            // A struck dynamic wall has a new path.
            self.swept.look.fill(Look::All);
        }
    }

    /// Finds grains with an impact.
    fn find_impacts(&mut self, pace: Pace, team: &Team) {
        let Simulation { world, swept, .. } = self;
        let Swept { poses, look, met, .. } = swept;
        met.resize_with(look.len(), Vec::new);
        let walls = world.walls.placed(poses);
        team.each_with(Phase::Integrate, look.len(), Each::of(met), |number, met| {
            pace.find_impacts(look[number], Row::of(world, chunk(number, world.grains())), &walls, met);
        });
    }

    /// Applies the impulses of impacts to a grain until its path is free. Returns true if dynamic walls received impulses, which
    /// requires `yields`.
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

    /// Applies the impact of a grain with a wall. Returns whether the wall is dynamic; `None` if the grain does not approach.
    fn strike(&mut self, place: usize, met: &PathImpact, yields: bool) -> Option<bool> {
        let (h, normal) = (self.settings.step, met.at.normal);
        let world = &mut self.world;
        let (sphere, body) = (world.spheres[place], world.bodies[place]);
        let (velocity, spin) = (Vector::from(body.velocity), Vector::from(body.scaled_spin));
        let face = world.walls.placed(&self.swept.poses).face(met.surface);
        let point = sphere.centre + velocity * (met.at.share * h) + normal * sphere.radius;
        let wall_velocity = face.velocity_at(&point) + face.slides_at(&normal);
        let along = normal.dot(&(wall_velocity - velocity));
        let material = world.wall_material(place, met.surface);
        // As in the solve, the velocity gained from gravity within the step does not count as impact speed.
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
        // Friction at the velocity after the normal impulse.
        let slip = wall_velocity - jacobian * (yields * share * borne) - velocity
            + normal * (borne * body.inverse_mass)
            - spin.cross(&normal);
        let slip = slip - normal * normal.dot(&slip);
        let across = (jacobian.norm_squared() - share * share).max(0.0);
        let sliding = slip.norm() > slip_speed(world.field.largest(), h);
        let coefficient = if sliding { material.kinetic_friction } else { material.friction };
        let sticking = 1.0 / (body.inverse_mass * (1.0 + INVERSE_INERTIA) + yields * across);
        let tangential = friction(slip, sticking, coefficient * borne);
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

    /// Stops a grain after the maximum number of impacts, for instance between walls that it would cross repeatedly in a step: it
    /// moves to the first wall, or with this wall. A remaining crossing is recorded.
    fn hold(&mut self, place: usize) {
        let walls = self.world.walls.placed(&self.swept.poses);
        let Some(met) = first_impact(&self.world, &walls, place, self.settings.step) else { return };
        let (h, world) = (self.settings.step, &self.world);
        let (centre, body) = (world.spheres[place].centre, world.bodies[place]);
        let velocity = Vector::from(body.velocity);
        let wall_velocity = walls.face(met.surface).carries(&centre, h);
        let short = velocity * (LONG_LEVEL * met.at.share);
        // Velocity of the wall, with a small component away from it.
        let along = wall_velocity - met.at.normal * (SHORT_LEVEL * met.distance / h);
        let velocities = [short, along, wall_velocity];
        let tried = velocities.map(|velocity| (velocity, crossed(&walls, &centre, &velocity, h)));
        let (held, crossed) = tried.iter().find(|(_, crossed)| crossed.is_none()).copied().unwrap_or(tried[1]);
        if let Some(surface) = crossed {
            let wall = world.walls.wall_of(surface);
            self.swept.crossing.get_or_insert(Crossing { grain: world.roll.number(world.ids[place]), wall });
        }
        self.world.bodies[place].velocity = held.into();
        let (normal, impulse) = (met.at.normal, (velocity - held) / body.inverse_mass);
        // The impulse acts on the centre, so the spin does not change.
        let (along, relative) = (normal.dot(&impulse), [wall_velocity - velocity, wall_velocity - held]);
        let noted = (Vector::zeros(), along, impulse - normal * along);
        self.note_strike(place, met.surface, normal, noted, wall_velocity, relative);
    }

    /// Records an impact of a grain, given its lever arm (m), the impulses on the wall, the wall's velocity at the contact, and
    /// the relative velocity, wall minus grain, before and after the impact.
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
        let impulse = -normal * along - tangential;
        self.book_wall_impulse(&WallImpulse {
            surface,
            velocity: (Vector::from(body.velocity) - impulse * body.inverse_mass).into(),
            mass: 1.0 / body.inverse_mass,
            normal: normal.into(),
            before: before.into(),
            after: after.into(),
            impulse: impulse.into(),
            wall_velocity: wall_velocity.into(),
            centre: self.world.spheres[place].centre.into(),
            arm: arm.into(),
        });
        self.swept.strikes.push(Strike {
            place: place as u32,
            struck: Struck::Face(surface),
            normal,
            along,
            tangential,
        });
    }
}
