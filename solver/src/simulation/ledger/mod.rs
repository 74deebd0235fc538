//! Ledger of energy, momentum and angular momentum: sources and sinks.
//!
//! A step changes velocities from v to v' by gravity and by impulses P at contacts. With the mean m = (v + v')/2 of any relative
//! velocity, the kinetic energy changes by exactly `sum P . m` over contacts plus `h f . m` over bodies. The second sum equals
//! the loss of potential energy half a step earlier, at `x - h v/2`. So the ledger estimates only the split of the work along
//! normals,
//!
//! ```text
//! lambda_n m_n = -(gain of stored energy) - (loss)          stored energy at the overlaps d and d - h u_n'
//! ```
//!
//! with the loss booked as restitution if the contact is an impact or the step resolves it, and as stabilisation otherwise.
//! Stored energy is elastic energy plus the potential energy of cohesion. The net energy stored by tangential springs has an
//! entry of its own; friction is the remaining, dissipated work across normals.
//!
//! `d - h u_n'` is the overlap predicted from the velocity of the step along the normal at its start. Grains move on straight
//! lines, so the overlap at the end differs. For each contact the ledger compares expected and actual stored energy, and books
//! the difference by its cause, so that the balance closes to rounding:
//!
//! - first touch: a contact without stored energy at the start of the step has some at its end. No force did this work, because
//!   none acts across a gap. Long steps add this energy to fast impacts; restitution removes most of it.
//! - turning: the two bodies also moved across their normal, which rotates with them, or along a curved surface.
//! - let go: a contact with stored energy ended: the grain has passed the rim of a disc.
//! - wall paths: a wall did not move straight along the normal for the whole step: it turned, started, stopped or moved across. The
//!   entry is the difference between the overlap with the face at the end and the overlap with the face at the start, advanced
//!   along the normal at its velocity in the solve.

//!
//! A step changes angular momentum about the origin from `sum x x m v + I w` to `sum x' x m v' + I w'`. Since `x' = x + h v'`,
//! centres count at their positions at the start. Friction between grains acts on arms of full radii, while the centres are only
//! `a + b - d` apart: an impulse P on the second grain changes the sum by `-d n x P`, an entry of its own.

mod balance;
mod walls;

pub use balance::Balance;
pub(crate) use walls::{WallContact, WallImpulse};

use super::energy::{ContactEnergy, Energy, Stored};
use crate::Simulation;
use crate::detect::Candidates;
use crate::effects::spring::SpringLanes;
use crate::groups::ContactLanes;
use crate::lanes::{Eight, cross, dot, minus, plus, times};
use crate::laws::cohesion::Pull;
use crate::laws::compliance::{NormalContact, NormalScheme};
use crate::partition::TaskGroups;
use crate::simulation::intervention::Booked;
use crate::world::{Body, Sphere, World};
use balance::{Expectations, Expected};
use nalgebra::Vector3;
use serde::{Deserialize, Serialize};

/// Ledger state carried from step to step.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
pub(crate) struct Ledger {
    start: Energy,
    momentum_start: [f64; 3],
    angular_momentum_start: [f64; 3],
    pub entries: Entries,
    /// Stored energy of contacts at the end of the last step.
    stored: Stored,
    /// True if no candidate list existed when the ledger was opened, so that the stored energy was unknown.
    unlisted: bool,
    /// Expected stored energy of contacts at the end of the step.
    #[serde(skip)]
    expectations: Expectations,
    /// Surface speeds at the start of the step, by body index.
    #[serde(skip)]
    scaled_spins: Vec<[f64; 3]>,
}

#[derive(Clone, Copy, Debug, Default, Serialize, Deserialize)]
pub(crate) struct Entries {
    friction: f64,
    /// Net energy taken up by tangential springs, J; stored separately in checkpoints, since few scenes have springs.
    #[serde(skip)]
    pub springs: f64,
    resistance: f64,
    restitution: f64,
    stabilisation: f64,
    first_touch: f64,
    turning: f64,
    let_go: f64,
    wall_paths: f64,
    walls: f64,
    changing_gravity: f64,
    inflow: Booked,
    outflow: Booked,
    gravity_impulse: [f64; 3],
    wall_impulse: [f64; 3],
    gravity_angular_impulse: [f64; 3],
    wall_angular_impulse: [f64; 3],
    overlap_angular_impulse: [f64; 3],
    period_angular_impulse: [f64; 3],
}

