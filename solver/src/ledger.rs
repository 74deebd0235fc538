//! The ledger of energy and momentum: where both come from and where they go.
//!
//! A step changes velocities from v to v' by gravity and by impulses P at contacts. With the mean m = (v + v')/2 of any relative
//! velocity, the kinetic energy changes by exactly `sum P . m` over contacts plus `h f . m` over bodies, the latter of which is
//! what the potential energy loses where grains are taken half a step earlier, at `x - h v/2`. So nothing is estimated but
//! the split of the work along normals,
//!
//! ```text
//! lambda_n m_n = -(gain of elastic energy) - (loss)          elastic energy at the overlaps d and d - h u_n'
//! ```
//!
//! whose loss goes to restitution where the contact is an impact or the step resolves it, and to stabilisation elsewhere.
//! Overlap that two grains have when they first touch has cost no work: it is an entry of its own. What is left open is
//! printed: the ledger closes up to the turning of normals within a step.

use crate::Simulation;
use crate::detect::Candidates;
use crate::effects::cohesion::Pull;
use crate::effects::compliance::{NormalContact, NormalScheme};
use crate::energy::Energy;
use crate::groups::ContactLanes;
use crate::lanes::{Eight, cross, dot, minus, plus, times};
use crate::partition::TaskGroups;
use crate::world::{ContactMaterial, World};
use nalgebra::Vector3;
use serde::{Deserialize, Serialize};

/// Energy (J) and momentum (kg m/s) since the ledger was opened.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Balance {
    /// Energy at the start; potential energy half a step earlier, as in `end`.
    pub start: Energy,
    /// Energy at the end.
    pub end: Energy,
    /// Lost to friction.
    pub friction: f64,
    /// Lost to resistance against rolling and twisting.
    #[serde(default)]
    pub resistance: f64,
    /// Lost in impacts.
    pub restitution: f64,
    /// Lost to the stabilisation of contacts at rest; negative where it gives.
    pub stabilisation: f64,
    /// Elastic energy of overlaps at first touch.
    pub first_touch: f64,
    /// Work of the walls on the grains.
    pub walls: f64,
    /// Potential energy that grains gained where they were, because gravity changed.
    #[serde(default)]
    pub changing_gravity: f64,
    /// Energy at the end that is not accounted for.
    pub closure: f64,
    /// Momentum at the start.
    pub momentum_start: [f64; 3],
    /// Momentum at the end.
    pub momentum_end: [f64; 3],
    /// Impulse of gravity.
    pub gravity_impulse: [f64; 3],
    /// Impulse of the walls.
    pub wall_impulse: [f64; 3],
    /// Momentum at the end that is not accounted for.
    pub momentum_closure: [f64; 3],
}

/// A ledger that is kept from step to step.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
pub(crate) struct Ledger {
    start: Energy,
    momentum_start: [f64; 3],
    entries: Entries,
    /// Surface speeds at the start of the step, by place.
    #[serde(skip)]
    surface_speeds: Vec<[f64; 3]>,
}

#[derive(Clone, Copy, Debug, Default, Serialize, Deserialize)]
struct Entries {
    friction: f64,
    resistance: f64,
    restitution: f64,
    stabilisation: f64,
    first_touch: f64,
    walls: f64,
    changing_gravity: f64,
    gravity_impulse: [f64; 3],
    wall_impulse: [f64; 3],
}

/// Velocities at a contact before and after the solve, by side: grain, or wall.
struct Passage {
    before: [f64; 3],
    after: [f64; 3],
    inverse_mass: f64,
}

impl Ledger {
    /// Opens a ledger at the present state.
    pub fn open(simulation: &Simulation) -> Ledger {
        let (start, momentum_start) = (simulation.energy_half_a_step_earlier(), simulation.momentum());
        Ledger { start, momentum_start, ..Ledger::default() }
    }

    /// Notes the state at the start of a step, after grains were put in order and before anything acts on them.
    pub fn begin(&mut self, world: &World) {
        self.surface_speeds.clear();
        self.surface_speeds.extend(world.bodies.iter().map(|body| body.surface_speed));
    }

    /// Notes that gravity is no longer what it was `before` (m/s2), after a step of length `h` (s) has moved the grains.
    pub fn change_gravity(&mut self, world: &World, before: Vector3<f64>, h: f64) {
        let change = world.gravity - before;
        for (sphere, body) in world.spheres[..world.grains()].iter().zip(&world.bodies) {
            let place = sphere.centre - Vector3::from(body.velocity) * (0.5 * h);
            self.entries.changing_gravity -= change.dot(&place) / body.inverse_mass;
        }
    }

