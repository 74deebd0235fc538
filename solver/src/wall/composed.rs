//! Composed motions: lists of motions, tables of poses, and motions of walls that carry others.
//!
//! With the poses M1, M2, ... of its motions in their order, a wall has the pose `... M2(t) M1(t)`, followed by the pose of the wall that
//! carries it. In a step the wall moves by D(x), the displacement between its poses at both ends. With the rotation vector theta of this
//! displacement and the present place c of the middle of the wall,
//!
//! ```text
//! chord of this step    D(x)/h = D(c)/h + s t + b omega a x t      omega a = theta/h    t = omega a x (x - c)
//! ```
//!
//! with s and b as for a single rotation ([`motion`](super::motion)). The change of this field since the last step is no approach of
//! resting grains, unless a motion begins, stops or reverses in between.

use super::motion::{Movement, Pose, active_time, is_active, turning_time};
use super::rigid::Rigid;
use super::{Vector, Walls};
use crate::scene::Motion;
use crate::surface::Face;

/// Velocity field of a rigid motion, `v + spin x x`.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Twist {
    /// Velocity of the point at the origin, m/s.
    velocity: Vector,
    /// Angular velocity, rad/s.
    spin: Vector,
}

impl Twist {
    fn about(centre: Vector, spin: Vector, velocity: Vector) -> Twist {
        Twist { velocity: velocity - spin.cross(&centre), spin }
    }

    fn at(&self, point: &Vector) -> Vector {
        self.velocity + self.spin.cross(point)
    }

    /// Returns the field that a rigid transform carries along.
    fn carried(&self, by: &Rigid) -> Twist {
        Twist::about(by.shift(), by.turn(&self.spin), by.turn(&self.velocity))
    }

    fn plus(&self, other: &Twist) -> Twist {
        Twist { velocity: self.velocity + other.velocity, spin: self.spin + other.spin }
    }
}

/// Parts of a wall that bound its displacements: a sphere around a finite wall in its scene, and the domain.
#[derive(Clone, Copy, Debug)]
pub(super) struct Extent {
    /// Centre (m) and radius (m) of the sphere; that of an infinite wall has an infinite radius.
    sphere: (Vector, f64),
    domain: (Vector, f64),
}

impl Extent {
    pub fn of(faces: &[Face], (low, high): (Vector, Vector)) -> Extent {
        let around = |low: Vector, high: Vector| ((low + high) * 0.5, (high - low).norm() * 0.5);
        let domain = around(low, high);
        let bounds: Option<Vec<[Vector; 2]>> = faces.iter().map(Face::bounds).collect();
        let corners = bounds.filter(|bounds| !bounds.is_empty()).map(|bounds| {
            bounds
                .iter()
                .fold((bounds[0][0], bounds[0][1]), |(low, high), [first, last]| (low.inf(first), high.sup(last)))
        });
        Extent { sphere: corners.map_or((domain.0, f64::INFINITY), |(low, high)| around(low, high)), domain }
    }

    /// Returns the middle of the wall in the scene, m; for an infinite wall, that of the domain.
    pub fn middle(&self) -> Vector {
        self.sphere.0
    }
}

/// Returns the displacement by a prescribed motion at a time (s).
fn displacement(motion: &Motion, time: f64) -> Rigid {
    match motion {
        Motion::Translating { velocity, start, stop } => {
            Rigid::by(Vector::from(*velocity) * active_time(time, *start, *stop))
        }
        Motion::Rotating { point, axis, rate, start, stop, reverse } => {
            let angle = rate * turning_time(time, *start, *stop, *reverse);
            Rigid::about(Vector::from(*point), Vector::from(*axis).normalize() * angle)
        }
        Motion::Vibrating { .. } => {
            Rigid::by(motion.vibration().map_or(Vector::zeros(), |vibration| vibration.displacement(time).into()))
        }
        Motion::Table { point, start, stop, content, .. } => {
            let (rows, time) = (content.rows(), stop.map_or(time, |stop| time.min(stop)) - start);
            let Some([first, last]) = span(rows, time) else { return Rigid::default() };
            let share = ((time - first[0]) / (last[0] - first[0])).clamp(0.0, 1.0);
            let turn = (turn_of(&first).inverse().then(&turn_of(&last))).vector();
            let turned = turn_of(&first).then(&Rigid::about(Vector::zeros(), turn * share));
            let point = Vector::from(*point);
            let shift = shift_of(&first) + (shift_of(&last) - shift_of(&first)) * share;
            Rigid::by(-point).then(&turned).then(&Rigid::by(point + shift))
        }
        _ => Rigid::default(),
    }
}

/// Returns the velocity field of a prescribed motion at a time (s).
fn velocity(motion: &Motion, time: f64) -> Twist {
    let (zero, (start, stop)) = (Vector::zeros(), motion.span());
    if !is_active(time, start, stop) {
        return Twist::about(zero, zero, zero);
    }
    match motion {
        Motion::Translating { velocity, .. } => Twist::about(zero, zero, Vector::from(*velocity)),
        Motion::Rotating { point, axis, rate, reverse, .. } => {
            let back = reverse.is_some_and(|reverse| time >= reverse);
            let spin = Vector::from(*axis).normalize() * if back { -rate } else { *rate };
            Twist::about(Vector::from(*point), spin, zero)
        }
        Motion::Vibrating { .. } => {
            Twist::about(zero, zero, motion.vibration().map_or(zero, |vibration| vibration.velocity(time).into()))
        }
        Motion::Table { point, start, content, .. } => {
            let Some([first, last]) = span(content.rows(), time - start) else { return Twist::about(zero, zero, zero) };
            let lasts = last[0] - first[0];
            let turn = turn_of(&first).inverse().then(&turn_of(&last)).vector();
            let centre = displacement(motion, time).place(&Vector::from(*point));
            Twist::about(centre, turn / lasts, (shift_of(&last) - shift_of(&first)) / lasts)
        }
        _ => Twist::about(zero, zero, zero),
    }
}

