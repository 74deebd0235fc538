//! Input of reference codes: the run as steps, numbered materials, walls as native surfaces of the codes, meshes.
//!
//! In codes that have them, planes across a coordinate axis and cylinders along one are endless. So a wall becomes one only where no grain can
//! reach the part that the scene's wall lacks. A plane has no end. The faces of a box have none for grains inside. A cylinder and its
//! two lids have none for grains between the lids if these close the cylinder.

use super::Job;
use makadam::scene::{ContactCoefficients, Grain, Motion, Shape, Wall};
use makadam::snapshot::Snapshot;
use makadam_frames::output::mesh::{Mesh, reach};
use makadam_frames::plan::MeasuredScene;
use makadam_frames::recording::Recording;
use nalgebra::Vector3;
use std::fmt::Write;

/// Time between the frames before measuring begins, s.
const COARSE_INTERVAL: f64 = 0.25;

/// One run in time steps.
pub(super) struct Plan {
    /// Time step, s: a whole number of them fills the interval between frames.
    pub time_step: f64,
    /// Number of steps.
    pub steps: u64,
    /// Steps between frames once measuring has begun.
    pub fine: u64,
    /// Steps between frames before that; a multiple of `fine`.
    pub coarse: u64,
    /// Step of the first measured frame.
    pub fine_from: u64,
}

/// Part of a wall's motion at one velocity, or a vibration.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct MotionPhase {
    /// First step of the phase.
    pub first: u64,
    /// Last step of the phase.
    pub last: u64,
    /// 1 for the direction of the scene, -1 for the opposite.
    pub direction: f64,
}

impl Plan {
    /// Divides a scene's duration by a step of at most `largest_step`.
    pub fn new(scene: &MeasuredScene, largest_step: f64) -> Plan {
        let interval = scene.measure.interval;
        let fine = (interval / largest_step - 1e-9).ceil().max(1.0);
        // An interval below the step shrinks the step to the interval, not further.
        let time_step = interval / fine;
        let step_at = |time: f64| (time / time_step).round() as u64;
        let steps = step_at(scene.duration).max(1);
        let fine = fine as u64;
        let coarse = fine.saturating_mul((COARSE_INTERVAL / interval).round().max(1.0) as u64);
        let fine_from = match scene.measure.from {
            Some(from) => (step_at(from).div_ceil(fine) * fine).min(steps),
            None => steps,
        };
        Plan { time_step, steps, fine, coarse, fine_from }
    }

    /// Returns the frames of a run of this plan by an explicit code, on one core, with their provenance.
    pub fn recording(
        &self,
        code: &str,
        version: String,
        job: &Job<'_>,
        wall_seconds: f64,
        frames: Vec<Snapshot>,
    ) -> Recording {
        Recording {
            time_step: self.time_step,
            rayleigh_fraction: Some(job.rayleigh_fraction),
            stiffness_factor: job.stiffness_factor,
            wall_seconds,
            simulated_seconds: self.steps as f64 * self.time_step,
            ..Recording::new(job.scene, code, version, job.seed, frames)
        }
    }

    /// Steps at which frames are taken, rising, the last one at the end.
    pub fn frames(&self) -> Vec<u64> {
        let coarse = (0..self.fine_from).step_by(self.coarse as usize);
        let fine = (self.fine_from..self.steps).step_by(self.fine as usize);
        coarse.chain(fine).chain([self.steps]).collect()
    }

    /// Returns the step of the run that begins nearest to a time (s).
    pub fn step_at(&self, time: f64) -> u64 {
        ((time / self.time_step).round() as u64).min(self.steps)
    }

    /// Returns the phases of a wall's motion within the run, in their order; a dynamic wall has none.
    pub fn phases(&self, motion: &Motion) -> Vec<MotionPhase> {
        let (start, stop, reverse) = match motion {
            Motion::Translating { start, stop, .. } | Motion::Vibrating { start, stop, .. } => (*start, *stop, None),
            Motion::Rotating { start, stop, reverse, .. } => (*start, *stop, *reverse),
            _ => return Vec::new(),
        };
        let step_at = |time: f64| self.step_at(time);
        let (first, last) = (step_at(start), stop.map_or(self.steps, step_at));
        let turn = reverse.map_or(last, step_at).clamp(first, last.max(first));
        let forth = MotionPhase { first, last: turn, direction: 1.0 };
        let back = MotionPhase { first: turn, last, direction: -1.0 };
        [forth, back].into_iter().filter(|phase| phase.first < phase.last).collect()
    }

