//! Smooth faces of walls: the point of each face nearest to a grain, and the first contact of a grain's path with a face.
//!
//! A face is independent of walls and motions. The time of impact is that of the first point of a straight path of a
//! sphere's centre within `level` of a face; at a level equal to the radius, the sphere is in contact,
//!
//! ```text
//! plane      n.(x + s d - p) = level                              x: start, d: path, 0 <= s <= 1
//! cylinder   |across(x + s d - b)| = R -+ level                   from inside, from outside
//! sphere     |x + s d - c| = R + level                            frustum: frustum.rs
//! ```
//!
//! A grain over a hole, or over the mouth of a tube, that is smaller than the grain is in contact with the rim on all sides, but a nearest
//! point is single. Three points of the rim represent the circle: the nearest one, from the disc or the shell, and one a third of a turn to
//! either side, each a [`Face::Rim`]. The three points rotate with the grain about the axis, so that no direction is preferred, and their
//! normals can support any force through the hole. On the axis, where the whole circle is equally near, the nearest point is in the grain's
//! direction of travel, as for a tube. At the height z over a rim of radius R, at a distance e from the axis, the distances are
//!
//! ```text
//! nearest point  sqrt(z^2 + (R - e)^2)        the two others  sqrt(z^2 + R^2 + e^2 + R e)
//! ```

use super::frustum::Frustum;
use super::triangle::{Triangle, round};
use crate::laws::period::Period;
use nalgebra::Vector3;

type Vector = Vector3<f64>;

/// Extension of a face beyond its edges for a path that crosses the face, over its size: rounding must leave no gap between adjacent faces.
pub(super) const JOINT: f64 = 1e-9;

/// Largest angle, rad, and fraction of the extent of a scene, within which two faces are the same surface.
const SAME: f64 = 1e-6;

/// Sines of a third of a turn in either direction, `sqrt(3)/2`.
pub(super) const THIRD_OF_A_TURN: [f64; 2] = [0.866_025_403_784_438_6, -0.866_025_403_784_438_6];

/// Position of a smooth surface, m.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Face {
    Plane {
        point: Vector,
        normal: Vector,
    },
    /// Thin disc with two sides.
    Disc {
        centre: Vector,
        normal: Vector,
        radius: f64,
    },
    /// Disc with a hole.
    Ring {
        centre: Vector,
        normal: Vector,
        radius: f64,
        hole: f64,
    },
    /// Cylindrical shell; `ends` are distances from the base along the axis. A shell along a periodic axis has no ends.
    Shell {
        base: Vector,
        axis: Vector,
        radius: f64,
        ends: [f64; 2],
    },
    /// Point of the rim of a hole: the point nearest to the grain's centre, rotated about the normal by an angle with
    /// this sine and the cosine -1/2.
    Rim {
        centre: Vector,
        normal: Vector,
        radius: f64,
        sine: f64,
    },
    /// Sphere seen from outside, and its images.
    Ball {
        centre: Vector,
        radius: f64,
        period: Period,
    },
    /// Thin triangle with two sides.
    Triangle(Triangle),
    /// Thin conical shell, or a line of one.
    Frustum(Frustum),
}

/// First point of the path of a grain's centre within some distance of a face.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Impact {
    /// Fraction of the path, 0 to 1.
    pub share: f64,
    /// Distance from the start of the path to the tangent plane of the face at this point, m.
    pub distance: f64,
    /// Unit normal towards the face.
    pub normal: Vector,
}

/// Rotation about a unit axis.
#[derive(Clone, Copy, Debug)]
pub struct Rotation {
    axis: Vector,
    sine: f64,
    cosine: f64,
}

impl Rotation {
    /// Creates a rotation by an angle, rad; sine and cosine are from a portable library, for equal bits on every platform.
    pub fn new(axis: Vector, angle: f64) -> Rotation {
        let (sine, cosine) = libm::sincos(angle);
        Rotation { axis, sine, cosine }
    }

    /// Creates a rotation with the sine and the cosine of its angle.
    pub fn of(axis: Vector, [sine, cosine]: [f64; 2]) -> Rotation {
        Rotation { axis, sine, cosine }
    }

    /// Returns the rotation vector, rad.
    pub fn vector(&self) -> Vector {
        self.axis * libm::atan2(self.sine, self.cosine)
    }

    /// Rotates a vector by Rodrigues' formula.
    #[inline]
    pub fn turn(&self, vector: Vector) -> Vector {
        let Rotation { axis, sine, cosine } = *self;
        vector * cosine + axis.cross(&vector) * sine + axis * (axis.dot(&vector) * (1.0 - cosine))
    }

