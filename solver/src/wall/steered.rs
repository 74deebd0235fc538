//! Kinematic walls under control of the caller, instead of the motion in the scene.
//!
//! Such a wall has a translation, or a rotation about a fixed axis; the first motion by the caller determines which. Its velocity
//! is constant over a step, and its position follows from `d' = d + h v` or `phi' = phi + h omega`, as for grains.
//!
//! The first velocity is a jump, as at the start of a motion in a scene: grains in contact with the wall have an
//! impact. Later changes are accelerations, as for a vibrating wall: resting grains follow the wall without rebound.

use super::Vector;
use super::motion::Movement;
use super::pose::{Displacement, Pose};
use crate::scene::Motion;
use serde::{Deserialize, Serialize};

/// Motion of a wall by the caller.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum WallMotion {
    /// Translation at a velocity.
    Translation {
        /// Velocity, m/s.
        velocity: [f64; 3],
    },
    /// Rotation about an axis.
    Rotation {
        /// Angular velocity about the axis, rad/s.
        rate: f64,
        /// Point of the axis (m) and its direction; absent for the axis of the scene, or that of an earlier motion.
        about: Option<([f64; 3], [f64; 3])>,
    },
}

/// State of a wall under control of the caller.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub(crate) struct Steered {
    /// Point of the axis (m) and its unit vector, for a rotation.
    about: Option<([f64; 3], [f64; 3])>,
    /// Displacement, m.
    shift: [f64; 3],
    shift_in_list: [f64; 3],
    velocity: [f64; 3],
    velocity_before: [f64; 3],
    /// Angle, rad.
    angle: f64,
    angle_in_list: f64,
    pub(super) rate: f64,
}

/// Upper bound of all positions and speeds of walls, in SI units.
const LARGEST: f64 = 1e9;

impl Steered {
    /// Begins the first motion of a wall by the caller; `now` is its pose in the scene, `then` its pose at the last
    /// build of the candidate list.
    fn begin(scene: &Motion, asked: &WallMotion, [now, then]: [&Pose; 2], angles: [f64; 2]) -> Result<Steered, String> {
        let along = |pose: &Pose| match pose.displacement {
            Displacement::By(shift) => shift.into(),
            _ => [0.0; 3],
        };
        const NOWHERE: &str = "its axis has no direction; give a vector that is not zero";
        let about = match (scene, asked) {
            (Motion::ForceDriven { .. } | Motion::TorqueDriven { .. }, _) => {
                Err("a force or a torque drives it; steer a wall that the scene holds fixed")
            }
            (Motion::Table { .. } | Motion::List(_), _) => {
                Err("the scene composes its motion; steer a wall that the scene holds fixed")
            }
            (Motion::Rotating { point, axis, .. }, WallMotion::Rotation { .. })
            | (Motion::Fixed, WallMotion::Rotation { about: Some((point, axis)), .. }) => {
                unit(axis).map(|axis| Some((*point, axis))).ok_or(NOWHERE)
            }
            (Motion::Rotating { .. }, WallMotion::Translation { .. }) => {
                Err("the scene turns it, so that it cannot be moved along; give a rate")
            }
            (_, WallMotion::Translation { .. }) => Ok(None),
            (Motion::Fixed, _) => Err("the scene gives it no axis; give a point and a direction of one"),
            _ => Err("the scene moves it along, so that it cannot be turned; give a velocity"),
        }?;
        let ([shift, shift_in_list], [angle, angle_in_list]) = ([along(now), along(then)], angles);
        Ok(Steered { about, shift, shift_in_list, angle, angle_in_list, ..Steered::default() })
    }

    /// Sets the motion; `first` for the first motion by the caller.
    fn take(&mut self, asked: &WallMotion, first: bool) -> Result<(), String> {
        match (self.about, asked) {
            (None, WallMotion::Translation { velocity }) if velocity.iter().all(|speed| speed.abs() < LARGEST) => {
                self.velocity = *velocity;
                self.velocity_before = if first { *velocity } else { self.velocity_before };
            }
            (None, WallMotion::Translation { velocity }) => {
                return Err(format!("{velocity:?} is no velocity; give three finite numbers, m/s"));
            }
            (Some(own), WallMotion::Rotation { rate, .. }) if rate.abs() < LARGEST => {
                same_axis(own, asked)?;
                self.rate = *rate;
            }
            (Some(_), WallMotion::Rotation { rate, .. }) => {
                return Err(format!("{rate} is no rate; give a finite number, rad/s"));
            }
            (None, _) => return Err("it was moved along before, so that it cannot be turned; give a velocity".into()),
            (Some(_), _) => return Err("it was turned before, so that it cannot be moved along; give a rate".into()),
        }
        Ok(())
    }

