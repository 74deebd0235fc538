//! Mechanical energy of a state.

use crate::Simulation;
use crate::detect::Candidates;
use crate::laws::cohesion::Pull;
use crate::laws::compliance::{NormalContact, NormalLaw};
use crate::partition::PlannedTask;
use crate::simulation::Request;
use crate::world::{INERTIA, World};
use serde::{Deserialize, Serialize};
use std::ops::Range;

/// Mechanical energy, J.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Energy {
    /// Kinetic energy of translation and rotation.
    pub kinetic: f64,
    /// Potential energy in the field of gravity, zero at the origin.
    pub potential: f64,
    /// Elastic energy of the overlaps.
    pub elastic: f64,
    /// Potential energy of cohesion, zero if no pair is within its range.
    #[serde(default)]
    pub cohesive: f64,
}

impl Energy {
    /// Total energy, J.
    pub fn total(&self) -> f64 {
        self.kinetic + self.potential + self.elastic + self.cohesive
    }
}

/// Stored energy of contacts, J.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub(crate) struct Stored {
    pub elastic: f64,
    pub cohesive: f64,
}

impl Stored {
    /// Energy of one contact.
    pub fn of(contact: &NormalContact<f64>, pull: &Pull, law: NormalLaw) -> Stored {
        Stored { elastic: contact.elastic_energy(law), cohesive: pull.energy(-contact.overlap) }
    }

    pub fn total(&self) -> f64 {
        self.elastic + self.cohesive
    }

    /// Adds the energy of other contacts.
    pub fn add(&mut self, other: Stored) {
        self.elastic += other.elastic;
        self.cohesive += other.cohesive;
    }
}

/// Energy of contacts, and the deepest overlap.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct ContactEnergy {
    /// Stored energy.
    pub stored: Stored,
    /// Largest overlap over the smaller radius, and the id of a grain with this overlap.
    pub deepest: Option<(f64, u32)>,
}

impl Simulation {
    /// Mechanical energy of the present state, J.
    pub fn energy(&self) -> Energy {
        self.energy_with(&self.contact_energy())
    }

    /// Mechanical energy with the known energy of the contacts, J.
    pub(crate) fn energy_with(&self, contacts: &ContactEnergy) -> Energy {
        let Stored { elastic, cohesive } = contacts.stored;
        Energy { elastic, cohesive, ..self.energy_of_grains() }
    }

    /// Kinetic and potential energy, J.
    pub(crate) fn energy_of_grains(&self) -> Energy {
        let mut energy = Energy::default();
        for (sphere, body) in self.world.spheres[..self.world.grains()].iter().zip(&self.world.bodies) {
            let mass = 1.0 / body.inverse_mass;
            let square = |vector: &[f64; 3]| vector.iter().map(|x| x * x).sum::<f64>();
            energy.kinetic += 0.5 * mass * (square(&body.velocity) + INERTIA * square(&body.scaled_spin));
            energy.potential -= mass * self.world.gravity.dot(&sphere.centre);
        }
        energy
    }

    /// Energy of the contacts, and the deepest overlap.
    pub(crate) fn contact_energy(&self) -> ContactEnergy {
        self.contact_energy_of(|_| true)
    }

    /// Energy of the contacts whose places satisfy a predicate, on all ranks; a wall counts as the place of its grain.
    pub(crate) fn contact_energy_of(&self, are_these: impl Fn([u32; 2]) -> bool) -> ContactEnergy {
        let Simulation { world, candidates, settings, .. } = self;
        let Some(ranks) = self.together(Request::Energy) else {
            return ContactEnergy::of_some(world, candidates, settings.normal_law, are_these);
        };
        let terms = |task: &PlannedTask, walls: bool| {
            let (mut terms, none) = (Vec::new(), 0..0);
            let [pairs, walls] = if walls { [&none, &task.walls] } else { [&task.pairs, &none] };
            let ranges = [pairs, walls].map(|range| range.start as usize..range.end as usize);
            for_each_term(world, candidates, settings.normal_law, ranges, &are_these, |term| terms.push(term));
            terms
        };
        let mut sum = ContactEnergy::default();
        for walls in [false, true] {
            let own = self.layout.plan.tasks().iter().map(|task| terms(task, walls)).collect();
            ranks.merge(own).into_iter().flatten().for_each(|term| sum.add(term));
        }
        sum
    }