    /// Returns the inverse rotation.
    pub fn inverse(self) -> Rotation {
        Rotation { sine: -self.sine, ..self }
    }
}

impl Face {
    /// Creates a triangle; its first corner becomes that opposite the longest side.
    pub fn triangle(corners: [[f64; 3]; 3]) -> Face {
        Face::Triangle(Triangle::new(corners.map(Vector::from)))
    }

    /// Returns the rim points of a hole that a grain contacts in addition to the nearest one.
    pub fn rim(centre: Vector, normal: Vector, radius: f64) -> [Face; 2] {
        THIRD_OF_A_TURN.map(|sine| Face::Rim { centre, normal, radius, sine })
    }

    /// Returns the corners of a box around the face, m, without its images; absent for an infinite face.
    pub fn bounds(&self) -> Option<[Vector; 2]> {
        let around = |middle: Vector, half: Vector| Some([middle - half, middle + half]);
        // A circle about a unit axis spans `R sqrt(1 - n_k^2)` along axis k.
        let span = |normal: Vector, radius: f64| normal.map(|along| radius * (1.0 - along * along).max(0.0).sqrt());
        match *self {
            Face::Plane { .. } => None,
            Face::Disc { centre, normal, radius }
            | Face::Ring { centre, normal, radius, .. }
            | Face::Rim { centre, normal, radius, .. } => around(centre, span(normal, radius)),
            Face::Shell { base, axis, radius, ends: [low, high] } if low.is_finite() && high.is_finite() => {
                let half = span(axis, radius) + axis.abs() * (0.5 * (high - low));
                around(base + axis * (0.5 * (low + high)), half)
            }
            Face::Shell { .. } => None,
            Face::Ball { centre, radius, .. } => around(centre, Vector::repeat(radius)),
            Face::Triangle(triangle) => Some(triangle.bounds()),
            Face::Frustum(Frustum { base, axis, radii, length, .. }) => {
                Face::Shell { base, axis, radius: radii[0].max(radii[1]), ends: [0.0, length] }.bounds()
            }
        }
    }

    /// Returns the corners of a triangle, m; none for other faces.
    pub fn corners(&self) -> &[Vector] {
        if let Face::Triangle(triangle) = self { &triangle.corners } else { &[] }
    }

    /// Returns the face after a translation.
    pub fn moved(self, by: Vector) -> Face {
        self.mapped(|point| point + by, |direction| direction)
    }

    /// Returns the face after a rotation about an axis through `centre`.
    pub fn turned(self, centre: Vector, rotation: &Rotation) -> Face {
        self.mapped(|point| centre + rotation.turn(point - centre), |direction| rotation.turn(direction))
    }

    /// Returns the face after a rigid motion of its points and directions.
    #[inline(always)]
    fn mapped(mut self, place: impl Fn(Vector) -> Vector, turn: impl Fn(Vector) -> Vector) -> Face {
        match &mut self {
            Face::Plane { point: middle, normal }
            | Face::Disc { centre: middle, normal, .. }
            | Face::Ring { centre: middle, normal, .. }
            | Face::Rim { centre: middle, normal, .. }
            | Face::Shell { base: middle, axis: normal, .. }
            | Face::Frustum(Frustum { base: middle, axis: normal, .. }) => {
                (*middle, *normal) = (place(*middle), turn(*normal));
            }
            Face::Ball { centre, .. } => *centre = place(*centre),
            Face::Triangle(triangle) => triangle.corners = triangle.corners.map(place),
        }
        self
    }

    /// Returns true if a rotation about this axis through `pivot` maps the face onto itself.
    pub fn turns_in_place(&self, pivot: Vector, axis: Vector) -> bool {
        let along = |direction: Vector| direction.cross(&axis).norm() < 1e-12;
        let on_axis = |place: Vector| (place - pivot).cross(&axis).norm() < 1e-12 * (1.0 + (place - pivot).norm());
        match *self {
            Face::Plane { normal, .. } => along(normal),
            Face::Disc { centre, normal, .. }
            | Face::Ring { centre, normal, .. }
            | Face::Rim { centre, normal, .. }
            | Face::Shell { base: centre, axis: normal, .. }
            | Face::Frustum(Frustum { base: centre, axis: normal, .. }) => along(normal) && on_axis(centre),
            Face::Ball { centre, .. } => on_axis(centre),
            Face::Triangle(_) => false,
        }
    }

