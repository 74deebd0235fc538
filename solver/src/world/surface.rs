//! Faces of walls: where they are at a time, how fast they move, and the nearest point to a grain.

use super::Sphere;
use crate::effects::period::Period;
use crate::scene::{Domain, Motion, Shape, Wall};
use nalgebra::Vector3;

type Vector = Vector3<f64>;

/// One smooth face of a wall; a box has up to six.
#[derive(Clone, Debug)]
pub struct Surface {
    /// Number of the wall in the scene.
    pub wall: u32,
    /// Number of its material.
    pub material: u8,
    shape: Face,
    motion: Motion,
    /// Whether its motion maps the face onto itself, so that only velocities change.
    in_place: bool,
    /// How far a drive has moved it, m or rad, now and when the candidate list was built; zero where nothing drives it.
    displacement: f64,
    displacement_in_list: f64,
    /// How fast a drive moves it, m/s or rad/s.
    rate: f64,
}

#[derive(Clone, Copy, Debug)]
enum Face {
    Plane {
        point: Vector,
        normal: Vector,
    },
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

/// A face at a moment: its geometry and its velocity field.
#[derive(Clone, Copy, Debug)]
pub struct Pose {
    shape: Face,
    velocity: Vector,
    /// What it has gained since the step before, by speeding up.
    gain: Vector,
    spin: Vector,
    centre: Vector,
}

impl Surface {
    /// The faces of a wall in a domain; along a periodic axis they repeat themselves or have no end.
    pub fn of_wall(wall: &Wall, domain: &Domain, index: u32, material: u8) -> Vec<Surface> {
        let period = domain.period();
        let faces = match &wall.shape {
            Shape::Plane { point, normal } => {
                vec![Face::Plane { point: Vector::from(*point), normal: Vector::from(*normal).normalize() }]
            }
            Shape::Disc { centre, normal, radius, hole } => {
                let (centre, normal) = (Vector::from(*centre), Vector::from(*normal).normalize());
                vec![match *hole > 0.0 {
                    true => Face::Ring { centre, normal, radius: *radius, hole: *hole },
                    false => Face::Disc { centre, normal, radius: *radius },
                }]
            }
            Shape::Cylinder { base, axis, radius, length } => vec![Face::Shell {
                base: Vector::from(*base),
                axis: Vector::from(*axis).normalize(),
                radius: *radius,
                ends: match (0..3).any(|along| period.is_periodic(along) && axis[along] != 0.0) {
                    true => [f64::NEG_INFINITY, f64::INFINITY],
                    false => [0.0, *length],
                },
            }],
            Shape::Spheres { centres, radius } => (centres.iter())
                .map(|centre| Face::Ball { centre: Vector::from(*centre), radius: *radius, period })
                .collect(),
            Shape::Box { min, max, open } => {
                let (min, max) = (Vector::from(*min), Vector::from(*max));
                ["-x", "+x", "-y", "+y", "-z", "+z"]
                    .iter()
                    .enumerate()
                    .filter(|(_, name)| !open.iter().any(|face| face == *name))
                    .map(|(number, _)| {
                        let inward = Vector::ith(number / 2, if number % 2 == 0 { 1.0 } else { -1.0 });
                        Face::Plane { point: if number % 2 == 0 { min } else { max }, normal: inward }
                    })
                    .collect()
            }
        };
        let surface = |shape: Face| Surface {
            wall: index,
            material,
            in_place: keeps_in_place(&shape, &wall.motion),
            shape,
            motion: wall.motion.clone(),
            displacement: 0.0,
            displacement_in_list: 0.0,
            rate: 0.0,
        };
        faces.into_iter().map(surface).collect()
    }

    /// Where a drive has moved it, m or rad, and how fast it moves it, m/s or rad/s. Faces that nothing drives take no notice.
    pub fn put(&mut self, displacement: f64, rate: f64) {
        (self.displacement, self.rate) = (displacement, rate);
    }

    /// Keeps in mind where a drive has it while the candidate list is built.
    pub(crate) fn enter_list(&mut self) {
        self.displacement_in_list = self.displacement;
    }

