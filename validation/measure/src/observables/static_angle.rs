//! Static angle of repose: the inclination of a heap's flank.
//!
//! The solid fraction is averaged over azimuth, in cells of one mean radius by one mean radius in (r, z) about the
//! heap's axis, from the foot upwards. The axis is the common axis of the upright discharge tubes, or without tubes the median of the grains.
//! The foot is the highest level plane or disc at the axis below the median height of the grains, or else the lowest grain. The outline is the
//! contour at half the heap's mean solid fraction; a grain that rolled away fills so little of its ring that it stays outside. The
//! line is fitted by total least squares to the outline between 20% and 80% of the heap's height. Vertical or
//! overhanging flanks are supported by a wall, and have no angle of repose. The standard error
//! is over six sectors of azimuth, measured one by one: unlike a flow, a heap at rest has no blocks of time.

use super::catalogue::{Group, define, nothing_of_a_frame};
use super::contour::{self, Loop, Segment};
use super::effort;
use super::field::{Field, mean_within};
use super::frames::Frames;
use super::line::{Line, clip};
use super::measurement::Measurement;
use super::setting::Setting;
use super::walls::PlacedWalls;
use crate::statistics::{ranked, standard_error};
use makadam::scene::Shape;
use makadam::snapshot::Snapshot;
use makadam_frames::plan::Observable;
use nalgebra::Vector3;
use std::f64::consts::TAU;

pub(super) const GROUP: Group = Group {
    observable: Observable::StaticAngleOfRepose,
    name: "static-angle-of-repose",
    read: nothing_of_a_frame,
    definitions: &[
        define(
            ["static_angle_of_repose", "α", "degree"],
            "inclination of the total-least-squares line through the outline of the heap, averaged over azimuth, \
             between 20% and 80% of its height; standard error over six sectors",
        )
        .of_span(),
        define(
            ["heap_height", "H", "m"],
            "height of the outline of the heap above its foot: the highest level plane or disc below the median \
             height of the grains, else the lowest grain",
        )
        .of_span(),
    ],
};

/// Sectors of azimuth for the standard error.
const SECTORS: usize = 6;

/// Smallest angle of a flank supported by a wall, degrees.
const UPRIGHT: f64 = 80.0;

/// Cosine of the largest angle of a level wall or an upright tube.
const LEVEL: f64 = 0.999;

/// Tolerance of the common axis of upright tubes, in mean diameters.
const SAME_AXIS: f64 = 0.01;

/// Sampling points per diameter for the volume of a grain over rings.
const POINTS: usize = 8;

/// Axis and foot of a heap.
#[derive(Clone, Copy)]
pub struct HeapFrame {
    origin: Vector3<f64>,
    across: [Vector3<f64>; 2],
    up: Vector3<f64>,
}

impl HeapFrame {
    /// Finds the axis.
    ///
    /// # Errors
    /// Message without gravity, and for upright tubes without a common axis: several tubes side by side, or one moved sideways.
    pub fn new(setting: &Setting<'_>, frame: &Snapshot) -> Result<Self, String> {
        let up = setting.up.ok_or("there is no gravity")?;
        let helper = Vector3::ith(up.iamin(), 1.0);
        let first = up.cross(&helper).normalize();
        let across = [first, up.cross(&first)];
        let (walls, scene) = (PlacedWalls::at(setting.scene(), frame), setting.scene());
        // A point of a wall and a direction, transformed by its motion.
        let placed = |wall: usize, point: &[f64; 3], along: &[f64; 3]| {
            let (point, along) = (Vector3::from(*point), Vector3::from(*along).normalize());
            let start = walls.point_of(wall, &point);
            (start, walls.point_of(wall, &(point + along)) - start)
        };
        // Tubes at their present pose and at their pose in the scene.
        let tubes = scene.wall.iter().enumerate().filter_map(|(number, wall)| match &wall.shape {
            Shape::Cylinder { base, axis, .. } => {
                let (place, axis) = placed(number, base, axis);
                (axis.dot(&up).abs() > LEVEL).then(|| [(&wall.name, place), (&wall.name, Vector3::from(*base))])
            }
            _ => None,
        });
        let tubes: Vec<(&String, Vector3<f64>)> = tubes.flatten().collect();
        let beside = |place: &Vector3<f64>| {
            let arm = place - tubes[0].1;
            (arm - up * arm.dot(&up)).norm() > SAME_AXIS * setting.diameter
        };
        if let Some((name, _)) = tubes.iter().find(|(_, place)| beside(place)) {
            return Err(match *name == tubes[0].0 {
                true => format!("the upright cylinder '{name}' has moved sideways, and gives the heap no axis"),
                false => format!("the upright cylinders '{}' and '{name}' give the heap different axes", tubes[0].0),
            });
        }
        let median = || across.iter().map(|axis| axis * median_along(frame, axis)).sum();
        let middle = tubes.first().map_or_else(median, |(_, place)| *place);
        let from_axis = |point: &Vector3<f64>| across.map(|axis| (point - middle).dot(&axis));
        let floors = scene.wall.iter().enumerate().filter_map(|(number, wall)| match &wall.shape {
            Shape::Plane { point, normal } => {
                let (point, normal) = placed(number, point, normal);
                (normal.dot(&up) > LEVEL).then(|| point.dot(&up))
            }
            Shape::Disc { centre, normal, radius, hole } => {
                let (centre, normal) = placed(number, centre, normal);
                let [x, y] = from_axis(&centre);
                let is_beneath = (*hole..=*radius).contains(&x.hypot(y));
                (normal.dot(&up).abs() > LEVEL && is_beneath).then(|| centre.dot(&up))
            }
            _ => None,
        });
        let half_up = median_along(frame, &up);
        let floor = floors.filter(|height| *height < half_up).reduce(f64::max);
        let lowest = || {
            let bottoms = frame.particles.iter().map(|grain| Vector3::from(grain.position).dot(&up) - grain.radius);
            bottoms.fold(f64::INFINITY, f64::min)
        };
        let origin = middle - up * middle.dot(&up) + up * floor.unwrap_or_else(lowest);
        Ok(Self { origin, across, up })
    }

