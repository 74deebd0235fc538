//! Frustum of a cone: its point nearest to a sphere's centre, and the first contact of a path with it.
//!
//! The nearest point lies in the half-plane of the axis and the grain, on the line from `(R_0, 0)` to `(R_1, L)`. The surface at a distance
//! from a cone is a cone with the same angle. At the distance r from the axis and the position z along it:
//!
//! ```text
//! n = (L, R_0 - R_1) / sqrt(L^2 + (R_0 - R_1)^2)      outward normal in the half-plane
//! d = n_r (r - R_0) + n_z z                           distance from the endless cone, negative inside
//! ```
//!
//! A grain in a funnel narrower than itself touches three lines, as it does three points of a rim ([`Face::Rim`](super::Face::Rim)).

use super::face::{Impact, JOINT, perpendicular};
use nalgebra::Vector3;

type Vector = Vector3<f64>;

/// Frustum, m.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Frustum {
    pub base: Vector,
    /// Unit vector.
    pub axis: Vector,
    /// Radii at the base and at the other end.
    pub radii: [f64; 2],
    pub length: f64,
    /// Sine of the angle from the half-plane of the grain to the line of this face; zero for the whole surface.
    pub sine: f64,
}

impl Frustum {
    /// Returns the distance to a point, and the unit normal towards the surface; `travel` decides on the axis.
    #[inline]
    pub fn nearest(&self, centre: &Vector, travel: impl FnOnce() -> Vector) -> (f64, Vector) {
        let Frustum { axis, radii: [first, last], length, sine, .. } = *self;
        let arm = centre - self.base;
        let along = axis.dot(&arm);
        let across = arm - axis * along;
        let distance = across.norm();
        let outward = if distance > 0.0 { across / distance } else { perpendicular(axis, travel()) };
        let (radial, place) = match sine == 0.0 {
            true => (outward, distance),
            false => (outward * -0.5 + axis.cross(&outward) * sine, -0.5 * distance),
        };
        let [u, v] = [last - first, length];
        let share = (((place - first) * u + along * v) / (u * u + v * v)).clamp(0.0, 1.0);
        let to = radial * (first + share * u) + axis * (share * v) - arm;
        let (gap, normal) = (to.norm(), || self.normal());
        (gap, if gap > 0.0 { to / gap } else { radial * normal()[0] + axis * normal()[1] })
    }

    /// Returns the outward normal of the side in a half-plane of the axis: its components from the axis and along it.
    fn normal(&self) -> [f64; 2] {
        let (length, step) = (self.length, self.radii[0] - self.radii[1]);
        [length, step].map(|part| part / (length * length + step * step).sqrt())
    }

    /// Returns the first point of a path from `centre` along `shift` (m) within `level` (m) of the surface, if the path starts farther
    /// away; at level 0, the crossing point. Paths past the rims are omitted.
    pub fn time_of_impact(&self, centre: &Vector, shift: &Vector, level: f64) -> Option<Impact> {
        if self.sine != 0.0 {
            return None;
        }
        let from = |side: f64| self.impacts(centre - self.base, *shift, side * level, side);
        [1.0, -1.0].into_iter().flat_map(from).min_by(|one, other| one.share.total_cmp(&other.share))
    }

    /// Returns the points of a path at a signed distance `level` (m), on the way to the surface from outside (`side` 1) or inside (-1).
    fn impacts(&self, arm: Vector, shift: Vector, level: f64, side: f64) -> impl Iterator<Item = Impact> {
        let Frustum { axis, radii, length, .. } = *self;
        let [n_r, n_z] = self.normal();
        let (along, rise) = (axis.dot(&arm), axis.dot(&shift));
        let (across, moved) = (arm - axis * along, shift - axis * rise);
        // The radius of the parallel cone at the height of the path is `radius + growth s`.
        let (radius, growth) = (radii[0] + (level - n_z * along) / n_r, -n_z * rise / n_r);
        let (square, half) = (moved.norm_squared() - growth * growth, across.dot(&moved) - radius * growth);
        let beyond = across.norm_squared() - radius * radius;
        // Rounding must not miss the tip of the cone, a double root. Without a root, both fractions are NaN.
        let root = (half * half * (1.0 + 1e-14) - square * beyond).sqrt();
        let sum = -(half + root.copysign(half));
        let joint = JOINT * (length + radii[0].max(radii[1]));
        [sum / square, beyond / sum].into_iter().filter_map(move |share| {
            if !(0.0..=1.0).contains(&share) || radius + growth * share < -joint {
                return None;
            }
            let place = across + moved * share;
            let distance = place.norm();
            let outward = if distance > 0.0 { place / distance } else { perpendicular(axis, shift) };
            let foot = along + rise * share - level * n_z;
            // The path approaches the side, between its ends.
            if side * (n_r * outward.dot(&moved) + n_z * rise) >= 0.0 || foot < -joint || foot > length + joint {
                return None;
            }
            let normal = (outward * n_r + axis * n_z) * -side;
            Some(Impact { share, distance: share * normal.dot(&shift) + side * level, normal })
        })
    }
}