/// Adds a vector to a sum.
fn add(sum: &mut [f64; 3], vector: [f64; 3]) {
    *sum = plus(*sum, vector);
}

impl Ledger {
    /// Opens a ledger at the present state.
    pub fn open(simulation: &Simulation) -> Ledger {
        let (start, momentum_start) = (simulation.energy_half_a_step_earlier(), simulation.momentum());
        let angular_momentum_start = simulation.angular_momentum();
        let stored = Stored { elastic: start.elastic, cohesive: start.cohesive };
        let unlisted = simulation.candidates.built_from().is_none();
        Ledger { start, momentum_start, angular_momentum_start, stored, unlisted, ..Ledger::default() }
    }

    /// Notes the state at the start of a step, after grains were sorted and before any force acts. A `rebuilt` list may add
    /// contacts: their stored energy counts as first touch or, if the caller has `disturbed` the state since the last step, as
    /// external. Returns the external part, J.
    pub fn begin(
        &mut self,
        world: &World,
        candidates: &Candidates,
        scheme: &NormalScheme,
        [rebuilt, disturbed]: [bool; 2],
    ) -> f64 {
        self.scaled_spins.clear();
        self.scaled_spins.extend(world.bodies.iter().map(|body| body.scaled_spin));
        if !rebuilt && !self.unlisted {
            return 0.0;
        }
        let stored = ContactEnergy::of(world, candidates, scheme.law).stored;
        let found = stored.total() - self.stored.total();
        self.stored = stored;
        if std::mem::take(&mut self.unlisted) {
            (self.start.elastic, self.start.cohesive) = (stored.elastic, stored.cohesive);
            return 0.0;
        }
        if disturbed {
            return found;
        }
        self.entries.first_touch += found;
        0.0
    }

    /// Books grains that `[come, go]` with their energy and momenta; `stored` is the elastic and cohesive energy (J) of the
    /// contacts of those that go. New grains have no overlap.
    pub fn exchange(&mut self, [come, go]: [&Booked; 2], stored: Stored) {
        let go = Booked { energy: go.energy + stored.elastic + stored.cohesive, ..*go };
        self.entries.inflow = self.entries.inflow.with(come);
        self.entries.outflow = self.entries.outflow.with(&go);
        self.stored.elastic -= stored.elastic;
        self.stored.cohesive -= stored.cohesive;
    }

    /// Restarts from the present stored energy of contacts, after an external change of the state.
    pub fn restart_stored(&mut self, world: &World, candidates: &Candidates, scheme: &NormalScheme) {
        self.stored = ContactEnergy::of(world, candidates, scheme.law).stored;
    }

    /// Books a change of gravity from the value `before` (m/s2), after a step of length `h` (s) has moved the grains.
    pub fn change_gravity(&mut self, world: &World, before: Vector3<f64>, h: f64) {
        self.entries.changing_gravity += work_of_changing_gravity(world, before, h);
    }

