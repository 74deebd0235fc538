//! Motion of a wall: the position of its shape at a time, and its velocity field. A wall has one pose for all its faces.
//!
//! A point X of the wall in the scene moves by
//!
//! ```text
//! translation   x = X + d(t)                    v = d'(t)
//! rotation      x = c + R(a, phi(t)) (X - c)    v = omega a x (x - c)
//! ```
//!
//! with the d and phi that the scene prescribes or a drive has reached. Steps are long compared with some motions, so
//! two further velocities belong to the same position: the mean velocity of a step for contacts ([`Movement::over`]),
//! and the velocity that leads to the position of the wall at the end of the step ([`Movement::through`]).
//!
//! Grains move on straight lines in a step. A grain that sticks to a wall with the rotation `theta = omega h` therefore retains its position on the
//! wall only if its centre moves along the chord of its arc. With the arm p from the centre of the wall to that of the grain and `t = omega a x p`,
//!
//! ```text
//! chord of this step    (R(theta) p - p)/h  = s t + b omega a x t      s = sin(theta)/theta    b = h (1 - cos(theta))/theta^2
//! previous step         (p - R(-theta) p)/h = s t - b omega a x t
//! ```
//!
//! Their mean `s t` is the velocity for the impulses of the step, and half their difference, `b omega a x t`, is the drift towards the axis
//! ([`Pose::drift`]). A face that the rotation maps onto itself moves only in its tangent plane: the normal component of the drift is omitted.

use super::WallFace;
use super::composed::{Extent, tabulate};
use super::rigid::Rigid;
use super::steered::Steered;
use crate::effects::drive::Drive;
use crate::scene::Motion;
use crate::surface::{Face, Rotation};
use nalgebra::Vector3;
use serde::{Deserialize, Serialize};
use std::f64::consts::TAU;

type Vector = Vector3<f64>;

/// Relative tolerance for rounding in the sum of steps.
const ROUNDING: f64 = 1e-9;

/// Motion of a wall: prescribed by the scene, or the result of a drive.
#[derive(Clone, Debug, Default)]
pub(super) struct Movement {
    pub(super) motion: Motion,
    /// Motions that make up a composed one, in their order; none for another motion.
    pub(super) parts: Vec<Movement>,
    pub(super) extent: Extent,
    /// Pose from which the motion begins, if not that of the scene.
    pub(super) base: Option<Rigid>,
    /// Time from which the times of the motion count, s.
    pub(super) origin: f64,
    /// Velocity of the surface along itself, m/s.
    pub(super) surface_velocity: Vector,
    /// True if a rotation moves at least one face, instead of mapping all faces onto themselves.
    pub(super) turns: bool,
    /// Motion by the caller instead of the scene.
    pub(super) steered: Option<Steered>,
    /// Displacement by a drive, m or rad, at present and at the last build of the candidate list; zero without a drive.
    pub(super) displacement: f64,
    pub(super) displacement_in_list: f64,
    /// Velocity by a drive, m/s or rad/s.
    pub(super) rate: f64,
}

/// Beginning of a motion that continues an earlier one of the same wall. Points and axes of the motion are those of the scene
/// at this time.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Beginning {
    /// Pose of the wall relative to its position in the scene.
    pub(crate) pose: Rigid,
    /// Time from which the times of the motion count, s.
    pub(crate) time: f64,
}

/// Wall at a time: its position and its velocity field.
#[derive(Clone, Copy, Debug, Default)]
pub struct Pose {
    pub(super) displacement: Displacement,
    /// Displacement of faces that the motion maps onto themselves.
    base: Displacement,
    pub(super) velocity: Vector,
    /// Velocity of the surface along itself, in addition to that of the wall.
    surface_velocity: Vector,
    /// Change of velocity since the last step.
    pub(super) gain: Vector,
    /// Change of the angular velocity about the centre of `turning`, of a composed motion.
    pub(super) gain_of_spin: Vector,
    /// Rotation for faces that the rotation moves.
    pub(super) turning: Turning,
    /// Rotation for faces that the rotation maps onto themselves.
    pub(super) in_place: Turning,
    /// True if the rotation moves at least one face.
    turns: bool,
}

