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

use super::WallFace;
use super::composed::{Extent, tabulate};
use super::pose::{Displacement, Pose, ROUNDING, Turning};
use super::rigid::Rigid;
use super::steered::Steered;
use crate::effects::drive::Drive;
use crate::scene::Motion;
use crate::surface::{Face, Rotation};
use nalgebra::Vector3;
use serde::{Deserialize, Serialize};
use std::f64::consts::TAU;

type Vector = Vector3<f64>;

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