    /// Books the work of a step's impulses, before the grains move.
    pub fn note(&mut self, simulation: &Simulation, scheme: &NormalScheme) {
        let Simulation { world, candidates, layout, .. } = simulation;
        self.expectations.restart(world, candidates, scheme.step);
        let fall: [f64; 3] = (world.gravity * scheme.step).into();
        for (sphere, body) in world.spheres[..world.grains()].iter().zip(&world.bodies) {
            let impulse = times(fall, 1.0 / body.inverse_mass);
            add(&mut self.entries.gravity_impulse, impulse);
            add(&mut self.entries.gravity_angular_impulse, cross(sphere.centre.into(), impulse));
        }
        for (_, task) in layout.tasks() {
            self.torques_of_pairs(world, task);
            for (number, (group, sources)) in task.pairs.iter().zip(&task.pair_sources).enumerate() {
                for (lane, source) in sources.occupied() {
                    let (i, j) = (group.first[lane] as usize, group.second[lane] as usize);
                    let normal = group.contacts.normal(lane);
                    let (first, second) = (self.passage(world, i, normal, 1.0), self.passage(world, j, normal, -1.0));
                    let [before, after] = [0, 1].map(|end| minus(second[end], first[end]));
                    let (contact, pull) = world.pair_contact(&candidates.pairs[source]);
                    let contact = NormalContact { velocity: dot(normal, before), ..contact };
                    let pull_impulse = task.pair_pulls.get(number).map_or(0.0, |pulls| pulls.0[lane]);
                    let in_impact = task.pair_impacts[number].speed[lane] > 0.0;
                    let borne = Borne { in_impact, ..Borne::of(&group.contacts, lane, pull_impulse) };
                    self.turn_pair(world, [i, j], &borne);
                    self.expectations.pairs[source] = self.contact(&borne, contact, pull, [before, after], scheme);
                }
            }
        }
        simulation.for_each_wall_contact(|one| {
            let (place, candidate) = (one.candidate.body as usize, &one.candidate);
            let normal = one.normal;
            let grain = self.passage(world, place, normal, 1.0);
            let [before, after] = one.velocities;
            let face = world.walls.placed(&self.expectations.poses).face(candidate.surface);
            let approach = minus(minus(before, face.gain_at(&world.spheres[place].centre).into()), grain[0]);
            let (contact, pull) = world.wall_contact(candidate, face.distance(&world.spheres[place].centre));
            let contact = NormalContact { velocity: dot(normal, approach), ..contact };
            let WallContact { tangential, springs, in_impact, .. } = *one;
            let borne = Borne { normal, along: one.along(), tangential, springs, in_impact };
            let passages = [minus(before, grain[0]), minus(after, grain[1])];
            let expected = self.contact(&borne, contact, pull, passages, scheme);
            self.expectations.walls[one.source] = expected;
            self.expectations.advances[one.source] = times(normal, scheme.step * dot(normal, after));
            self.entries.resistance -= dot(one.angular_impulse, minus(one.mean_spin(), self.mean_spin(world, place)));
            // The grain receives the opposite impulse.
            self.entries.walls += one.work();
            let (impulse, sphere) = (times(one.impulse(), -1.0), &world.spheres[place]);
            let point = plus(sphere.centre.into(), times(normal, sphere.radius));
            add(&mut self.entries.wall_impulse, impulse);
            add(&mut self.entries.wall_angular_impulse, minus(cross(point, impulse), one.angular_impulse));
        });
    }

    /// Books the losses by restitution and friction in an impact of two grains outside of the solve, J; its angular momentum error, and
    /// the part of a period between the two grains, kg m2/s.
    pub fn book_impact(&mut self, [restitution, friction]: [f64; 2], [overlap, period]: [[f64; 3]; 2]) {
        self.entries.restitution += restitution;
        self.entries.friction += friction;
        add(&mut self.entries.overlap_angular_impulse, overlap);
        add(&mut self.entries.period_angular_impulse, period);
    }

    /// Compares the stored energy after grains and walls have moved with the expected energy.
    pub fn settle(&mut self, world: &World, candidates: &Candidates, scheme: &NormalScheme) {
        let Ledger { entries, expectations, stored, .. } = self;
        let mut differences = balance::Differences::default();
        *stored = expectations.compare(world, candidates, scheme.law, &mut differences);
        entries.first_touch += differences.first_touch;
        entries.turning += differences.turning;
        entries.let_go += differences.let_go;
        entries.wall_paths += differences.wall_paths;
    }

