//! Frames of a run, and the figures of cases from them: the same for every code.

use makadam::scene::{Grain, Material, NormalLaw};
use makadam::snapshot::{Particle, Partner, Snapshot};
use makadam::wall::PlacedWalls;
use makadam_frames::neighbours::close_pairs;
use makadam_frames::plan::MeasuredScene;
use nalgebra::Vector3;
use std::f64::consts::PI;

/// Scene, its initial grains, and the frames of a run.
pub(crate) struct Evidence<'a> {
    scene: &'a MeasuredScene,
    grains: &'a [Grain],
    frames: &'a [Snapshot],
    masses: Vec<f64>,
}

impl<'a> Evidence<'a> {
    /// Evidence of a run; `frames` holds at least one frame.
    pub(crate) fn new(scene: &'a MeasuredScene, grains: &'a [Grain], frames: &'a [Snapshot]) -> Evidence<'a> {
        let mass = |grain: &Grain| 4.0 / 3.0 * PI * grain.radius.powi(3) * scene.material[&grain.material].density;
        Evidence { scene, grains, frames, masses: grains.iter().map(mass).collect() }
    }

    /// All frames, by time.
    pub(super) fn frames(&self) -> &[Snapshot] {
        self.frames
    }

    /// Last frame.
    pub(super) fn last(&self) -> &Snapshot {
        &self.frames[self.frames.len() - 1]
    }

    /// Returns a grain of the last frame.
    pub(super) fn grain(&self, id: usize) -> &Particle {
        &self.last().particles[id]
    }

    /// Returns true if every number of every frame is finite.
    pub(super) fn is_finite(&self) -> bool {
        let finite = |values: &[f64; 3]| values.iter().all(|value| value.is_finite());
        self.frames.iter().all(|frame| {
            let grains = frame.particles.iter();
            grains.clone().all(|grain| finite(&grain.position) && finite(&grain.velocity) && finite(&grain.spin))
                && frame.contacts.iter().all(|contact| contact.normal_force.is_finite())
        })
    }

    /// Weight of all grains, N.
    pub(super) fn weight(&self) -> f64 {
        self.masses.iter().sum::<f64>() * Vector3::from(self.scene.gravity).norm()
    }

    /// Mass of a grain, kg.
    pub(super) fn mass(&self, id: usize) -> f64 {
        self.masses[id]
    }

    /// Upward force of the walls over the weight, averaged over the last part of the run.
    pub(super) fn carried(&self, share: f64) -> f64 {
        -self.mean_force(share, |_| true).z / self.weight()
    }

    /// Force on one wall.
    pub(super) fn force_on_wall(&self, wall: u32, share: f64) -> Vector3<f64> {
        self.mean_force(share, |at| at == wall)
    }

    /// Force of the grains on walls, N, averaged over the last part of the run.
    fn mean_force(&self, share: f64, counts: impl Fn(u32) -> bool) -> Vector3<f64> {
        let frames = self.ending(share);
        let contacts = frames.iter().flat_map(|frame| &frame.contacts);
        let on_walls = contacts.filter(|contact| matches!(contact.second, Partner::Wall(wall) if counts(wall)));
        on_walls.map(|contact| contact.force_on_partner()).sum::<Vector3<f64>>() / frames.len() as f64
    }

    /// Frames of the last part of the run.
    pub(super) fn ending(&self, share: f64) -> &[Snapshot] {
        let from = ((1.0 - share) * (self.frames.len() - 1) as f64).ceil() as usize;
        &self.frames[from.min(self.frames.len() - 1)..]
    }

    /// Largest speed in the last frame, m/s.
    pub(super) fn fastest(&self) -> f64 {
        self.last().particles.iter().map(speed).fold(0.0, f64::max)
    }

    /// Largest speed in any frame, m/s.
    pub(super) fn fastest_ever(&self) -> f64 {
        self.frames.iter().flat_map(|frame| &frame.particles).map(speed).fold(0.0, f64::max)
    }

    /// Momentum of a frame, kg m/s.
    pub(super) fn momentum(&self, frame: &Snapshot) -> Vector3<f64> {
        let parts = frame.particles.iter().zip(&self.masses);
        parts.map(|(grain, mass)| Vector3::from(grain.velocity) * *mass).sum()
    }

    /// Height of the centre of mass of a frame along an axis, m.
    pub(super) fn centre_of_mass(&self, frame: &Snapshot, axis: usize) -> f64 {
        let parts = frame.particles.iter().zip(&self.masses);
        parts.map(|(grain, mass)| grain.position[axis] * mass).sum::<f64>() / self.masses.iter().sum::<f64>()
    }

    /// Kinetic energy of a frame, J.
    pub(super) fn kinetic(&self, frame: &Snapshot) -> f64 {
        let square = |vector: &[f64; 3]| vector.iter().map(|x| x * x).sum::<f64>();
        let parts = frame.particles.iter().zip(&self.masses);
        parts
            .map(|(grain, mass)| {
                let inertia = 0.4 * mass * grain.radius * grain.radius;
                0.5 * (mass * square(&grain.velocity) + inertia * square(&grain.spin))
            })
            .sum()
    }

    /// Kinetic energy, potential energy in the field of gravity and elastic energy of the overlaps of a frame, J.
    pub(super) fn mechanical(&self, frame: &Snapshot) -> f64 {
        let gravity = Vector3::from(self.scene.gravity);
        let parts = frame.particles.iter().zip(&self.masses);
        let potential = parts.map(|(grain, mass)| -mass * gravity.dot(&Vector3::from(grain.position))).sum::<f64>();
        self.kinetic(frame) + potential + self.elastic(frame)
    }

    /// Elastic energy of the overlaps by Hertz's law, `2/5 k_H d^(5/2)`; none where the scene's contacts are rigid.
    pub(super) fn elastic(&self, frame: &Snapshot) -> f64 {
        if self.scene.solver.normal_law == NormalLaw::Rigid {
            return 0.0;
        }
        let material = |id: usize| &self.scene.material[&self.grains[id].material];
        let grains = &frame.particles;
        let pairs = close_pairs(grains, 0.0).into_iter().map(|pair| {
            let (a, b) = (grains[pair.first].radius, grains[pair.second].radius);
            let effective_radius = a * b / (a + b);
            stored(-pair.gap, effective_radius, [material(pair.first), material(pair.second)])
        });
        let placed = self.walls(frame);
        let walls = placed.faces().flat_map(|(wall, face)| {
            let wall = &self.scene.material[&self.scene.wall[wall].material];
            grains.iter().enumerate().map(move |(id, grain)| {
                stored(grain.radius - face.distance(&grain.position.into()), grain.radius, [material(id), wall])
            })
        });
        pairs.sum::<f64>() + walls.sum::<f64>()
    }

    /// Largest overlap of two grains or of a grain and a wall over the smaller radius, in the frames of the last part of the
    /// run; 0 without overlaps.
    pub(super) fn largest_overlap(&self, share: f64) -> f64 {
        let of_frame = |frame: &Snapshot| {
            let grains = &frame.particles;
            let pairs = close_pairs(grains, 0.0)
                .into_iter()
                .map(|pair| -pair.gap / grains[pair.first].radius.min(grains[pair.second].radius))
                .fold(0.0, f64::max);
            let placed = self.walls(frame);
            let walls = placed.faces().flat_map(|(_, face)| {
                grains.iter().map(move |grain| 1.0 - face.distance(&grain.position.into()) / grain.radius)
            });
            walls.fold(pairs, f64::max)
        };
        self.ending(share).iter().map(of_frame).fold(0.0, f64::max)
    }

    /// Number of grains whose centre lies outside the domain in the last frame.
    pub(super) fn lost(&self) -> f64 {
        let domain = &self.scene.domain;
        let outside = |grain: &&Particle| {
            (0..3).any(|axis| !(domain.min[axis]..=domain.max[axis]).contains(&grain.position[axis]))
        };
        self.last().particles.iter().filter(outside).count() as f64
    }

    /// Walls at their positions in a frame.
    fn walls(&self, frame: &Snapshot) -> PlacedWalls {
        PlacedWalls::at(&self.scene.wall, &self.scene.domain, frame.time, &frame.driven_walls, &frame.beginnings)
    }
}

fn stored(overlap: f64, effective_radius: f64, materials: [&Material; 2]) -> f64 {
    let softness: f64 = materials.iter().map(|m| (1.0 - m.poisson_ratio * m.poisson_ratio) / m.youngs_modulus).sum();
    let overlap = overlap.max(0.0);
    0.4 * 4.0 / 3.0 / softness * effective_radius.sqrt() * overlap * overlap * overlap.sqrt()
}

fn speed(grain: &Particle) -> f64 {
    Vector3::from(grain.velocity).norm()
}