    /// Where a drive had it then, m or rad.
    pub(crate) fn displacement_in_list(&self) -> f64 {
        self.displacement_in_list
    }

    /// The face at a time, with its velocity there; a driven one as it was last put.
    pub fn at(&self, time: f64) -> Pose {
        let zero = Vector::zeros();
        let mut pose = Pose { shape: self.shape, velocity: zero, gain: zero, spin: zero, centre: zero };
        match &self.motion {
            Motion::Fixed => {}
            Motion::Translating { velocity, start, stop } => {
                let velocity = Vector::from(*velocity);
                pose.shape = self.shape.moved(velocity * active_time(time, *start, *stop));
                if is_active(time, *start, *stop) {
                    pose.velocity = velocity;
                }
            }
            Motion::Rotating { point, axis, rate, start, stop, reverse } => {
                let (centre, axis) = (Vector::from(*point), Vector::from(*axis).normalize());
                if !self.in_place {
                    let back = reverse.map_or(0.0, |reverse| active_time(time, reverse, *stop));
                    let turned = active_time(time, *start, *stop) - 2.0 * back;
                    pose.shape = self.shape.turned(centre, axis, rate * turned);
                }
                if is_active(time, *start, *stop) {
                    let backwards = reverse.is_some_and(|reverse| time >= reverse);
                    pose.spin = axis * if backwards { -*rate } else { *rate };
                    pose.centre = centre;
                }
            }
            Motion::Vibrating { .. } => {
                if let Some(vibration) = self.motion.vibration() {
                    pose.shape = self.shape.moved(vibration.displacement(time).into());
                    pose.velocity = vibration.velocity(time).into();
                }
            }
            Motion::ForceDriven { axis, .. } => {
                let axis = Vector::from(*axis).normalize();
                pose.shape = self.shape.moved(axis * self.displacement);
                pose.velocity = axis * self.rate;
            }
            Motion::TorqueDriven { point, axis, .. } => {
                let (centre, axis) = (Vector::from(*point), Vector::from(*axis).normalize());
                if !self.in_place {
                    pose.shape = self.shape.turned(centre, axis, self.displacement);
                }
                (pose.spin, pose.centre) = (axis * self.rate, centre);
            }
        }
        pose
    }

    /// The face at the start of a step of length `step` (s), with the velocity that counts in it: where it vibrates, the mean
    /// one.
    pub(crate) fn over(&self, time: f64, step: f64) -> Pose {
        let mut pose = self.at(time);
        if let Some(vibration) = self.motion.vibration() {
            pose.velocity = vibration.mean_velocity(time, time + step).into();
            if vibration.is_smooth(time - step, time + step) {
                pose.gain = pose.velocity - Vector::from(vibration.mean_velocity(time - step, time));
            }
        }
        pose
    }

    /// Whether it ever moves.
    pub fn moves(&self) -> bool {
        !matches!(self.motion, Motion::Fixed)
    }

