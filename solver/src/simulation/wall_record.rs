//! Loads and wear of walls, summed over steps on request.
//!
//! A grain exerts on a wall the impulse P and, by its resistance to turning, the angular impulse L in a step. With the contact
//! point x, and the velocity v and the angular velocity w of the wall, over a time T:
//!
//! ```text
//! force      sum P / T                        on the wall
//! torque     sum ((x - c) x P + L) / T        on the wall, about the point c of its axis, or about the origin without an axis
//! power      - sum (P.v + L.w) / T            of the wall on the grains, as in the ledger
//! Archard    sum P_n |s|                      work of the normal force along the slip, J
//! Finnie     sum m u^2 f(a)                   over impacts, J
//! f(a)       sin 2a - 3 sin^2 a               if tan a < 1/3, otherwise cos^2 a / 3
//! ```
//!
//! P_n is the normal impulse with that of cohesion, and s the velocity of the grain's surface along the wall, relative to the wall, at
//! the end of the step, which moves the grain. An impact is a contact that carried nothing in the step before. The mass m hits the wall
//! at the relative speed u of its centre, at the angle a to the surface. The volume lost is proportional to these sums: `K/H` times the first for a hardness H (J. F.
//! Archard, J. Appl. Phys. 24, 981, 1953), `1/(2 p psi)` times the second for a flow stress p, with a ratio of forces of 2 (I. Finnie,
//! Wear 3, 87, 1960).

use super::ledger::{WallContact, WallImpulse};
use crate::Simulation;
use crate::lanes::{cross, dot, minus, plus, times};
use crate::world::World;
use serde::{Deserialize, Serialize};

/// Load of a wall: mean over the time since the last measured frame.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct WallLoad {
    /// Force of the grains on the wall, N.
    pub force: [f64; 3],
    /// Torque of the grains on the wall about the point of its axis, or about the origin if its motion has no axis, N m.
    pub torque: [f64; 3],
    /// Power of the wall on the grains, W.
    pub power: f64,
}

/// Wear of a face of a wall.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct FaceWear {
    /// Index of the wall in the scene.
    pub wall: u32,
    /// Index of the face among those of the wall: of the triangle for a mesh.
    pub face: u32,
    /// Normal force, mean over the time since the last measured frame, N.
    pub normal_force: f64,
    /// Work of the normal force along the slip since the start, J.
    pub archard: f64,
    /// Energy of the impacts since the start, weighted by Finnie's function of their angle, J.
    pub finnie: f64,
}

/// Sums of the loads and of the wear of all walls.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub(crate) struct WallRecord {
    /// Time at which the sums of the loads begin, s.
    since: f64,
    /// Impulse, angular impulse and work by wall.
    loads: Vec<WallLoad>,
    /// Normal impulse, Archard's and Finnie's sum by face; empty without wear.
    faces: Vec<[f64; 3]>,
}

impl WallRecord {
    /// Returns true if the sums are possible and belong to the walls of a world.
    pub fn fits(&self, world: &World) -> bool {
        let loads = self.loads.iter().flat_map(|load| [load.force, load.torque, [load.power; 3]]);
        self.loads.len() == world.walls.count()
            && (self.faces.is_empty() || self.faces.len() == world.walls.faces())
            && self.since.is_finite()
            && loads.chain(self.faces.iter().copied()).flatten().all(f64::is_finite)
    }

    /// Adds an impulse on a grain, its normal part `along` with that of cohesion (N s), the angular impulse on the wall (N m s) and the
    /// work of the wall (J); `begins` for a new contact.
    fn add(&mut self, world: &World, one: &WallImpulse, along: f64, angular: [f64; 3], work: f64, begins: bool) {
        let wall = world.walls.wall_of(one.surface);
        let (load, impulse) = (&mut self.loads[wall as usize], times(one.impulse, -1.0));
        let point: [f64; 3] = world.wrapped(&plus(one.centre, one.arm).into()).into();
        load.force = plus(load.force, impulse);
        load.torque = plus(load.torque, plus(cross(minus(point, world.walls.pivot(wall)), impulse), angular));
        load.power += work;
        let Some([normal, archard, wear]) = self.faces.get_mut(one.surface as usize) else { return };
        let slip = minus(one.after, times(one.normal, dot(one.normal, one.after)));
        *normal += along;
        *archard += along * dot(slip, slip).sqrt();
        if begins {
            let velocity = minus(one.velocity, one.wall_velocity);
            *wear += one.mass * finnie(dot(velocity, velocity), dot(one.normal, velocity));
        }
    }
}

