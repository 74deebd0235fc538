//! Frames: tables of particles and contacts, common to all codes, and arrays by grain.
//!
//! ```
//! use makadam::Partner;
//! # use makadam::{Scene, Simulation};
//! # let scene = Scene::example();
//! let mut simulation = Simulation::builder(&scene).time_step(5e-4).build()?;
//! for _ in 0..600 {
//!     simulation.step();
//! }
//! let snapshot = simulation.snapshot();
//! let on_walls = snapshot.contacts.iter().filter(|contact| !contact.second.is_grain());
//! println!("{} grains, {} contacts with walls", snapshot.particles.len(), on_walls.count());
//! # assert!(snapshot.contacts.iter().any(|contact| contact.second == Partner::Wall(0)));
//! # Ok::<(), makadam::Error>(())
//! ```

use crate::Simulation;
use crate::detect::WallCandidate;
use crate::effects::drive::Drive;
use crate::partition::TaskGroups;
use crate::simulation::Request;
pub use crate::simulation::flow::Passed;
pub use crate::simulation::gauge::Passages;
use crate::simulation::ledger::WallContact;
pub use crate::simulation::stages::PresentStage;
use crate::simulation::swept::Struck;
pub use crate::simulation::wall_record::{FaceWear, WallLoad};
pub use crate::wall::{Beginning, DrivenWall};
use crate::world::Roll;
use nalgebra::Vector3;
use serde::{Deserialize, Serialize};

/// State of one grain.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct Particle {
    /// Number of the grain in its frame; grains are numbered contiguously from 0, in the order of [`populate`](crate::scene::populate()).
    /// Removal of a grain renumbers all later grains: [`Snapshot::origins`] then identifies them.
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

/// Partner of a grain in a contact.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum Partner {
    /// Another grain, by its id.
    Grain(u32),
    /// A wall, by its index in the scene's list of walls.
    Wall(u32),
}

impl Partner {
    /// Returns true if the partner is a grain.
    pub fn is_grain(self) -> bool {
        matches!(self, Partner::Grain(_))
    }
}

/// Contact with a force.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Contact {
    /// Id of the first grain.
    pub first: u32,
    /// Partner.
    pub second: Partner,
    /// Contact point, metres.
    pub point: [f64; 3],
    /// Unit normal from the first grain to its partner.
    pub normal: [f64; 3],
    /// Normal force, N: positive for repulsion; negative if cohesion exceeds the repulsive force of the contact.
    pub normal_force: f64,
    /// Tangential force on the partner, N; the first grain receives the opposite force.
    pub tangential_force: [f64; 3],
}

impl Contact {
    /// Force of the first grain on its partner, N: `f_n n + f_t`.
    pub fn force_on_partner(&self) -> Vector3<f64> {
        Vector3::from(self.normal) * self.normal_force + Vector3::from(self.tangential_force)
    }
}

/// Identity of a grain over a run with insertion and removal of grains.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Origin {
    /// Number that is unique over the run: grains of the scene in placement order, then inserted grains.
    pub number: u64,
    /// Number of the material, in the order of the scene's material names.
    pub material: u8,
    /// Index of the source in the scene; absent for grains of the scene and for grains inserted by the caller.
    pub source: Option<u16>,
}

/// State of all grains and all contacts at a time.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Snapshot {
    /// Simulated time, s.
    pub time: f64,
    /// Grains, in the order of their ids.
    pub particles: Vec<Particle>,
    /// Contacts with a force.
    pub contacts: Vec<Contact>,
    /// Dynamic walls, moved by a force or a torque, in scene order.
    pub driven_walls: Vec<DrivenWall>,
    /// Identities of the grains, in the order of [`Snapshot::particles`]; empty if no grain was inserted or removed, so that ids
    /// equal those of the scene's grains.
    pub origins: Vec<Origin>,
    /// Grains that have come from sources and gone into sinks.
    pub passed: [Passed; 2],
    /// Stage of the last step; absent for a scene without stages.
    pub stage: Option<PresentStage>,
    /// Beginnings of the motions that stages have given to walls, by the number of the wall in the scene.
    pub beginnings: Vec<(u32, Beginning)>,
    /// Passages forward and backward of each gauge since the start.
    pub gauges: Vec<[Passages; 2]>,
    /// Mean load of each wall since the last measured frame; empty unless recorded ([`Simulation::record_walls`]).
    pub wall_loads: Vec<WallLoad>,
    /// Wear of the faces that grains have touched, and of the first face of each wall; empty unless recorded.
    pub wear: Vec<FaceWear>,
}

impl Simulation {
    /// Returns the present grains, wrapped along periodic axes, and the contacts of the last step with their forces (impulse over time step).
    pub fn snapshot(&self) -> Snapshot {
        let world = &self.world;
        let particle = |(id, place): (usize, u32)| {
            let (sphere, body) = (&world.spheres[place as usize], &world.bodies[place as usize]);
            Particle {
                id: id as u32,
                position: world.wrapped(&sphere.centre).into(),
                radius: sphere.radius,
                velocity: body.velocity,
                spin: body.scaled_spin.map(|component| component / sphere.radius),
            }
        };
        let particles = self.places_by_id().into_iter().enumerate().map(particle).collect();
        let driven = world.drives.iter().map(|drive| {
            let Drive { wall, displacement, rate, .. } = *drive;
            DrivenWall { wall, displacement, rate }
        });
        Snapshot {
            time: world.time,
            particles,
            contacts: self.contacts(),
            driven_walls: driven.collect(),
            origins: self.origins(),
            passed: self.passed(),
            stage: self.stage(),
            beginnings: self.beginnings(),
            gauges: self.gauges().to_vec(),
            wall_loads: self.wall_loads(),
            wear: self.wear(),
        }
    }