    /// Largest overlap of two grains, or of a grain and a wall, over the smaller radius; the radius of a wall counts as infinite.
    /// Above 1, a centre lies inside its partner. Zero without overlaps.
    pub fn largest_overlap(&self) -> f64 {
        self.contact_energy().deepest.map_or(0.0, |(share, _)| share)
    }
}

impl ContactEnergy {
    /// Sums the energy of the candidates of a list.
    pub fn of(world: &World, candidates: &Candidates, law: NormalLaw) -> ContactEnergy {
        ContactEnergy::of_some(world, candidates, law, |_| true)
    }

    /// Sums the energy of the candidates whose places satisfy a predicate; a wall counts as the place of its grain.
    pub fn of_some(
        world: &World,
        candidates: &Candidates,
        law: NormalLaw,
        are_these: impl Fn([u32; 2]) -> bool,
    ) -> ContactEnergy {
        let mut sum = ContactEnergy::default();
        let ranges = [0..candidates.pairs.len(), 0..candidates.walls.len()];
        for_each_term(world, candidates, law, ranges, are_these, |term| sum.add(term));
        sum
    }

    fn add(&mut self, Term { stored, share, grain }: Term) {
        self.stored.add(stored);
        if share > 0.0 && self.deepest.is_none_or(|(most, _)| share > most) {
            self.deepest = Some((share, grain));
        }
    }
}

/// Energy of one contact, its overlap over the radius, and the id of its first grain.
#[derive(Clone, Copy, Debug, Serialize, Deserialize)]
struct Term {
    stored: Stored,
    share: f64,
    grain: u32,
}

/// Calls a function for each contact among ranges of pairs and walls of a list whose places satisfy a predicate.
fn for_each_term(
    world: &World,
    candidates: &Candidates,
    law: NormalLaw,
    [pairs, walls]: [Range<usize>; 2],
    are_these: impl Fn([u32; 2]) -> bool,
    mut add: impl FnMut(Term),
) {
    let mut take = |(contact, pull): (NormalContact<f64>, Pull), radius: f64, grain: usize| {
        if contact.overlap > -pull.range {
            let stored = Stored::of(&contact, &pull, law);
            add(Term { stored, share: contact.overlap / radius, grain: world.ids[grain] });
        }
    };
    // Most candidates are apart: this test needs neither a square root nor their materials.
    let range = world.range_of_cohesion();
    for pair in candidates.pairs[pairs].iter().filter(|pair| are_these([pair.first, pair.second])) {
        let (first, second) = (pair.first as usize, pair.second as usize);
        let (a, b) = (world.spheres[first].radius, world.spheres[second].radius);
        if world.arm(first, second).norm_squared() <= (a + b + range).powi(2) * (1.0 + 1e-9) {
            take(world.pair_contact(pair), a.min(b), first);
        }
    }
    let poses: Vec<_> = world.walls.poses(world.time).collect();
    let placed = world.walls.placed(&poses);
    let mut last = None;
    for wall in candidates.walls[walls].iter().filter(|wall| are_these([wall.body; 2])) {
        let sphere = &world.spheres[wall.body as usize];
        if let Some(mesh) = world.walls.mesh_of(wall.surface) {
            // All slots of the grain at once.
            if last.replace((wall.body, mesh)) != Some((wall.body, mesh)) {
                for contact in placed.minima(mesh, &sphere.centre, sphere.radius + range).list() {
                    take(world.wall_contact(wall, contact.distance), sphere.radius, wall.body as usize);
                }
            }
            continue;
        }
        let distance = placed.distance(wall.surface, &sphere.centre);
        if distance <= (sphere.radius + range) * (1.0 + 1e-9) {
            take(world.wall_contact(wall, distance), sphere.radius, wall.body as usize);
        }
    }
}
