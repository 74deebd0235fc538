//! State of a simulation: bodies, walls and their drives, material pairs, the clock.

mod materials;

pub use materials::{ContactMaterial, MaterialTable};

use crate::effects::drive::Drive;
use crate::effects::gravity::Field;
use crate::lanes::{LANES, Line, Quad};
use crate::laws::compliance::NormalContact;
use crate::laws::period::Period;
use crate::scene::{Grain, REACHES, Scene, sphere_volume};
use crate::schedule::{Phase, Runs, Team};
use crate::wall::{Pose, Walls, drive_of};
use bytemuck::{Pod, Zeroable};
use nalgebra::Vector3;
use std::collections::TryReserveError;
use std::ops::Range;

/// Dummy bodies of a box, at which padding lanes point: one for each lane and side. A box has its own, so that no two
/// tasks of a stage write to the same.
pub const DUMMIES: usize = 2 * LANES;

/// Grains that are moved, sorted or compared as one task.
const CHUNK: usize = 4096;

/// Number of such tasks.
pub(crate) fn chunks(grains: usize) -> usize {
    grains.div_ceil(CHUNK)
}

/// Places of the grains of one.
pub(crate) fn chunk(number: usize, grains: usize) -> Range<usize> {
    CHUNK * number..(CHUNK * (number + 1)).min(grains)
}

/// Chunks of an array of grains, or of bodies.
pub(crate) fn by_chunk<T>(array: &mut [T]) -> Runs<'_, T> {
    Runs::of(array, CHUNK)
}

/// Number of the one that a grain belongs to.
pub(crate) fn chunk_of(place: usize) -> usize {
    place / CHUNK
}

/// Moment of inertia of a solid sphere over `m r^2`.
pub(crate) const INERTIA: f64 = 0.4;
/// One over [`INERTIA`].
pub(crate) const INVERSE_INERTIA: f64 = 2.5;

/// Dynamic state of a grain: one cache line of two quads.
///
/// The spin is kept as the scaled spin `radius * angular velocity` (m/s), which takes the lever arm out of the
/// contact: for solid spheres an impulse P changes it by `INVERSE_INERTIA` (5/2) over m times the cross product of P and the normal.
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
#[repr(C, align(64))]
pub struct Body {
    /// Velocity, m/s.
    pub velocity: [f64; 3],
    /// One over the mass, 1/kg.
    pub inverse_mass: f64,
    /// Radius times angular velocity, m/s.
    pub scaled_spin: [f64; 3],
    /// One over the radius, 1/m.
    pub(crate) inverse_radius: f64,
}

/// Centre and radius of a grain: one quad.
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
#[repr(C, align(32))]
pub struct Sphere {
    /// Centre, m.
    pub centre: Vector3<f64>,
    /// Radius, m.
    pub radius: f64,
}

/// All bodies and walls, and the clock.
///
/// Grains lie in memory in the order of the boxes and cells that they were in when the candidate list was last built; a
/// grain's index there is its place. `ids` tells who is who.
#[derive(Clone, Debug)]
pub struct World {
    /// Grains by place, then the dummy bodies at rest, box after box.
    pub bodies: Vec<Body>,
    /// Spheres of the same, those of the dummies out of reach of each other.
    pub spheres: Vec<Sphere>,
    /// Material numbers of the same.
    pub materials: Vec<u8>,
    /// Id of the grain at each place.
    pub ids: Vec<u32>,
    /// Velocity and inverse mass of every body at the start of the step; between steps, room to reorder grains in.
    pub(crate) before: Vec<Quad>,
    /// Surface speed of every body at the start of the step, where friction goes by how contacts slide or the step may be abandoned.
    pub(crate) spins_before: Vec<Quad>,
    /// The scene's walls.
    pub walls: Walls,
    /// Walls driven by a force or a torque.
    pub drives: Vec<Drive>,
    /// Pair properties.
    pub table: MaterialTable,
    /// Acceleration of gravity at the present time, m/s2.
    pub gravity: Vector3<f64>,
    /// Gravity over time.
    pub field: Field,
    /// Corners of the domain, m.
    pub domain: (Vector3<f64>, Vector3<f64>),
    /// Axes along which the domain repeats itself.
    pub period: Period,
    /// Simulated time, s.
    pub time: f64,
    /// True while bodies and spheres must not move in memory.
    pub(crate) kept: KeptInPlace,
}

/// True while arrays must not move in memory. A copy has arrays of its own, which may move.
#[derive(Debug, Default)]
pub(crate) struct KeptInPlace(bool);