/// State of a wall under a force or a torque.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct DrivenWall {
    /// Index in the scene's list of walls.
    pub wall: u32,
    /// Displacement from the position in the scene, along or about the axis, m or rad.
    pub displacement: f64,
    /// Velocity, m/s or rad/s.
    pub rate: f64,
}

/// Pose of a wall relative to its position in the scene.
#[derive(Clone, Copy, Debug, Default)]
pub(super) enum Displacement {
    #[default]
    Nowhere,
    By(Vector),
    About(Vector, Rotation),
    /// Rotation about the origin, then a translation.
    Rigid(Rotation, Vector),
}

impl Displacement {
    pub(super) fn of(rigid: &Rigid) -> Displacement {
        match rigid.rotation() {
            Some(rotation) => Displacement::Rigid(rotation, rigid.shift()),
            None if rigid.shift() == Vector::zeros() => Displacement::Nowhere,
            None => Displacement::By(rigid.shift()),
        }
    }

    pub(super) fn rigid(&self) -> Rigid {
        match self {
            Displacement::Nowhere => Rigid::default(),
            Displacement::By(shift) => Rigid::by(*shift),
            Displacement::About(centre, rotation) => Rigid::about(*centre, rotation.vector()),
            Displacement::Rigid(rotation, shift) => {
                Rigid::about(Vector::zeros(), rotation.vector()).then(&Rigid::by(*shift))
            }
        }
    }

    /// Returns a face after the displacement, if there is one.
    #[inline]
    fn moved(&self, face: &Face) -> Option<Face> {
        match self {
            Displacement::Nowhere => None,
            Displacement::By(shift) => Some(face.moved(*shift)),
            Displacement::About(centre, rotation) => Some(face.turned(*centre, rotation)),
            Displacement::Rigid(rotation, shift) => Some(face.turned(Vector::zeros(), rotation).moved(*shift)),
        }
    }
}

/// Angular velocity, rad/s, and a point of the axis, m.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Turning {
    pub(super) spin: Vector,
    pub(super) centre: Vector,
    /// Ratio of the length of the chord to that of the arc, and of the drift to `omega a x t` (s): s and b above.
    pub(super) chord: [f64; 2],
}

impl Turning {
    /// Creates the rotation at one time: the tangent.
    pub(super) fn about(centre: Vector, spin: Vector) -> Turning {
        Turning { spin, centre, chord: [1.0, 0.0] }
    }

    /// Returns the rotation over a step of length `step` (s): the chord.
    fn over(self, step: f64) -> Turning {
        let angle = self.spin.norm() * step;
        if angle == 0.0 {
            return self;
        }
        let (sine, half) = (libm::sin(angle), libm::sin(0.5 * angle));
        Turning { chord: [sine / angle, 2.0 * step * half * half / (angle * angle)], ..self }
    }

    /// Returns the velocity (m/s) of a point (m) without its drift.
    #[inline]
    fn velocity(&self, point: &Vector) -> Vector {
        self.spin.cross(&(point - self.centre)) * self.chord[0]
    }

    /// Returns the drift (m/s) of a point (m) towards the axis.
    #[inline]
    fn drift(&self, point: &Vector) -> Vector {
        self.spin.cross(&self.spin.cross(&(point - self.centre))) * self.chord[1]
    }
}

impl Movement {
    /// Creates the motion of a wall at time zero.
    pub fn new(motion: &Motion, surface_velocity: [f64; 3], extent: Extent) -> Movement {
        let mut movement = Movement { surface_velocity: surface_velocity.into(), extent, ..Movement::default() };
        movement.begin(motion, &Beginning::default());
        movement
    }

