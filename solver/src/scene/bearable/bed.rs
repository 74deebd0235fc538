//! How far the grains of a start fall until they lie on a bed.

use super::ray::{Ray, stays};
use crate::scene::{Grain, Scene};
use nalgebra::Vector3;
use std::collections::HashMap;

/// Solid fraction of a bed.
const FRACTION: f64 = 0.6;
/// Sides of a column that the bed is looked at in, over the largest radius.
const COLUMN: f64 = 4.0;
/// Grains beneath that a listed grain is held against, column by column.
const NEAREST: usize = 32;

/// Where a grain goes if gravity alone moves it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Fall {
    /// Gravity does not pull it, or not always in one direction.
    Unknown,
    /// It comes to lie on the bed after so many metres.
    Down(f64),
    /// Nothing is beneath it up to the domain's end, so many metres away; whether a moving wall gets there is not known.
    Out(f64),
}

/// The start, as gravity will have it.
pub(super) struct Bed {
    /// Of every grain.
    pub falls: Vec<Fall>,
    /// Depth of the deepest column, solid volume over area, m.
    pub solid_depth: f64,
    /// Magnitude of gravity, m/s2; zero where it changes.
    pub gravity: f64,
    /// Whether all walls are where they are placed, but for vibrations.
    pub walls_stay: bool,
}

impl Bed {
    pub fn new(scene: &Scene, grains: &[Grain]) -> Bed {
        let gravity = Vector3::from(scene.gravity);
        let walls_stay = scene.wall.iter().all(stays);
        if gravity.norm() < 1e-12 || !scene.gravity_changes.is_empty() || grains.is_empty() {
            let falls = vec![Fall::Unknown; grains.len()];
            return Bed { falls, solid_depth: 0.0, gravity: 0.0, walls_stay };
        }
        let down = gravity.normalize();
        let period = scene.domain.period();
        let side = COLUMN * grains.iter().map(|grain| grain.radius).fold(0.0, f64::max);
        let [first, second] = across(&down);
        let heights: Vec<f64> = grains.iter().map(|grain| -down.dot(&Vector3::from(grain.position))).collect();
        let mut order: Vec<usize> = (0..grains.len()).collect();
        order.sort_by(|&a, &b| heights[a].total_cmp(&heights[b]));
        let mut columns: HashMap<(i64, i64), Column> = HashMap::new();
        let mut bed =
            Bed { falls: vec![Fall::Unknown; grains.len()], solid_depth: 0.0, gravity: gravity.norm(), walls_stay };
        let listed = scene.grain.len();
        for index in order {
            let grain = &grains[index];
            let centre = Vector3::from(grain.position);
            let ray = Ray { centre, along: down, radius: grain.radius };
            let to_end = ray.to_end(scene, &period);
            let to_wall = ray.to_wall(scene, &period).filter(|distance| *distance <= to_end);
            let at = [centre.dot(&first), centre.dot(&second)];
            let cell = ((at[0] / side).floor() as i64, (at[1] / side).floor() as i64);
            let resting = (index < listed)
                .then(|| resting_on(grains, &heights, &columns, &bed.falls, (index, at, cell), [&first, &second]))
                .flatten();
            let column = columns.entry(cell).or_default();
            let solid = column.solid / (side * side);
            bed.falls[index] = match (to_wall, resting) {
                (Some(distance), resting) => {
                    let settled = (distance - solid / FRACTION).max(0.0);
                    Fall::Down(resting.map_or(settled, |fall| fall.min(settled)))
                }
                (None, Some(fall)) => Fall::Down(fall),
                (None, None) => Fall::Out(to_end),
            };
            if to_wall.is_some() {
                let volume = 4.0 / 3.0 * std::f64::consts::PI * grain.radius.powi(3);
                column.solid += volume;
                bed.solid_depth = bed.solid_depth.max((column.solid) / (side * side));
            }
            if index < listed {
                column.listed.push(index);
            }
        }
        bed
    }
}

#[derive(Default)]
struct Column {
    /// Volume of the grains so far, m3.
    solid: f64,
    /// Listed grains, from below.
    listed: Vec<usize>,
}

/// How far a listed grain falls until it is on a listed one beneath it, where that one comes to rest, m.
fn resting_on(
    grains: &[Grain],
    heights: &[f64],
    columns: &HashMap<(i64, i64), Column>,
    falls: &[Fall],
    (index, at, (i, j)): (usize, [f64; 2], (i64, i64)),
    [first, second]: [&Vector3<f64>; 2],
) -> Option<f64> {
    let around = (-1..=1).flat_map(|di| (-1..=1).map(move |dj| (i + di, j + dj)));
    let beneath =
        around.filter_map(|cell| columns.get(&cell)).flat_map(|column| column.listed.iter().rev().take(NEAREST));
    let gaps = beneath.filter_map(|&other| {
        let centre = Vector3::from(grains[other].position);
        let aside = (centre.dot(first) - at[0]).hypot(centre.dot(second) - at[1]);
        let touch = grains[index].radius + grains[other].radius;
        match falls[other] {
            Fall::Down(fall) if aside < touch => {
                let height = heights[index] - heights[other] - (touch * touch - aside * aside).sqrt();
                Some(height.max(0.0) + fall)
            }
            _ => None,
        }
    });
    gaps.min_by(f64::total_cmp)
}

/// Two directions across one.
fn across(along: &Vector3<f64>) -> [Vector3<f64>; 2] {
    let least = along.iamin();
    let first = along.cross(&Vector3::ith(least, 1.0)).normalize();
    [first, along.cross(&first)]
}