    /// Steps at which some wall starts or stops or the frames become denser, rising, with both ends of the run.
    pub fn boundaries(&self, scene: &MeasuredScene) -> Vec<u64> {
        let mut at: Vec<u64> = scene
            .wall
            .iter()
            .flat_map(|wall| self.phases(&wall.motion))
            .flat_map(|phase| [phase.first, phase.last])
            .chain([0, self.fine_from, self.steps])
            .collect();
        at.sort_unstable();
        at.dedup();
        at
    }
}

/// Numbered materials of a scene. A material of both grains and walls has two entries, since friction and
/// restitution follow other rules at walls.
pub(super) struct Palette<'a> {
    scene: &'a MeasuredScene,
    entries: Vec<(&'a str, bool)>,
}

impl<'a> Palette<'a> {
    pub fn new(scene: &'a MeasuredScene, grains: &[Grain]) -> Palette<'a> {
        let mut entries = Vec::new();
        for name in scene.material.keys() {
            if grains.iter().any(|grain| grain.material == *name) {
                entries.push((name.as_str(), false));
            }
        }
        for name in scene.material.keys() {
            if scene.wall.iter().any(|wall| wall.material == *name) {
                entries.push((name.as_str(), true));
            }
        }
        Palette { scene, entries }
    }

    /// Number of entries.
    pub fn len(&self) -> usize {
        self.entries.len()
    }

    /// Returns every pair of entries that may have a contact, in ascending order of the entries.
    pub fn pairs(&self) -> impl Iterator<Item = (usize, usize, ContactCoefficients)> + '_ {
        let pairs = (0..self.len()).flat_map(|a| (a..self.len()).map(move |b| (a, b)));
        pairs.filter_map(|(a, b)| self.coefficients(a, b).map(|coefficients| (a, b, coefficients)))
    }

    /// Returns true if an entry is a material of walls; these come last.
    pub fn is_wall(&self, entry: usize) -> bool {
        self.entries[entry].1
    }

    /// Index of a material, from 0.
    pub fn index(&self, material: &str, wall: bool) -> usize {
        self.entries.iter().position(|entry| *entry == (material, wall)).unwrap_or_default()
    }

    /// Returns the materials in order.
    pub fn materials(&self) -> impl Iterator<Item = &'a makadam::scene::Material> + '_ {
        self.entries.iter().map(|(name, _)| &self.scene.material[*name])
    }

    /// Returns the coefficients of two entries; `None` for two walls, which have no contacts.
    pub fn coefficients(&self, first: usize, second: usize) -> Option<ContactCoefficients> {
        let ((a, a_wall), (b, b_wall)) = (self.entries[first], self.entries[second]);
        match (a_wall, b_wall) {
            (true, true) => None,
            (true, false) => Some(self.scene.contact_coefficients(b, a, true)),
            (false, wall) => Some(self.scene.contact_coefficients(a, b, wall)),
        }
    }
}

/// Tolerance of directions and positions, relative to one and to the radius of a cylinder.
const SLACK: f64 = 1e-9;

/// A surface without an end.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Primitive {
    /// Plane across an axis.
    Plane {
        /// Axis, 0 to 2.
        axis: usize,
        /// Position on the axis, m.
        at: f64,
    },
    /// Cylinder along an axis; grains are inside.
    Cylinder {
        /// Axis, 0 to 2.
        axis: usize,
        /// A point of the centre line, m.
        centre: [f64; 3],
        /// Radius, m.
        radius: f64,
        /// Angular velocity about the axis's positive direction, rad/s, from the start to the end.
        rate: f64,
    },
}