    /// Identities of the grains by id; empty if no grain was inserted or removed.
    fn origins(&self) -> Vec<Origin> {
        let Roll { changed: true, numbers, sources, .. } = &self.world.roll else { return Vec::new() };
        let places = self.places_by_id().into_iter();
        let origin = |((place, &number), &source): ((u32, &u64), &u16)| {
            let (material, source) = (self.world.materials[place as usize], source.checked_sub(1));
            Origin { number, material, source }
        };
        places.zip(numbers).zip(sources).map(origin).collect()
    }

    /// Contacts of the last step: pairs of grains, contacts with walls, impacts outside of the solve.
    fn contacts(&self) -> Vec<Contact> {
        let mut contacts = self.pair_contacts();
        self.for_each_wall_contact(|one| contacts.push(self.wall_contact(one)));
        contacts.retain(|contact| contact.normal_force != 0.0);
        contacts.extend(self.strikes());
        contacts
    }

    /// Pairs of grains in contact, of all ranks.
    pub(crate) fn pair_contacts(&self) -> Vec<Contact> {
        let own = self.layout.tasks().map(|(_, task)| self.pair_contacts_of(task));
        let mut contacts = Vec::new();
        match self.together(Request::PairContacts) {
            // A loop is faster than the collection of a chain.
            None => own.flatten().for_each(|contact| contacts.push(contact)),
            Some(ranks) => contacts = ranks.merge(own.map(Iterator::collect).collect()).concat(),
        }
        contacts
    }

    fn pair_contacts_of<'a>(&'a self, task: &'a TaskGroups) -> impl Iterator<Item = Contact> + 'a {
        let world = &self.world;
        let numbered = task.pairs.iter().zip(&task.pair_sources).enumerate();
        let groups = numbered.map(|(number, (group, sources))| (group, sources, task.pair_pulls.get(number)));
        groups.flat_map(move |(group, sources, pulls)| {
            sources.occupied().map(move |(lane, _)| {
                let (i, j) = (group.first[lane] as usize, group.second[lane] as usize);
                let along = world.pair_geometry(i, j).point;
                let point = world.spheres[i].centre + Vector3::from(group.contacts.normal(lane)) * along;
                let (contacts, pull) = (&group.contacts, pulls.map_or(0.0, |pulls| pulls.0[lane]));
                let (normal, along) = (contacts.normal(lane), contacts.normal_impulse(lane) - pull);
                let impulse = (normal, along, contacts.tangential_impulse(lane));
                self.contact(world.ids[i], Partner::Grain(world.ids[j]), point, impulse)
            })
        })
    }

    fn wall_contact(&self, one: &WallContact) -> Contact {
        let (world, WallCandidate { body, surface }) = (&self.world, one.candidate);
        let sphere = &world.spheres[body as usize];
        let point = sphere.centre + Vector3::from(one.normal) * sphere.radius;
        let wall = Partner::Wall(world.walls.wall_of(surface));
        self.contact(world.ids[body as usize], wall, point, (one.normal, one.along(), one.tangential))
    }

    /// Impacts outside of the solve of the last step.
    fn strikes(&self) -> impl Iterator<Item = Contact> + '_ {
        let (world, h) = (&self.world, self.settings.step);
        self.swept.strikes.iter().map(move |strike| {
            let sphere = &world.spheres[strike.place as usize];
            Contact {
                first: world.ids[strike.place as usize],
                second: match strike.struck {
                    Struck::Face(surface) => Partner::Wall(world.walls.wall_of(surface)),
                    Struck::Grain(place) => Partner::Grain(world.ids[place as usize]),
                },
                point: world.wrapped(&(sphere.centre + strike.normal * sphere.radius)).into(),
                normal: strike.normal.into(),
                normal_force: strike.along / h,
                tangential_force: (strike.tangential / h).into(),
            }
        })
    }

    fn contact(
        &self,
        first: u32,
        second: Partner,
        point: Vector3<f64>,
        (normal, along, tangential): ([f64; 3], f64, [f64; 3]),
    ) -> Contact {
        let h = self.settings.step;
        Contact {
            first,
            second,
            point: self.world.wrapped(&point).into(),
            normal,
            normal_force: along / h,
            tangential_force: tangential.map(|component| component / h),
        }
    }
}

/// Grains and contacts at a time. Arrays of grains are indexed by id, contiguous from 0: the grains that a scene lists, then
/// population after population.
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
    crate::getters! {
        /// Simulated time, s.
        pub time: f64 = |frame| frame.time;
        /// Number of grains.
        pub grains: usize = |frame| frame.radii.len();
        /// Centres, m, wrapped along periodic axes.
        pub positions: &[[f64; 3]] = |frame| &frame.positions;
        /// Velocities, m/s.
        pub velocities: &[[f64; 3]] = |frame| &frame.velocities;
        /// Angular velocities, rad/s.
        pub spins: &[[f64; 3]] = |frame| &frame.spins;
        /// Radii, m.
        pub radii: &[f64] = |frame| &frame.radii;
        /// Contacts of the last step with a force, with grains and walls.
        pub contacts: &[Contact] = |frame| &frame.contacts;
    }

    /// Mean number of contacts per grain: a contact of two grains counts for both, a contact with a wall for its grain; 0 without grains.
    pub fn coordination_number(&self) -> f64 {
        let ends: usize = self.contacts.iter().map(|contact| if contact.second.is_grain() { 2 } else { 1 }).sum();
        ends as f64 / self.grains().max(1) as f64
    }
}

impl Simulation {
    /// Returns the present grains, and the contacts of the last step.
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
