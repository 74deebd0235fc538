//! Bed in a drum's cross-section: its solid fraction over time, its outline, its free surface.

use super::contour::{self, Loop, Segment};
use super::drum::Drum;
use super::effort;
use super::field::Field;
use super::frames::Frames;
use super::line::{Line, clip};
use super::setting::Setting;
use crate::statistics::block_count;
use makadam::snapshot::{Particle, Snapshot};
use nalgebra::Vector3;
use std::ops::Range;

/// Ratio of the circle's diameter to the drum's.
const CIRCLE_OVER_DRUM: f64 = 0.2;

/// Reason for a missing [`MeanField`].
pub const NO_MEAN_FIELD: &str = "grains are too small for the drum, or too unlike in size";

/// Free surface of the bed in the mean of all frames, and in the means of blocks of them.
#[derive(Default)]
pub struct BedSurfaces {
    /// Frames of each block of time; empty if there are too few frames for blocks.
    pub blocks: Vec<Range<usize>>,
    /// Surface in each block; absent if the bed has none.
    pub parts: Vec<Option<BedSurface>>,
    /// Surface in all frames; absent if the bed has none.
    pub whole: Option<BedSurface>,
}

impl BedSurfaces {
    /// Finds the surfaces in frames, at least one; `None` if a block has no [`MeanField`].
    pub fn new<F: Frames + ?Sized>(setting: &Setting<'_>, drum: &Drum, frames: &F) -> Result<Option<Self>, F::Error> {
        let all = frames.count();
        let mean_of = |range: Range<usize>| {
            let mut mean = MeanField::new(setting, drum, frames.grains(range.clone()));
            frames.visit_grains(range, &mut |frame| mean.add(frame)).map(|()| mean.finish())
        };
        let surface_of = |field: &Field| surface(setting, drum, &outline(field)?);
        let Some(count) = block_count(all) else {
            let found = |field: Field| Self { whole: surface_of(&field), ..Self::default() };
            return Ok(mean_of(0..all)?.map(found));
        };
        let border = |block: usize| block * all / count;
        let blocks: Vec<Range<usize>> = (0..count).map(|block| border(block)..border(block + 1)).collect();
        let (mut parts, mut whole) = (Vec::with_capacity(count), None);
        for block in &blocks {
            let Some(mut field) = mean_of(block.clone())? else { return Ok(None) };
            parts.push(surface_of(&field));
            field.scale(block.len() as f64 / all as f64);
            match &mut whole {
                None => whole = Some(field),
                Some(whole) => whole.add(&field),
            }
        }
        Ok(Some(Self { blocks, parts, whole: whole.as_ref().and_then(surface_of) }))
    }
}

/// Surface of the bed in the cross-section of a drum.
#[derive(Clone, Debug)]
pub struct BedSurface {
    /// Line fitted to the middle half of the free surface.
    pub line: Line,
    /// Angle of the fitted line, degrees.
    pub line_angle: f64,
    /// Angle of the line through the crossings with the circle, degrees.
    pub circle_angle: f64,
}

/// Solid fraction in the cross-section, averaged over frames and over a length of about one radius.
///
/// Cells are half a radius wide and smoothed once with weights 1, 2, 1. Cells of a radius without smoothing are as
/// noisy, but shift the surface towards their own lines: by half a degree at 12 degrees.
///
/// The mean is missing if the grains are so small relative to the drum, or some so large relative to the mean, that the work would exceed
/// [`effort::most`].
pub struct MeanField<'a> {
    drum: &'a Drum,
    /// Sums; absent after the work limit is exceeded.
    field: Option<Field>,
    /// Remaining number of cell updates.
    left: usize,
    /// Volume of a cell over the drum's length, m3.
    volume: f64,
    frames: u32,
}

impl<'a> MeanField<'a> {
    /// Begins the mean over frames with a total of `grains` grains.
    pub fn new(setting: &Setting<'_>, drum: &'a Drum, grains: usize) -> Self {
        let (reach, left) = (drum.radius, effort::most(grains));
        let field = Field::new([-reach; 2], [reach; 2], 0.25 * setting.diameter, left);
        let volume = field.as_ref().map_or(0.0, |field| field.cell * field.cell * drum.length);
        Self { drum, field, left, volume, frames: 0 }
    }