    /// Begins another motion of the wall.
    pub fn begin(&mut self, motion: &Motion, beginning: &Beginning) {
        let Movement { surface_velocity, extent, .. } = *self;
        let part = |part: &Motion| Movement { motion: part.clone(), extent, turns: true, ..Movement::default() };
        let is_composed = matches!(motion, Motion::List(_) | Motion::Table { .. });
        let parts = motion.parts().iter().filter(|_| is_composed).map(part).collect();
        let base = Some(beginning.pose).filter(|pose| *pose != Rigid::default());
        let (motion, origin) = (motion.clone(), beginning.time);
        *self = Movement { motion, parts, extent, base, origin, surface_velocity, ..Movement::default() };
    }

    /// Returns a point (m) and the unit vector of the axis of a rotation; `None` for other motions.
    pub fn axis(&self) -> Option<(Vector, Vector)> {
        match &self.steered {
            Some(steered) => steered.about().map(|(point, axis)| (point.into(), axis.into())),
            None => self.motion.axis().map(|(point, axis)| (point.into(), Vector::from(axis).normalize())),
        }
    }

    /// Returns true if the motion maps a face in the scene onto itself, so that only velocities change.
    pub fn keeps_in_place(&self, face: &Face) -> bool {
        match self.axis() {
            Some((point, axis)) => self.based(face).turns_in_place(point, axis),
            None => !self.moves(),
        }
    }

    /// Returns a face at the pose from which the motion begins.
    pub fn based(&self, face: &Face) -> Face {
        self.base.and_then(|base| Displacement::of(&base).moved(face)).unwrap_or(*face)
    }

    /// Returns the pose of the wall at a time (s), with the velocity at that time; for a dynamic wall, the last state of its drive.
    pub fn at(&self, time: f64) -> Pose {
        let mut pose = self.relative_pose(time - self.origin);
        if let Some(base) = &self.base {
            pose.base = Displacement::of(base);
            pose.displacement = match pose.displacement {
                Displacement::Nowhere => pose.base,
                other => Displacement::of(&base.then(&other.rigid())),
            };
        }
        pose
    }

    /// Returns the pose relative to that at the beginning of the motion, at a time (s) since its origin.
    pub(super) fn relative_pose(&self, time: f64) -> Pose {
        let mut pose = Pose { surface_velocity: self.surface_velocity, turns: self.turns, ..Pose::default() };
        if let Some(steered) = &self.steered {
            match steered.about() {
                Some(_) => self.turn(&mut pose, steered.place().1, Some(steered.rate)),
                None => steered.shift(&mut pose),
            }
            return pose;
        }
        if !self.parts.is_empty() {
            self.compose(&mut pose, time);
            return pose;
        }
        match &self.motion {
            Motion::Fixed | Motion::List(_) => {}
            Motion::Table { point, start, stop, content, .. } => {
                let stop = stop.map_or(f64::INFINITY, |stop| stop - start);
                tabulate(&mut pose, content.rows(), Vector::from(*point), time - start, stop);
            }
            Motion::Translating { velocity, start, stop } => {
                let velocity = Vector::from(*velocity);
                pose.displacement = Displacement::By(velocity * active_time(time, *start, *stop));
                if is_active(time, *start, *stop) {
                    pose.velocity = velocity;
                }
            }
            Motion::Rotating { rate, start, stop, reverse, .. } => {
                let backwards = reverse.is_some_and(|reverse| time >= reverse);
                let rate = is_active(time, *start, *stop).then_some(if backwards { -*rate } else { *rate });
                self.turn(&mut pose, self.angle(time), rate);
            }
            Motion::Vibrating { .. } => {
                if let Some(vibration) = self.motion.vibration() {
                    pose.displacement = Displacement::By(vibration.displacement(time).into());
                    pose.velocity = vibration.velocity(time).into();
                }
            }
            Motion::ForceDriven { axis, .. } => {
                let axis = Vector::from(*axis).normalize();
                pose.displacement = Displacement::By(axis * self.displacement);
                pose.velocity = axis * self.rate;
            }
            Motion::TorqueDriven { .. } => self.turn(&mut pose, self.angle(time), Some(self.rate)),
        }
        pose
    }

