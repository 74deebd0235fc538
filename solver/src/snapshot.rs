//! What leaves a simulation: two tables, particles and contacts. Every code delivers the same two.

use crate::Simulation;
use crate::detect::Impulse;
use nalgebra::Vector3;
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

impl Simulation {
    /// Grains as they are now, and the contacts of the last step with their forces (impulse over time step).
    pub fn snapshot(&self) -> Snapshot {
        let world = &self.world;
        let particles = world.positions.iter().zip(&world.bodies).enumerate();
        let particles = particles.map(|(id, (position, body))| Particle {
            id: id as u32,
            position: (*position).into(),
            radius: body.radius,
            velocity: body.velocity,
            spin: body.surface_speed.map(|component| component / body.radius),
        });
        let contacts = self.pair_contacts().chain(self.wall_contacts()).filter(|contact| contact.normal_force > 0.0);
        Snapshot { time: world.time, particles: particles.collect(), contacts: contacts.collect() }
    }

    fn pair_contacts(&self) -> impl Iterator<Item = Contact> + '_ {
        let world = &self.world;
        self.layout.pairs.iter().flat_map(move |group| {
            group.contacts.occupied().map(move |(lane, _)| {
                let (first, second) = (group.first[lane], group.second[lane]);
                let (i, j) = (first as usize, second as usize);
                // The contact point lies in the middle of the overlap.
                let distance = (world.positions[j] - world.positions[i]).norm();
                let depth = 0.5 * (distance + world.bodies[i].radius - world.bodies[j].radius);
                let normal = group.contacts.normal(lane);
                let point = world.positions[i] + Vector3::from(normal) * depth;
                self.contact(first, Partner::Grain(second), point, normal, group.contacts.impulse(lane))
            })
        })
    }

    fn wall_contacts(&self) -> impl Iterator<Item = Contact> + '_ {
        let world = &self.world;
        self.layout.walls.iter().flat_map(move |group| {
            group.contacts.occupied().map(move |(lane, source)| {
                let grain = group.body[lane];
                let surface = self.candidates.walls[source].surface;
                let wall = world.surfaces[surface as usize].wall;
                let normal = group.contacts.normal(lane);
                let reach = Vector3::from(normal) * world.bodies[grain as usize].radius;
                let point = world.positions[grain as usize] + reach;
                self.contact(grain, Partner::Wall(wall), point, normal, group.contacts.impulse(lane))
            })
        })
    }

    fn contact(&self, first: u32, second: Partner, point: Vector3<f64>, normal: [f64; 3], impulse: Impulse) -> Contact {
        let h = self.settings.step;
        Contact {
            first,
            second,
            point: point.into(),
            normal,
            normal_force: impulse.normal / h,
            tangential_force: impulse.tangential.map(|component| component / h),
        }
    }
}
