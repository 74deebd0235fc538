//! What leaves a simulation: two tables, particles and contacts. Every code delivers the same two.

use serde::{Deserialize, Serialize};

/// State of one grain.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Particle {
    /// Number of the grain; grains are numbered from 0 without holes, in the order of [`populate`](crate::scene::populate()).
    pub id: u32,
    /// Centre, metres.
    pub position: [f64; 3],
    /// Radius, metres.
    pub radius: f64,
    /// Velocity, m/s.
    pub velocity: [f64; 3],
    /// Angular velocity, rad/s.
    pub spin: [f64; 3],
}

/// What a grain touches.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum Partner {
    /// Another grain, by its id.
    Grain(u32),
    /// A wall, by its place in the scene's list of walls.
    Wall(u32),
}

/// One contact that bears a force.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Contact {
    /// Id of the first grain.
    pub first: u32,
    /// What it touches.
    pub second: Partner,
    /// Contact point, metres.
    pub point: [f64; 3],
    /// Unit normal from the first grain to its partner.
    pub normal: [f64; 3],
    /// Magnitude of the normal force, N; positive pushes the two apart.
    pub normal_force: f64,
    /// Tangential force on the partner, N; the first grain bears the opposite.
    pub tangential_force: [f64; 3],
}

/// One frame: the state of all grains and all contacts at a time.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Snapshot {
    /// Simulated time, s.
    pub time: f64,
    /// Grains, in the order of their ids.
    pub particles: Vec<Particle>,
    /// Contacts that bear a force.
    pub contacts: Vec<Contact>,
}
