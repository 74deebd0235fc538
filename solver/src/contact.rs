//! Geometry of a contact, shared by the set-up of a step, the energy balance, snapshots and the contact problem.
//!
//! Two spheres of radii a and b with an arm c between their centres, or a sphere of radius a at a distance D from a face of a wall:
//!
//! ```text
//! pair   D = |c|    n = c / D             gap = D - a - b    R* = a b / (a + b)    contact point at (D + a - b) / 2
//! wall   D          n towards the face    gap = D - a        R* = a                contact point at a
//! ```
//!
//! n is the unit normal from the first partner to the second, R* the effective radius; the contact point lies on n from the first centre.
//! An overlap is a gap below zero. Impulses act at the arms a n and -b n: on the surfaces, not at the contact point. Friction P then
//! removes `d n x P` from the angular momentum of two grains with an overlap d; the balance has an entry for this term.

use crate::detect::{PairCandidate, WallCandidate};
use crate::lanes::{Number, dot, times};
use crate::laws::cohesion::Pull;
use crate::laws::compliance::{NormalContact, effective_radius};
use crate::laws::period::Period;
use crate::world::{ContactMaterial, Sphere, World, WorldBesideBodies};
use nalgebra::Vector3;

/// Geometry of one contact, or of eight contacts.
#[derive(Clone, Copy, Debug)]
pub(crate) struct ContactGeometry<N> {
    /// Unit normal from the first partner to the second.
    pub normal: [N; 3],
    /// Gap, m; negative for an overlap.
    pub gap: N,
    /// Overlap, m; negative for a gap. For pairs, overlap and negative gap may differ in the last digit: each is rounded independently.
    pub overlap: N,
    /// Effective radius R*, m.
    pub effective_radius: N,
    /// Distance of the contact point from the first centre along the normal, m.
    pub point: N,
}

impl<N: Number> ContactGeometry<N> {
    /// Creates the geometry of two spheres from the arm from the first centre to the second (m) and their radii (m).
    /// Coincident centres define no normal, and +z is used: any direction separates the spheres.
    #[inline(always)]
    pub fn of_pair(arm: [N; 3], [first, second]: [N; 2]) -> Self {
        let distance = dot(arm, arm).sqrt();
        let one_centre = distance.at_most(N::zero());
        let upward = [N::zero(), N::zero(), N::splat(1.0)];
        let along = times(arm, N::splat(1.0) / distance);
        ContactGeometry {
            normal: std::array::from_fn(|axis| N::select(one_centre, upward[axis], along[axis])),
            gap: distance - first - second,
            overlap: first + second - distance,
            effective_radius: effective_radius(first, second),
            point: N::splat(0.5) * (distance + first - second),
        }
    }

    /// Creates the geometry of a sphere and a wall from the distance of its centre to the face and the normal towards
    /// the face: see [`PlacedFace::nearest`](crate::wall::PlacedFace::nearest).
    #[inline(always)]
    pub fn with_wall(distance: N, normal: [N; 3], radius: N) -> Self {
        let (gap, overlap) = (distance - radius, radius - distance);
        ContactGeometry { normal, gap, overlap, effective_radius: radius, point: radius }
    }

    /// Returns the input of the normal laws from the normal velocity (m/s), the sum of the inverse masses (1/kg), the
    /// effective modulus (Pa) and the damping ratio.
    #[inline(always)]
    pub fn normal_contact(
        &self,
        velocity: N,
        inverse_mass: N,
        effective_modulus: N,
        damping_ratio: N,
    ) -> NormalContact<N> {
        let Self { overlap, effective_radius, .. } = *self;
        NormalContact { overlap, velocity, effective_modulus, effective_radius, inverse_mass, damping_ratio }
    }
}

/// Returns the arms from the centres of two spheres to the points of action of impulses, m.
pub(crate) fn lever_arms(normal: &Vector3<f64>, [first, second]: [f64; 2]) -> [Vector3<f64>; 2] {
    [normal * first, normal * -second]
}

impl World {
    /// Returns the geometry of the contact between the grains in two slots, at their present positions.
    #[inline]
    pub(crate) fn pair_geometry(&self, first: usize, second: usize) -> ContactGeometry<f64> {
        between(&self.spheres, &self.period, first, second)
    }

    /// Returns the contact between two grains at their present positions, without its velocity, and its cohesive force.
    pub(crate) fn pair_contact(&self, pair: &PairCandidate) -> (NormalContact<f64>, Pull) {
        let (first, second) = (pair.first as usize, pair.second as usize);
        let material = self.table.between_grains(self.materials[first], self.materials[second]);
        let inverse_mass = self.bodies[first].inverse_mass + self.bodies[second].inverse_mass;
        as_it_is(&self.pair_geometry(first, second), inverse_mass, material)
    }

    /// Returns the contact between a grain and a wall at a distance (m) from its centre, without its velocity, and its cohesive force.
    pub(crate) fn wall_contact(&self, wall: &WallCandidate, distance: f64) -> (NormalContact<f64>, Pull) {
        let grain = wall.body as usize;
        let geometry = ContactGeometry::with_wall(distance, [0.0; 3], self.spheres[grain].radius);
        as_it_is(&geometry, self.bodies[grain].inverse_mass, self.wall_material(grain, wall.surface))
    }
}

impl WorldBesideBodies<'_> {
    /// Returns the geometry, as [`World::pair_geometry`] does.
    #[inline]
    pub(crate) fn pair_geometry(&self, first: usize, second: usize) -> ContactGeometry<f64> {
        between(self.spheres, self.period, first, second)
    }
}

#[inline]
fn between(spheres: &[Sphere], period: &Period, first: usize, second: usize) -> ContactGeometry<f64> {
    let [one, other] = [&spheres[first], &spheres[second]];
    ContactGeometry::of_pair(period.arm(&one.centre, &other.centre).into(), [one.radius, other.radius])
}

/// Returns a contact without its velocity, and its cohesive force.
fn as_it_is(
    geometry: &ContactGeometry<f64>,
    inverse_mass: f64,
    material: &ContactMaterial,
) -> (NormalContact<f64>, Pull) {
    let contact = geometry.normal_contact(0.0, inverse_mass, material.effective_modulus, material.damping_ratio);
    (contact, material.pull(geometry.effective_radius))
}