    /// Notes what a step's impulses did, before the grains move.
    pub fn note(&mut self, simulation: &Simulation, scheme: &NormalScheme) {
        let Simulation { world, candidates, layout, .. } = simulation;
        let poses: Vec<_> = world.surfaces.iter().map(|surface| surface.over(world.time, scheme.step)).collect();
        for body in &world.bodies[..world.grains()] {
            for axis in 0..3 {
                self.entries.gravity_impulse[axis] += world.gravity[axis] * scheme.step / body.inverse_mass;
            }
        }
        for (_, task) in layout.tasks() {
            self.torques(world, candidates, task);
            for (number, (group, sources)) in task.pairs.iter().zip(&task.pair_sources).enumerate() {
                for (lane, _) in sources.occupied() {
                    let (i, j) = (group.first[lane] as usize, group.second[lane] as usize);
                    let (a, b) = (&world.spheres[i], &world.spheres[j]);
                    let normal = group.contacts.normal(lane);
                    let (first, second) = (self.passage(world, i, normal, 1.0), self.passage(world, j, normal, -1.0));
                    let before = minus(second.before, first.before);
                    let after = minus(second.after, first.after);
                    let material = world.table.between_grains(world.materials[i], world.materials[j]);
                    let contact = normal_contact(
                        (a.radius + b.radius - world.arm(i, j).norm(), dot(normal, before)),
                        a.radius * b.radius / (a.radius + b.radius),
                        first.inverse_mass + second.inverse_mass,
                        material,
                    );
                    let pull = material.pull(contact.effective_radius);
                    let borne = Borne::of(&group.contacts, lane, task.pair_pulls.get(number));
                    self.contact(&borne, contact, pull, [before, after], scheme);
                }
            }
            for (number, (group, sources)) in task.walls.iter().zip(&task.wall_sources).enumerate() {
                for (lane, source) in sources.occupied() {
                    let i = group.body[lane] as usize;
                    let (sphere, wall) = (&world.spheres[i], candidates.walls[source]);
                    let normal = group.contacts.normal(lane);
                    let grain = self.passage(world, i, normal, 1.0);
                    let velocity = std::array::from_fn(|axis| group.wall_velocity[axis].0[lane]);
                    let material =
                        world.table.with_wall(world.materials[i], world.surfaces[wall.surface as usize].material);
                    let pose = &poses[wall.surface as usize];
                    let distance = pose.distance(&sphere.centre);
                    // A driven wall has another velocity before its impulses.
                    let before: [f64; 3] = match world.drive_of(wall.surface) {
                        Some(_) => pose.velocity_at(&(sphere.centre + Vector3::from(normal) * distance)).into(),
                        None => velocity,
                    };
                    let approach = minus(minus(before, pose.gain().into()), grain.before);
                    let contact = normal_contact(
                        (sphere.radius - distance, dot(normal, approach)),
                        sphere.radius,
                        grain.inverse_mass,
                        material,
                    );
                    let passages = [minus(before, grain.before), minus(velocity, grain.after)];
                    let borne = Borne::of(&group.contacts, lane, task.wall_pulls.get(number));
                    let impulse = self.contact(&borne, contact, material.pull(sphere.radius), passages, scheme);
                    // The grain bears the opposite.
                    self.entries.walls -= dot(impulse, times(plus(before, velocity), 0.5));
                    self.entries.wall_impulse = minus(self.entries.wall_impulse, impulse);
                }
            }
        }
    }

    /// Enters the work of a task's torques.
    fn torques(&mut self, world: &World, candidates: &Candidates, task: &TaskGroups) {
        // Mean angular velocity of a grain over the step.
        let mean = |place: u32| {
            let (before, body) = (self.surface_speeds[place as usize], &world.bodies[place as usize]);
            times(plus(before, body.surface_speed), 0.5 * body.inverse_radius)
        };
        let (mut lost, mut driven) = (0.0, 0.0);
        for ((group, sources), torques) in task.pairs.iter().zip(&task.pair_sources).zip(&task.pair_torques) {
            for (lane, _) in sources.occupied() {
                let turning = minus(mean(group.second[lane]), mean(group.first[lane]));
                lost -= dot(torques.angular_impulse(lane), turning);
            }
        }
        for ((group, sources), lanes) in task.walls.iter().zip(&task.wall_sources).zip(&task.wall_torques) {
            for (lane, source) in sources.occupied() {
                let after = std::array::from_fn(|axis| lanes.wall_spin[axis].0[lane]);
                let before = match world.drive_of(candidates.walls[source].surface) {
                    Some(drive) => (world.drives[drive].turning() * world.drives[drive].rate_before).into(),
                    None => after,
                };
                let wall_spin = times(plus(before, after), 0.5);
                let impulse = lanes.torques.angular_impulse(lane);
                lost -= dot(impulse, minus(wall_spin, mean(group.body[lane])));
                driven -= dot(impulse, wall_spin);
            }
        }
        self.entries.resistance += lost;
        self.entries.walls += driven;
    }

