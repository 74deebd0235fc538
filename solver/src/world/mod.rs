//! What is simulated: bodies, surfaces and their motion, material pairs, the clock.

mod materials;
mod surface;

pub use materials::{ContactMaterial, MaterialTable};
pub use surface::{Pose, Surface};

use crate::scene::{Grain, Scene};
use nalgebra::Vector3;

/// Number of contacts in a lane group; a part of the algorithm, not of the machine.
pub const LANES: usize = 8;

/// Dummy bodies behind the real ones, at which padding lanes point: one for each lane and side.
pub const DUMMIES: usize = 2 * LANES;

/// Dynamic state of a grain: one cache line.
///
/// The spin is kept as the surface speed `radius * angular velocity` (m/s), which takes the lever arm out of the
/// contact: for solid spheres (I = 0.4 m r^2) an impulse P changes it by 2.5/m times the cross product of P and the normal.
#[derive(Clone, Copy, Debug, PartialEq)]
#[repr(C, align(64))]
pub struct Body {
    /// Velocity, m/s.
    pub velocity: [f64; 3],
    /// One over the mass, 1/kg.
    pub inverse_mass: f64,
    /// Radius times angular velocity, m/s.
    pub surface_speed: [f64; 3],
    /// Radius, m.
    pub radius: f64,
}

/// All bodies and surfaces, and the clock.
#[derive(Clone, Debug)]
pub struct World {
    /// Grains by id, then [`DUMMIES`] dummy bodies at rest.
    pub bodies: Vec<Body>,
    /// Centres of the grains, m.
    pub positions: Vec<Vector3<f64>>,
    /// Material number of each grain.
    pub materials: Vec<u8>,
    /// Faces of the scene's walls.
    pub surfaces: Vec<Surface>,
    /// Pair properties.
    pub table: MaterialTable,
    /// Acceleration of gravity, m/s2.
    pub gravity: Vector3<f64>,
    /// Corners of the domain, m.
    pub domain: (Vector3<f64>, Vector3<f64>),
    /// Simulated time, s.
    pub time: f64,
}

impl World {
    /// Builds the world of a scene at time zero.
    pub fn new(scene: &Scene, grains: &[Grain]) -> World {
        let table = MaterialTable::new(scene);
        let mut bodies: Vec<Body> = grains
            .iter()
            .map(|grain| {
                let volume = 4.0 / 3.0 * std::f64::consts::PI * grain.radius * grain.radius * grain.radius;
                Body {
                    velocity: grain.velocity,
                    inverse_mass: 1.0 / (scene.material[&grain.material].density * volume),
                    surface_speed: grain.spin.map(|component| component * grain.radius),
                    radius: grain.radius,
                }
            })
            .collect();
        let dummy = Body { velocity: [0.0; 3], inverse_mass: 1.0, surface_speed: [0.0; 3], radius: 1.0 };
        bodies.extend([dummy; DUMMIES]);
        World {
            bodies,
            positions: grains.iter().map(|grain| Vector3::from(grain.position)).collect(),
            materials: grains.iter().map(|grain| table.number(&grain.material)).collect(),
            surfaces: scene
                .wall
                .iter()
                .enumerate()
                .flat_map(|(index, wall)| Surface::of_wall(wall, index as u32, table.number(&wall.material)))
                .collect(),
            table,
            gravity: Vector3::from(scene.gravity),
            domain: (Vector3::from(scene.domain.min), Vector3::from(scene.domain.max)),
            time: 0.0,
        }
    }

    /// Number of grains.
    pub fn grains(&self) -> usize {
        self.positions.len()
    }

    pub(crate) fn memory_bytes(&self) -> usize {
        self.bodies.capacity() * size_of::<Body>()
            + self.positions.capacity() * size_of::<Vector3<f64>>()
            + self.materials.capacity()
    }

    /// Largest and mean radius, m; (0, 0) in an empty world.
    pub fn largest_and_mean_radius(&self) -> (f64, f64) {
        let radii = || self.bodies[..self.grains()].iter().map(|body| body.radius);
        (radii().fold(0.0, f64::max), radii().sum::<f64>() / self.grains().max(1) as f64)
    }
}
