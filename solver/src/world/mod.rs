//! State of a simulation: bodies, walls and their drives, material pairs, time.

mod limits;
mod materials;
mod roll;

pub use materials::{ContactMaterial, MaterialTable};

use crate::effects::drive::Drive;
use crate::effects::gravity::Field;
use crate::lanes::{LANES, Line, Quad};
use crate::laws::compliance::NormalContact;
use crate::laws::period::Period;
use crate::scene::{Grain, Motion, REACHES, Scene, sphere_volume};
use crate::schedule::{Phase, Runs, Team};
use crate::wall::{Beginning, Pose, Walls, drive_of};
use bytemuck::{Pod, Zeroable};
pub(crate) use limits::Limits;
use nalgebra::Vector3;
pub(crate) use roll::{GONE, Moves, NewGrain, Roll};
use std::collections::TryReserveError;
use std::ops::Range;

/// Padding bodies of a box for padding lanes: one for each lane and side. Each box has its own, so that no two tasks of
/// a stage write to the same body.
pub const DUMMIES: usize = 2 * LANES;

/// Number of grains that one task moves, sorts or compares.
const CHUNK: usize = 4096;

/// Returns the number of chunks.
pub(crate) fn chunks(grains: usize) -> usize {
    grains.div_ceil(CHUNK)
}

/// Returns the slots of the grains of one chunk.
pub(crate) fn chunk(number: usize, grains: usize) -> Range<usize> {
    CHUNK * number..(CHUNK * (number + 1)).min(grains)
}

/// Splits an array of grains or bodies into chunks.
pub(crate) fn by_chunk<T>(array: &mut [T]) -> Runs<'_, T> {
    Runs::of(array, CHUNK)
}

/// Returns the number of the chunk of a grain.
pub(crate) fn chunk_of(place: usize) -> usize {
    place / CHUNK
}

/// Moment of inertia of a solid sphere over `m r^2`.
pub(crate) const INERTIA: f64 = 0.4;
/// Inverse of [`INERTIA`].
pub(crate) const INVERSE_INERTIA: f64 = 2.5;

/// Dynamic state of a grain: one cache line of two quads.
///
/// The spin is stored as the scaled spin `radius * angular velocity` (m/s), which removes the lever arm from the contact: for solid
/// spheres, an impulse P changes the scaled spin by `INVERSE_INERTIA` (5/2) over m times the cross product of P and the normal.
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
#[repr(C, align(64))]
pub struct Body {
    /// Velocity, m/s.
    pub velocity: [f64; 3],
    /// Inverse mass, 1/kg.
    pub inverse_mass: f64,
    /// Radius times angular velocity, m/s.
    pub scaled_spin: [f64; 3],
    /// Inverse radius, 1/m.
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

/// All bodies and walls, and the time.
///
/// Grains are stored in the order of their boxes and cells at the last build of the candidate list; a grain's index in
/// this order is its slot. `ids` maps slots to grains.
#[derive(Clone, Debug)]
pub struct World {
    /// Grains by slot, then the padding bodies at rest, box after box.
    pub bodies: Vec<Body>,
    /// Spheres of the bodies; those of padding bodies are out of the interaction range of each other.
    pub spheres: Vec<Sphere>,
    /// Material indices of the bodies.
    pub materials: Vec<u8>,
    /// Id of the grain in each slot.
    pub ids: Vec<u32>,
    /// Velocity and inverse mass of every body at the start of the step; between steps, a buffer for reordering grains.
    pub(crate) before: Vec<Quad>,
    /// Surface speed of every body at the start of the step, if friction depends on sliding or the step may be abandoned.
    pub(crate) spins_before: Vec<Quad>,
    /// Walls of the scene.
    pub walls: Walls,
    /// Drives of dynamic walls.
    pub drives: Vec<Drive>,
    /// Pair properties.
    pub table: MaterialTable,
    /// Acceleration of gravity at the present time, m/s2.
    pub gravity: Vector3<f64>,
    /// Gravity over time.
    pub field: Field,
    /// Corners of the domain, m.
    pub domain: (Vector3<f64>, Vector3<f64>),
    /// Periods of the domain.
    pub period: Period,
    /// Simulated time, s.
    pub time: f64,
    /// Limits of the grains, if grains come and go by the scene.
    pub(crate) limits: Option<Limits>,
    /// Permanent numbers of the grains.
    pub(crate) roll: Roll,
    /// True while bodies and spheres must not move in memory.
    pub(crate) kept: KeptInPlace,
}

/// True while arrays must not move in memory. The arrays of a copy are independent and may move.
#[derive(Debug, Default)]
pub(crate) struct KeptInPlace(bool);

impl Clone for KeptInPlace {
    fn clone(&self) -> KeptInPlace {
        KeptInPlace(false)
    }
}

/// Parts of a [`World`] other than the bodies, which are borrowed for writing.
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
    /// Returns the number of grains.
    pub fn grains(&self) -> usize {
        self.grains
    }

