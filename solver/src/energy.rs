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
        let mut energy = Energy::default();
        for (sphere, body) in self.world.spheres[..self.world.grains()].iter().zip(&self.world.bodies) {
            let mass = 1.0 / body.inverse_mass;
            let square = |vector: &[f64; 3]| vector.iter().map(|x| x * x).sum::<f64>();
            energy.kinetic += 0.5 * mass * (square(&body.velocity) + 0.4 * square(&body.surface_speed));
            energy.potential -= mass * self.world.gravity.dot(&sphere.centre);
        }
        let contacts = self.overlapping_pairs().chain(self.overlapping_walls());
        energy.elastic = contacts.map(|contact| contact.elastic_energy(self.settings.normal_law)).sum();
        energy
    }

    fn overlapping_pairs(&self) -> impl Iterator<Item = NormalContact<f64>> + '_ {
        let world = &self.world;
        let contacts = self.candidates.pairs.iter().map(|pair| {
            let (i, j) = (pair.first as usize, pair.second as usize);
            let (a, b) = (&world.spheres[i], &world.spheres[j]);
            let material = world.table.between_grains(world.materials[i], world.materials[j]);
            NormalContact {
                overlap: a.radius + b.radius - (b.centre - a.centre).norm(),
                velocity: 0.0,
                effective_modulus: material.effective_modulus,
                effective_radius: a.radius * b.radius / (a.radius + b.radius),
                inverse_mass: world.bodies[i].inverse_mass + world.bodies[j].inverse_mass,
                damping_ratio: material.damping_ratio,
            }
        });
        contacts.filter(|contact| contact.overlap > 0.0)
    }

    fn overlapping_walls(&self) -> impl Iterator<Item = NormalContact<f64>> + '_ {
        let world = &self.world;
        let poses: Vec<_> = world.surfaces.iter().map(|surface| surface.at(world.time)).collect();
        let contacts = self.candidates.walls.iter().map(move |wall| {
            let (grain, surface) = (wall.body as usize, wall.surface as usize);
            let sphere = &world.spheres[grain];
            let material = world.table.with_wall(world.materials[grain], world.surfaces[surface].material);
            NormalContact {
                overlap: sphere.radius - poses[surface].nearest(&sphere.centre).0,
                velocity: 0.0,
                effective_modulus: material.effective_modulus,
                effective_radius: sphere.radius,
                inverse_mass: world.bodies[grain].inverse_mass,
                damping_ratio: material.damping_ratio,
            }
        });
        contacts.filter(|contact| contact.overlap > 0.0)
    }
}