    /// Velocity of a grain at its contact; the surface moves with `s x n` on the first side and against it on the second.
    fn passage(&self, world: &World, place: usize, normal: [f64; 3], side: f64) -> Passage {
        let body = &world.bodies[place];
        let [x, y, z, inverse_mass] = world.before[place].0;
        let surface = |speed: [f64; 3]| times(cross(speed, normal), side);
        Passage {
            before: plus([x, y, z], surface(self.surface_speeds[place])),
            after: plus(body.velocity, surface(body.surface_speed)),
            inverse_mass,
        }
    }

    /// Enters one contact as it was at the start of the step, given its relative velocities before and after; returns its impulse
    /// on the second side.
    fn contact(
        &mut self,
        borne: &Borne,
        contact: NormalContact<f64>,
        pull: Pull,
        [before, after]: [[f64; 3]; 2],
        scheme: &NormalScheme,
    ) -> [f64; 3] {
        let Borne { normal, along, tangential } = *borne;
        let mean = times(plus(before, after), 0.5);
        let entries = &mut self.entries;
        entries.friction -= dot(tangential, mean);
        let later = NormalContact { overlap: contact.overlap - scheme.step * dot(normal, after), ..contact };
        let stored = contact.elastic_energy(scheme.law);
        let gained = later.elastic_energy(scheme.law) - stored;
        let cohesive = pull.energy(-later.overlap) - pull.energy(-contact.overlap);
        let loss = -along * dot(normal, mean) - gained - cohesive;
        // With the velocity that brought the two here they were apart a step ago.
        if contact.overlap + scheme.step * contact.velocity <= 0.0 {
            entries.first_touch += stored;
        }
        let impact = contact.velocity < -scheme.restitution_threshold;
        match impact || contact.constraint(scheme).resolves_impact {
            true => entries.restitution += loss,
            false => entries.stabilisation += loss,
        }
        plus(times(normal, along), tangential)
    }
}

/// Impulses of one contact: its net normal impulse, with what cohesion pulled, and the tangential one, N s.
struct Borne {
    normal: [f64; 3],
    along: f64,
    tangential: [f64; 3],
}

impl Borne {
    fn of(lanes: &ContactLanes, lane: usize, pulls: Option<&Eight>) -> Borne {
        Borne {
            normal: lanes.normal(lane),
            along: lanes.normal_impulse(lane) - pulls.map_or(0.0, |pulls| pulls.0[lane]),
            tangential: lanes.tangential_impulse(lane),
        }
    }
}

fn normal_contact(
    (overlap, velocity): (f64, f64),
    effective_radius: f64,
    inverse_mass: f64,
    material: &ContactMaterial,
) -> NormalContact<f64> {
    let ContactMaterial { effective_modulus, damping_ratio, .. } = *material;
    NormalContact { overlap, velocity, effective_modulus, effective_radius, inverse_mass, damping_ratio }
}

impl Simulation {
    /// Keeps a ledger from here on; costs about a sixth of a step of ten sweeps.
    pub fn open_ledger(&mut self) {
        self.ledger = Some(Ledger::open(self));
    }

    /// The balance since the ledger was opened; absent if it was not.
    pub fn balance(&self) -> Option<Balance> {
        let Ledger { start, momentum_start, entries, .. } = self.ledger.as_ref()?;
        let (end, momentum_end) = (self.energy_half_a_step_earlier(), self.momentum());
        let gained = entries.walls + entries.first_touch + entries.changing_gravity;
        let lost = entries.friction + entries.resistance + entries.restitution + entries.stabilisation;
        Some(Balance {
            start: *start,
            end,
            friction: entries.friction,
            resistance: entries.resistance,
            restitution: entries.restitution,
            stabilisation: entries.stabilisation,
            first_touch: entries.first_touch,
            walls: entries.walls,
            changing_gravity: entries.changing_gravity,
            closure: end.total() - start.total() - gained + lost,
            momentum_start: *momentum_start,
            momentum_end,
            gravity_impulse: entries.gravity_impulse,
            wall_impulse: entries.wall_impulse,
            momentum_closure: std::array::from_fn(|axis| {
                momentum_end[axis] - momentum_start[axis] - entries.gravity_impulse[axis] - entries.wall_impulse[axis]
            }),
        })
    }

    /// Momentum of the grains, kg m/s.
    pub fn momentum(&self) -> [f64; 3] {
        let bodies = &self.world.bodies[..self.world.grains()];
        let momentum = |axis: usize| bodies.iter().map(|body| body.velocity[axis] / body.inverse_mass).sum();
        [momentum(0), momentum(1), momentum(2)]
    }

    /// Energy with the potential energy of grains half a step earlier, at `x - h v/2`: without contacts no step changes it.
    pub(crate) fn energy_half_a_step_earlier(&self) -> Energy {
        let mut energy = self.energy();
        let (momentum, half) = (self.momentum(), 0.5 * self.settings.step);
        energy.potential += half * (0..3).map(|axis| self.world.gravity[axis] * momentum[axis]).sum::<f64>();
        energy
    }
}