/// Returns the primitives of each wall of a scene; empty where a wall has none.
pub(super) fn primitives(scene: &MeasuredScene, grains: &[Grain]) -> Vec<Vec<Primitive>> {
    let closed = scene.wall.iter().filter_map(|wall| Tube::of(wall, scene, grains)).collect::<Vec<_>>();
    scene.wall.iter().map(|wall| of_wall(wall, &closed, scene, grains)).collect()
}

fn of_wall(wall: &Wall, closed: &[Tube], scene: &MeasuredScene, grains: &[Grain]) -> Vec<Primitive> {
    let planes = |faces: &[Face]| {
        let is_inside =
            |grain: &Grain| faces.iter().all(|face| face.inwards * (grain.position[face.axis] - face.at) > 0.0);
        let faces = faces.iter().filter(|_| grains.iter().all(is_inside));
        faces.map(|&Face { axis, at, .. }| Primitive::Plane { axis, at }).collect()
    };
    let plane = |point: &[f64; 3], normal: &[f64; 3]| match along(normal) {
        Some((axis, inwards)) => planes(&[Face { axis, inwards, at: point[axis] }]),
        None => Vec::new(),
    };
    let fixed = wall.motion == Motion::Fixed;
    match &wall.shape {
        Shape::Plane { point, normal } if fixed => plane(point, normal),
        Shape::Box { min, max, open } if fixed => planes(&closed_faces(min, max, open)),
        Shape::Cylinder { .. } => Tube::of(wall, scene, grains).map(Tube::primitive).into_iter().collect(),
        Shape::Disc { centre, normal, .. } if fixed && closed.iter().any(|tube| tube.has_lid(&wall.shape)) => {
            plane(centre, normal)
        }
        _ => Vec::new(),
    }
}

/// Names of the axes.
pub(super) const AXES: [&str; 3] = ["x", "y", "z"];

/// A face across an axis.
pub(super) struct Face {
    /// Axis, 0 to 2.
    pub axis: usize,
    /// 1 if grains are above it, -1 if they are below.
    pub inwards: f64,
    /// Position on the axis, m.
    pub at: f64,
}

/// Returns the faces of a box that are not open.
pub(super) fn closed_faces(min: &[f64; 3], max: &[f64; 3], open: &[String]) -> Vec<Face> {
    let ends = (0..3).flat_map(|axis| [(axis, "-", 1.0, min[axis]), (axis, "+", -1.0, max[axis])]);
    let closed = ends.filter(|(axis, end, ..)| !open.contains(&format!("{end}{}", AXES[*axis])));
    closed.map(|(axis, _, inwards, at)| Face { axis, inwards, at }).collect()
}

/// Returns the coordinate axis along which a direction lies, and its sign.
pub(super) fn along(direction: &[f64; 3]) -> Option<(usize, f64)> {
    let unit = Vector3::from(*direction).try_normalize(0.0)?;
    let axis = unit.iamax();
    let across = (0..3).filter(|&other| other != axis).all(|other| unit[other].abs() < SLACK);
    across.then(|| (axis, unit[axis].signum()))
}

/// Cylinder along a coordinate axis, closed at both ends, with all grains inside.
struct Tube {
    axis: usize,
    centre: [f64; 3],
    radius: f64,
    /// Positions of its ends on the axis.
    ends: [f64; 2],
    rate: f64,
}

impl Tube {
    /// Converts a wall, if it is such a cylinder.
    fn of(wall: &Wall, scene: &MeasuredScene, grains: &[Grain]) -> Option<Tube> {
        let Shape::Cylinder { base, axis: direction, radius, length } = &wall.shape else { return None };
        let (axis, sign) = along(direction)?;
        let (one, other) = (base[axis], base[axis] + sign * length);
        let rate = Tube::rate(&wall.motion, axis, base, scene.duration)?;
        let tube = Tube { axis, centre: *base, radius: *radius, ends: [one.min(other), one.max(other)], rate };
        let limits = reach(&scene.domain);
        let beyond = [tube.ends[0] <= limits.min[axis], tube.ends[1] >= limits.max[axis]];
        let is_closed = |end: usize| beyond[end] || scene.wall.iter().any(|wall| tube.is_closed_by(wall, end));
        (grains.iter().all(|grain| tube.holds(grain.position)) && is_closed(0) && is_closed(1)).then_some(tube)
    }