    /// Turns a pose by an angle (rad) about the axis of the motion; the rate (rad/s) is absent at rest.
    fn turn(&self, pose: &mut Pose, angle: f64, rate: Option<f64>) {
        let (centre, axis) = self.axis().unwrap_or_default();
        if self.turns {
            pose.displacement = Displacement::About(centre, Rotation::new(axis, angle));
        }
        pose.in_place = rate.map_or(pose.in_place, |rate| Turning::about(centre, axis * rate));
        pose.turning = pose.in_place;
    }

    /// Returns true if any face would jump, or a vibration change its phase, if the time were reset from a time (s) to
    /// zero, in a scene of this extent, m. Displacements by a drive remain.
    pub fn jumps_back(&self, time: f64, faces: &[WallFace], extent: f64) -> bool {
        let begins = |motion: &Motion| *motion != Motion::Fixed && motion.span().0 < time * (1.0 - ROUNDING);
        if self.motion.is_driven() || !self.motion.parts().iter().any(begins) {
            return false;
        }
        let (first, last) = (self.at(0.0), self.at(time));
        let stands = |pose: &Pose, face: &WallFace| pose.moved(&face.shape, face.in_place).unwrap_or(face.shape);
        let elsewhere = faces.iter().any(|face| !stands(&last, face).is_same(&stands(&first, face), extent));
        let out_of_phase = self.motion.vibration().is_some_and(|vibration| {
            let rate = (TAU * vibration.frequency).max(f64::MIN_POSITIVE);
            let lag = (last.velocity - first.velocity) / rate;
            faces.iter().any(|face| !face.shape.moved(lag).is_same(&face.shape, extent))
        });
        let differs = |one: Vector, other: Vector| (one - other).norm() > ROUNDING.sqrt() * (one.norm() + other.norm());
        let other_course = !self.parts.is_empty()
            && (differs(first.velocity, last.velocity) || differs(first.turning.spin, last.turning.spin));
        elsewhere || out_of_phase || other_course
    }

    /// Returns the displacement (m) and angle (rad) at a time (s) from the position in the scene; for a dynamic wall, the last state of its drive.
    pub(super) fn place(&self, time: f64) -> ([f64; 3], f64) {
        if let Some(steered) = &self.steered {
            return steered.place();
        }
        let angle = self.angle(time - self.origin);
        match self.at(time).displacement {
            Displacement::By(shift) => (shift.into(), angle),
            other if !self.parts.is_empty() => {
                let (place, middle) = (other.rigid(), self.extent.middle);
                (place.displacement(&middle).into(), place.vector().norm())
            }
            _ => ([0.0; 3], angle),
        }
    }

    /// Returns the angle (rad) at a time (s) since its origin: prescribed, or that of the drive.
    pub(super) fn angle(&self, time: f64) -> f64 {
        match &self.motion {
            Motion::Rotating { rate, start, stop, reverse, .. } => rate * turning_time(time, *start, *stop, *reverse),
            Motion::TorqueDriven { .. } => self.displacement,
            _ => 0.0,
        }
    }

    /// Returns the pose at the start of a step of length `step` (s), with the effective velocity of the step: the mean
    /// velocity of a vibration, the velocity along the chord of a rotation.
    pub fn over(&self, time: f64, step: f64) -> Pose {
        if !self.parts.is_empty() {
            return self.composed_over(time, step);
        }
        let mut pose = self.at(time).along_chord(step);
        let time = time - self.origin;
        if let Some(vibration) = self.motion.vibration().filter(|_| self.steered.is_none()) {
            pose.velocity = vibration.mean_velocity(time, time + step).into();
            if vibration.is_smooth(time - step, time + step) {
                pose.gain = pose.velocity - Vector::from(vibration.mean_velocity(time - step, time));
            }
        }
        pose
    }

