//! Balance of a ledger, and the stored energy of contacts.

use crate::Simulation;
use crate::detect::Candidates;
use crate::lanes::{cross, plus, times};
use crate::laws::compliance::NormalLaw;
use crate::simulation::energy::{Energy, Stored};
use crate::surface::MOST_CONTACTS;
use crate::wall::{Pose, WallsAt};
use crate::world::{INVERSE_INERTIA, World};
use nalgebra::Vector3;
use serde::{Deserialize, Serialize};

/// Energy (J), momentum (kg m/s) and angular momentum about the origin (kg m2/s) since the ledger was opened.
///
/// Angular momentum covers the centres and the spins of the grains. With periodic axes, centres count in unwrapped coordinates.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Balance {
    /// Energy at the start, with the potential energy half a step earlier, as in `end`.
    pub start: Energy,
    /// Energy at the end.
    pub end: Energy,
    /// Lost to friction.
    pub friction: f64,
    /// Net energy stored by tangential springs.
    #[serde(default, skip_serializing_if = "crate::is_default")]
    pub springs: f64,
    /// Lost to resistance against rolling and twisting.
    #[serde(default)]
    pub resistance: f64,
    /// Lost in impacts.
    pub restitution: f64,
    /// Lost to the stabilisation of contacts at rest; negative if stabilisation adds energy.
    pub stabilisation: f64,
    /// Gained from stored energy at first contact, or at first entry into the range of cohesion.
    pub first_touch: f64,
    /// Gained from rotating normals and curved surfaces while contacts stored energy.
    #[serde(default)]
    pub turning: f64,
    /// Lost from contacts that ended while they stored energy.
    #[serde(default)]
    pub let_go: f64,
    /// Gained from wall motion within a step, other than straight motion along the normals of the contacts.
    #[serde(default)]
    pub wall_paths: f64,
    /// Work of the walls on the grains.
    pub walls: f64,
    /// Potential energy gained by grains at fixed positions because gravity changed.
    #[serde(default)]
    pub changing_gravity: f64,
    /// Gained from actions of the caller: work of forces and torques, written states, inserted and removed grains.
    #[serde(default, skip_serializing_if = "crate::is_default")]
    pub outside: f64,
    /// Energy of grains that came from sources.
    #[serde(default, skip_serializing_if = "crate::is_default")]
    pub inflow: f64,
    /// Energy of grains that went into sinks, with the stored energy of their contacts.
    #[serde(default, skip_serializing_if = "crate::is_default")]
    pub outflow: f64,
    /// Energy at the end without an entry.
    pub closure: f64,
    /// Momentum at the start.
    pub momentum_start: [f64; 3],
    /// Momentum at the end.
    pub momentum_end: [f64; 3],
    /// Impulse of gravity.
    pub gravity_impulse: [f64; 3],
    /// Impulse of the walls.
    pub wall_impulse: [f64; 3],
    /// Momentum added by actions of the caller.
    #[serde(default, skip_serializing_if = "crate::is_default")]
    pub outside_impulse: [f64; 3],
    /// Momentum of grains that came from sources.
    #[serde(default, skip_serializing_if = "crate::is_default")]
    pub inflow_impulse: [f64; 3],
    /// Momentum of grains that went into sinks.
    #[serde(default, skip_serializing_if = "crate::is_default")]
    pub outflow_impulse: [f64; 3],
    /// Momentum at the end without an entry.
    pub momentum_closure: [f64; 3],
    /// Angular momentum at the start.
    #[serde(default)]
    pub angular_momentum_start: [f64; 3],
    /// Angular momentum at the end.
    #[serde(default)]
    pub angular_momentum_end: [f64; 3],
    /// Angular impulse of gravity.
    #[serde(default)]
    pub gravity_angular_impulse: [f64; 3],
    /// Angular impulse of the walls.
    #[serde(default)]
    pub wall_angular_impulse: [f64; 3],
    /// Angular momentum from two errors of the method. Friction between grains acts on arms of full radii although centres are
    /// closer by the overlap. Impacts of fast grains act at the positions at the start of the step. Both are of first order, in
    /// the overlap and in the path of a step.
    #[serde(default)]
    pub overlap_angular_impulse: [f64; 3],
    /// Angular momentum from contacts across a period: their two impulses act a period apart.
    #[serde(default, skip_serializing_if = "crate::is_default")]
    pub period_angular_impulse: [f64; 3],
    /// Angular momentum added by actions of the caller.
    #[serde(default, skip_serializing_if = "crate::is_default")]
    pub outside_angular_impulse: [f64; 3],
    /// Angular momentum of grains that came from sources.
    #[serde(default, skip_serializing_if = "crate::is_default")]
    pub inflow_angular_impulse: [f64; 3],
    /// Angular momentum of grains that went into sinks.
    #[serde(default, skip_serializing_if = "crate::is_default")]
    pub outflow_angular_impulse: [f64; 3],
    /// Angular momentum at the end without an entry.
    #[serde(default)]
    pub angular_momentum_closure: [f64; 3],
}