    /// Upper bound of how far a point of the face within `reach` of the motion's centre moves between two times, m; of a driven one
    /// since it entered the list.
    pub fn largest_shift(&self, from: f64, to: f64, reach: f64) -> f64 {
        match &self.motion {
            _ if self.in_place => 0.0,
            Motion::Fixed => 0.0,
            Motion::Translating { velocity, start, stop } => {
                Vector::from(*velocity).norm() * (active_time(to, *start, *stop) - active_time(from, *start, *stop))
            }
            Motion::Vibrating { .. } => self.motion.vibration().map_or(0.0, |vibration| {
                (Vector::from(vibration.displacement(to)) - Vector::from(vibration.displacement(from))).norm()
            }),
            Motion::Rotating { rate, start, stop, .. } => {
                rate.abs() * reach * (active_time(to, *start, *stop) - active_time(from, *start, *stop))
            }
            Motion::ForceDriven { .. } => (self.displacement - self.displacement_in_list).abs(),
            Motion::TorqueDriven { .. } => (self.displacement - self.displacement_in_list).abs() * reach,
        }
    }
}

/// Time spent in motion up to `time`.
fn active_time(time: f64, start: f64, stop: Option<f64>) -> f64 {
    (stop.map_or(time, |stop| time.min(stop)) - start).max(0.0)
}

fn is_active(time: f64, start: f64, stop: Option<f64>) -> bool {
    time >= start && stop.is_none_or(|stop| time < stop)
}

fn keeps_in_place(shape: &Face, motion: &Motion) -> bool {
    let (Motion::Rotating { point, axis, .. } | Motion::TorqueDriven { point, axis, .. }) = motion else {
        return matches!(motion, Motion::Fixed);
    };
    let (centre, axis) = (Vector::from(*point), Vector::from(*axis).normalize());
    let along = |direction: Vector| direction.cross(&axis).norm() < 1e-12;
    let on_axis = |place: Vector| (place - centre).cross(&axis).norm() < 1e-12 * (1.0 + (place - centre).norm());
    match *shape {
        Face::Plane { normal, .. } => along(normal),
        Face::Disc { centre, normal, .. } | Face::Ring { centre, normal, .. } => along(normal) && on_axis(centre),
        Face::Shell { base, axis: own, .. } => along(own) && on_axis(base),
        Face::Ball { centre, .. } => on_axis(centre),
    }
}

/// Rodrigues' rotation of a vector about a unit axis; sine and cosine from a portable library, for equal bits everywhere.
fn rotated(vector: Vector, axis: Vector, angle: f64) -> Vector {
    let (sine, cosine) = libm::sincos(angle);
    vector * cosine + axis.cross(&vector) * sine + axis * (axis.dot(&vector) * (1.0 - cosine))
}

impl Face {
    fn moved(self, by: Vector) -> Face {
        match self {
            Face::Plane { point, normal } => Face::Plane { point: point + by, normal },
            Face::Disc { centre, normal, radius } => Face::Disc { centre: centre + by, normal, radius },
            Face::Ring { centre, normal, radius, hole } => Face::Ring { centre: centre + by, normal, radius, hole },
            Face::Shell { base, axis, radius, ends } => Face::Shell { base: base + by, axis, radius, ends },
            Face::Ball { centre, radius, period } => Face::Ball { centre: centre + by, radius, period },
        }
    }

    fn turned(self, centre: Vector, about: Vector, angle: f64) -> Face {
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
}

impl Pose {
    /// Distance from a grain's centre to the face, negative behind a plane or disc: see [`Pose::nearest`].
    #[inline]
    pub fn distance(&self, centre: &Vector) -> f64 {
        self.nearest(centre, Vector::zeros).0
    }

