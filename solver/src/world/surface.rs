//! Faces of walls: where they are at a time, how fast they move, and what a grain meets on its way.

use super::Sphere;
use super::face::{Face, Reached, rotated};
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

/// A face at a moment: its geometry and its velocity field.
#[derive(Clone, Copy, Debug)]
pub struct Pose {
    shape: Face,
    velocity: Vector,
    /// What it has gained since the step before, by speeding up.
    gain: Vector,
    spin: Vector,
    centre: Vector,
    /// Whether its spin moves the face, rather than mapping it onto itself.
    turns: bool,
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
        let mut pose =
            Pose { shape: self.shape, velocity: zero, gain: zero, spin: zero, centre: zero, turns: !self.in_place };
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
                    let turned = turning_time(time, *start, *stop, *reverse);
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

    /// The face at the start of a step of length `step` (s), with the velocity that takes it to where it is at the end; a driven one
    /// moves at `rate` (m/s or rad/s).
    pub(crate) fn through(&self, time: f64, step: f64, rate: f64) -> Pose {
        let mut pose = self.at(time);
        match &self.motion {
            Motion::Translating { velocity, start, stop } => {
                let moves = active_time(time + step, *start, *stop) - active_time(time, *start, *stop);
                pose.velocity = Vector::from(*velocity) * (moves / step);
            }
            Motion::Rotating { point, axis, rate, start, stop, reverse } if !self.in_place => {
                let turned = |time| turning_time(time, *start, *stop, *reverse);
                pose.spin = Vector::from(*axis).normalize() * (rate * (turned(time + step) - turned(time)) / step);
                pose.centre = Vector::from(*point);
            }
            Motion::Vibrating { .. } => pose.velocity = self.over(time, step).velocity,
            Motion::ForceDriven { axis, .. } => pose.velocity = Vector::from(*axis).normalize() * rate,
            Motion::TorqueDriven { axis, .. } => pose.spin = Vector::from(*axis).normalize() * rate,
            Motion::Fixed | Motion::Rotating { .. } => {}
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

/// Time spent in turning up to `time`, less that of turning the other way.
fn turning_time(time: f64, start: f64, stop: Option<f64>, reverse: Option<f64>) -> f64 {
    let back = reverse.map_or(0.0, |reverse| active_time(time, reverse, stop));
    active_time(time, start, stop) - 2.0 * back
}

fn is_active(time: f64, start: f64, stop: Option<f64>) -> bool {
    time >= start && stop.is_none_or(|stop| time < stop)
}

fn keeps_in_place(shape: &Face, motion: &Motion) -> bool {
    match motion {
        Motion::Rotating { point, axis, .. } | Motion::TorqueDriven { point, axis, .. } => {
            shape.turns_in_place(Vector::from(*point), Vector::from(*axis).normalize())
        }
        _ => matches!(motion, Motion::Fixed),
    }
}

impl Pose {
    /// Distance from a grain's centre to the face, negative behind a plane: see [`Pose::nearest`].
    #[inline]
    pub fn distance(&self, centre: &Vector) -> f64 {
        self.nearest(centre, Vector::zeros).0
    }

    /// Distance from a grain's centre to the face (m), and the unit normal from the centre to the nearest point. Where a whole circle or
    /// sphere of points is nearest, as to the axis of a tube, it is the one that the grain is `heading` for, a vector of any length.
    ///
    /// Behind a plane the distance is negative, so that the grain is pushed back. Discs, with a hole or without, and shells are thin: they
    /// have two sides, and rims that grains roll over.
    #[inline]
    pub fn nearest(&self, centre: &Vector, heading: impl FnOnce() -> Vector) -> (f64, Vector) {
        self.shape.nearest(centre, heading)
    }

    /// False if no point within `reach` (m) of `centre` can lie on the face or behind it.
    pub(crate) fn may_be_within(&self, centre: &Vector, reach: f64) -> bool {
        self.shape.may_be_within(centre, reach)
    }

    /// What a grain meets that moves by more than its radius against the wall within a step: the distance from its centre to
    /// the plane that touches the face where they meet, and the unit normal towards it; nothing if it meets nothing.
    ///
    /// Such a grain would otherwise be deep behind the face, or on the other side of a shell, before the two are seen to touch.
    pub(crate) fn met_on_the_way(&self, sphere: &Sphere, velocity: &Vector, step: f64) -> Option<(f64, Vector)> {
        let (shift, reach) = (self.way(&sphere.centre, velocity, step), sphere.radius);
        if shift.norm_squared() <= reach * reach {
            return None;
        }
        self.shape.reached(&sphere.centre, &shift, reach).map(|met| (met.distance, met.normal))
    }

    /// The contact of a grain with the face in a step: the distance from its centre to the face, or to the plane that touches the face
    /// where a grain too fast for the step meets it (m); the unit normal towards it; and whether it is met on the way. `velocity` is
    /// the grain's at the start of the step, m/s; for `heading` see [`Pose::nearest`].
    #[inline]
    pub(crate) fn contact(
        &self,
        sphere: &Sphere,
        velocity: &Vector,
        step: f64,
        heading: impl FnOnce() -> Vector,
    ) -> (f64, Vector, bool) {
        match self.met_on_the_way(sphere, velocity, step) {
            Some((distance, normal)) => (distance, normal, true),
            None => {
                let (distance, normal) = self.nearest(&sphere.centre, heading);
                (distance, normal, false)
            }
        }
    }

    /// The way of a point that moves at `velocity` (m/s) for a step (s), as seen from the face, m.
    pub(crate) fn way(&self, from: &Vector, velocity: &Vector, step: f64) -> Vector {
        if self.turns && self.spin != Vector::zeros() {
            let end = from + (velocity - self.velocity) * step;
            let turn = self.spin.norm();
            return self.centre + rotated(end - self.centre, self.spin / turn, -turn * step) - from;
        }
        (velocity - self.velocity) * step
    }

    /// The velocity that takes a point where the wall takes it within a step (s), m/s.
    pub(crate) fn carries(&self, point: &Vector, step: f64) -> Vector {
        if self.turns && self.spin != Vector::zeros() {
            let turn = self.spin.norm();
            return (self.centre + rotated(point - self.centre, self.spin / turn, turn * step) - point) / step;
        }
        self.velocity_at(point)
    }

    /// Where the way of a point first comes within `level` (m) of the face, having begun farther away.
    pub(crate) fn reached(&self, from: &Vector, way: &Vector, level: f64) -> Option<Reached> {
        self.shape.reached(from, way, level)
    }

    /// Largest speed of a point of the wall within `reach` (m) of the point that it turns about, as far as it moves the face, m/s.
    pub(crate) fn largest_speed(&self, reach: f64) -> f64 {
        self.velocity.norm() + if self.turns { self.spin.norm() * reach } else { 0.0 }
    }

    /// Distance of a point from the one that the wall turns about, m.
    pub(crate) fn pivot_distance(&self, point: &Vector) -> f64 {
        (point - self.centre).norm()
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