    /// Returns true if a moved face is the same surface again, in a scene of this extent, m.
    pub fn is_same(&self, other: &Face, extent: f64) -> bool {
        let near = |gap: Vector| gap.norm() < SAME * extent;
        let aligned = |one: Vector, other: Vector| (one - other).norm() < SAME;
        match (*self, *other) {
            (Face::Plane { point, normal }, Face::Plane { point: place, normal: turned }) => {
                aligned(normal, turned) && near(normal * normal.dot(&(place - point)))
            }
            (Face::Disc { centre, normal, .. }, Face::Disc { centre: place, normal: turned, .. })
            | (Face::Ring { centre, normal, .. }, Face::Ring { centre: place, normal: turned, .. })
            | (Face::Rim { centre, normal, .. }, Face::Rim { centre: place, normal: turned, .. }) => {
                (aligned(normal, turned) || aligned(normal, -turned)) && near(place - centre)
            }
            (Face::Shell { base, axis, ends, .. }, Face::Shell { base: place, axis: turned, .. }) => {
                let gap = place - base;
                let endless = ends.iter().all(|end| end.is_infinite());
                aligned(axis, turned) && near(if endless { gap - axis * axis.dot(&gap) } else { gap })
            }
            (Face::Ball { centre, period, .. }, Face::Ball { centre: place, .. }) => near(period.arm(&centre, &place)),
            (Face::Triangle(one), Face::Triangle(other)) => {
                one.corners.iter().zip(&other.corners).all(|(one, other)| near(other - one))
            }
            (Face::Frustum(one), Face::Frustum(other)) => aligned(one.axis, other.axis) && near(other.base - one.base),
            _ => false,
        }
    }

    /// Returns the distance from a point to the face, negative behind a plane. Most faces are planes, which need no further computation.
    #[inline(always)]
    pub fn distance(&self, point: &Vector) -> f64 {
        match self {
            Face::Plane { point: foot, normal } => height(normal, point, foot),
            _ => self.nearest(point, Vector::zeros).0,
        }
    }

    /// Returns true if a point is nearer to the face than `radius`, m.
    #[inline]
    pub fn is_nearer(&self, point: &Vector, radius: f64) -> bool {
        match self {
            Face::Triangle(triangle) => triangle.nearest_within(point, radius).is_some(),
            _ => self.distance(point) < radius,
        }
    }

    /// Returns the distance from a point to the face, and the unit normal towards the face: see [`PlacedFace::nearest`](crate::wall::PlacedFace::nearest).
    #[inline]
    pub fn nearest(&self, centre: &Vector, travel: impl FnOnce() -> Vector) -> (f64, Vector) {
        match *self {
            Face::Plane { point, normal } => (height(&normal, centre, &point), -normal),
            Face::Disc { centre: middle, normal, radius } => {
                let arm = centre - middle;
                let height = normal.dot(&arm);
                let across = arm - normal * height;
                let side = if height >= 0.0 { -normal } else { normal };
                let square = across.norm_squared();
                if square <= radius * radius {
                    return (height.abs(), side);
                }
                let distance = square.sqrt();
                let to_rim = across * (radius / distance - 1.0) - normal * height;
                let gap = to_rim.norm();
                (gap, if gap > 0.0 { to_rim / gap } else { side })
            }
            Face::Ring { centre: middle, normal, radius, hole } => {
                let arm = centre - middle;
                let height = normal.dot(&arm);
                let across = arm - normal * height;
                let distance = across.norm();
                let outward = if distance > 0.0 { across / distance } else { perpendicular(normal, travel()) };
                let to_ring = outward * (distance.clamp(hole, radius) - distance) - normal * height;
                let gap = to_ring.norm();
                let side = if height >= 0.0 { -normal } else { normal };
                (gap, if gap > 0.0 { to_ring / gap } else { side })
            }
            Face::Rim { centre: middle, normal, radius, sine } => {
                let arm = centre - middle;
                let across = arm - normal * normal.dot(&arm);
                let outward = across.try_normalize(0.0).unwrap_or_else(|| perpendicular(normal, travel()));
                let to_rim = outward * (-0.5 * radius) + normal.cross(&outward) * (sine * radius) - arm;
                let gap = to_rim.norm();
                (gap, if gap > 0.0 { to_rim / gap } else { -outward })
            }
            Face::Shell { base, axis, radius, ends } => {
                let arm = centre - base;
                let along = axis.dot(&arm);
                let across = arm - axis * along;
                let distance = across.norm();
                let outward = if distance > 0.0 { across / distance } else { perpendicular(axis, travel()) };
                let to_shell = outward * (radius - distance) + axis * (along.clamp(ends[0], ends[1]) - along);
                let gap = to_shell.norm();
                let side = if distance <= radius { outward } else { -outward };
                (gap, if gap > 0.0 { to_shell / gap } else { side })
            }
            Face::Ball { centre: middle, radius, period } => {
                let arm = period.arm(centre, &middle);
                let distance = arm.norm();
                // At the centre, any direction is outward.
                let inward = if distance > 0.0 {
                    arm / distance
                } else {
                    -travel().try_normalize(0.0).unwrap_or_else(Vector::z)
                };
                (distance - radius, inward)
            }
            Face::Triangle(triangle) => {
                let near = triangle.nearest(centre);
                (near.distance, near.normal)
            }
            Face::Frustum(frustum) => frustum.nearest(centre, travel),
        }
    }

