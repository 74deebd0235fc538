//! Columns of grains in a tube that is lifted off.

use super::super::{Case, DIAMETER, SPREAD, grains_of};
use super::law;
use crate::sketch::{GRAVITY, SPACING, Sketch};
use makadam::scene::{Motion, Reaction, Region, Shape};
use makadam_frames::plan::MeasuredScene;
use std::f64::consts::{PI, SQRT_2};

/// Friction of the grains: that of sand and glass.
const FRICTION: f64 = 0.5;
/// Rolling friction of the grains, which models the angularity: a [`heap`] of them has the angle of repose of sand. With
/// 0.1 the angle is that of rounded grains.
const ROLLING_FRICTION: f64 = 0.3;
/// Friction and rolling friction of the plane: single grains on a base of glued grains stay at rest on slopes of up to about 25
/// degrees, half the normal force.
const BASE: [f64; 2] = [1.0, 0.5];
/// Speed of the tube over `sqrt(g h0)`.
const LIFT: f64 = 5.0;
/// Speed of the tube, m/s, that leaves a heap, and time until all grains are at rest, s.
const HEAP: (f64, f64) = (0.05, 1.0);
/// Time step, s, and sweeps per step.
const SOLVE: (f64, u32) = (5e-4, 10);
/// Solid fraction for the number of grains.
const SOLID: f64 = 0.6;
/// Longest time until rest, over `sqrt(h0/g)`.
const PATIENCE: f64 = 12.0;

/// Simulated part of a column.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Part {
    Whole,
    /// Quarter between the planes x = 0 and y = 0, which are smooth and without friction, as planes of symmetry are.
    Quarter,
}

impl Part {
    pub(super) fn share(self) -> f64 {
        match self {
            Part::Whole => 1.0,
            Part::Quarter => 0.25,
        }
    }

    pub(super) fn of(case: &Case) -> Part {
        if case.of("share") < 1.0 { Part::Quarter } else { Part::Whole }
    }
}

/// Returns a column of the given radius in diameters.
pub(super) fn case(radius_in_diameters: f64, aspect: f64, part: Part) -> Case {
    let radius = radius_in_diameters * DIAMETER;
    let height = aspect * radius;
    let (suffix, words) = match part {
        Part::Whole => ("", "A column"),
        Part::Quarter => ("-quarter", "A quarter of a column"),
    };
    let release = release(height);
    let until = release + PATIENCE * (height / GRAVITY).sqrt();
    let mut scene =
        lifted([radius, height], part, LIFT * (GRAVITY * height).sqrt(), radius * (1.0 + 2.5 * law(aspect)), until);
    scene.name = format!("collapse-{aspect}-r{radius_in_diameters}{suffix}");
    scene.description = format!("{words} of aspect ratio {aspect} on a rough plane, whose tube is lifted off.");
    let given = [("radius", radius), ("nominal_aspect", aspect), ("release", release), ("share", part.share())];
    Case::new(scene, given)
}

/// Returns a heap for the angle of repose, from a tube of eight diameters in radius, filled to four times that and lifted slowly.
pub(super) fn heap() -> Case {
    let radius = 8.0 * DIAMETER;
    let height = 4.0 * radius;
    let until = release(height) + height / HEAP.0 + HEAP.1;
    let mut scene = lifted([radius, height], Part::Whole, HEAP.0, 5.0 * radius, until);
    scene.name = "heap".into();
    scene.description = "The grains of the collapsing columns, as a heap.".into();
    Case::new(scene, [])
}

/// Time at which a tube filled to a height (m) begins to rise, s.
fn release(height: f64) -> f64 {
    0.4 + 2.5 * (2.0 * height / GRAVITY).sqrt()
}

/// Returns a tube of some radius, filled to some height (m), that is lifted off at a speed (m/s); the plane under it has the
/// given extent (m).
fn lifted([radius, height]: [f64; 2], part: Part, lift: f64, reach: f64, until: f64) -> MeasuredScene {
    let grain = 0.5 * DIAMETER;
    let count = grains_of(part.share() * SOLID * PI * radius * radius * height);
    // The initial lattice of the grains is less than half as dense as the column.
    let room = 3.0 * height + 10.0 * DIAMETER;
    let tube = Motion::Translating { velocity: [0.0, 0.0, lift], start: release(height), stop: None };
    let up = [0.0, 0.0, 1.0];
    let (low, populations) = match part {
        Part::Whole => (-reach, vec![(count, Region::Cylinder { base: [0.0; 3], axis: up, radius, length: room })]),
        Part::Quarter => (-DIAMETER, strips(radius, room, count)),
    };
    let mut sketch = Sketch::new("lifted", until)
        .domain([low, low, -DIAMETER], [reach, reach, room])
        .step(SOLVE.0)
        .sweeps(SOLVE.1)
        .interval(0.05)
        .material("plate", |plate| [plate.friction, plate.rolling_friction] = BASE)
        .moving_wall(
            Shape::Cylinder { base: [0.0, 0.0, -2.0 * DIAMETER], axis: up, radius, length: room + 4.0 * DIAMETER },
            tube,
        )
        // Single grains may roll away.
        .with(|scene| scene.watch.on_escape = Reaction::Ignore)
        // The tube slides off without friction on the grains.
        .change_material("wall", |wall| wall.friction = 0.0)
        .change_material("grain", |grain| (grain.friction, grain.rolling_friction) = (FRICTION, ROLLING_FRICTION))
        .named_wall("plate", "plate", Shape::Plane { point: [0.0; 3], normal: up }, Motion::Fixed);
    for (count, region) in populations {
        sketch = sketch.polydisperse(count, [grain, SPREAD], region, 0.05);
    }
    if part == Part::Quarter {
        sketch = sketch.plane([0.0; 3], [1.0, 0.0, 0.0]).plane([0.0; 3], [0.0, 1.0, 0.0]);
    }
    sketch.scene()
}

/// Quarter of a tube as boxes, each one lattice site wide along x and as long along y as the tube allows, and the number of
/// grains in each: the same number of layers everywhere.
fn strips(radius: f64, room: f64, count: usize) -> Vec<(usize, Region)> {
    let largest = 0.5 * DIAMETER * (1.0 + SPREAD);
    let pitch = 2.0 * largest * SPACING;
    let jitter = 0.5 * pitch - largest;
    // A grain's site may be displaced along a diagonal.
    let arm = radius - largest - jitter * SQRT_2;
    // Slightly wider than a site, so that rounding leaves one site.
    let width = pitch * (1.0 + 1e-6);
    let middles = (0..).map(|number| (f64::from(number) + 0.5) * width).take_while(|x| *x < arm);
    let lengths = middles.map(|x| (x, (arm * arm - x * x).sqrt())).filter(|(_, y)| *y >= 0.5 * pitch);
    let strips: Vec<(f64, f64, usize)> =
        lengths.map(|(x, y)| (x, y, ((y - 0.5 * pitch) / pitch + 1e-9).floor() as usize + 1)).collect();
    let sites: usize = strips.iter().map(|(.., sites)| sites).sum();
    let (mut before, mut placed) = (0, 0);
    let mut regions = Vec::new();
    for (x, y, own) in strips {
        before += own;
        // Rounding the cumulative number preserves the sum.
        let until = (count * before + sites / 2) / sites;
        let region = Region::Box { min: [x - 0.5 * width, 0.0, 0.0], max: [x + 0.5 * width, y + 0.5 * pitch, room] };
        regions.push((until - placed, region));
        placed = until;
    }
    regions
}

#[cfg(test)]
#[path = "../../../tests/unit/laws_collapse_column.rs"]
mod tests;
