//! Discharge: the mass that passes through the hole of a disc, such as the floor of a silo, and its rate.
//!
//! Grains with centres below the disc at its present pose have passed, unless they came over its outer edge. Without
//! gravity across the disc, "below" is the side opposite to its normal. No grain passes the edge if a shell adjoins the disc.
//! Elsewhere a grain has passed through the hole
//!
//! - if it lies within the outer edge both in the last frame above and in the first frame below;
//! - or if the straight path between these positions crosses the disc nearer to the rim of the hole than to the outer edge. The path must be
//!   shorter than half the distance between the two, or else nothing is measured.
//!
//! Grains below the disc in the first frame count as passed, since their path is unknown.
//!
//! In a scene with sinks (`[[remove]]`), the mass is that of the grains that have gone into them, which frames state.
//!
//! Grains are identified by their lasting numbers: a grain that passed and was deleted later has passed. If a grain disappears without having
//! been below in the previous frame, the passed mass is unknown, and nothing is measured. The rate is the mass passed between the first
//! and the last frame over the time between them; its standard error is over blocks of time.

use super::catalogue::{Group, define, nothing_of_a_frame};
use super::frames::Frames;
use super::measurement::Measurement;
use super::setting::{Properties, Setting};
use super::walls::PlacedWalls;
use crate::statistics::{block_count, standard_error};
use makadam::scene::{Shape, Wall};
use makadam::snapshot::Snapshot;
use makadam_frames::plan::{MeasuredScene, Observable, lasting_number};
use nalgebra::Vector3;
use std::collections::HashMap;

pub(super) const GROUP: Group = Group {
    observable: Observable::Discharge,
    name: "discharge",
    read: nothing_of_a_frame,
    definitions: &[
        define(
            ["mass_flow_rate", "W", "kg/s"],
            "(m(t_n) − m(t_1)) / (t_n − t_1) of the discharged mass m over the measured frames; standard error over \
             blocks of time",
        )
        .of_span(),
        define(
            ["discharged_mass", "m", "kg"],
            "mass that has gone into the sinks by the last measured frame. Without sinks, mass that has passed the hole \
             of the first disc with one, with grains deleted since. It consists of the grains below the disc at the first measured frame and those that came \
             through the hole, not over the outer edge. Not measured where a grain was deleted above the disc, or \
             where frames are too far apart to distinguish hole and edge",
        )
        .of_span(),
    ],
};

/// Smallest component of gravity across a disc, over its magnitude, that defines a side below the disc.
const ACROSS: f64 = 1e-6;

/// Sine of an angle, and fraction of a disc's radius, within which a shell adjoins it.
const ROUNDING: f64 = 1e-6;

/// Disc with a hole: its middle and its unit normal in the scene, and the radii of its edges.
struct Outlet {
    wall: usize,
    point: Vector3<f64>,
    normal: Vector3<f64>,
    hole: f64,
    radius: f64,
    /// True if a shell adjoins the disc.
    closed: bool,
}

/// Outlet in a frame: a point, and the unit normal towards the grains that have not passed.
struct PlacedOutlet {
    point: Vector3<f64>,
    normal: Vector3<f64>,
    /// True if the scene's normal points to this side.
    as_placed: bool,
}

impl Outlet {
    /// Returns the scene's first disc with a hole; `None` without such a disc.
    fn find(scene: &MeasuredScene) -> Option<Outlet> {
        scene.wall.iter().enumerate().find_map(|(wall, known)| match &known.shape {
            Shape::Disc { centre, normal, hole, radius } if *hole > 0.0 => {
                let (point, normal) = (Vector3::from(*centre), Vector3::from(*normal).normalize());
                let outlet = Outlet { wall, point, normal, hole: *hole, radius: *radius, closed: false };
                let closed = scene.wall.iter().any(|shell| shell.motion == known.motion && outlet.carries(shell));
                Some(Outlet { closed, ..outlet })
            }
            _ => None,
        })
    }

    /// Returns true if a wall is a shell about the disc's axis that adjoins its ring or crosses it.
    fn carries(&self, wall: &Wall) -> bool {
        let Shape::Cylinder { base, axis, radius, length } = &wall.shape else { return false };
        let (axis, arm) = (Vector3::from(*axis).normalize(), self.point - Vector3::from(*base));
        let slack = ROUNDING * self.radius;
        axis.cross(&self.normal).norm() <= ROUNDING
            && arm.cross(&axis).norm() <= slack
            && (-slack..=length + slack).contains(&arm.dot(&axis))
            && (self.hole..=self.radius + slack).contains(radius)
    }

    fn at(&self, setting: &Setting<'_>, frame: &Snapshot) -> PlacedOutlet {
        let walls = PlacedWalls::at(setting.scene(), frame);
        let point = walls.point_of(self.wall, &self.point);
        let normal = walls.point_of(self.wall, &(self.point + self.normal)) - point;
        let as_placed = setting.up.map_or(0.0, |up| up.dot(&normal)) >= -ACROSS;
        PlacedOutlet { point, normal: if as_placed { normal } else { -normal }, as_placed }
    }
}

impl PlacedOutlet {
    /// Returns the height of a position over the disc, and its component across the axis, m.
    fn place(&self, place: [f64; 3]) -> (f64, Vector3<f64>) {
        let arm = Vector3::from(place) - self.point;
        let height = arm.dot(&self.normal);
        (height, arm - self.normal * height)
    }
}