/// Returns `u^2 f(a)` (m2/s2) from the squared speed `u^2` and its component `u sin a` towards the wall; zero if that is negative.
fn finnie(square: f64, towards: f64) -> f64 {
    let (down, across) = (towards.max(0.0), (square - towards * towards).max(0.0));
    match 3.0 * down < across.sqrt() {
        true => down * (2.0 * across.sqrt() - 3.0 * down),
        false => across / 3.0 * f64::from(down > 0.0),
    }
}

impl Simulation {
    /// Records loads of the walls from the next step on, and with `wear` the wear of their faces. A record in progress continues.
    pub fn record_walls(&mut self, wear: bool) {
        let walls = &self.world.walls;
        if self.wall_record.as_ref().is_none_or(|record| wear && record.faces.is_empty()) {
            let (loads, faces) = (vec![WallLoad::default(); walls.count()], if wear { walls.faces() } else { 0 });
            self.wall_record = Some(WallRecord { since: self.world.time, loads, faces: vec![[0.0; 3]; faces] });
        }
    }

    /// Restarts the means of the loads at the present time.
    pub fn restart_wall_means(&mut self) {
        let Some(record) = &mut self.wall_record else { return };
        record.since = self.world.time;
        record.loads.fill(WallLoad::default());
        record.faces.iter_mut().for_each(|face| face[0] = 0.0);
    }

    /// Returns the load of each wall since the means were restarted; empty without a record, and before the first step of the means.
    pub fn wall_loads(&self) -> Vec<WallLoad> {
        let Some(record) = &self.wall_record else { return Vec::new() };
        let time = self.world.time - record.since;
        let mean = |sum: &WallLoad| WallLoad {
            force: times(sum.force, 1.0 / time),
            torque: times(sum.torque, 1.0 / time),
            power: sum.power / time,
        };
        record.loads.iter().filter(|_| time > 0.0).map(mean).collect()
    }

    /// Returns the wear of the first face of each wall and of all faces that grains have touched; empty without a record of wear.
    pub fn wear(&self) -> Vec<FaceWear> {
        let Some(record) = &self.wall_record else { return Vec::new() };
        let time = self.world.time - record.since;
        let faces = (0..).zip(&record.faces).map(|(number, &[impulse, archard, finnie])| {
            let (wall, face) = self.world.walls.place_of(number);
            let normal_force = if time > 0.0 { impulse / time } else { 0.0 };
            FaceWear { wall, face, normal_force, archard, finnie }
        });
        faces.filter(|face| face.face == 0 || face.archard + face.finnie + face.normal_force > 0.0).collect()
    }

    /// Adds the solved contacts of the step, before the grains move.
    pub(super) fn note_wall_contacts(&mut self) {
        let Some(mut record) = self.wall_record.take() else { return };
        let world = &self.world;
        self.for_each_wall_contact(|one| {
            let WallContact { candidate, normal, velocities: [wall_velocity, after], .. } = *one;
            let place = candidate.body as usize;
            let (sphere, body, [x, y, z, _]) = (&world.spheres[place], &world.bodies[place], world.before[place].0);
            let impulse = WallImpulse {
                surface: candidate.surface,
                mass: 1.0 / body.inverse_mass,
                velocity: [x, y, z],
                normal,
                before: [0.0; 3],
                after: minus(minus(after, body.velocity), cross(body.scaled_spin, normal)),
                impulse: times(one.impulse(), -1.0),
                wall_velocity,
                centre: sphere.centre.into(),
                arm: times(normal, sphere.radius),
            };
            record.add(world, &impulse, one.pressing, one.angular_impulse, one.work(), one.begins);
        });
        self.wall_record = Some(record);
    }

    /// Adds an impulse outside of the solve.
    pub(super) fn note_wall_impulse(&mut self, one: &WallImpulse) {
        if let Some(record) = &mut self.wall_record {
            let (along, work) = (-dot(one.normal, one.impulse), dot(one.impulse, one.wall_velocity));
            record.add(&self.world, one, along, [0.0; 3], work, true);
        }
    }
}