impl Clone for KeptInPlace {
    fn clone(&self) -> KeptInPlace {
        KeptInPlace(false)
    }
}

/// A [`World`] whose bodies are being written.
#[derive(Clone, Copy, Debug)]
pub(crate) struct WorldBesideBodies<'a> {
    grains: usize,
    pub spheres: &'a [Sphere],
    pub materials: &'a [u8],
    pub before: &'a [Quad],
    pub spins_before: &'a [Quad],
    pub walls: &'a Walls,
    pub drives: &'a [Drive],
    pub table: &'a MaterialTable,
    pub gravity: &'a Vector3<f64>,
    pub period: &'a Period,
}

impl WorldBesideBodies<'_> {
    /// Number of grains.
    pub fn grains(&self) -> usize {
        self.grains
    }

    /// Place of the first dummy of a box.
    #[inline]
    pub fn dummies_of(&self, number: usize) -> u32 {
        (self.grains + number * DUMMIES) as u32
    }

    /// Number of the drive of the wall that a face belongs to, if it has one.
    pub fn drive_of(&self, surface: u32) -> Option<usize> {
        drive_of_wall(self.drives, self.walls.wall_of(surface))
    }

    /// Properties of contacts of a grain with a face.
    #[inline]
    pub fn wall_material(&self, grain: usize, surface: u32) -> &ContactMaterial {
        self.table.with_wall(self.materials[grain], self.walls.material_of(surface))
    }
}

fn drive_of_wall(drives: &[Drive], wall: u32) -> Option<usize> {
    drives.iter().position(|drive| drive.wall == wall)
}

impl World {
    /// Builds the world of a checked scene at time zero, without dummies.
    pub(crate) fn new(scene: &Scene, grains: &[Grain]) -> World {
        let table = MaterialTable::new(scene);
        let body = |grain: &Grain| Body {
            velocity: grain.velocity,
            inverse_mass: 1.0 / (scene.material[&grain.material].density * sphere_volume(grain.radius)),
            scaled_spin: grain.spin.map(|component| component * grain.radius),
            inverse_radius: 1.0 / grain.radius,
        };
        let sphere = |grain: &Grain| Sphere { centre: Vector3::from(grain.position), radius: grain.radius };
        World {
            bodies: grains.iter().map(body).collect(),
            spheres: grains.iter().map(sphere).collect(),
            materials: grains.iter().map(|grain| table.number(&grain.material)).collect(),
            ids: (0..grains.len() as u32).collect(),
            before: Vec::new(),
            spins_before: Vec::new(),
            walls: Walls::new(&scene.wall, &scene.domain, |name| table.number(name)),
            drives: (0..).zip(&scene.wall).filter_map(|(index, wall)| drive_of(wall, index)).collect(),
            table,
            gravity: Vector3::from(scene.gravity),
            field: scene.gravity_field(),
            domain: (Vector3::from(scene.domain.min), Vector3::from(scene.domain.max)),
            period: scene.domain.period(),
            time: 0.0,
            kept: KeptInPlace::default(),
        }
    }

    /// Returns the world without its grains.
    pub(crate) fn without_grains(&self) -> World {
        World {
            bodies: Vec::new(),
            spheres: Vec::new(),
            materials: Vec::new(),
            ids: Vec::new(),
            before: Vec::new(),
            spins_before: Vec::new(),
            walls: self.walls.clone(),
            drives: self.drives.clone(),
            table: self.table.clone(),
            gravity: self.gravity,
            field: self.field.clone(),
            domain: self.domain,
            period: self.period,
            time: self.time,
            kept: KeptInPlace::default(),
        }
    }

    /// Makes room for the dummies of so many boxes, and sees to it that bodies and spheres do not move from here on.
    ///
    /// # Errors
    /// Where there is no memory for them.
    pub(crate) fn keep_in_place(&mut self, boxes: usize) -> Result<(), TryReserveError> {
        let all = self.grains() + boxes * DUMMIES;
        self.bodies.try_reserve_exact(all.saturating_sub(self.bodies.len()))?;
        self.spheres.try_reserve_exact(all.saturating_sub(self.spheres.len()))?;
        self.kept = KeptInPlace(true);
        Ok(())
    }