    /// Books the angular momentum error of a pair: friction acts on arms longer than the distance of the centres, and across a
    /// period the two impulses act a period apart.
    fn turn_pair(&mut self, world: &World, [first, second]: [usize; 2], borne: &Borne) {
        let gap = world.pair_geometry(first, second).gap;
        add(&mut self.entries.overlap_angular_impulse, times(cross(borne.normal, borne.tangential), gap));
        if world.period.any() {
            let apart = world.spheres[second].centre - world.spheres[first].centre - world.arm(first, second);
            let impulse = plus(times(borne.normal, borne.along), borne.tangential);
            add(&mut self.entries.period_angular_impulse, cross(apart.into(), impulse));
        }
    }

    /// Mean angular velocity of a grain over the step, rad/s.
    fn mean_spin(&self, world: &World, place: usize) -> [f64; 3] {
        let (before, body) = (self.scaled_spins[place], &world.bodies[place]);
        times(plus(before, body.scaled_spin), 0.5 * body.inverse_radius)
    }

    /// Books the work of the torques of a task's pairs.
    fn torques_of_pairs(&mut self, world: &World, task: &TaskGroups) {
        for ((group, sources), torques) in task.pairs.iter().zip(&task.pair_sources).zip(&task.pair_torques) {
            for (lane, _) in sources.occupied() {
                let mean = |place: u32| self.mean_spin(world, place as usize);
                let turning = minus(mean(group.second[lane]), mean(group.first[lane]));
                self.entries.resistance -= dot(torques.angular_impulse(lane), turning);
            }
        }
    }

    /// Velocities of a grain at its contact before and after the solve; the surface moves with `s x n` on the first side and opposite to it on the second.
    fn passage(&self, world: &World, place: usize, normal: [f64; 3], side: f64) -> [[f64; 3]; 2] {
        let body = &world.bodies[place];
        let [x, y, z, _] = world.before[place].0;
        let surface = |speed: [f64; 3]| times(cross(speed, normal), side);
        let before = plus([x, y, z], surface(self.scaled_spins[place]));
        [before, plus(body.velocity, surface(body.scaled_spin))]
    }

    /// Books one contact in its state at the start of the step, given its relative velocities before and after; returns its
    /// expected stored energy at the end.
    fn contact(
        &mut self,
        borne: &Borne,
        contact: NormalContact<f64>,
        pull: Pull,
        [before, after]: [[f64; 3]; 2],
        scheme: &NormalScheme,
    ) -> Expected {
        let Borne { normal, along, tangential, springs, in_impact } = *borne;
        let mean = times(plus(before, after), 0.5);
        let entries = &mut self.entries;
        entries.friction -= dot(tangential, mean) + springs;
        entries.springs += springs;
        let later = NormalContact { overlap: contact.overlap - scheme.step * dot(normal, after), ..contact };
        let (now, then) = (Stored::of(&contact, &pull, scheme.law), Stored::of(&later, &pull, scheme.law));
        // Across a gap no force does work for the stored energy.
        let expected = Expected {
            elastic: (contact.overlap > 0.0).then_some(then.elastic),
            cohesive: (-contact.overlap <= pull.range).then_some(then.cohesive),
        };
        let gained = expected.elastic.map_or(0.0, |then| then - now.elastic)
            + expected.cohesive.map_or(0.0, |then| then - now.cohesive);
        let loss = -along * dot(normal, mean) - gained;
        let impact = in_impact || contact.velocity < -scheme.restitution_threshold;
        match impact || contact.constraint(scheme, 0.0).resolves_impact {
            true => entries.restitution += loss,
            false => entries.stabilisation += loss,
        }
        expected
    }
}

/// Impulses of one contact: net normal impulse including cohesion, and tangential impulse, N s.
struct Borne {
    normal: [f64; 3],
    along: f64,
    tangential: [f64; 3],
    /// Energy stored by the tangential spring, J.
    springs: f64,
    /// True if the contact is in an impact.
    in_impact: bool,
}