    /// Returns the first point of a path from `centre` along `shift` (m), relative to the face, within `level` (m) of the face,
    /// if the path starts farther away; at level 0, the crossing point. Rims are omitted: a path past a face does not cross it.
    pub fn time_of_impact(&self, centre: &Vector, shift: &Vector, level: f64) -> Option<Impact> {
        match *self {
            Face::Plane { point, normal } => flat(normal, centre - point, shift, level, [0.0, f64::INFINITY]),
            Face::Disc { centre: middle, normal, radius } => {
                flat(facing(normal, centre - middle), centre - middle, shift, level, [0.0, radius])
            }
            Face::Ring { centre: middle, normal, radius, hole } => {
                flat(facing(normal, centre - middle), centre - middle, shift, level, [hole, radius])
            }
            Face::Rim { .. } => None,
            Face::Shell { base, axis, radius, ends } => {
                let arm = centre - base;
                let (across, moved) = (arm - axis * axis.dot(&arm), shift - axis * axis.dot(shift));
                // From inside, the far intersection with the circle at this level; from outside, the near one.
                let inside = across.norm() < radius;
                let (side, touch) = if inside { (1.0, radius - level) } else { (-1.0, radius + level) };
                let (square, half) = (moved.norm_squared(), across.dot(&moved));
                let beyond = across.norm_squared() - touch * touch;
                let root = half * half - square * beyond;
                if square <= 0.0 || root < 0.0 || (side * beyond > 0.0 && side * half >= 0.0) || touch <= 0.0 {
                    return None;
                }
                let share = (side * root.sqrt() - half) / square;
                let along = axis.dot(&(arm + shift * share));
                let joint = JOINT * (radius + ends[1]);
                if !(0.0..=1.0).contains(&share) || along < ends[0] - joint || along > ends[1] + joint {
                    return None;
                }
                let normal = (across + moved * share) * (side / touch);
                Some(Impact { share, distance: side * radius - normal.dot(&across), normal })
            }
            Face::Ball { centre: middle, radius, period } => {
                let (arm, touch) = (period.arm(&middle, centre), radius + level);
                let share = round(&arm, shift, touch)?;
                let normal = -(arm + shift * share) / touch;
                Some(Impact { share, distance: -normal.dot(&arm) - radius, normal })
            }
            Face::Triangle(triangle) => triangle.time_of_impact(centre, shift, level),
            Face::Frustum(frustum) => frustum.time_of_impact(centre, shift, level),
        }
    }
}

/// Returns the height of a point above a plane, m, from a point of the plane.
#[inline(always)]
fn height(normal: &Vector, point: &Vector, foot: &Vector) -> f64 {
    normal.dot(&(point - foot))
}

/// Returns the normal of a two-sided face on the side of a point.
fn facing(normal: Vector, arm: Vector) -> Vector {
    if normal.dot(&arm) < 0.0 { -normal } else { normal }
}

/// Computes [`Face::time_of_impact`] for the area between two circles of a plane, with the `arm` from its centre to the start.
fn flat(normal: Vector, arm: Vector, shift: &Vector, level: f64, [hole, radius]: [f64; 2]) -> Option<Impact> {
    let (height, fall) = (normal.dot(&arm), -normal.dot(shift));
    let share = (height - level) / fall;
    // The point is in front of the face, and at this level before the path ends.
    let nears = height > level && (0.0..=1.0).contains(&share);
    let across = (arm + shift * share - normal * level).norm();
    let beside = across > radius * (1.0 + JOINT) || across < hole * (1.0 - JOINT);
    (nears && !beside).then_some(Impact { share, distance: height, normal: -normal })
}

/// Returns a unit vector normal to a unit vector: the normal part of `travel`, or any direction if that part is zero.
#[cold]
pub(super) fn perpendicular(axis: Vector, travel: Vector) -> Vector {
    let across = travel - axis * axis.dot(&travel);
    across.try_normalize(0.0).unwrap_or_else(|| {
        let other = if axis.x.abs() < 0.9 { Vector::x() } else { Vector::y() };
        axis.cross(&other).normalize()
    })
}