    /// Distance from a grain's centre to the face, and the unit normal from the centre to the nearest point. Where a whole circle or
    /// sphere of points is nearest, as to the axis of a tube, it is the one that the grain is `heading` for, a vector of any length.
    ///
    /// Behind a plane or disc the distance is negative, so that the grain is pushed back. A shell is thin and has two
    /// sides; beyond its ends the nearest point lies on its rim. A disc has no rim: beside it the distance is infinite. A disc
    /// with a hole is thin and has two sides and two rims, so that grains fall through the hole and roll over its edge.
    #[inline]
    pub fn nearest(&self, centre: &Vector, heading: impl FnOnce() -> Vector) -> (f64, Vector) {
        match self.shape {
            Face::Plane { point, normal } => (normal.dot(&(centre - point)), -normal),
            Face::Disc { centre: middle, normal, radius } => {
                let arm = centre - middle;
                let height = normal.dot(&arm);
                let beside = (arm - normal * height).norm_squared() > radius * radius;
                (if beside { f64::INFINITY } else { height }, -normal)
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
    pub(crate) fn may_be_within(&self, centre: &Vector, reach: f64) -> bool {
        match self.shape {
            Face::Plane { point, normal } | Face::Disc { centre: point, normal, .. } => {
                normal.dot(&(centre - point)) < reach
            }
            Face::Shell { .. } | Face::Ball { .. } | Face::Ring { .. } => self.distance(centre) < reach,
        }
    }

    /// What a grain meets that moves by more than its radius against the wall within a step: the distance from its centre to
    /// the plane that touches the face where they meet, and the unit normal towards it; nothing if it meets nothing.
    ///
    /// Such a grain would otherwise be deep behind the face, or on the other side of a shell, before the two are seen to touch.
    pub(crate) fn met_on_the_way(&self, sphere: &Sphere, velocity: &Vector, step: f64) -> Option<(f64, Vector)> {
        let (shift, reach) = ((velocity - self.velocity) * step, sphere.radius);
        if shift.norm_squared() <= reach * reach {
            return None;
        }
        match self.shape {
            Face::Plane { point, normal } | Face::Disc { centre: point, normal, .. } => {
                let arm = sphere.centre - point;
                let (height, fall) = (normal.dot(&arm), -normal.dot(&shift));
                let share = (height - reach) / fall;
                // In front of the face now, at it before the step ends.
                let meets = height > reach && (0.0..=1.0).contains(&share);
                let across = arm + shift * share - normal * reach;
                let beside = matches!(self.shape, Face::Disc { radius, .. } if across.norm() > radius);
                (meets && !beside).then_some((height, -normal))
            }
            Face::Ring { centre: middle, normal, radius, hole } => {
                let arm = sphere.centre - middle;
                // The normal on the side that the grain comes from.
                let normal = if normal.dot(&arm) < 0.0 { -normal } else { normal };
                let (height, fall) = (normal.dot(&arm), -normal.dot(&shift));
                let share = (height - reach) / fall;
                let meets = height > reach && (0.0..=1.0).contains(&share);
                let across = arm + shift * share - normal * reach;
                (meets && (hole..=radius).contains(&across.norm())).then_some((height, -normal))
            }
            Face::Shell { base, axis, radius, ends } => {
                let arm = sphere.centre - base;
                let (across, moved) = (arm - axis * axis.dot(&arm), shift - axis * axis.dot(&shift));
                // From inside the far crossing with the circle of touch, from outside the near one.
                let inside = across.norm() < radius;
                let (side, touch) = if inside { (1.0, radius - reach) } else { (-1.0, radius + reach) };
                let (square, half) = (moved.norm_squared(), across.dot(&moved));
                let beyond = across.norm_squared() - touch * touch;
                let root = half * half - square * beyond;
                if root < 0.0 || (side * beyond > 0.0 && side * half >= 0.0) || touch <= 0.0 {
                    return None;
                }
                let share = (side * root.sqrt() - half) / square;
                let along = axis.dot(&(arm + shift * share));
                if !(0.0..=1.0).contains(&share) || !(ends[0]..=ends[1]).contains(&along) {
                    return None;
                }
                let normal = (across + moved * share) * (side / touch);
                Some((side * radius - normal.dot(&across), normal))
            }
            Face::Ball { centre, radius, period } => {
                let (arm, touch) = (period.arm(&centre, &sphere.centre), radius + reach);
                let (square, half, beyond) =
                    (shift.norm_squared(), arm.dot(&shift), arm.norm_squared() - touch * touch);
                let root = half * half - square * beyond;
                // Apart now and nearing, at touch before the step ends.
                if root < 0.0 || beyond <= 0.0 || half >= 0.0 {
                    return None;
                }
                let share = -(root.sqrt() + half) / square;
                let normal = -(arm + shift * share) / touch;
                (share <= 1.0).then(|| (-normal.dot(&arm) - radius, normal))
            }
        }
    }

    /// Speed of the wall's translation, m/s.
    pub(crate) fn speed(&self) -> f64 {
        self.velocity.norm()
    }

    /// Velocity of the wall at a point, m/s; in a step that of the step.
    #[inline]
    pub fn velocity_at(&self, point: &Vector) -> Vector {
        self.velocity + self.spin.cross(&(point - self.centre))
    }

    /// What the wall's velocity has gained since the step before without a jump, m/s: no approach of what rests on it.
    pub(crate) fn gain(&self) -> Vector {
        self.gain
    }

    /// Angular velocity, rad/s.
    pub fn spin(&self) -> Vector {
        self.spin
    }
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
