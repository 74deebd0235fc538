//! What the scene says that measures need: directions, masses, friction, the drum.

use super::drum::Drum;
use crate::plan::Scene;
use makadam::scene::ContactCoefficients;
use makadam::snapshot::{Contact, Particle, Partner, Snapshot};
use nalgebra::Vector3;

/// A scene as measures see it.
pub struct Setting<'a> {
    /// The scene.
    pub scene: &'a Scene,
    /// Unit vector against gravity; absent where there is no gravity.
    pub up: Option<Vector3<f64>>,
    /// Magnitude of gravity, m/s2.
    pub gravity: f64,
    /// Mean grain diameter, m.
    pub diameter: f64,
    /// The drum, if the scene has one.
    pub drum: Option<Drum>,
    /// Material of each grain by id, as an index into the tables below.
    material: Vec<usize>,
    density: Vec<f64>,
    grain_contacts: Vec<Vec<ContactCoefficients>>,
    wall_contacts: Vec<Vec<ContactCoefficients>>,
}

impl<'a> Setting<'a> {
    /// Reads the scene; `frame` gives the mean diameter and the time at which gravity is taken.
    pub fn new(scene: &'a Scene, frame: &Snapshot) -> Self {
        let names: Vec<&String> = scene.material.keys().collect();
        let index = |name: &String| names.iter().position(|known| *known == name).unwrap_or(0);
        // Grains are numbered as they are placed: listed ones first, then each population.
        let mut material: Vec<usize> = scene.grain.iter().map(|entry| index(&entry.material)).collect();
        for population in &scene.population {
            material.resize(material.len() + population.count, index(&population.material));
        }
        let gravity = scene.gravity_field().at(frame.time);
        let count = frame.particles.len().max(1) as f64;
        Self {
            scene,
            up: gravity.try_normalize(1e-12).map(|down| -down),
            gravity: gravity.norm(),
            diameter: 2.0 * frame.particles.iter().map(|grain| grain.radius).sum::<f64>() / count,
            drum: Drum::find(scene),
            density: names.iter().map(|name| scene.material[*name].density).collect(),
            grain_contacts: (names.iter())
                .map(|a| names.iter().map(|b| scene.contact_coefficients(a, b, false)).collect())
                .collect(),
            wall_contacts: (names.iter())
                .map(|a| scene.wall.iter().map(|wall| scene.contact_coefficients(a, &wall.material, true)).collect())
                .collect(),
            material,
        }
    }

    fn material(&self, id: u32) -> usize {
        self.material.get(id as usize).or(self.material.last()).copied().unwrap_or(0)
    }

    /// Mass of a grain, kg.
    pub fn mass(&self, grain: &Particle) -> f64 {
        self.density[self.material(grain.id)] * super::sphere_volume::sphere(grain.radius)
    }

    /// Largest tangential force that a contact can bear, N; absent where the scene tells nothing of the contact, and where
    /// cohesion adds a force that the two tables of a frame do not tell.
    pub fn coulomb_bound(&self, contact: &Contact) -> Option<f64> {
        let first = self.material(contact.first);
        let coefficients = match contact.second {
            Partner::Grain(id) => self.grain_contacts[first].get(self.material(id)),
            Partner::Wall(wall) => self.wall_contacts[first].get(wall as usize),
        }?;
        coefficients.cohesion.is_none().then_some(coefficients.friction * contact.normal_force)
    }

    /// Whether grains rub against each other at all.
    pub fn frictional(&self) -> bool {
        let first = self.material.first().copied().unwrap_or(0);
        self.material.iter().any(|&other| self.grain_contacts[first][other].friction > 0.0)
    }
}