    /// Returns the distance from the axis and the height above the floor, m.
    pub fn meridian(&self, point: &Vector3<f64>) -> [f64; 2] {
        let arm = point - self.origin;
        [arm.dot(&self.across[0]).hypot(arm.dot(&self.across[1])), arm.dot(&self.up)]
    }

    fn sector(&self, point: &Vector3<f64>) -> usize {
        let arm = point - self.origin;
        let turn = arm.dot(&self.across[1]).atan2(arm.dot(&self.across[0])) / TAU + 0.5;
        ((turn * SECTORS as f64) as usize).min(SECTORS - 1)
    }
}

/// Returns the median of the grains' centres along an axis, m; 0 without grains.
fn median_along(frame: &Snapshot, axis: &Vector3<f64>) -> f64 {
    let mut places: Vec<f64> = frame.particles.iter().map(|grain| Vector3::from(grain.position).dot(axis)).collect();
    places.sort_by(f64::total_cmp);
    let at = |place: usize| places.get(place).copied().unwrap_or(0.0);
    f64::midpoint(at(places.len() / 2), at(places.len().saturating_sub(1) / 2))
}

/// Measures angle (degrees) and height (m) of a heap.
pub fn measure(setting: &Setting<'_>, fields: &HeapFields) -> Result<Vec<Measurement>, String> {
    let outline = fields.outline().ok_or("the grains form no heap")?;
    let angle = flank_angle(&outline, setting.diameter)
        .ok_or("the heap is lower or narrower than two mean diameters, or walls hold its flanks upright")?;
    let of_sector = |field: &Field| flank_angle(&self::outline(field)?, setting.diameter);
    let sectors: Vec<f64> = fields.sectors.iter().filter_map(of_sector).collect();
    Ok(vec![
        Measurement::of("static_angle_of_repose", angle, standard_error(&sectors), fields.frames),
        Measurement::of("heap_height", top(&outline), None, fields.frames),
    ])
}

/// Solid fraction of a heap in (r, z), averaged over frames, in each sector of azimuth.
pub struct HeapFields {
    /// Axis of the heap in the last frame.
    pub heap: HeapFrame,
    sectors: Vec<Field>,
    frames: usize,
}

