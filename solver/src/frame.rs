//! A frame as arrays: what programs that compute with grains want of a simulation.
//!
//! ```
//! # use makadam::{Face, Material, Population, RadiusDistribution, Region, Scene, Shape, Simulation, Wall};
//! # let [min, max] = [[0.0; 3], [0.04, 0.04, 0.12]];
//! # let scene = Scene::builder()
//! #     .material("glass", Material::default())
//! #     .wall(Wall::new("box", "glass", Shape::cuboid(min, max, &[Face::Top])))
//! #     .population(Population::new(40, "glass", RadiusDistribution::uniform(0.005, 0.05), Region::cuboid(min, max)))
//! #     .build()?;
//! let mut simulation = Simulation::builder(&scene).time_step(5e-4).build()?;
//! simulation.step();
//! let frame = simulation.frame();
//! let fastest = frame.velocities().iter().map(|[x, y, z]| x * x + y * y + z * z).fold(0.0, f64::max).sqrt();
//! println!("{} grains, the fastest at {fastest:.3} m/s", frame.grains());
//! # assert_eq!((frame.grains(), frame.positions().len(), frame.radii().len()), (40, 40, 40));
//! # Ok::<(), makadam::Error>(())
//! ```

use crate::Simulation;
use crate::snapshot::{Contact, Particle};

/// Grains and contacts at a time. Arrays of grains go by their ids, which are numbered from 0 without holes: the grains that a scene lists,
/// then population after population.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Frame {
    time: f64,
    positions: Vec<[f64; 3]>,
    velocities: Vec<[f64; 3]>,
    spins: Vec<[f64; 3]>,
    radii: Vec<f64>,
    contacts: Vec<Contact>,
}

impl Frame {
    /// Simulated time, s.
    pub fn time(&self) -> f64 {
        self.time
    }

    /// Number of grains.
    pub fn grains(&self) -> usize {
        self.radii.len()
    }

    /// Centres, m; inside the domain where that repeats itself.
    pub fn positions(&self) -> &[[f64; 3]] {
        &self.positions
    }

    /// Velocities, m/s.
    pub fn velocities(&self) -> &[[f64; 3]] {
        &self.velocities
    }

    /// Angular velocities, rad/s.
    pub fn spins(&self) -> &[[f64; 3]] {
        &self.spins
    }

    /// Radii, m.
    pub fn radii(&self) -> &[f64] {
        &self.radii
    }

    /// Contacts of the last step that bear a force, with grains and walls.
    pub fn contacts(&self) -> &[Contact] {
        &self.contacts
    }

    /// Mean number of contacts per grain: each contact of two grains counts for both, one with a wall for its grain; 0 without grains.
    pub fn coordination_number(&self) -> f64 {
        let ends: usize = self.contacts.iter().map(|contact| if contact.second.is_grain() { 2 } else { 1 }).sum();
        ends as f64 / self.grains().max(1) as f64
    }
}

impl Simulation {
    /// Grains as they are now, and the contacts of the last step.
    pub fn frame(&self) -> Frame {
        let snapshot = self.snapshot();
        let vectors = |of: fn(&Particle) -> [f64; 3]| snapshot.particles.iter().map(of).collect();
        Frame {
            time: snapshot.time,
            positions: vectors(|grain| grain.position),
            velocities: vectors(|grain| grain.velocity),
            spins: vectors(|grain| grain.spin),
            radii: snapshot.particles.iter().map(|grain| grain.radius).collect(),
            contacts: snapshot.contacts,
        }
    }
}