    /// Returns the pose at the start of a step of length `step` (s), with the velocity that leads to the position at
    /// the end; a dynamic wall moves at `rate` (m/s or rad/s).
    pub fn through(&self, time: f64, step: f64, rate: f64) -> Pose {
        if !self.parts.is_empty() {
            return self.composed_through(time, step);
        }
        let mut pose = self.at(time);
        if self.steered.is_some() {
            return pose;
        }
        let (local, (centre, turning)) = (time - self.origin, self.axis().unwrap_or_default());
        match &self.motion {
            Motion::Translating { velocity, start, stop } => {
                let moves = active_time(local + step, *start, *stop) - active_time(local, *start, *stop);
                pose.velocity = Vector::from(*velocity) * (moves / step);
            }
            Motion::Rotating { rate, start, stop, reverse, .. } => {
                let turned = |time| turning_time(time, *start, *stop, *reverse);
                let mean = rate * (turned(local + step) - turned(local)) / step;
                pose.turning = Turning::about(centre, turning * mean);
            }
            Motion::Vibrating { .. } => pose.velocity = self.over(time, step).velocity,
            Motion::ForceDriven { axis, .. } => pose.velocity = Vector::from(*axis).normalize() * rate,
            Motion::TorqueDriven { .. } => {
                pose.turning.spin = turning * rate;
                pose.in_place = pose.turning;
            }
            Motion::Fixed | Motion::Table { .. } | Motion::List(_) => {}
        }
        pose
    }

    /// Returns true if the wall moves at any time.
    pub fn moves(&self) -> bool {
        self.steered.is_some() || !matches!(self.motion, Motion::Fixed)
    }

    /// Returns an upper bound of the displacement (m) between two times (s) of a point within `radius` (m) of the centre of the motion,
    /// unless the motion maps the wall onto itself. The displacement of a dynamic wall is that since the build of the list.
    pub fn largest_shift(&self, from: f64, to: f64, radius: f64) -> f64 {
        if let Some(steered) = &self.steered {
            return steered.largest_shift(radius, self.turns);
        }
        if !self.parts.is_empty() {
            return self.composed_shift(from, to);
        }
        let (from, to) = (from - self.origin, to - self.origin);
        match &self.motion {
            Motion::Fixed | Motion::Table { .. } | Motion::List(_) => 0.0,
            Motion::Translating { velocity, start, stop } => {
                Vector::from(*velocity).norm() * (active_time(to, *start, *stop) - active_time(from, *start, *stop))
            }
            Motion::Vibrating { .. } => self.motion.vibration().map_or(0.0, |vibration| {
                (Vector::from(vibration.displacement(to)) - Vector::from(vibration.displacement(from))).norm()
            }),
            Motion::ForceDriven { .. } => (self.displacement - self.displacement_in_list).abs(),
            _ if !self.turns => 0.0,
            Motion::Rotating { rate, start, stop, .. } => {
                rate.abs() * radius * (active_time(to, *start, *stop) - active_time(from, *start, *stop))
            }
            Motion::TorqueDriven { .. } => (self.displacement - self.displacement_in_list).abs() * radius,
        }
    }
}

/// Returns the drive of a dynamic wall; `number` is the index of the wall in the scene, and times count from `origin` (s).
pub(crate) fn drive_of(motion: &Motion, number: u32, origin: f64) -> Option<Drive> {
    match *motion {
        Motion::ForceDriven { axis, force, mass, largest_speed, start } => {
            let axis = Vector::from(axis).normalize();
            Some(Drive::new(number, axis, None, [force, mass], largest_speed, origin + start))
        }
        Motion::TorqueDriven { point, axis, torque, moment_of_inertia, largest_speed, start } => {
            let (axis, pivot) = (Vector::from(axis).normalize(), Some(Vector::from(point)));
            Some(Drive::new(number, axis, pivot, [torque, moment_of_inertia], largest_speed, origin + start))
        }
        _ => None,
    }
}