/// State of a grain in the frames so far.
struct Known {
    mass: f64,
    /// Number of the last frame with the grain, and its position over the outlet and across its axis there, m.
    last: usize,
    place: (f64, Vector3<f64>),
    way: Way,
}

/// Path of a grain past the disc.
#[derive(Clone, Copy, PartialEq)]
enum Way {
    NotYet,
    ThroughHole,
    OverEdge,
}

impl Outlet {
    /// Returns the path of a grain between two positions; `None` if the positions do not determine it.
    fn way(&self, from: Option<&Known>, to: (f64, Vector3<f64>)) -> Option<Way> {
        let Some(from) = from.filter(|_| to.0 < 0.0) else {
            return Some(if to.0 < 0.0 { Way::ThroughHole } else { Way::NotYet });
        };
        if from.way != Way::NotYet {
            return Some(from.way);
        }
        let (above, start) = from.place;
        if self.closed || start.norm().max(to.1.norm()) < self.radius {
            return Some(Way::ThroughHole);
        }
        let (fall, along) = (above - to.0, to.1 - start);
        let crossing = (start + along * (above / fall)).norm();
        let is_at_hole = crossing < 0.5 * (self.hole + self.radius);
        let is_told = fall.hypot(along.norm()) < 0.5 * (self.radius - self.hole);
        is_told.then_some(if is_at_hole { Way::ThroughHole } else { Way::OverEdge })
    }
}

/// Measures mass and rate; empty without sinks and without a disc with a hole, and no rate for a single frame. The inner error is the reason for no result.
pub fn measure<F: Frames + ?Sized>(
    properties: &Properties<'_>,
    frames: &F,
) -> Result<Result<Vec<Measurement>, String>, F::Error> {
    if !properties.scene.remove.is_empty() {
        let mut passed = Vec::new();
        frames.visit_grains(0..frames.count(), &mut |frame| passed.push([frame.time, frame.passed[1].mass]))?;
        return Ok(Ok(measurements(&passed)));
    }
    let Some(outlet) = Outlet::find(&properties.scene) else { return Ok(Ok(Vec::new())) };
    let mut grains: HashMap<u64, Known> = HashMap::new();
    let mut passed: Vec<[f64; 2]> = Vec::new();
    let mut side = None;
    let mut refused = None;
    frames.visit_grains(0..frames.count(), &mut |frame| {
        let setting = Setting::new(properties, frame);
        let (placed, number) = (outlet.at(&setting, frame), passed.len());
        if *side.get_or_insert(placed.as_placed) != placed.as_placed {
            refused.get_or_insert_with(|| format!("gravity turns to the other side of the disc by {} s", frame.time));
        }
        for grain in &frame.particles {
            let (lasting, place) = (lasting_number(frame, grain.id), placed.place(grain.position));
            let way = outlet.way(grains.get(&lasting), place).unwrap_or_else(|| {
                refused.get_or_insert_with(|| {
                    format!(
                        "grain {lasting} is below the disc by {} s, and frames are too far apart to tell whether it went through the hole or \
                         over the outer edge: measure.interval or that of the frames has to be shorter",
                        frame.time
                    )
                });
                Way::NotYet
            });
            grains.insert(lasting, Known { mass: setting.mass(frame, grain), last: number, place, way });
        }
        // In the order of grain numbers, so that a sum has the same bits in every run.
        let mut beyond: Vec<(u64, f64)> = Vec::new();
        for (&grain, known) in &grains {
            match known.way {
                Way::ThroughHole => beyond.push((grain, known.mass)),
                Way::NotYet if known.last < number => {
                    refused.get_or_insert_with(|| {
                        let time = frame.time;
                        format!("grain {grain} is gone by {time} s, and had not passed the disc in the frame before")
                    });
                }
                Way::NotYet | Way::OverEdge => {}
            }
        }
        beyond.sort_unstable_by_key(|(grain, _)| *grain);
        passed.push([frame.time, beyond.iter().map(|(_, mass)| mass).sum()]);
    })?;
    if let Some(why) = refused {
        return Ok(Err(why));
    }
    Ok(Ok(measurements(&passed)))
}

/// Returns the observables from the times (s) of the frames and the masses (kg) that have passed by then.
fn measurements(passed: &[[f64; 2]]) -> Vec<Measurement> {
    let mut measurements = Vec::new();
    if let Some(rate) = rate(passed) {
        measurements.push(Measurement::of("mass_flow_rate", rate, error_of_rate(passed), passed.len()));
    }
    if let Some([_, mass]) = passed.last() {
        measurements.push(Measurement::of("discharged_mass", *mass, None, passed.len()));
    }
    measurements
}

/// Returns the mass over the time between the first and the last point, kg/s; points between may have any times.
pub(super) fn rate(passed: &[[f64; 2]]) -> Option<f64> {
    let ([start, before], [end, after]) = (passed.first()?, passed.last()?);
    (end > start).then(|| (after - before) / (end - start))
}

/// Returns the standard error of the rate over consecutive blocks, kg/s.
pub(super) fn error_of_rate(passed: &[[f64; 2]]) -> Option<f64> {
    let gaps = passed.len().saturating_sub(1);
    let blocks = block_count(gaps)?;
    let part = |block: usize| &passed[block * gaps / blocks..=(block + 1) * gaps / blocks];
    let rates: Option<Vec<f64>> = (0..blocks).map(|block| rate(part(block))).collect();
    standard_error(&rates?)
}

#[cfg(test)]
#[path = "../../tests/unit/observables_discharge.rs"]
mod tests;
