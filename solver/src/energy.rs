//! Mechanical energy of a state.

use crate::Simulation;
use crate::effects::cohesion::Pull;
use crate::effects::compliance::NormalContact;
use serde::{Deserialize, Serialize};

/// Mechanical energy, J.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Energy {
    /// Kinetic energy of translation and rotation.
    pub kinetic: f64,
    /// Potential energy in the field of gravity, zero at the origin.
    pub potential: f64,
    /// Elastic energy of the overlaps.
    pub elastic: f64,
    /// Potential energy of cohesion, zero where nothing is within its range.
    #[serde(default)]
    pub cohesive: f64,
}

impl Energy {
    /// All of it, J.
    pub fn total(&self) -> f64 {
        self.kinetic + self.potential + self.elastic + self.cohesive
    }
}

/// Energy of contacts, and the deepest of them.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct ContactEnergy {
    /// Elastic, J.
    pub elastic: f64,
    /// Cohesive, J.
    pub cohesive: f64,
    /// Largest overlap over the smaller radius, and the id of a grain that has it.
    pub deepest: Option<(f64, u32)>,
}

impl Simulation {
    /// Mechanical energy of the present state, J.
    pub fn energy(&self) -> Energy {
        let ContactEnergy { elastic, cohesive, .. } = self.contact_energy();
        Energy { elastic, cohesive, ..self.energy_of_grains() }
    }

    /// Kinetic and potential energy, J.
    pub(crate) fn energy_of_grains(&self) -> Energy {
        let mut energy = Energy::default();
        for (sphere, body) in self.world.spheres[..self.world.grains()].iter().zip(&self.world.bodies) {
            let mass = 1.0 / body.inverse_mass;
            let square = |vector: &[f64; 3]| vector.iter().map(|x| x * x).sum::<f64>();
            energy.kinetic += 0.5 * mass * (square(&body.velocity) + 0.4 * square(&body.surface_speed));
            energy.potential -= mass * self.world.gravity.dot(&sphere.centre);
        }
        energy
    }

    /// Energy of the contacts, and the deepest overlap.
    pub(crate) fn contact_energy(&self) -> ContactEnergy {
        let law = self.settings.normal_law;
        let mut sum = ContactEnergy::default();
        let mut take = |(contact, pull): (NormalContact<f64>, Pull), radius: f64, grain: u32| {
            sum.elastic += contact.elastic_energy(law);
            sum.cohesive += pull.energy(-contact.overlap);
            let share = contact.overlap / radius;
            if share > 0.0 && sum.deepest.is_none_or(|(most, _)| share > most) {
                sum.deepest = Some((share, grain));
            }
        };
        let world = &self.world;
        for (grain, radius, contact) in self.close_pairs() {
            take(contact, radius, world.ids[grain]);
        }
        for (grain, radius, contact) in self.close_walls() {
            take(contact, radius, world.ids[grain]);
        }
        sum
    }

    /// Contacts of grains that overlap or cohere, with the first one's place and the smaller radius.
    fn close_pairs(&self) -> impl Iterator<Item = (usize, f64, (NormalContact<f64>, Pull))> + '_ {
        let world = &self.world;
        let contacts = self.candidates.pairs.iter().map(|pair| {
            let (i, j) = (pair.first as usize, pair.second as usize);
            let (a, b) = (&world.spheres[i], &world.spheres[j]);
            let material = world.table.between_grains(world.materials[i], world.materials[j]);
            let contact = NormalContact {
                overlap: a.radius + b.radius - world.arm(i, j).norm(),
                velocity: 0.0,
                effective_modulus: material.effective_modulus,
                effective_radius: a.radius * b.radius / (a.radius + b.radius),
                inverse_mass: world.bodies[i].inverse_mass + world.bodies[j].inverse_mass,
                damping_ratio: material.damping_ratio,
            };
            let pull = material.pull(contact.effective_radius);
            (i, a.radius.min(b.radius), (contact, pull))
        });
        contacts.filter(|(_, _, (contact, pull))| contact.overlap > -pull.range)
    }

    /// Contacts with walls that overlap or cohere, with the grain's place and radius.
    fn close_walls(&self) -> impl Iterator<Item = (usize, f64, (NormalContact<f64>, Pull))> + '_ {
        let world = &self.world;
        let poses: Vec<_> = world.surfaces.iter().map(|surface| surface.at(world.time)).collect();
        let contacts = self.candidates.walls.iter().map(move |wall| {
            let (grain, surface) = (wall.body as usize, wall.surface as usize);
            let sphere = &world.spheres[grain];
            let material = world.table.with_wall(world.materials[grain], world.surfaces[surface].material);
            let contact = NormalContact {
                overlap: sphere.radius - poses[surface].distance(&sphere.centre),
                velocity: 0.0,
                effective_modulus: material.effective_modulus,
                effective_radius: sphere.radius,
                inverse_mass: world.bodies[grain].inverse_mass,
                damping_ratio: material.damping_ratio,
            };
            let pull = material.pull(sphere.radius);
            (grain, sphere.radius, (contact, pull))
        });
        contacts.filter(|(_, _, (contact, pull))| contact.overlap > -pull.range)
    }
}