    /// Puts the dummies of so many boxes behind the grains. Dummies of the two sides of a contact are far apart and at
    /// rest, so that padding lanes bear nothing without being masked. Along a periodic axis half a period is as far as it gets.
    /// Those that are there already stay.
    pub(crate) fn add_dummies(&mut self, boxes: usize) {
        let grains = self.grains();
        if self.bodies.len() == grains + boxes * DUMMIES {
            return;
        }
        let all = grains + boxes * DUMMIES;
        // Somebody may hold pointers into them.
        let stays = !self.kept.0 || all <= self.bodies.capacity().min(self.spheres.capacity());
        assert!(stays, "arrays that are kept in place would have to move for {boxes} boxes");
        self.bodies.truncate(grains);
        self.spheres.truncate(grains);
        self.materials.truncate(grains);
        let body = Body { velocity: [0.0; 3], inverse_mass: 1.0, scaled_spin: [0.0; 3], inverse_radius: 1.0 };
        let (far, radius) = match self.period.length(0) {
            length if length > 0.0 => (0.5 * length, 0.01 * length),
            _ => (1e6, 1.0),
        };
        for dummy in 0..boxes * DUMMIES {
            let side = (dummy / LANES % 2) as f64;
            self.bodies.push(body);
            self.spheres.push(Sphere { centre: Vector3::new(far * side, 0.0, 0.0), radius });
            self.materials.push(0);
        }
    }

    /// The bodies, to be written, and all that contacts are made from beside them.
    pub(crate) fn split(&mut self) -> (&mut [Body], WorldBesideBodies<'_>) {
        let World { bodies, spheres, materials, ids, before, spins_before, walls, drives, table, .. } = self;
        let (grains, gravity, period) = (ids.len(), &self.gravity, &self.period);
        let beside = WorldBesideBodies {
            grains,
            spheres,
            materials,
            before,
            spins_before,
            walls,
            drives,
            table,
            gravity,
            period,
        };
        (bodies, beside)
    }

    /// The vector from one sphere's centre to the nearest image of another's, m.
    #[inline]
    pub(crate) fn arm(&self, from: usize, to: usize) -> Vector3<f64> {
        self.period.arm(&self.spheres[from].centre, &self.spheres[to].centre)
    }

    /// Wraps a point into the domain along periodic axes, m.
    #[inline]
    pub(crate) fn wrapped(&self, point: &Vector3<f64>) -> Vector3<f64> {
        self.period.wrapped(point, &self.domain.0)
    }

    /// Sets the clock, and gravity to what it then is.
    pub(crate) fn set_time(&mut self, time: f64) {
        self.time = time;
        if self.field.changes() {
            self.gravity = self.field.at(time);
        }
    }

    /// Puts driven walls where their drives have moved them.
    pub(crate) fn place_driven_walls(&mut self) {
        let World { walls, drives, .. } = self;
        drives.iter().for_each(|drive| walls.put(drive.wall, drive.displacement, drive.rate));
    }

    /// Number of the drive of the wall that a face belongs to, if it has one.
    pub(crate) fn drive_of(&self, surface: u32) -> Option<usize> {
        self.drive_of_wall(self.walls.wall_of(surface))
    }

    fn drive_of_wall(&self, wall: u32) -> Option<usize> {
        drive_of_wall(&self.drives, wall)
    }

    /// A wall at the start of a step of length `step` (s), with the velocity that takes it to where it is at the end.
    pub(crate) fn pose_through(&self, wall: u32, step: f64) -> Pose {
        let rate = self.drive_of_wall(wall).map_or(0.0, |drive| self.drives[drive].rate);
        self.walls.pose_through(wall, self.time, step, rate)
    }

    /// Properties of contacts of a grain with a face.
    #[inline]
    pub(crate) fn wall_material(&self, grain: usize, surface: u32) -> &ContactMaterial {
        self.table.with_wall(self.materials[grain], self.walls.material_of(surface))
    }

    /// Number of grains.
    pub fn grains(&self) -> usize {
        self.ids.len()
    }

    /// Moves the grain at place `order[i]` to place `i`.
    pub(crate) fn reorder(&mut self, order: &[u32], team: &Team) {
        let World { bodies, spheres, materials, ids, before, .. } = self;
        before.resize(bodies.len(), Quad::default());
        let bodies: &mut [Line] = bytemuck::must_cast_slice_mut(&mut bodies[..order.len()]);
        for half in 0..2 {
            reorder_quads(bodies, order, before, team, |line| &mut line.0[half]);
        }
        let spheres: &mut [Quad] = bytemuck::must_cast_slice_mut(&mut spheres[..order.len()]);
        reorder_quads(spheres, order, before, team, |quad| quad);
        team.alone(Phase::Detect, || {
            // Ids and materials are small: one quad takes both.
            for (quad, (id, material)) in before.iter_mut().zip(ids.iter().zip(&*materials)) {
                *quad = Quad([f64::from(*id), f64::from(*material), 0.0, 0.0]);
            }
            for ((id, material), &old) in ids.iter_mut().zip(materials).zip(order) {
                let Quad([old_id, old_material, ..]) = before[old as usize];
                (*id, *material) = (old_id as u32, old_material as u8);
            }
        });
    }

