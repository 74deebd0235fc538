//! What the scene says that measures need: directions, masses, friction, the drum.

use super::drum::Drum;
use makadam::scene::Scene;
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
    grain_friction: Vec<Vec<f64>>,
    wall_friction: Vec<Vec<f64>>,
}

impl<'a> Setting<'a> {
    /// Reads the scene; `frame` gives the mean diameter.
    pub fn new(scene: &'a Scene, frame: &Snapshot) -> Self {
        let names: Vec<&String> = scene.material.keys().collect();
        let index = |name: &String| names.iter().position(|known| *known == name).unwrap_or(0);
        // Grains are numbered as they are placed: listed ones first, then each population.
        let mut material: Vec<usize> = scene.grain.iter().map(|entry| index(&entry.material)).collect();
        for population in &scene.population {
            material.resize(material.len() + population.count, index(&population.material));
        }
        let gravity = Vector3::from(scene.gravity);
        let count = frame.particles.len().max(1) as f64;
        Self {
            scene,
            up: gravity.try_normalize(1e-12).map(|down| -down),
            gravity: gravity.norm(),
            diameter: 2.0 * frame.particles.iter().map(|grain| grain.radius).sum::<f64>() / count,
            drum: Drum::find(scene),
            density: names.iter().map(|name| scene.material[*name].density).collect(),
            grain_friction: (names.iter())
                .map(|a| names.iter().map(|b| scene.contact_coefficients(a, b, false).0).collect())
                .collect(),
            wall_friction: (names.iter())
                .map(|a| scene.wall.iter().map(|wall| scene.contact_coefficients(a, &wall.material, true).0).collect())
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

    /// Coulomb friction coefficient of a contact.
    pub fn friction(&self, contact: &Contact) -> f64 {
        let first = self.material(contact.first);
        match contact.second {
            Partner::Grain(id) => self.grain_friction[first][self.material(id)],
            Partner::Wall(wall) => self.wall_friction[first].get(wall as usize).copied().unwrap_or(0.0),
        }
    }

    /// Whether grains rub against each other at all.
    pub fn frictional(&self) -> bool {
        let first = self.material.first().copied().unwrap_or(0);
        self.material.iter().any(|&other| self.grain_friction[first][other] > 0.0)
    }
}