/// Returns the time in motion up to `time`, s.
fn active_time(time: f64, start: f64, stop: Option<f64>) -> f64 {
    (stop.map_or(time, |stop| time.min(stop)) - start).max(0.0)
}

/// Returns the time of rotation up to `time`, minus that of reverse rotation, s.
fn turning_time(time: f64, start: f64, stop: Option<f64>, reverse: Option<f64>) -> f64 {
    let back = reverse.map_or(0.0, |reverse| active_time(time, reverse, stop));
    active_time(time, start, stop) - 2.0 * back
}

fn is_active(time: f64, start: f64, stop: Option<f64>) -> bool {
    time >= start && stop.is_none_or(|stop| time < stop)
}

impl Pose {
    /// Returns the pose with the velocity along the chord of a step, s.
    pub(super) fn along_chord(self, step: f64) -> Pose {
        Pose { turning: self.turning.over(step), in_place: self.in_place.over(step), ..self }
    }

    /// Returns a face at its present position, if that differs from its position in the scene; `in_place` if the motion maps the face onto itself.
    #[inline]
    pub(super) fn moved(&self, face: &Face, in_place: bool) -> Option<Face> {
        if in_place { self.base.moved(face) } else { self.displacement.moved(face) }
    }

    /// Transforms a point (m) from the world to the frame of the wall, in which the wall has its position in the scene.
    pub(super) fn in_wall(&self, point: &Vector) -> Vector {
        match &self.displacement {
            Displacement::Nowhere => *point,
            Displacement::By(shift) => point - shift,
            Displacement::About(centre, rotation) => centre + rotation.inverse().turn(point - centre),
            Displacement::Rigid(rotation, shift) => rotation.inverse().turn(point - shift),
        }
    }

    /// Transforms a point (m) from the frame of the wall to the world.
    pub(super) fn in_world(&self, point: &Vector) -> Vector {
        match &self.displacement {
            Displacement::Nowhere => *point,
            Displacement::By(shift) => point + shift,
            Displacement::About(centre, rotation) => centre + rotation.turn(point - centre),
            Displacement::Rigid(rotation, shift) => rotation.turn(*point) + shift,
        }
    }

    #[inline]
    fn turning(&self, in_place: bool) -> &Turning {
        if in_place { &self.in_place } else { &self.turning }
    }

    /// Returns the velocity of the wall at a point (m), m/s; in a step, the effective velocity without the drift of a rotation.
    #[inline]
    pub(super) fn velocity_at(&self, point: &Vector, in_place: bool) -> Vector {
        self.velocity + self.turning(in_place).velocity(point)
    }

    /// Returns the velocity of the surface along itself (m/s) at a contact with this normal.
    #[inline]
    pub(super) fn slides_at(&self, normal: &Vector) -> Vector {
        self.surface_velocity - normal * normal.dot(&self.surface_velocity)
    }

    /// Returns the drift towards the axis (m/s) of a grain with this centre (m) that moves with a face, given the normal towards
    /// the face. The drift is the difference between the chord and the tangent velocity of a step; zero without rotation.
    #[inline]
    pub(super) fn drift(&self, centre: &Vector, normal: &Vector, in_place: bool) -> Vector {
        let drift = self.turning(in_place).drift(centre);
        if in_place { drift - normal * normal.dot(&drift) } else { drift }
    }

    /// Returns true if a face of the wall may have a drift in the step.
    #[inline]
    pub(crate) fn drifts(&self) -> bool {
        self.turning.chord[1] != 0.0 || self.in_place.chord[1] != 0.0
    }

    /// Returns the change of the wall's velocity at a point (m) since the last step, without a jump and without the drift, m/s; no part of the
    /// approach speed of a resting grain.
    #[inline]
    pub(crate) fn gain_at(&self, point: &Vector) -> Vector {
        match self.gain_of_spin == Vector::zeros() {
            true => self.gain,
            false => self.gain + self.gain_of_spin.cross(&(point - self.turning.centre)),
        }
    }