impl Balance {
    /// Returns the losses, then the gains, J; those by grains that went and came are last.
    fn entries(&self) -> [[f64; 7]; 2] {
        let lost = [self.friction, self.springs, self.resistance, self.restitution, self.stabilisation, self.let_go];
        let gained = [self.walls, self.first_touch, self.turning, self.wall_paths, self.changing_gravity, self.outside];
        let with = |[a, b, c, d, e, f]: [f64; 6], last: f64| [a, b, c, d, e, f, last];
        [with(lost, self.outflow), with(gained, self.inflow)]
    }

    /// Total loss, J, including the energy stored in springs.
    pub fn lost(&self) -> f64 {
        self.entries()[0].iter().sum()
    }

    /// Total gain, J.
    pub fn gained(&self) -> f64 {
        self.entries()[1].iter().sum()
    }

    /// Exchanged energy, J: the sum of the magnitudes of all entries, and the scale of `closure`.
    pub fn exchanged(&self) -> f64 {
        let lost = [self.friction, self.springs, self.resistance, self.restitution, self.stabilisation, self.let_go];
        let gained = [self.walls, self.first_touch, self.turning, self.wall_paths, self.changing_gravity, self.outside];
        let flow = [self.inflow, self.outflow];
        lost.iter().chain(&gained).chain(&flow).map(|entry| entry.abs()).sum()
    }
}

impl Simulation {
    /// Momentum of the grains, kg m/s.
    pub fn momentum(&self) -> [f64; 3] {
        let bodies = &self.world.bodies[..self.world.grains()];
        let momentum = |axis: usize| bodies.iter().map(|body| body.velocity[axis] / body.inverse_mass).sum();
        [momentum(0), momentum(1), momentum(2)]
    }

    /// Angular momentum of the grains about the origin, kg m2/s, of their centres and spins. Centres count in unwrapped
    /// coordinates, not as images inside the domain.
    pub fn angular_momentum(&self) -> [f64; 3] {
        let grains = self.world.spheres[..self.world.grains()].iter().zip(&self.world.bodies);
        grains.fold([0.0; 3], |sum, (sphere, body)| {
            let orbit = cross(sphere.centre.into(), body.velocity);
            let own = times(body.scaled_spin, sphere.radius / INVERSE_INERTIA);
            plus(sum, times(plus(orbit, own), 1.0 / body.inverse_mass))
        })
    }

    /// Energy with the potential energy of grains half a step earlier, at `x - h v/2`: without contacts no step changes it.
    pub(crate) fn energy_half_a_step_earlier(&self) -> Energy {
        let mut energy = self.energy();
        let (momentum, half) = (self.momentum(), 0.5 * self.settings.step);
        energy.potential += half * (0..3).map(|axis| self.world.gravity[axis] * momentum[axis]).sum::<f64>();
        energy
    }
}

/// Expected stored energy of a contact at the end of a step, J; `None` if no force acted at the start, so that no work was done.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Expected {
    pub elastic: Option<f64>,
    pub cohesive: Option<f64>,
}

/// Differences from the expected energy, J: see the entries of [`Balance`](super::Balance).
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Differences {
    pub first_touch: f64,
    pub turning: f64,
    pub let_go: f64,
    pub wall_paths: f64,
}

impl Differences {
    fn add_pair(&mut self, stored: f64, expected: Option<f64>) {
        match expected {
            Some(expected) => self.turning += stored - expected,
            None => self.first_touch += stored,
        }
    }

    /// `beside` is the stored energy for straight motion of the wall along the normal; `None` if the contact has ended.
    fn add_wall(&mut self, stored: f64, beside: Option<f64>, expected: Option<f64>) {
        match (expected, beside) {
            (Some(expected), Some(beside)) => {
                self.turning += beside - expected;
                self.wall_paths += stored - beside;
            }
            (Some(expected), None) => self.let_go += expected - stored,
            (None, _) => self.first_touch += stored,
        }
    }
}

