//! Dynamic angle of repose: the inclination of the flowing surface in a rotating drum.
//!
//! The solid fraction is averaged over the measured frames on a grid in the cross-section (cells one mean radius
//! wide, exact sphere volumes, whole length of the drum). The bed's outline is the contour at half the field's
//! largest value. Two lines are put through its free part, which lies more than 1.5 mean diameters inside the shell:
//!
//! - `surface_line_angle`: total least squares over the middle half of the surface's chord;
//! - `dynamic_angle_of_repose`: the line through the two points at which the outline crosses a circle whose diameter
//!   is a fifth of the drum's. The circle is centred on the middle of the surface: the point of the fitted line
//!   that is nearest to the drum's axis. In a half-filled drum that is the axis itself; in a drum filled to less
//!   than some 37% a circle about the axis would miss the surface altogether.
//!
//! Both are positive where the bed rises towards the side to which the shell carries it, whatever the sense of
//! rotation. Standard errors are over blocks of time, the fields of which are measured one by one.

use super::contour::{self, Loop, Segment};
use super::drum::Drum;
use super::field::Field;
use super::line::{Line, clip};
use super::measurement::{Measurement, Quantity};
use super::setting::Setting;
use crate::statistics::{block_count, standard_error};
use makadam::snapshot::Snapshot;
use nalgebra::Vector3;

/// Name of the angle that is compared between codes.
pub const ANGLE: &str = "dynamic_angle_of_repose";

const CIRCLE: Quantity = Quantity::mean(ANGLE, "degree");
const LEAST_SQUARES: Quantity = Quantity::mean("surface_line_angle", "degree");

/// Diameter of the circle over the drum's.
const CIRCLE_OVER_DRUM: f64 = 0.2;

/// Frames averaged, centred, into one point of the angle over time.
const WINDOW: usize = 5;

/// The bed's surface in the cross-section of a drum.
#[derive(Clone, Debug)]
pub struct BedSurface {
    /// Outline of the bed, m, in the coordinates of [`Drum::section`].
    pub outline: Loop,
    /// Line fitted to the middle half of the free surface.
    pub line: Line,
    /// Angle of that line, degrees.
    pub line_angle: f64,
    /// Angle of the line through the crossings with the circle, degrees.
    pub circle_angle: f64,
}

/// Both angles over the measured frames, degrees; nothing where there is no drum or no surface.
pub fn measure(setting: &Setting<'_>, frames: &[&Snapshot]) -> Vec<Measurement> {
    let Some(drum) = &setting.drum else {
        return Vec::new();
    };
    let blocks = block_count(frames.len()).unwrap_or(1);
    let fields: Vec<Field> = (0..blocks)
        .map(|block| &frames[block * frames.len() / blocks..(block + 1) * frames.len() / blocks])
        .map(|part| mean_field(setting, drum, part.iter().copied()))
        .collect();
    let mut whole = fields[0].clone();
    fields[1..].iter().for_each(|field| whole.add(field));
    let Some(surface) = surface(setting, drum, &whole) else {
        return Vec::new();
    };
    let parts: Vec<BedSurface> =
        fields.iter().filter_map(|field| self::surface(setting, drum, field)).collect();
    let error = |angle: fn(&BedSurface) -> f64| {
        let angles: Vec<f64> = parts.iter().map(angle).collect();
        standard_error(&angles)
    };
    vec![
        CIRCLE.measured(surface.circle_angle, error(|part| part.circle_angle), frames.len()),
        LEAST_SQUARES.measured(surface.line_angle, error(|part| part.line_angle), frames.len()),
    ]
}

/// Time (s) and angle by the circle (degrees) of each frame, the field averaged over five frames about it.
pub fn over_time(setting: &Setting<'_>, frames: &[Snapshot]) -> Vec<(f64, f64)> {
    let Some(drum) = &setting.drum else {
        return Vec::new();
    };
    let fields: Vec<Field> = frames.iter().map(|frame| mean_field(setting, drum, std::iter::once(frame))).collect();
    let at = |index: usize| {
        let reach = (WINDOW / 2).min(index).min(frames.len() - 1 - index);
        let mut field = fields[index - reach].clone();
        fields[index - reach + 1..=index + reach].iter().for_each(|more| field.add(more));
        let surface = surface(setting, drum, &field)?;
        Some((frames[index].time, surface.circle_angle))
    };
    (0..frames.len()).filter_map(at).collect()
}

/// Solid fraction in the cross-section, averaged over frames.
pub fn mean_field<'a>(setting: &Setting<'_>, drum: &Drum, frames: impl Iterator<Item = &'a Snapshot>) -> Field {
    let reach = drum.radius;
    let mut field = Field::new([-reach; 2], [reach; 2], 0.5 * setting.diameter);
    let volume = field.cell * field.cell * drum.length;
    let mut count = 0;
    for frame in frames {
        for grain in &frame.particles {
            field.add_sphere(drum.section(&Vector3::from(grain.position)), grain.radius, volume);
        }
        count += 1;
    }
    field.scale(1.0 / f64::from(count.max(1)));
    field
}

/// The surface of the bed in a field; absent where the bed has none.
pub fn surface(setting: &Setting<'_>, drum: &Drum, field: &Field) -> Option<BedSurface> {
    let outline = contour::outline(field, 0.5 * field.largest())?;
    let inside = drum.radius - 1.5 * setting.diameter;
    let free: Vec<Segment> =
        contour::segments(&outline).filter(|[a, b]| a[0].hypot(a[1]) < inside && b[0].hypot(b[1]) < inside).collect();
    let mut line = Line::fit(free.iter().copied())?;
    // The middle half depends on the line, and the line on the middle half: a few rounds settle both.
    for _ in 0..5 {
        let offset = line.above([0.0; 2]).abs();
        let half_chord = (drum.radius.powi(2) - offset.powi(2)).max(0.0).sqrt();
        let middle = Line { point: line.foot([0.0; 2]), ..line };
        let pieces = free.iter().filter_map(|piece| {
            clip(*piece, |point| middle.along(point), -0.5 * half_chord, 0.5 * half_chord)
        });
        line = Line::fit(pieces)?;
    }
    let centre = line.foot([0.0; 2]);
    let crossings = circle_crossings(&outline, centre, 0.5 * CIRCLE_OVER_DRUM * 2.0 * drum.radius);
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
        outline,
    })
}

/// Points at which a closed line crosses a circle.
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
