//! Mechanical energy of a state.

use crate::Simulation;
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
}

impl Simulation {
    /// Mechanical energy of the present state, J.
    pub fn energy(&self) -> Energy {
        Energy { elastic: self.elastic_energy_and_deepest().0, ..self.energy_without_elastic() }
    }

    /// Kinetic and potential energy, J.
    pub(crate) fn energy_without_elastic(&self) -> Energy {
        let mut energy = Energy::default();
        for (sphere, body) in self.world.spheres[..self.world.grains()].iter().zip(&self.world.bodies) {
            let mass = 1.0 / body.inverse_mass;
            let square = |vector: &[f64; 3]| vector.iter().map(|x| x * x).sum::<f64>();
            energy.kinetic += 0.5 * mass * (square(&body.velocity) + 0.4 * square(&body.surface_speed));
            energy.potential -= mass * self.world.gravity.dot(&sphere.centre);
        }
        energy
    }

    /// Elastic energy, J, and of the deepest overlap its share of the smaller radius and a grain's id.
    pub(crate) fn elastic_energy_and_deepest(&self) -> (f64, Option<(f64, u32)>) {
        let law = self.settings.normal_law;
        let (mut elastic, mut deepest) = (0.0, None);
        let mut take = |contact: &NormalContact<f64>, radius: f64, grain: u32| {
            elastic += contact.elastic_energy(law);
            let share = contact.overlap / radius;
            if deepest.is_none_or(|(most, _)| share > most) {
                deepest = Some((share, grain));
            }
        };
        let world = &self.world;
        for (grain, radius, contact) in self.overlapping_pairs() {
            take(&contact, radius, world.ids[grain]);
        }
        for (grain, radius, contact) in self.overlapping_walls() {
            take(&contact, radius, world.ids[grain]);
        }
        (elastic, deepest)
    }

    /// Contacts of grains that overlap, with the first one's place and the smaller radius.
    fn overlapping_pairs(&self) -> impl Iterator<Item = (usize, f64, NormalContact<f64>)> + '_ {
        let world = &self.world;
        let contacts = self.candidates.pairs.iter().map(|pair| {
            let (i, j) = (pair.first as usize, pair.second as usize);
            let (a, b) = (&world.spheres[i], &world.spheres[j]);
            let material = world.table.between_grains(world.materials[i], world.materials[j]);
            let contact = NormalContact {
                overlap: a.radius + b.radius - (b.centre - a.centre).norm(),
                velocity: 0.0,
                effective_modulus: material.effective_modulus,
                effective_radius: a.radius * b.radius / (a.radius + b.radius),
                inverse_mass: world.bodies[i].inverse_mass + world.bodies[j].inverse_mass,
                damping_ratio: material.damping_ratio,
            };
            (i, a.radius.min(b.radius), contact)
        });
        contacts.filter(|(_, _, contact)| contact.overlap > 0.0)
    }

    /// Contacts with walls that overlap, with the grain's place and radius.
    fn overlapping_walls(&self) -> impl Iterator<Item = (usize, f64, NormalContact<f64>)> + '_ {
        let world = &self.world;
        let poses: Vec<_> = world.surfaces.iter().map(|surface| surface.at(world.time)).collect();
        let contacts = self.candidates.walls.iter().map(move |wall| {
            let (grain, surface) = (wall.body as usize, wall.surface as usize);
            let sphere = &world.spheres[grain];
            let material = world.table.with_wall(world.materials[grain], world.surfaces[surface].material);
            let contact = NormalContact {
                overlap: sphere.radius - poses[surface].nearest(&sphere.centre).0,
                velocity: 0.0,
                effective_modulus: material.effective_modulus,
                effective_radius: sphere.radius,
                inverse_mass: world.bodies[grain].inverse_mass,
                damping_ratio: material.damping_ratio,
            };
            (grain, sphere.radius, contact)
        });
        contacts.filter(|(_, _, contact)| contact.overlap > 0.0)
    }
}
