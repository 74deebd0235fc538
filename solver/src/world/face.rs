//! The geometry of one face of a wall: the nearest point to a grain, and where a path first comes near it.

use crate::effects::period::Period;
use nalgebra::Vector3;

type Vector = Vector3<f64>;

/// How far a face reaches beyond its edges for a path that crosses it, over its size: where two faces meet, rounding must leave no gap.
const JOINT: f64 = 1e-9;

/// Where a smooth surface lies, m.
#[derive(Clone, Copy, Debug)]
pub(super) enum Face {
    Plane {
        point: Vector,
        normal: Vector,
    },
    /// Thin, with two sides.
    Disc {
        centre: Vector,
        normal: Vector,
        radius: f64,
    },
    /// A disc with a hole.
    Ring {
        centre: Vector,
        normal: Vector,
        radius: f64,
        hole: f64,
    },
    /// Its ends lie so far from the base along the axis; there are none where the axis is periodic.
    Shell {
        base: Vector,
        axis: Vector,
        radius: f64,
        ends: [f64; 2],
    },
    /// A sphere seen from outside, and its images.
    Ball {
        centre: Vector,
        radius: f64,
        period: Period,
    },
}

/// Where the path of a grain's centre first comes within some distance of a face.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Reached {
    /// Share of the path, 0 to 1.
    pub share: f64,
    /// Distance from the start of the path to the plane that touches the face there, m.
    pub distance: f64,
    /// Unit normal towards the face.
    pub normal: Vector,
}

/// Rodrigues' rotation of a vector about a unit axis; sine and cosine from a portable library, for equal bits everywhere.
pub(super) fn rotated(vector: Vector, axis: Vector, angle: f64) -> Vector {
    let (sine, cosine) = libm::sincos(angle);
    vector * cosine + axis.cross(&vector) * sine + axis * (axis.dot(&vector) * (1.0 - cosine))
}

impl Face {
    /// The face, moved.
    pub(super) fn moved(self, by: Vector) -> Face {
        match self {
            Face::Plane { point, normal } => Face::Plane { point: point + by, normal },
            Face::Disc { centre, normal, radius } => Face::Disc { centre: centre + by, normal, radius },
            Face::Ring { centre, normal, radius, hole } => Face::Ring { centre: centre + by, normal, radius, hole },
            Face::Shell { base, axis, radius, ends } => Face::Shell { base: base + by, axis, radius, ends },
            Face::Ball { centre, radius, period } => Face::Ball { centre: centre + by, radius, period },
        }
    }

    /// The face, turned about an axis through `centre` by an angle, rad.
    pub(super) fn turned(self, centre: Vector, about: Vector, angle: f64) -> Face {
        let place = |point: Vector| centre + rotated(point - centre, about, angle);
        let turn = |direction: Vector| rotated(direction, about, angle);
        match self {
            Face::Plane { point, normal } => Face::Plane { point: place(point), normal: turn(normal) },
            Face::Disc { centre: middle, normal, radius } => {
                Face::Disc { centre: place(middle), normal: turn(normal), radius }
            }
            Face::Ring { centre: middle, normal, radius, hole } => {
                Face::Ring { centre: place(middle), normal: turn(normal), radius, hole }
            }
            Face::Shell { base, axis, radius, ends } => {
                Face::Shell { base: place(base), axis: turn(axis), radius, ends }
            }
            Face::Ball { centre: middle, radius, period } => Face::Ball { centre: place(middle), radius, period },
        }
    }

    /// Whether turning about this axis through `pivot` maps the face onto itself.
    pub(super) fn turns_in_place(&self, pivot: Vector, axis: Vector) -> bool {
        let along = |direction: Vector| direction.cross(&axis).norm() < 1e-12;
        let on_axis = |place: Vector| (place - pivot).cross(&axis).norm() < 1e-12 * (1.0 + (place - pivot).norm());
        match *self {
            Face::Plane { normal, .. } => along(normal),
            Face::Disc { centre, normal, .. } | Face::Ring { centre, normal, .. } => along(normal) && on_axis(centre),
            Face::Shell { base, axis: own, .. } => along(own) && on_axis(base),
            Face::Ball { centre, .. } => on_axis(centre),
        }
    }