    /// Returns the angular velocity of a cylinder that does not move and turns all the time or not at all.
    fn rate(motion: &Motion, axis: usize, base: &[f64; 3], duration: f64) -> Option<f64> {
        match motion {
            Motion::Fixed => Some(0.0),
            Motion::Rotating { point, axis: direction, rate, start, stop, reverse } => {
                let (about, sign) = along(direction)?;
                let own = about == axis && (0..3).all(|at| at == axis || (point[at] - base[at]).abs() < SLACK);
                let lasts = |until: &Option<f64>| until.is_none_or(|until| until >= duration);
                (own && *start <= 0.0 && lasts(stop) && lasts(reverse)).then_some(sign * rate)
            }
            _ => None,
        }
    }

    fn holds(&self, position: [f64; 3]) -> bool {
        let across = |at: usize| if at == self.axis { 0.0 } else { position[at] - self.centre[at] };
        let along = position[self.axis];
        (0..3).map(|at| across(at).powi(2)).sum::<f64>() < self.radius * self.radius
            && self.ends[0] < along
            && along < self.ends[1]
    }

    fn is_central(&self, point: &[f64; 3]) -> bool {
        (0..3).all(|at| at == self.axis || (point[at] - self.centre[at]).abs() <= SLACK * self.radius)
    }

    /// Returns true if a disc covers the cross-section, at one of the ends or between them.
    fn has_lid(&self, shape: &Shape) -> bool {
        let Shape::Disc { centre, normal, radius, hole } = shape else { return false };
        let slack = SLACK * self.radius;
        let centred = self.is_central(centre);
        let within = self.ends[0] - slack <= centre[self.axis] && centre[self.axis] <= self.ends[1] + slack;
        along(normal).is_some_and(|(axis, _)| axis == self.axis)
            && *hole == 0.0
            && centred
            && within
            && *radius >= self.radius - slack
    }

    /// Returns true if a wall that does not move closes an end, 0 the lower one.
    fn is_closed_by(&self, wall: &Wall, end: usize) -> bool {
        let inwards = [1.0, -1.0][end];
        let faces = |normal: &[f64; 3]| along(normal) == Some((self.axis, inwards));
        // Between the end and the middle, so that the cylinder extends at least as far as the lid.
        let before = |at: f64| inwards * (at - self.ends[end]) >= -SLACK * self.radius;
        match (&wall.shape, &wall.motion) {
            (Shape::Disc { normal, .. }, Motion::Fixed) => faces(normal) && self.has_lid(&wall.shape),
            (Shape::Disc { normal, .. }, Motion::Rotating { point, axis, .. }) => {
                let about_own = along(axis).is_some_and(|(about, _)| about == self.axis) && self.is_central(point);
                faces(normal) && self.has_lid(&wall.shape) && about_own
            }
            (Shape::Plane { point, normal }, Motion::Fixed) => faces(normal) && before(point[self.axis]),
            _ => false,
        }
    }

    fn primitive(self) -> Primitive {
        Primitive::Cylinder { axis: self.axis, centre: self.centre, radius: self.radius, rate: self.rate }
    }
}

/// Text of a file: enough digits to decide on which side of a face a grain lies.
pub(super) fn stl(mesh: &Mesh) -> String {
    let mut text = String::from("solid wall\n");
    for [a, b, c] in &mesh.triangles {
        let (p, q, r) = (Vector3::from(*a), Vector3::from(*b), Vector3::from(*c));
        let normal = (q - p).cross(&(r - p)).normalize();
        let _ = writeln!(text, "facet normal {} {} {}\nouter loop", normal.x, normal.y, normal.z);
        for [x, y, z] in [a, b, c] {
            let _ = writeln!(text, "vertex {x:.12e} {y:.12e} {z:.12e}");
        }
        text += "endloop\nendfacet\n";
    }
    text + "endsolid wall\n"
}
