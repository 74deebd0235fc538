//! Wall at a time: its position and its velocity field, and the path of a grain relative to it.
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

use super::rigid::Rigid;
use crate::surface::{Face, Rotation};
use nalgebra::Vector3;

type Vector = Vector3<f64>;

/// Relative tolerance for rounding in the sum of steps.
pub(super) const ROUNDING: f64 = 1e-9;

/// Wall at a time: its position and its velocity field.
#[derive(Clone, Copy, Debug, Default)]
pub struct Pose {
    pub(super) displacement: Displacement,
    /// Displacement of faces that the motion maps onto themselves.
    pub(super) base: Displacement,
    pub(super) velocity: Vector,
    /// Velocity of the surface along itself, in addition to that of the wall.
    pub(super) surface_velocity: Vector,
    /// Change of velocity since the last step.
    pub(super) gain: Vector,
    /// Change of the angular velocity about the centre of `turning`, of a composed motion.
    pub(super) gain_of_spin: Vector,
    /// Rotation for faces that the rotation moves.
    pub(super) turning: Turning,
    /// Rotation for faces that the rotation maps onto themselves.
    pub(super) in_place: Turning,
    /// True if the rotation moves at least one face.
    pub(super) turns: bool,
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
    pub(super) fn moved(&self, face: &Face) -> Option<Face> {
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