    /// Distance from a point to the face, and the unit normal towards it: see [`Pose::nearest`](super::Pose::nearest).
    #[inline]
    pub(super) fn nearest(&self, centre: &Vector, heading: impl FnOnce() -> Vector) -> (f64, Vector) {
        match *self {
            Face::Plane { point, normal } => (normal.dot(&(centre - point)), -normal),
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
                let outward = if distance > 0.0 { across / distance } else { perpendicular(normal, heading()) };
                let to_ring = outward * (distance.clamp(hole, radius) - distance) - normal * height;
                let gap = to_ring.norm();
                let side = if height >= 0.0 { -normal } else { normal };
                (gap, if gap > 0.0 { to_ring / gap } else { side })
            }
            Face::Shell { base, axis, radius, ends } => {
                let arm = centre - base;
                let along = axis.dot(&arm);
                let across = arm - axis * along;
                let distance = across.norm();
                let outward = if distance > 0.0 { across / distance } else { perpendicular(axis, heading()) };
                let to_shell = outward * (radius - distance) + axis * (along.clamp(ends[0], ends[1]) - along);
                let gap = to_shell.norm();
                let side = if distance <= radius { outward } else { -outward };
                (gap, if gap > 0.0 { to_shell / gap } else { side })
            }
            Face::Ball { centre: middle, radius, period } => {
                let arm = period.arm(centre, &middle);
                let distance = arm.norm();
                // Any direction leads out of the middle.
                let inward = if distance > 0.0 {
                    arm / distance
                } else {
                    -heading().try_normalize(0.0).unwrap_or_else(Vector::z)
                };
                (distance - radius, inward)
            }
        }
    }

    /// False if no point within `reach` (m) of `centre` can lie on the face or behind it.
    pub(super) fn may_be_within(&self, centre: &Vector, reach: f64) -> bool {
        self.nearest(centre, Vector::zeros).0 < reach
    }

    /// Where a path from `centre` along `shift` (m), seen from the face, first comes within `level` (m) of it, having begun farther away;
    /// at level 0 where it crosses the face. Absent where it does not. Rims are left out: what passes beside a face does not cross it.
    pub(super) fn reached(&self, centre: &Vector, shift: &Vector, level: f64) -> Option<Reached> {
        match *self {
            Face::Plane { point, normal } => flat(normal, centre - point, shift, level, [0.0, f64::INFINITY]),
            Face::Disc { centre: middle, normal, radius } => {
                flat(facing(normal, centre - middle), centre - middle, shift, level, [0.0, radius])
            }
            Face::Ring { centre: middle, normal, radius, hole } => {
                flat(facing(normal, centre - middle), centre - middle, shift, level, [hole, radius])
            }
            Face::Shell { base, axis, radius, ends } => {
                let arm = centre - base;
                let (across, moved) = (arm - axis * axis.dot(&arm), shift - axis * axis.dot(shift));
                // From inside the far crossing with the circle at this level, from outside the near one.
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
                Some(Reached { share, distance: side * radius - normal.dot(&across), normal })
            }
            Face::Ball { centre: middle, radius, period } => {
                let (arm, touch) = (period.arm(&middle, centre), radius + level);
                let (square, half, beyond) = (shift.norm_squared(), arm.dot(shift), arm.norm_squared() - touch * touch);
                let root = half * half - square * beyond;
                // Apart now and nearing, at this level before the path ends.
                if root < 0.0 || beyond <= 0.0 || half >= 0.0 {
                    return None;
                }
                let share = -(root.sqrt() + half) / square;
                let normal = -(arm + shift * share) / touch;
                (share <= 1.0).then(|| Reached { share, distance: -normal.dot(&arm) - radius, normal })
            }
        }
    }
}

/// The normal of a face with two sides on the side of a point.
fn facing(normal: Vector, arm: Vector) -> Vector {
    if normal.dot(&arm) < 0.0 { -normal } else { normal }
}

/// [`Face::reached`] for a part of a plane between two circles, given the `arm` from its middle to the start.
fn flat(normal: Vector, arm: Vector, shift: &Vector, level: f64, [hole, radius]: [f64; 2]) -> Option<Reached> {
    let (height, fall) = (normal.dot(&arm), -normal.dot(shift));
    let share = (height - level) / fall;
    // In front of the face now, at this level before the path ends.
    let meets = height > level && (0.0..=1.0).contains(&share);
    let across = (arm + shift * share - normal * level).norm();
    let beside = across > radius * (1.0 + JOINT) || across < hole * (1.0 - JOINT);
    (meets && !beside).then_some(Reached { share, distance: height, normal: -normal })
}

/// A unit vector across a unit vector: the way that `heading` leads across it, or any if it leads nowhere.
#[cold]
fn perpendicular(axis: Vector, heading: Vector) -> Vector {
    let across = heading - axis * axis.dot(&heading);
    across.try_normalize(0.0).unwrap_or_else(|| {
        let other = if axis.x.abs() < 0.9 { Vector::x() } else { Vector::y() };
        axis.cross(&other).normalize()
    })
}