/// Returns the rows before and after a time (s) of a table.
fn span(rows: &[[f64; 7]], time: f64) -> Option<[[f64; 7]; 2]> {
    let last = rows.partition_point(|row| row[0] <= time).clamp(1, rows.len().max(2) - 1);
    Some([*rows.get(last - 1)?, *rows.get(last)?])
}

fn shift_of(row: &[f64; 7]) -> Vector {
    Vector::new(row[1], row[2], row[3])
}

fn turn_of(row: &[f64; 7]) -> Rigid {
    Rigid::about(Vector::zeros(), Vector::new(row[4], row[5], row[6]))
}

/// Returns true if a motion neither begins nor stops nor reverses between two times (s).
fn is_smooth(motion: &Motion, from: f64, to: f64) -> bool {
    let (start, stop) = motion.span();
    let reverse = if let Motion::Rotating { reverse, .. } = motion { *reverse } else { None };
    let slack = 1e-9 * (to - from);
    let inside = |time: f64| time > from + slack && time < to - slack;
    !(inside(start) || stop.is_some_and(inside) || reverse.is_some_and(inside))
}

impl Walls {
    /// Returns the pose and the velocity field of a wall at a time (s), by the motions of the wall and of those that carry it.
    fn course(&self, wall: usize, time: f64) -> (Rigid, Twist) {
        let Movement { motion, base, origin, carrier, .. } = &self.walls[wall].movement;
        let still = Twist::about(Vector::zeros(), Vector::zeros(), Vector::zeros());
        let mut all = (base.unwrap_or_default(), still);
        let follow =
            |(place, field): (Rigid, Twist), by: &Rigid, own: &Twist| (place.then(by), field.carried(by).plus(own));
        for part in motion.parts() {
            let time = time - origin;
            all = follow(all, &displacement(part, time), &velocity(part, time));
        }
        if let Some((parent, start)) = carrier {
            let (place, field) = self.course(*parent as usize, time);
            all = follow(all, &start.inverse(), &still);
            all = follow(all, &place, &field);
        }
        all
    }

    /// Returns true if no motion of a wall, or of those that carry it, begins, stops or reverses between two times (s).
    fn is_smooth(&self, wall: usize, from: f64, to: f64) -> bool {
        let Movement { motion, origin, carrier, .. } = &self.walls[wall].movement;
        motion.parts().iter().all(|part| is_smooth(part, from - origin, to - origin))
            && carrier.is_none_or(|(parent, _)| self.is_smooth(parent as usize, from, to))
    }

    /// Returns the pose of a wall by its motions and those of its carriers, in the scene: also that of a wall whose faces stay in place.
    pub(super) fn material_pose(&self, wall: usize, time: f64) -> Rigid {
        self.course(wall, time).0
    }

    /// Returns the pose at a time (s) of a wall with a composed motion.
    pub(super) fn composed_at(&self, wall: usize, time: f64) -> Pose {
        let (place, field) = self.course(wall, time);
        let centre = place.place(&self.walls[wall].extent.middle());
        self.walls[wall].movement.composed(&place, centre, [field.at(&centre), field.spin])
    }

    /// Returns the pose at the start of a step of length `step` (s), with the velocity that leads to the pose at its end.
    pub(super) fn composed_through(&self, wall: usize, time: f64, step: f64) -> Pose {
        let [now, end] = [time, time + step].map(|time| self.course(wall, time).0);
        let centre = now.place(&self.walls[wall].extent.middle());
        let path = now.inverse().then(&end);
        self.walls[wall].movement.composed(&now, centre, [(path.place(&centre) - centre) / step, path.vector() / step])
    }

    /// Returns the pose at the start of a step of length `step` (s), with the velocity along the chord of the step.
    pub(super) fn composed_over(&self, wall: usize, time: f64, step: f64) -> Pose {
        let mut pose = self.composed_through(wall, time, step).along_chord(step);
        if self.is_smooth(wall, time - step, time + step) {
            let before = self.composed_through(wall, time - step, step).along_chord(step);
            pose.gain_since(&before);
        }
        pose
    }

    /// Returns true if a wall with a composed motion jumps back: see [`first_that_jumps_back`](super::first_that_jumps_back).
    pub(super) fn composed_jumps_back(&self, wall: usize, time: f64, faces: &[Face], extent: f64) -> bool {
        let [first, last] = [0.0, time].map(|time| self.composed_at(wall, time));
        let stands = |pose: &Pose, face: &Face| pose.moved(face, false).unwrap_or(*face);
        let elsewhere = faces.iter().any(|face| !stands(&last, face).is_same(&stands(&first, face), extent));
        let differs = |one: Vector, other: Vector| (one - other).norm() > 1e-6 * (one.norm() + other.norm());
        elsewhere || differs(first.velocity, last.velocity) || differs(first.spin(false), last.spin(false))
    }

    /// Returns an upper bound of the displacement (m) between two times (s) of the points of a wall with a composed motion.
    pub(super) fn composed_shift(&self, wall: usize, from: f64, to: f64) -> f64 {
        let [first, last] = [from, to].map(|time| self.course(wall, time).0);
        let (back, Extent { sphere, domain }) = (last.inverse().then(&first), self.walls[wall].extent);
        let angle = back.vector().norm();
        let bound = |centre: Vector, radius: f64| (back.place(&centre) - centre).norm() + angle * radius;
        bound(domain.0, domain.1).min(bound(last.place(&sphere.0), if angle == 0.0 { 0.0 } else { sphere.1 }))
    }
}