    /// Completes the pose at rest of a translation.
    pub(super) fn shift(&self, pose: &mut Pose) {
        pose.displacement = Displacement::By(self.shift.into());
        pose.velocity = self.velocity.into();
        pose.gain = pose.velocity - Vector::from(self.velocity_before);
    }

    /// Returns an upper bound of the displacement (m) of a point within `radius` (m) of the centre since the build of the candidate list.
    pub(super) fn largest_shift(&self, radius: f64, turns: bool) -> f64 {
        match self.about {
            None => (Vector::from(self.shift) - Vector::from(self.shift_in_list)).norm(),
            Some(_) if turns => (self.angle - self.angle_in_list).abs() * radius,
            Some(_) => 0.0,
        }
    }

    pub(super) fn enter_list(&mut self) {
        (self.shift_in_list, self.angle_in_list) = (self.shift, self.angle);
    }

    /// Returns a point (m) and the unit vector of the axis of a rotation.
    pub(crate) fn about(&self) -> Option<([f64; 3], [f64; 3])> {
        self.about
    }

    /// Returns the displacement, m, and the angle, rad.
    pub(crate) fn place(&self) -> ([f64; 3], f64) {
        (self.shift, self.angle)
    }

    /// Returns displacement and angle at the last build of the candidate list.
    pub(crate) fn in_list(&self) -> Steered {
        Steered { shift: self.shift_in_list, angle: self.angle_in_list, ..*self }
    }

    /// Moves the wall for a step of length `h`, s.
    pub(super) fn advance(&mut self, h: f64) {
        for axis in 0..3 {
            self.shift[axis] += h * self.velocity[axis];
        }
        self.angle += h * self.rate;
        self.velocity_before = self.velocity;
    }

    /// Returns true if the values are valid for a run.
    pub(crate) fn is_sound(&self) -> bool {
        let vectors = [self.shift, self.shift_in_list, self.velocity, self.velocity_before];
        let (point, axis) = self.about.unwrap_or_default();
        let numbers = vectors.as_flattened().iter().chain(&point).chain(&axis);
        let mut all = numbers.chain([&self.angle, &self.angle_in_list, &self.rate]);
        all.all(|number| number.abs() < LARGEST)
    }
}

impl Movement {
    /// Prescribes a motion of the wall from its next step on; `now` is the present time and `listed` that of the last build of the candidate list, s.
    pub(super) fn steer(&mut self, asked: &WallMotion, [now, listed]: [f64; 2]) -> Result<(), String> {
        let begin = || {
            let angles = [now, listed].map(|time| self.angle(time - self.origin));
            let poses = [now, listed].map(|time| self.relative_pose(time - self.origin));
            Steered::begin(&self.motion, asked, poses.each_ref(), angles)
        };
        let mut steered = self.steered.map_or_else(begin, Ok)?;
        steered.take(asked, self.steered.is_none())?;
        self.steered = Some(steered);
        Ok(())
    }
}

/// Refuses a requested axis other than that of a wall.
fn same_axis(own: ([f64; 3], [f64; 3]), asked: &WallMotion) -> Result<(), String> {
    let WallMotion::Rotation { about: Some((point, axis)), .. } = asked else { return Ok(()) };
    let (along, arm) = (Vector::from(own.1), Vector::from(*point) - Vector::from(own.0));
    let axis = unit(axis).ok_or("its axis has no direction; give a vector that is not zero")?;
    let same = (Vector::from(axis) - along).norm() < 1e-9 && arm.cross(&along).norm() < 1e-9 * (1.0 + arm.norm());
    if same { Ok(()) } else { Err("it turns about another axis, which stays; leave the axis out".into()) }
}

fn unit(vector: &[f64; 3]) -> Option<[f64; 3]> {
    Vector::from(*vector).try_normalize(1e-12).map(Vector::into)
}
