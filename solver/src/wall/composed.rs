//! Composed motions: lists of motions, and tables of poses.
//!
//! With the poses M1, M2, ... of its motions in their order, a wall has the pose `... M2(t) M1(t)`. In a step it moves by D(x), the
//! displacement between its poses at both ends. With the rotation vector theta of this displacement and the present place c of the middle of
//! the wall,
//!
//! ```text
//! chord of this step    D(x)/h = D(c)/h + s t + b omega a x t      omega a = theta/h    t = omega a x (x - c)
//! ```
//!
//! with s and b as for a single rotation ([`motion`](super::motion)). The change of this field since the last step is no approach of
//! resting grains, unless a motion begins, stops or reverses in between, or a row of a table lies there.

use super::Vector;
use super::motion::Movement;
use super::pose::{Displacement, Pose, Turning};
use super::rigid::Rigid;
use crate::scene::{Domain, Motion};
use crate::surface::Face;

/// Sphere around the points of a wall in the scene, or around the domain if the wall is infinite.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Extent {
    /// Centre, m.
    pub middle: Vector,
    radius: f64,
    /// True if the sphere moves with the wall.
    of_wall: bool,
}

impl Extent {
    pub fn of(faces: &[Face], domain: &Domain) -> Extent {
        let bounds: Option<Vec<[Vector; 2]>> = faces.iter().map(Face::bounds).collect();
        let finite = bounds.filter(|bounds| !bounds.is_empty());
        let of_wall = finite.is_some();
        let all = finite.unwrap_or_else(|| vec![[Vector::from(domain.min), Vector::from(domain.max)]]);
        let [low, high] = all.iter().fold(all[0], |[low, high], [first, last]| [low.inf(first), high.sup(last)]);
        Extent { middle: (low + high) * 0.5, radius: (high - low).norm() * 0.5, of_wall }
    }
}

impl Movement {
    /// Returns the displacement from the pose at the beginning of the motion, and the velocity field `v + w x x` by v (m/s) and w (rad/s), at a
    /// time (s) since its origin.
    fn course(&self, time: f64) -> (Rigid, [Vector; 2]) {
        let about = |centre: Vector, spin: Vector, velocity: Vector| [velocity - spin.cross(&centre), spin];
        self.parts.iter().fold(Default::default(), |(place, [velocity, spin]), part| {
            let own = part.relative_pose(time);
            let by = own.displacement.rigid();
            let carried = about(by.shift(), by.turn(&spin), by.turn(&velocity));
            let added = about(own.turning.centre, own.turning.spin, own.velocity);
            (place.then(&by), [carried[0] + added[0], carried[1] + added[1]])
        })
    }

    /// Returns the middle of the wall after a displacement from the beginning of the motion, m.
    fn middle(&self, place: &Rigid) -> Vector {
        place.place(&self.base.map_or(self.extent.middle, |base| base.place(&self.extent.middle)))
    }

    /// Sets the displacement and the velocity of a pose at a time (s) since the origin of the motion.
    pub(super) fn compose(&self, pose: &mut Pose, time: f64) {
        let (place, [velocity, spin]) = self.course(time);
        let centre = self.middle(&place);
        pose.displacement = Displacement::of(&place);
        pose.velocity = velocity + spin.cross(&centre);
        pose.turning = Turning::about(centre, spin);
    }

    /// Returns the pose at the start of a step of length `step` (s), with the velocity that leads to the pose at its end.
    pub(super) fn composed_through(&self, time: f64, step: f64) -> Pose {
        let [now, end] = [time, time + step].map(|time| self.course(time - self.origin).0);
        let (path, centre) = (now.inverse().then(&end), self.middle(&now));
        let mut pose = self.at(time);
        pose.velocity = path.displacement(&centre) / step;
        pose.turning = Turning::about(centre, path.vector() / step);
        pose
    }

    /// Returns the pose at the start of a step of length `step` (s), with the velocity along the chord of the step.
    pub(super) fn composed_over(&self, time: f64, step: f64) -> Pose {
        let mut pose = self.composed_through(time, step).along_chord(step);
        let slack = 1e-9 * step;
        let [from, to] = [time - step + slack, time + step - slack].map(|time| time - self.origin);
        if !self.parts.iter().any(|part| part.motion.breaks_between(from, to)) {
            let before = self.composed_through(time - step, step).along_chord(step);
            pose.gain = pose.velocity - before.velocity;
            pose.gain_of_spin = pose.spin(false) - before.spin(false);
        }
        pose
    }

    /// Returns an upper bound of the displacement (m) between two times (s) of the points of the wall in the domain.
    pub(super) fn composed_shift(&self, from: f64, to: f64) -> f64 {
        let [first, last] = [from, to].map(|time| self.course(time - self.origin).0);
        let Extent { middle, radius, of_wall } = self.extent;
        let (back, centre) = (last.inverse().then(&first), if of_wall { self.middle(&last) } else { middle });
        back.displacement(&centre).norm() + back.vector().norm() * radius
    }
}

/// Sets the displacement and the velocity of a pose by the rows of a table, about a point (m), at a time (s) of the table. The table ends at `stop`.
pub(super) fn tabulate(pose: &mut Pose, rows: &[[f64; 7]], point: Vector, time: f64, stop: f64) {
    let last = rows.partition_point(|row| row[0] <= time.min(stop)).clamp(1, rows.len().max(2) - 1);
    let (Some(before), Some(after)) = (rows.get(last - 1), rows.get(last)) else { return };
    let shift = |row: &[f64; 7]| Vector::new(row[1], row[2], row[3]);
    let turn = |row: &[f64; 7]| Rigid::about(Vector::zeros(), Vector::new(row[4], row[5], row[6]));
    let lasts = after[0] - before[0];
    let share = ((time.min(stop) - before[0]) / lasts).clamp(0.0, 1.0);
    let (turned, along) = (turn(before).inverse().then(&turn(after)).vector(), shift(after) - shift(before));
    let place = point + shift(before) + along * share;
    let rotation = turn(before).then(&Rigid::about(Vector::zeros(), turned * share));
    pose.displacement = Displacement::of(&Rigid::by(-point).then(&rotation).then(&Rigid::by(place)));
    if time >= rows[0][0] && time < stop && time < rows[rows.len() - 1][0] {
        pose.velocity = along / lasts;
        pose.turning = Turning::about(place, turned / lasts);
    }
}

impl Motion {
    /// Returns true if the motion begins, stops or reverses between two times (s), or changes from one row of a table to the next.
    fn breaks_between(&self, from: f64, to: f64) -> bool {
        let inside = |time: f64| time > from && time < to;
        let (start, stop) = self.span();
        let other = match self {
            Motion::Rotating { reverse, .. } => reverse.is_some_and(inside),
            Motion::Table { start, content, .. } => {
                let after = content.rows().partition_point(|row| start + row[0] <= from);
                content.rows().get(after).is_some_and(|row| inside(start + row[0]))
            }
            _ => false,
        };
        other || inside(start) || stop.is_some_and(inside)
    }
}
