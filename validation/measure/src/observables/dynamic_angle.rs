//! Dynamic angle of repose: the inclination of the flowing surface in a rotating drum.
//!
//! The solid fraction is averaged over the measured frames on a grid in the cross-section (exact sphere volumes, whole
//! length of the drum, smoothed over about one radius). Both lines use the free part of the outline, more than 1.5
//! mean diameters inside the shell. The circle is centred on the point of the fitted line that is nearest to the drum's axis: in a drum
//! filled to less than some 37% a circle about the axis would miss the surface altogether.
//!
//! Both angles are positive if the bed rises towards the side at which the shell lifts the grains, for either sense of
//! rotation. Standard errors are over blocks of time, with fields measured one by one. The line through
//! two points a fifth of the drum apart is about twice as noisy as the fitted line; the S-shape of a fast
//! surface affects it less.

use super::bed_surface::{BedSurface, BedSurfaces, MeanField, outline, surface};
use super::catalogue::{Group, define, nothing_of_a_frame};
use super::field::Field;
use super::measurement::Measurement;
use super::setting::{Properties, Setting, is_one_direction};
use crate::statistics::standard_error;
use makadam::snapshot::Snapshot;
use makadam_frames::plan::Observable;

pub(super) const GROUP: Group = Group {
    observable: Observable::DynamicAngleOfRepose,
    name: "dynamic-angle-of-repose",
    read: nothing_of_a_frame,
    definitions: &[
        define(
            ["dynamic_angle_of_repose", "θ", "degree"],
            "inclination of the line through the two points at which the outline of the bed (half of the largest \
             time-averaged solid fraction) crosses a circle of a fifth of the drum's diameter about the middle of the \
             surface; positive in the sense of rotation",
        )
        .of_span(),
        define(
            ["surface_line_angle", "θ_l", "degree"],
            "inclination of the total-least-squares line through the middle half of the surface of the bed",
        )
        .of_span(),
    ],
};

/// Number of frames averaged, centred, for one point of the angle over time.
const WINDOW: usize = 5;

/// Returns both angles over `frames` measured frames, degrees; empty without a surface.
pub fn measure(bed: &BedSurfaces, frames: usize) -> Vec<Measurement> {
    let Some(whole) = &bed.whole else {
        return Vec::new();
    };
    let parts = || bed.parts.iter().flatten();
    let error = |angle: fn(&BedSurface) -> f64| standard_error(&parts().map(angle).collect::<Vec<f64>>());
    vec![
        Measurement::of("dynamic_angle_of_repose", whole.circle_angle, error(|part| part.circle_angle), frames),
        Measurement::of("surface_line_angle", whole.line_angle, error(|part| part.line_angle), frames),
    ]
}

/// Returns time (s) and circle angle (degrees) of each frame, with the field averaged over the five frames about it. The drum must turn in
/// one sense in all five.
///
/// Empty without a drum, and for gravity of changing direction: the fields would then have no common cross-section.
pub fn over_time(properties: &Properties<'_>, frames: &[Snapshot]) -> Vec<(f64, f64)> {
    let settings: Vec<Setting<'_>> = frames.iter().map(|frame| Setting::new(properties, frame)).collect();
    let Some(setting) = settings.first() else { return Vec::new() };
    if !settings.iter().all(|other| is_one_direction(setting.up, other.up)) {
        return Vec::new();
    }
    let field = |(frame, own): (&Snapshot, &Setting<'_>)| {
        let mut mean = MeanField::new(setting, own.drum.as_ref()?, frame.particles.len());
        mean.add(frame);
        mean.finish()
    };
    let fields: Vec<Option<Field>> = frames.iter().zip(&settings).map(field).collect();
    let at = |index: usize| {
        let reach = (WINDOW / 2).min(index).min(frames.len() - 1 - index);
        let about = index - reach..=index + reach;
        let sense = settings[index].sense();
        if sense == 0.0 || settings[about.clone()].iter().any(|other| other.sense() != sense) {
            return None;
        }
        let mut field = fields[index - reach].clone()?;
        for more in &fields[about][1..] {
            field.add(more.as_ref()?);
        }
        let surface = surface(setting, settings[index].drum.as_ref()?, &outline(&field)?)?;
        Some((frames[index].time, surface.circle_angle))
    };
    (0..frames.len()).filter_map(at).collect()
}