    /// Returns the angular velocity, rad/s; in a step, that of grains that stick to the wall.
    #[inline]
    pub(super) fn spin(&self, in_place: bool) -> Vector {
        let Turning { spin, chord, .. } = self.turning(in_place);
        spin * chord[0]
    }

    /// Returns the path of a point (m) with the given `velocity` (m/s) over a step (s), relative to a face, m.
    #[inline]
    pub(super) fn path(&self, from: &Vector, velocity: &Vector, step: f64, in_place: bool) -> Vector {
        match in_place || self.turning.spin == Vector::zeros() {
            true => (velocity - self.velocity) * step,
            false => self.path_from_turning(from, velocity, step),
        }
    }

    /// Returns the path if its length exceeds `length` (m).
    ///
    /// Every grain near a wall calls this function in every step, and almost all paths are short: short paths must not be written to memory.
    #[inline(always)]
    pub(super) fn long_path(
        &self,
        from: &Vector,
        velocity: &Vector,
        step: f64,
        in_place: bool,
        length: f64,
    ) -> Option<Vector> {
        if !in_place && self.turning.spin != Vector::zeros() {
            let (shift, arm) = (((velocity - self.velocity) * step).norm(), (from - self.turning.centre).norm());
            // An upper bound: the turned point moves by at most its arm times the angle.
            if (shift + self.turning.spin.norm() * step * (arm + shift)) * (1.0 + ROUNDING) < length {
                return None;
            }
            return Some(self.path_from_turning(from, velocity, step))
                .filter(|path| path.norm_squared() > length * length);
        }
        let path = (velocity - self.velocity) * step;
        (path.norm_squared() > length * length).then_some(path)
    }

    /// Returns the path relative to a rotating face, m.
    #[inline(never)]
    fn path_from_turning(&self, from: &Vector, velocity: &Vector, step: f64) -> Vector {
        let Turning { spin, centre, .. } = self.turning;
        let (end, turn) = (from + (velocity - self.velocity) * step, spin.norm());
        centre + Rotation::new(spin / turn, -turn * step).turn(end - centre) - from
    }

    /// Returns the length (m) of the longest path of [`Pose::path`] over all faces.
    pub(crate) fn longest_path(&self, from: &Vector, velocity: &Vector, step: f64) -> f64 {
        let seen = |in_place| self.path(from, velocity, step, in_place).norm();
        seen(true).max(if self.turns { seen(false) } else { 0.0 })
    }

    /// Returns the velocity (m/s) of a point (m) that moves with the wall over a step (s).
    pub(super) fn carries(&self, point: &Vector, step: f64, in_place: bool) -> Vector {
        let Turning { spin, centre, .. } = self.turning;
        if !in_place && spin != Vector::zeros() {
            let turn = spin.norm();
            return (centre + Rotation::new(spin / turn, turn * step).turn(point - centre) - point) / step;
        }
        self.velocity_at(point, in_place)
    }

    /// Returns the largest speed (m/s) of a point of the wall within `radius` (m) of another point (m); for faces that
    /// a rotation maps onto themselves, without the rotation.
    pub(crate) fn largest_speed(&self, around: &Vector, radius: f64) -> f64 {
        if self.turns { self.largest_speed_of(around, radius, false) } else { self.velocity.norm() }
    }

    /// Returns the largest speed (m/s) of a point of one face, without the rotation if the rotation maps the face onto itself.
    pub(super) fn largest_speed_of(&self, around: &Vector, radius: f64, in_place: bool) -> f64 {
        let Turning { spin, centre, .. } = self.turning;
        let turning = if in_place { 0.0 } else { spin.norm() * ((around - centre).norm() + radius) };
        self.velocity.norm() + turning
    }
}