    /// Adds a frame.
    pub fn add(&mut self, frame: &Snapshot) {
        let Some(field) = &mut self.field else { return };
        let place = |grain: &Particle| (self.drum.section(&Vector3::from(grain.position)), grain.radius);
        let spheres: Vec<_> = frame.particles.iter().map(place).collect();
        let visits = spheres.iter().map(|(place, radius)| field.reached(*place, *radius));
        let left = self.left.checked_sub(visits.fold(0, usize::saturating_add));
        let is_large = |(_, radius): &_| effort::too_large(*radius, field.cell);
        let Some(left) = left.filter(|_| !spheres.iter().any(is_large)) else {
            self.field = None;
            return;
        };
        field.add_spheres(&spheres, self.volume);
        (self.left, self.frames) = (left, self.frames + 1);
    }

    /// Returns the mean.
    pub fn finish(self) -> Option<Field> {
        let mut field = self.field?;
        field.scale(1.0 / f64::from(self.frames.max(1)));
        field.smooth();
        Some(field)
    }
}

/// Returns the outline of the bed in a field, at half of its largest value; `None` without a bed.
pub fn outline(field: &Field) -> Option<Loop> {
    contour::outline(field, 0.5 * field.largest())
}

/// Returns the surface of a bed with this outline; `None` if the bed has no surface.
pub fn surface(setting: &Setting<'_>, drum: &Drum, outline: &Loop) -> Option<BedSurface> {
    let inside = drum.radius - 1.5 * setting.diameter;
    let free: Vec<Segment> =
        contour::segments(outline).filter(|[a, b]| a[0].hypot(a[1]) < inside && b[0].hypot(b[1]) < inside).collect();
    let mut line = Line::fit(free.iter().copied())?;
    // The middle half depends on the line, and the line on the middle half: a few iterations converge.
    for _ in 0..5 {
        let offset = line.above([0.0; 2]).abs();
        let half_chord = (drum.radius.powi(2) - offset.powi(2)).max(0.0).sqrt();
        let middle = Line { point: line.foot([0.0; 2]), ..line };
        let pieces = free
            .iter()
            .filter_map(|piece| clip(*piece, |point| middle.along(point), -0.5 * half_chord, 0.5 * half_chord));
        line = Line::fit(pieces)?;
    }
    let centre = line.foot([0.0; 2]);
    let crossings = circle_crossings(outline, centre, 0.5 * CIRCLE_OVER_DRUM * 2.0 * drum.radius);
    // A bubble or a splash may cross the circle as well: take the crossing nearest to the line on either side.
    let middle = Line { point: centre, ..line };
    let nearest = |side: f64| {
        let on_side = crossings.iter().filter(|point| side * middle.along(**point) > 0.0);
        on_side.min_by(|a, b| middle.above(**a).abs().total_cmp(&middle.above(**b).abs()))
    };
    let (low, high) = (nearest(-1.0)?, nearest(1.0)?);
    Some(BedSurface {
        line,
        line_angle: line.degrees(),
        circle_angle: (high[1] - low[1]).atan2(high[0] - low[0]).to_degrees(),
    })
}

fn circle_crossings(line: &Loop, centre: [f64; 2], radius: f64) -> Vec<[f64; 2]> {
    let mut points = Vec::new();
    for [a, b] in contour::segments(line) {
        let (arm, along) = ([a[0] - centre[0], a[1] - centre[1]], [b[0] - a[0], b[1] - a[1]]);
        // |arm + s along|^2 = radius^2
        let square = along[0] * along[0] + along[1] * along[1];
        let half = arm[0] * along[0] + arm[1] * along[1];
        let rest = arm[0] * arm[0] + arm[1] * arm[1] - radius * radius;
        let root = half * half - square * rest;
        if square <= 0.0 || root < 0.0 {
            continue;
        }
        for share in [(-half - root.sqrt()) / square, (-half + root.sqrt()) / square] {
            if (0.0..1.0).contains(&share) {
                points.push([a[0] + share * along[0], a[1] + share * along[1]]);
            }
        }
    }
    points
}
