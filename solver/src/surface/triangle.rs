//! Triangle of a mesh: its point nearest to a sphere's centre, and the first contact of a path with it.
//!
//! The first corner is the one opposite the longest side, so that the cross product of the two sides there gives the normal of a needle
//! to rounding. A point x is over the triangle if it lies inside of all sides; otherwise the nearest point is on a side that x lies
//! outside of:
//!
//! ```text
//! m_e . (x - a_e) <= 0 for each side e     m_e = d_e x n: outward normal of the side in the plane, d_e its direction, a_e its start
//! ```
//!
//! A sphere of radius `level` on a path touches the face at this height, a side as it would a cylinder, and a corner as it would a
//! sphere of this radius, whichever is first.

use super::face::{Impact, JOINT};
use nalgebra::Vector3;

type Vector = Vector3<f64>;

/// Height of a triangle over its longest side below which it has no area.
const FLAT: f64 = 1e-9;

/// Triangle by its corners, m.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Triangle {
    pub corners: [Vector; 3],
}

/// Point of a triangle nearest to another point.
#[derive(Clone, Copy, Debug)]
pub(crate) struct NearestPoint {
    /// Distance, m.
    pub distance: f64,
    /// Unit vector towards the nearest point.
    pub normal: Vector,
    /// True if the nearest point is inside the triangle, not on a side or a corner.
    pub inside: bool,
}

impl Triangle {
    /// Creates a triangle; the order of its corners is rotated.
    pub fn new([a, b, c]: [Vector; 3]) -> Triangle {
        let [ab, bc, ca] = [(b - a).norm_squared(), (c - b).norm_squared(), (a - c).norm_squared()];
        let corners = if bc >= ab && bc >= ca {
            [a, b, c]
        } else if ca >= ab {
            [b, c, a]
        } else {
            [c, a, b]
        };
        Triangle { corners }
    }

    /// Returns true if the corners span an area.
    pub fn has_area(&self) -> bool {
        let [a, b, c] = self.corners;
        (b - a).cross(&(c - a)).norm() > FLAT * (c - b).norm_squared()
    }

    /// Returns the corners of the box around the triangle, m.
    pub fn bounds(&self) -> [Vector; 2] {
        let [a, b, c] = &self.corners;
        [a.inf(b).inf(c), a.sup(b).sup(c)]
    }

    /// Returns the normal by the right-hand rule, with the length of twice the area, m2.
    #[inline]
    pub fn area_vector(&self) -> Vector {
        let [a, b, c] = self.corners;
        (b - a).cross(&(c - a))
    }

    /// Returns the nearest point if it is nearer than `reach`, m. Most triangles near a sphere are beside it: the distances from their
    /// planes and sides exclude them without a division.
    #[inline]
    pub fn nearest_within(&self, point: &Vector, reach: f64) -> Option<NearestPoint> {
        let normal = self.area_vector();
        let (height, most) = (normal.dot(&(point - self.corners[0])), reach * reach * normal.norm_squared());
        if height * height > most {
            return None;
        }
        for edge in 0..3 {
            let (start, along) = self.edge(edge);
            let beside = along.cross(&normal).dot(&(point - start)).max(0.0);
            if beside * beside > (most - height * height) * along.norm_squared() {
                return None;
            }
        }
        // In this form, a comparison with NaN is false.
        Some(self.nearest(point)).filter(|near| near.distance < reach)
    }

    /// Returns the nearest point; on the triangle itself, the direction is opposite to its normal.
    #[inline]
    pub fn nearest(&self, point: &Vector) -> NearestPoint {
        let normal = self.area_vector().normalize();
        let height = normal.dot(&(point - self.corners[0]));
        let side = if height >= 0.0 { -normal } else { normal };
        let mut nearest: Option<(f64, Vector)> = None;
        for edge in 0..3 {
            let (start, along) = self.edge(edge);
            let arm = point - start;
            if along.cross(&normal).dot(&arm) > 0.0 {
                let share = (along.dot(&arm) / along.norm_squared()).clamp(0.0, 1.0);
                let to = along * share - arm;
                let square = to.norm_squared();
                if nearest.is_none_or(|(least, _)| square < least) {
                    nearest = Some((square, to));
                }
            }
        }
        match nearest {
            None => NearestPoint { distance: height.abs(), normal: side, inside: true },
            Some((square, to)) => {
                let distance = square.sqrt();
                let normal = if distance > 0.0 { to / distance } else { side };
                NearestPoint { distance, normal, inside: false }
            }
        }
    }

    /// Returns start and vector of a side.
    #[inline]
    fn edge(&self, number: usize) -> (Vector, Vector) {
        let (start, end) = (self.corners[number], self.corners[(number + 1) % 3]);
        (start, end - start)
    }

    /// Returns the first point of a path from `centre` along `shift` (m) within `level` (m) of the triangle, if the path starts farther
    /// away; at level 0, the crossing point.
    pub fn time_of_impact(&self, centre: &Vector, shift: &Vector, level: f64) -> Option<Impact> {
        let own = self.area_vector().normalize();
        let arm = centre - self.corners[0];
        let normal = if own.dot(&arm) < 0.0 { -own } else { own };
        let (height, fall) = (normal.dot(&arm), -normal.dot(shift));
        let share = (height - level) / fall;
        if height > level && (0.0..=1.0).contains(&share) {
            let foot = centre + shift * share - normal * level;
            let inside = (0..3).all(|edge| {
                let (start, along) = self.edge(edge);
                along.cross(&own).dot(&(foot - start)) <= JOINT * along.norm_squared()
            });
            if inside {
                return Some(Impact { share, distance: height, normal: -normal });
            }
        }
        if level <= 0.0 || height - fall.max(0.0) > level || self.nearest(centre).distance <= level {
            return None;
        }
        let meetings = (0..3).flat_map(|edge| {
            let (start, along) = self.edge(edge);
            let arm = centre - start;
            let corner = round(&arm, shift, level).map(|share| (share, start));
            let axis = along.normalize();
            let across = |vector: &Vector| vector - axis * axis.dot(vector);
            let side = round(&across(&arm), &across(shift), level).and_then(|share| {
                let place = axis.dot(&(arm + shift * share));
                (0.0..=along.norm()).contains(&place).then(|| (share, start + axis * place))
            });
            [corner, side].into_iter().flatten()
        });
        let (share, foot) = meetings.min_by(|one, other| one.0.total_cmp(&other.0))?;
        let normal = (foot - (centre + shift * share)) / level;
        Some(Impact { share, distance: normal.dot(&(foot - centre)), normal })
    }
}

/// Returns the fraction of a path after which it comes within `level` (m) of the origin, from an `arm` outside.
pub(super) fn round(arm: &Vector, shift: &Vector, level: f64) -> Option<f64> {
    let (square, half, beyond) = (shift.norm_squared(), arm.dot(shift), arm.norm_squared() - level * level);
    let root = half * half - square * beyond;
    if root < 0.0 || beyond <= 0.0 || half >= 0.0 {
        return None;
    }
    Some(-(root.sqrt() + half) / square).filter(|share| *share <= 1.0)
}