/// Expected stored energy of the candidates of a step; its buffers are reused.
#[derive(Clone, Debug, Default)]
pub(super) struct Expectations {
    /// By candidate.
    pub pairs: Vec<Expected>,
    /// By candidate.
    pub walls: Vec<Expected>,
    /// Advance of the walls along the normals, m, by candidate.
    pub advances: Vec<[f64; 3]>,
    /// Poses of the walls at the start of the step.
    pub poses: Vec<Pose>,
}

impl Expectations {
    /// Clears the expectations for a step of length `h`, s.
    pub fn restart(&mut self, world: &World, candidates: &Candidates, h: f64) {
        self.pairs.clear();
        self.pairs.resize(candidates.pairs.len(), Expected::default());
        self.walls.clear();
        self.walls.resize(candidates.walls.len(), Expected::default());
        self.advances.clear();
        self.advances.resize(candidates.walls.len(), [0.0; 3]);
        self.poses.clear();
        self.poses.extend(world.walls.poses_over(world.time, h));
    }

    /// Compares with the state at the end of the step; returns the stored energy.
    pub fn compare(
        &self,
        world: &World,
        candidates: &Candidates,
        law: NormalLaw,
        differences: &mut Differences,
    ) -> Stored {
        let mut sum = Stored::default();
        for (pair, expected) in candidates.pairs.iter().zip(&self.pairs) {
            let (contact, pull) = world.pair_contact(pair);
            let stored = Stored::of(&contact, &pull, law);
            differences.add_pair(stored.elastic, expected.elastic);
            differences.add_pair(stored.cohesive, expected.cohesive);
            sum.add(stored);
        }
        let poses: Vec<_> = world.walls.poses(world.time).collect();
        let (before, after) = (world.walls.placed(&self.poses), world.walls.placed(&poses));
        let (mut first, mut slots) = (0, None);
        for (place, ((wall, expected), advance)) in
            candidates.walls.iter().zip(&self.walls).zip(&self.advances).enumerate()
        {
            let centre = &world.spheres[wall.body as usize].centre;
            let beside = centre - Vector3::from(*advance);
            let [distance, beside] = match world.walls.mesh_of(wall.surface) {
                None => [after.face(wall.surface).distance(centre), before.face(wall.surface).distance(&beside)],
                Some(mesh) => {
                    if slots.is_none() || place >= first + MOST_CONTACTS {
                        first = place;
                        slots = Some(self.distances(world, (candidates, first), mesh, &after, centre));
                    }
                    let slot = place - first;
                    let beside = self.distances(world, (candidates, first), mesh, &before, &beside)[slot];
                    [slots.map_or(f64::INFINITY, |distances| distances[slot]), beside]
                }
            };
            let at = |distance: f64| match distance.is_finite() {
                true => {
                    let (contact, pull) = world.wall_contact(wall, distance);
                    Stored::of(&contact, &pull, law)
                }
                false => Stored::default(),
            };
            let stored = at(distance);
            let beside = (distance.is_finite() && beside.is_finite()).then(|| at(beside));
            differences.add_wall(stored.elastic, beside.map(|one| one.elastic), expected.elastic);
            differences.add_wall(stored.cohesive, beside.map(|one| one.cohesive), expected.cohesive);
            sum.add(stored);
        }
        sum
    }

    /// Distances (m) of a point from the contacts with a mesh in the slots of a grain, of which `first` is the first: the contacts that
    /// bore an impulse in the step, at their present faces, and new ones; infinite for slots without a contact.
    fn distances(
        &self,
        world: &World,
        (candidates, first): (&Candidates, usize),
        mesh: u32,
        walls: &WallsAt<'_>,
        point: &Vector3<f64>,
    ) -> [f64; MOST_CONTACTS] {
        let slots = first..first + MOST_CONTACTS;
        let radius = world.spheres[candidates.walls[first].body as usize].radius;
        let found = walls.minima(mesh, point, radius + world.range_of_cohesion());
        let mut known = [None; MOST_CONTACTS];
        for ((known, wall), expected) in known.iter_mut().zip(&candidates.walls[slots.clone()]).zip(&self.walls[slots])
        {
            *known = expected.elastic.or(expected.cohesive).map(|_| wall.surface);
        }
        let contacts = walls.assign_slots(mesh, point, &found, &known);
        contacts.map(|contact| contact.map_or(f64::INFINITY, |contact| contact.distance))
    }
}
