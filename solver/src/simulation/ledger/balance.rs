//! Balance of a ledger, and the energy that contacts store.

use crate::Simulation;
use crate::detect::Candidates;
use crate::lanes::{cross, plus, times};
use crate::laws::cohesion::Pull;
use crate::laws::compliance::{NormalContact, NormalLaw};
use crate::simulation::energy::{ContactEnergy, Energy};
use crate::wall::Pose;
use crate::world::{INVERSE_INERTIA, World};
use nalgebra::Vector3;
use serde::{Deserialize, Serialize};

/// Energy (J), momentum (kg m/s) and angular momentum about the origin (kg m2/s) since the ledger was opened.
///
/// Angular momentum is that of the grains where they are, of centres and of spins. With periodic axes it is that of unwrapped coordinates.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Balance {
    /// Energy at the start; potential energy half a step earlier, as in `end`.
    pub start: Energy,
    /// Energy at the end.
    pub end: Energy,
    /// Lost to friction.
    pub friction: f64,
    /// Taken up by tangential springs, less what they gave back.
    #[serde(default, skip_serializing_if = "is_zero")]
    pub springs: f64,
    /// Lost to resistance against rolling and twisting.
    #[serde(default)]
    pub resistance: f64,
    /// Lost in impacts.
    pub restitution: f64,
    /// Lost to the stabilisation of contacts at rest; negative where it gives.
    pub stabilisation: f64,
    /// Gained from what contacts store when they first touch, or first come within the range of cohesion.
    pub first_touch: f64,
    /// Gained from normals that turned, and surfaces that curve, while contacts stored energy.
    #[serde(default)]
    pub turning: f64,
    /// Lost from contacts that ended while they stored energy.
    #[serde(default)]
    pub let_go: f64,
    /// Gained from what walls did within a step besides going on straight along the normals of their contacts.
    #[serde(default)]
    pub wall_paths: f64,
    /// Work of the walls on the grains.
    pub walls: f64,
    /// Potential energy that grains gained where they were, because gravity changed.
    #[serde(default)]
    pub changing_gravity: f64,
    /// Gained from what the caller did: work of forces and torques, states that were written, grains that came or went.
    #[serde(default, skip_serializing_if = "is_zero")]
    pub outside: f64,
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
    /// Momentum that came with what the caller did.
    #[serde(default, skip_serializing_if = "are_zero")]
    pub outside_impulse: [f64; 3],
    /// Momentum at the end that is not accounted for.
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
    /// Angular momentum from friction between grains, which acts on arms of full radii although centres are closer by the overlap, and from
    /// impacts of fast grains, which act where the two are at the start of the step: the error of the method, of first order in the overlap,
    /// and in the path of a step.
    #[serde(default)]
    pub overlap_angular_impulse: [f64; 3],
    /// Angular momentum from contacts across a period, whose two impulses act a period apart.
    #[serde(default, skip_serializing_if = "are_zero")]
    pub period_angular_impulse: [f64; 3],
    /// Angular momentum that came with what the caller did.
    #[serde(default, skip_serializing_if = "are_zero")]
    pub outside_angular_impulse: [f64; 3],
    /// Angular momentum at the end that is not accounted for.
    #[serde(default)]
    pub angular_momentum_closure: [f64; 3],
}

/// Nobody did anything from outside: nothing is written of it.
fn is_zero(value: &f64) -> bool {
    *value == 0.0
}

/// As [`is_zero`].
fn are_zero(vector: &[f64; 3]) -> bool {
    *vector == [0.0; 3]
}

impl Balance {
    /// All that was lost, J, what springs hold included.
    pub fn lost(&self) -> f64 {
        self.friction + self.springs + self.resistance + self.restitution + self.stabilisation + self.let_go
    }

    /// All that was gained, J.
    pub fn gained(&self) -> f64 {
        self.walls + self.first_touch + self.turning + self.wall_paths + self.changing_gravity + self.outside
    }

    /// Exchanged energy, J: the sizes of all entries. It is what `closure` compares with.
    pub fn exchanged(&self) -> f64 {
        let lost = [self.friction, self.springs, self.resistance, self.restitution, self.stabilisation, self.let_go];
        let gained = [self.walls, self.first_touch, self.turning, self.wall_paths, self.changing_gravity, self.outside];
        lost.iter().chain(&gained).map(|entry| entry.abs()).sum()
    }
}

impl Simulation {
    /// Momentum of the grains, kg m/s.
    pub fn momentum(&self) -> [f64; 3] {
        let bodies = &self.world.bodies[..self.world.grains()];
        let momentum = |axis: usize| bodies.iter().map(|body| body.velocity[axis] / body.inverse_mass).sum();
        [momentum(0), momentum(1), momentum(2)]
    }

    /// Angular momentum of the grains about the origin, kg m2/s: of their centres, which count where they are and not as images inside the
    /// domain, and of their spins.
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

/// Energy that contacts store, J.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub(super) struct Stored {
    pub elastic: f64,
    pub cohesive: f64,
}

impl Stored {
    /// Of one contact.
    pub fn of(contact: &NormalContact<f64>, pull: &Pull, law: NormalLaw) -> Stored {
        Stored { elastic: contact.elastic_energy(law), cohesive: pull.energy(-contact.overlap) }
    }

    /// Of all that a candidate list knows.
    pub fn of_all(world: &World, candidates: &Candidates, law: NormalLaw) -> Stored {
        let ContactEnergy { elastic, cohesive, .. } = ContactEnergy::of(world, candidates, law);
        Stored { elastic, cohesive }
    }

    pub fn total(&self) -> f64 {
        self.elastic + self.cohesive
    }
}

/// Expected stored energy of a contact at the end of a step, J; absent where nothing worked for it, because nothing acted at the start.
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

    /// `beside` is what it would store if the wall had gone on straight along the normal; absent where the contact is no more.
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
    /// Walls at the start of the step.
    pub poses: Vec<Pose>,
}

impl Expectations {
    /// Expects nothing yet of a step of length `h`, s.
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

    /// Compares with the state that the step has led to; returns what is stored.
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
            sum = sum.plus(stored);
        }
        let poses: Vec<_> = world.walls.poses(world.time).collect();
        let (before, after) = (world.walls.placed(&self.poses), world.walls.placed(&poses));
        for ((wall, expected), advance) in candidates.walls.iter().zip(&self.walls).zip(&self.advances) {
            let centre = &world.spheres[wall.body as usize].centre;
            let distance = after.face(wall.surface).distance(centre);
            let beside = before.face(wall.surface).distance(&(centre - Vector3::from(*advance)));
            let at = |distance: f64| {
                let (contact, pull) = world.wall_contact(wall, distance);
                Stored::of(&contact, &pull, law)
            };
            let stored = at(distance);
            let beside = (distance.is_finite() && beside.is_finite()).then(|| at(beside));
            differences.add_wall(stored.elastic, beside.map(|one| one.elastic), expected.elastic);
            differences.add_wall(stored.cohesive, beside.map(|one| one.cohesive), expected.cohesive);
            sum = sum.plus(stored);
        }
        sum
    }
}

impl Stored {
    fn plus(self, other: Stored) -> Stored {
        Stored { elastic: self.elastic + other.elastic, cohesive: self.cohesive + other.cohesive }
    }
}