impl Borne {
    fn of(lanes: &ContactLanes<Eight, SpringLanes>, lane: usize, pull: f64) -> Borne {
        let tangential = lanes.tangential_impulse(lane);
        Borne {
            normal: lanes.normal(lane),
            along: lanes.normal_impulse(lane) - pull,
            tangential,
            springs: lanes.tangential.spring.taken_up(lane, tangential),
            in_impact: false,
        }
    }
}

/// Potential energy (J) gained by grains at fixed positions when gravity changes from `before` (m/s2), after a step of length `h`
/// (s) has moved them. Positions are taken half a step earlier, as for all potential energy in a ledger.
pub(crate) fn work_of_changing_gravity(world: &World, before: Vector3<f64>, h: f64) -> f64 {
    let change = world.gravity - before;
    if change == Vector3::zeros() {
        return 0.0;
    }
    let gained = |(sphere, body): (&Sphere, &Body)| {
        let place = sphere.centre - Vector3::from(body.velocity) * (0.5 * h);
        -change.dot(&place) / body.inverse_mass
    };
    world.spheres[..world.grains()].iter().zip(&world.bodies).map(gained).sum()
}

impl Simulation {
    /// Opens a ledger; it costs about a fifth of a step of ten sweeps.
    pub fn open_ledger(&mut self) {
        self.ledger = Some(Ledger::open(self));
        self.interventions.booked = Booked::default();
        self.note_known_energy();
    }

    /// Returns the balance since the ledger was opened; `None` without a ledger.
    pub fn balance(&self) -> Option<Balance> {
        let Ledger { start, momentum_start, angular_momentum_start, entries, .. } = self.ledger.as_ref()?;
        let outside = self.interventions.booked;
        let (end, momentum_end) = (self.energy_half_a_step_earlier(), self.momentum());
        let angular_momentum_end = self.angular_momentum();
        let closure = |[start, end]: [[f64; 3]; 2], gained: &[[f64; 3]], lost| {
            plus(gained.iter().fold(minus(end, start), |left, entry| minus(left, *entry)), lost)
        };
        let balance = Balance {
            start: *start,
            end,
            friction: entries.friction,
            springs: entries.springs,
            resistance: entries.resistance,
            restitution: entries.restitution,
            stabilisation: entries.stabilisation,
            first_touch: entries.first_touch,
            turning: entries.turning,
            let_go: entries.let_go,
            wall_paths: entries.wall_paths,
            walls: entries.walls,
            changing_gravity: entries.changing_gravity,
            inflow: entries.inflow.energy,
            outflow: entries.outflow.energy,
            closure: 0.0,
            momentum_start: *momentum_start,
            momentum_end,
            gravity_impulse: entries.gravity_impulse,
            wall_impulse: entries.wall_impulse,
            outside: outside.energy,
            outside_impulse: outside.impulse,
            inflow_impulse: entries.inflow.impulse,
            outflow_impulse: entries.outflow.impulse,
            momentum_closure: closure(
                [*momentum_start, momentum_end],
                &[entries.gravity_impulse, entries.wall_impulse, outside.impulse, entries.inflow.impulse],
                entries.outflow.impulse,
            ),
            angular_momentum_start: *angular_momentum_start,
            angular_momentum_end,
            gravity_angular_impulse: entries.gravity_angular_impulse,
            wall_angular_impulse: entries.wall_angular_impulse,
            overlap_angular_impulse: entries.overlap_angular_impulse,
            period_angular_impulse: entries.period_angular_impulse,
            outside_angular_impulse: outside.angular_impulse,
            inflow_angular_impulse: entries.inflow.angular_impulse,
            outflow_angular_impulse: entries.outflow.angular_impulse,
            angular_momentum_closure: closure(
                [*angular_momentum_start, angular_momentum_end],
                &[
                    entries.gravity_angular_impulse,
                    entries.wall_angular_impulse,
                    entries.overlap_angular_impulse,
                    entries.period_angular_impulse,
                    outside.angular_impulse,
                    entries.inflow.angular_impulse,
                ],
                entries.outflow.angular_impulse,
            ),
        };
        Some(Balance { closure: end.total() - start.total() - balance.gained() + balance.lost(), ..balance })
    }
}