    /// Returns the slot of the first padding body of a box.
    #[inline]
    pub fn dummies_of(&self, number: usize) -> u32 {
        (self.grains + number * DUMMIES) as u32
    }

    /// Returns the index of the drive of the wall of a face, if any.
    pub fn drive_of(&self, surface: u32) -> Option<usize> {
        drive_of_wall(self.drives, self.walls.wall_of(surface))
    }

    /// Returns the properties of contacts of a grain with a face.
    #[inline]
    pub fn wall_material(&self, grain: usize, surface: u32) -> &ContactMaterial {
        self.table.with_wall(self.materials[grain], self.walls.material_of(surface))
    }
}

fn drive_of_wall(drives: &[Drive], wall: u32) -> Option<usize> {
    drives.iter().position(|drive| drive.wall == wall)
}

impl World {
    /// Builds the world of a checked scene at time zero, without padding bodies.
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
            drives: (0..).zip(&scene.wall).filter_map(|(index, wall)| drive_of(&wall.motion, index, 0.0)).collect(),
            limits: Limits::of(scene, |name| table.number(name)),
            roll: Roll::default(),
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
            limits: self.limits.clone(),
            roll: self.roll.clone(),
            table: self.table.clone(),
            gravity: self.gravity,
            field: self.field.clone(),
            domain: self.domain,
            period: self.period,
            time: self.time,
            kept: KeptInPlace::default(),
        }
    }

    /// Reserves memory for the padding bodies of n boxes; bodies and spheres do not move in memory from then on.
    ///
    /// # Errors
    /// The memory cannot be allocated.
    pub(crate) fn keep_in_place(&mut self, boxes: usize) -> Result<(), TryReserveError> {
        let all = self.grains() + boxes * DUMMIES;
        self.bodies.try_reserve_exact(all.saturating_sub(self.bodies.len()))?;
        self.spheres.try_reserve_exact(all.saturating_sub(self.spheres.len()))?;
        self.kept = KeptInPlace(true);
        Ok(())
    }

    /// Adds the padding bodies of n boxes after the grains. Padding bodies of the two sides of a contact are at rest
    /// and far apart, so that padding lanes are inactive without a mask. Along a periodic axis, the largest distance is
    /// half a period. Existing padding bodies remain.
    pub(crate) fn add_dummies(&mut self, boxes: usize) {
        let grains = self.grains();
        if self.bodies.len() == grains + boxes * DUMMIES {
            return;
        }
        let all = grains + boxes * DUMMIES;
        // Other code may have pointers into the arrays.
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

    /// Returns the bodies for writing, and separately all other data that contacts are built from.
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

    /// Returns the vector from the centre of one sphere to the nearest image of another, m.
    #[inline]
    pub(crate) fn arm(&self, from: usize, to: usize) -> Vector3<f64> {
        self.period.arm(&self.spheres[from].centre, &self.spheres[to].centre)
    }

    /// Wraps a point into the domain along periodic axes, m.
    #[inline]
    pub(crate) fn wrapped(&self, point: &Vector3<f64>) -> Vector3<f64> {
        self.period.wrapped(point, &self.domain.0)
    }

    /// Sets the time, and gravity at that time.
    pub(crate) fn set_time(&mut self, time: f64) {
        self.time = time;
        if self.field.changes() {
            self.gravity = self.field.at(time);
        }
    }

    /// Begins another motion of a wall. The rate of a drive about or along the same axis continues; any other motion starts at rest.
    /// The candidate list must be built again before the next step.
    pub(crate) fn begin_motion(&mut self, wall: u32, motion: &Motion, beginning: &Beginning) {
        self.walls.begin_motion(wall, motion, beginning);
        let before = self.drive_of_wall(wall).map(|drive| self.drives.remove(drive));
        if let Some(mut drive) = drive_of(motion, wall, beginning.time) {
            drive.rate = before.filter(|before| before.has_axis_of(&drive)).map_or(0.0, |before| before.rate);
            let place = self.drives.partition_point(|other| other.wall < wall);
            self.drives.insert(place, drive);
        }
        self.place_driven_walls();
    }

    /// Moves dynamic walls to the positions of their drives.
    pub(crate) fn place_driven_walls(&mut self) {
        let World { walls, drives, .. } = self;
        drives.iter().for_each(|drive| walls.put(drive.wall, drive.displacement, drive.rate));
    }

    /// Returns the index of the drive of the wall of a face, if any.
    pub(crate) fn drive_of(&self, surface: u32) -> Option<usize> {
        self.drive_of_wall(self.walls.wall_of(surface))
    }

    fn drive_of_wall(&self, wall: u32) -> Option<usize> {
        drive_of_wall(&self.drives, wall)
    }

    /// Returns the pose of a wall at the start of a step of length `step` (s), with the velocity that leads to its position at the end.
    pub(crate) fn pose_through(&self, wall: u32, step: f64) -> Pose {
        let rate = self.drive_of_wall(wall).map_or(0.0, |drive| self.drives[drive].rate);
        self.walls.pose_through(wall, self.time, step, rate)
    }

    /// Returns the properties of contacts of a grain with a face.
    #[inline]
    pub(crate) fn wall_material(&self, grain: usize, surface: u32) -> &ContactMaterial {
        self.table.with_wall(self.materials[grain], self.walls.material_of(surface))
    }

    /// Returns the number of grains.
    pub fn grains(&self) -> usize {
        self.ids.len()
    }

    /// Moves the grain in slot `order[i]` to slot `i`.
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
            // Ids and materials are small: both fit into one quad.
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

    /// Returns the largest and mean radius, m, of the present grains or of those of a scene in which grains come and go; (0, 0) in
    /// an empty world.
    pub fn largest_and_mean_radius(&self) -> (f64, f64) {
        if let Some(limits) = &self.limits {
            return (limits.radii.1, limits.mean);
        }
        let radii = || self.spheres[..self.grains()].iter().map(|sphere| sphere.radius);
        (radii().fold(0.0, f64::max), radii().sum::<f64>() / self.grains().max(1) as f64)
    }

    /// Returns the largest gap with a cohesive force, m.
    pub fn range_of_cohesion(&self) -> f64 {
        // The range from a work of adhesion increases with the effective radius, which is that of the grain at a wall.
        let (largest, _) = self.largest_and_mean_radius();
        if largest > 0.0 { self.largest(|pair| pair.pull(largest).range).max(0.0) } else { 0.0 }
    }

    /// Returns the largest value of a property over the possible contacts of the grains, for materials of existing grains and walls.
    fn largest(&self, property: impl Fn(&ContactMaterial) -> f64) -> f64 {
        let grains = self.materials_of_grains();
        let mut walls: Vec<u8> = (0..self.walls.faces() as u32).map(|face| self.walls.material_of(face)).collect();
        walls.sort_unstable();
        walls.dedup();
        self.table.largest(&grains, &walls, property)
    }

    /// Returns the largest skin of a candidate list with periodic axes, m.
    pub(crate) fn longest_reach(&self) -> f64 {
        let pair = 2.0 * self.largest_and_mean_radius().0 + self.range_of_cohesion();
        let periods = (0..3).filter(|&axis| self.period.is_periodic(axis)).map(|axis| self.period.length(axis));
        periods.fold(f64::INFINITY, |reach, period| reach.min(period / REACHES - pair))
    }

    /// Returns an upper bound of the stiffness, relative to inertia, of all possible contacts: two of the smallest
    /// grains, at zero overlap, of the stiffest and least damped pair of materials.
    pub fn stiffest_contact(&self) -> NormalContact<f64> {
        let (radius, inverse_mass) = (self.smallest_radius(), self.largest_inverse_mass());
        // Without grains there are no contacts, and the bound is zero.
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

/// Moves the quad of the record at `order[i]` to the record at `i`, with `room` as a buffer.
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