    pub(crate) fn memory_bytes(&self) -> usize {
        self.bodies.capacity() * size_of::<Body>()
            + self.spheres.capacity() * size_of::<Sphere>()
            + self.materials.capacity()
            + self.ids.capacity() * size_of::<u32>()
            + (self.before.capacity() + self.spins_before.capacity()) * size_of::<Quad>()
            + self.walls.memory_bytes()
    }

    /// Largest and mean radius, m; (0, 0) in an empty world.
    pub fn largest_and_mean_radius(&self) -> (f64, f64) {
        let radii = || self.spheres[..self.grains()].iter().map(|sphere| sphere.radius);
        (radii().fold(0.0, f64::max), radii().sum::<f64>() / self.grains().max(1) as f64)
    }

    /// Largest gap across which cohesion pulls, m.
    pub fn range_of_cohesion(&self) -> f64 {
        // The range from a work of adhesion grows with the effective radius, which is that of the grain at a wall.
        let (largest, _) = self.largest_and_mean_radius();
        if largest > 0.0 { self.largest(|pair| pair.pull(largest).range).max(0.0) } else { 0.0 }
    }

    /// Largest value of a property over the contacts that the grains can have: of materials that no grain and no wall has there are none.
    fn largest(&self, property: impl Fn(&ContactMaterial) -> f64) -> f64 {
        let mut known = [false; 256];
        self.materials[..self.grains()].iter().for_each(|&material| known[usize::from(material)] = true);
        let grains: Vec<u8> = (0..=u8::MAX).filter(|&material| known[usize::from(material)]).collect();
        let mut walls: Vec<u8> = (0..self.walls.faces() as u32).map(|face| self.walls.material_of(face)).collect();
        walls.sort_unstable();
        walls.dedup();
        self.table.largest(&grains, &walls, property)
    }

    /// Largest skin of a candidate list where axes are periodic, m.
    pub(crate) fn longest_reach(&self) -> f64 {
        let pair = 2.0 * self.largest_and_mean_radius().0 + self.range_of_cohesion();
        let periods = (0..3).filter(|&axis| self.period.is_periodic(axis)).map(|axis| self.period.length(axis));
        periods.fold(f64::INFINITY, |reach, period| reach.min(period / REACHES - pair))
    }

    /// A bound on the stiffness, against its inertia, of every contact that the grains can have: two of the smallest grains, at
    /// touch, made of the stiffest and least damped pair of materials that meet.
    pub fn stiffest_contact(&self) -> NormalContact<f64> {
        let grains = self.spheres[..self.grains()].iter().zip(&self.bodies);
        let (radius, inverse_mass) = grains.fold((f64::INFINITY, 0.0_f64), |(radius, inverse_mass), (sphere, body)| {
            (radius.min(sphere.radius), inverse_mass.max(body.inverse_mass))
        });
        // Without grains there is no contact, and nothing to bound.
        let bound = |largest: f64| if largest.is_finite() { largest } else { 0.0 };
        NormalContact {
            overlap: 0.0,
            velocity: 0.0,
            effective_modulus: bound(self.largest(|pair| pair.effective_modulus)),
            effective_radius: if radius.is_finite() { 0.5 * radius } else { 0.0 },
            inverse_mass: 2.0 * inverse_mass,
            damping_ratio: -bound(self.largest(|pair| -pair.damping_ratio)),
        }
    }
}

/// Moves the quad of the record at `order[i]` to the record at `i`, by way of `room`.
fn reorder_quads<R: Copy + Send + Sync>(
    records: &mut [R],
    order: &[u32],
    room: &mut [Quad],
    team: &Team,
    quad: impl Fn(&mut R) -> &mut Quad + Sync,
) {
    let tasks = chunks(order.len());
    team.each_with(Phase::Detect, tasks, (by_chunk(records), by_chunk(room)), |_, (records, copies)| {
        records.iter_mut().zip(copies).for_each(|(record, copy)| *copy = *quad(record));
    });
    team.each_with(Phase::Detect, tasks, by_chunk(records), |number, records| {
        let order = &order[chunk(number, order.len())];
        records.iter_mut().zip(order).for_each(|(record, &old)| *quad(record) = room[old as usize]);
    });
}