impl HeapFields {
    /// Averages the frames, at least one. The inner error is the reason for no mean: the heap has no axis, or grains lie
    /// so far apart that the grid would need more cells than `effort::most`.
    pub fn new<F: Frames + ?Sized>(setting: &Setting<'_>, frames: &F) -> Result<Result<Self, String>, F::Error> {
        let (count, cell) = (frames.count(), 0.5 * setting.diameter);
        let mut heap = Err(String::new());
        frames.visit_grains(count - 1..count, &mut |last| heap = HeapFrame::new(setting, last))?;
        let heap = match heap {
            Ok(heap) => heap,
            Err(why) => return Ok(Err(why)),
        };
        // Nine tenths of the grains set the width; grains farther out are not part of the heap.
        let grains = frames.grains(0..count);
        let mut highest = 0.0_f64;
        let reach = ranked((grains * 9 / 10) as u64, |look| {
            frames.visit_grains(0..count, &mut |frame| {
                for grain in &frame.particles {
                    let [distance, up] = heap.meridian(&Vector3::from(grain.position));
                    highest = highest.max(up);
                    look(distance);
                }
            })
        })?;
        let (width, height) = (2.0 * reach + 4.0 * cell, highest + 4.0 * cell);
        // Mirrored at the axis, so that the axis is not taken for a surface. An even number of columns makes the axis a border.
        let half_width = (width / cell).ceil() * cell;
        let top = (height / cell).ceil() * cell;
        let Some(field) = Field::new([-half_width, 0.0], [half_width, top], cell, effort::most(grains)) else {
            return Ok(Err("grains lie too far apart".into()));
        };
        let mut fields = Self { heap, sectors: vec![field; SECTORS], frames: count };
        let ball = unit_ball();
        frames.visit_grains(0..count, &mut |frame| fields.add(frame, &ball))?;
        Ok(Ok(fields))
    }

    /// Adds the volumes of a frame's grains, spread over the points of a `ball`.
    fn add(&mut self, frame: &Snapshot, ball: &[Vector3<f64>]) {
        for grain in &frame.particles {
            let share = super::sphere_volume::sphere(grain.radius) / ball.len() as f64;
            for offset in ball {
                let point = Vector3::from(grain.position) + offset * grain.radius;
                let [distance, up] = self.heap.meridian(&point);
                let field = &mut self.sectors[self.heap.sector(&point)];
                let cell = field.cell;
                let (column, row) = ((distance / cell) as usize, ((up - field.origin[1]) / cell).floor());
                if column < field.columns / 2 && row >= 0.0 && (row as usize) < field.rows {
                    let ring = TAU / SECTORS as f64 * (column as f64 + 0.5) * cell * cell * cell;
                    let (middle, start) = (field.columns / 2, row as usize * field.columns);
                    let value = share / (ring * self.frames as f64);
                    field.values[start + middle + column] += value;
                    field.values[start + middle - 1 - column] += value;
                }
            }
        }
    }

    /// Returns the outline of the heap in (r, z), mirrored at the axis, m; averaged over the sectors of azimuth.
    pub fn outline(&self) -> Option<Loop> {
        let mut sum = self.sectors[0].clone();
        self.sectors[1..].iter().for_each(|field| sum.add(field));
        sum.scale(1.0 / self.sectors.len() as f64);
        outline(&sum)
    }
}

/// Returns evenly spread points in the unit ball.
fn unit_ball() -> Vec<Vector3<f64>> {
    let place = |index: usize| (2 * index + 1) as f64 / POINTS as f64 - 1.0;
    (0..POINTS.pow(3))
        .map(|n| Vector3::new(place(n % POINTS), place(n / POINTS % POINTS), place(n / POINTS / POINTS)))
        .filter(|point| point.norm() < 1.0)
        .collect()
}

/// Returns the contour at half the mean solid fraction of the heap.
fn outline(field: &Field) -> Option<Loop> {
    // Rings near the axis are small and noisy: weights by volume limit their influence.
    let weight = |column: usize| (column as f64 + 0.5 - 0.5 * field.columns as f64).abs();
    let bulk = mean_within(&field.values, |index| weight(index % field.columns));
    (bulk > 0.0).then(|| contour::outline(field, 0.5 * bulk))?
}

fn top(outline: &Loop) -> f64 {
    outline.iter().map(|point| point[1]).fold(0.0, f64::max)
}

/// Returns the inclination of the flank, degrees; `None` for a heap lower or narrower than two diameters, and for grains supported by a wall.
fn flank_angle(outline: &Loop, diameter: f64) -> Option<f64> {
    let height = top(outline);
    let width = outline.iter().map(|point| point[0]).fold(0.0, f64::max);
    if height < 2.0 * diameter || width < 2.0 * diameter {
        return None;
    }
    let right = contour::segments(outline).filter_map(|piece| clip(piece, |point| point[0], 0.0, f64::INFINITY));
    let flank: Vec<Segment> =
        right.filter_map(|piece| clip(piece, |point| point[1], 0.2 * height, 0.8 * height)).collect();
    let angle = -Line::fit(flank.into_iter())?.degrees();
    (0.0..UPRIGHT).contains(&angle).then_some(angle)
}

#[cfg(test)]
#[path = "../../tests/unit/observables_static_angle.rs"]
mod tests;
