//! One measurement code for every simulator: frames in, numbers out.
//!
//! ```text
//! Recording ─> frames from `measure.from` on ─> View of a frame ─> readings ─> averages over blocks of time
//!                        └─> time-smoothed solid fraction ─> free surface ─> angle, bulk
//! ```
//!
//! Nothing is taken from a simulator's own estimators: every quantity follows from the two tables of a
//! [`Snapshot`] and from the scene. Directions come from the scene: up is against
//! gravity, a drum is the cylinder that turns about its own level axis.
//!
//! **Bulk.** Grains whose centres, and contacts whose points, lie at least two mean diameters from every wall and
//! from the free surface. Where fewer than 50 grains a frame are left, one diameter is used.
//!
//! | quantity | where |
//! | --- | --- |
//! | `dynamic_angle_of_repose`, `surface_line_angle` | [`dynamic_angle`] |
//! | `static_angle_of_repose` | [`static_angle`] |
//! | `packing_fraction` | [`packing_fraction`] |
//! | `coordination_number` and its kin | [`coordination`] |
//! | `share_below_mean`, `gini`, `friction_mobilisation`, ... | [`contact_forces`] |
//! | `wall_force_over_weight`, `largest_overlap`, ... | [`balances`] |
//! | `shell_layer_speed_ratio`, `wall_torque`, ... | [`drum_flow`] |
//! | `size_mixing_index`, `population_mixing_index`, ... | [`mixing`] |
//! | `driven_wall_displacement` | [`driven_wall`] |

pub mod balances;
pub mod bed_surface;
pub mod bulk;
pub mod catalogue;
pub mod contact_forces;
pub mod contour;
pub mod coordination;
pub mod driven_wall;
pub mod drum;
pub mod drum_flow;
pub mod dynamic_angle;
pub mod effort;
pub mod field;
pub mod force_distribution;
pub mod line;
pub mod literature;
pub mod measurement;
pub mod mixing;
pub mod neighbours;
pub mod packing_fraction;
pub mod setting;
pub mod sphere_volume;
pub mod static_angle;
pub mod view;
pub mod walls;

pub use force_distribution::{ForcePool, force_distribution};
pub use measurement::Measurement;
pub use neighbours::close_pairs;

use crate::compare::Series;
use crate::recording::Recording;
use bed_surface::BedFields;
use bulk::Bulk;
use makadam::scene::{Observable, Scene};
use makadam::snapshot::Snapshot;
use measurement::Readings;
use setting::Setting;
use view::View;

/// Measures a recording: the quantities of `scene.measure.observables`, over the frames from `scene.measure.from` on,
/// or over the last frame alone where the scene gives no such time.
///
/// A quantity that cannot be measured (no bulk, no drum, no contacts, grains too far apart or too unlike for a grid of
/// [`effort::most`] cells) is left out of the list; none is NaN.
pub fn measure(scene: &Scene, recording: &Recording) -> Vec<Measurement> {
    let frames = measured_frames(scene, recording);
    if frames.is_empty() {
        return Vec::new();
    }
    let setting = Setting::new(scene, frames[0]);
    let asks = |observable| scene.measure.observables.contains(&observable);
    let mut measurements = Vec::new();

    let asks_bulk = [Observable::PackingFraction, Observable::CoordinationNumber, Observable::ContactForces];
    let needs_bulk = asks_bulk.into_iter().any(asks);
    let needs_bed = needs_bulk || asks(Observable::DynamicAngleOfRepose) || asks(Observable::DrumFlow);
    let bed = setting.drum.as_ref().filter(|_| needs_bed).and_then(|drum| BedFields::new(&setting, drum, &frames));

    // Quantities of the whole span: they rest on fields averaged over time.
    if let Some(bed) = &bed {
        if asks(Observable::DynamicAngleOfRepose) {
            measurements.extend(dynamic_angle::measure(&setting, bed, frames.len()));
        }
        if asks(Observable::DrumFlow) {
            measurements.extend(drum_flow::measure_span(&setting, bed, &frames));
        }
    }
    if asks(Observable::StaticAngleOfRepose) {
        measurements.extend(static_angle::measure(&setting, &frames));
    }

    // Quantities of single frames, averaged afterwards.
    let bulk = match needs_bulk {
        true => Bulk::new(&setting, bed.as_ref(), &frames),
        false => Bulk::nowhere(),
    };
    let mut readings = Readings::default();
    for frame in &frames {
        let view = View::new(&setting, &bulk, frame);
        if asks(Observable::PackingFraction) {
            packing_fraction::read(&view, &mut readings);
        }
        if asks(Observable::CoordinationNumber) {
            coordination::read(&view, &mut readings);
        }
        if asks(Observable::ContactForces) {
            contact_forces::read(&view, &mut readings);
        }
        if asks(Observable::DrumFlow) {
            drum_flow::read(&view, &mut readings);
        }
        if asks(Observable::SizeMixing) {
            mixing::read(&view, &mut readings);
        }
        if asks(Observable::DrivenWall) {
            driven_wall::read(&view, &mut readings);
        }
        if asks(Observable::Balances) {
            balances::read(&view, &mut readings);
        }
    }
    measurements.extend(readings.averages());
    measurements
}

/// Quantities over time, one point a frame, over the whole run: the dynamic angle of repose (degrees) where the scene
/// asks for it. Frames in which the bed has no surface yet are left out.
pub fn series(scene: &Scene, recording: &Recording) -> Vec<Series> {
    let asked = scene.measure.observables.contains(&Observable::DynamicAngleOfRepose);
    let Some(first) = recording.frames.first().filter(|_| asked) else {
        return Vec::new();
    };
    let setting = Setting::new(scene, first);
    let (time, value): (Vec<f64>, Vec<f64>) = dynamic_angle::over_time(&setting, &recording.frames).into_iter().unzip();
    match time.is_empty() {
        true => Vec::new(),
        false => vec![Series {
            code: recording.code.clone(),
            seed: recording.seed,
            observable: dynamic_angle::ANGLE.into(),
            time,
            value,
        }],
    }
}

/// Frames that are measured: those from `scene.measure.from` on, or the last one.
pub fn measured_frames<'a>(scene: &Scene, recording: &'a Recording) -> Vec<&'a Snapshot> {
    // Times are sums of steps: a frame due at `from` may bear a time just below it.
    let slack = 1e-3 * scene.measure.interval;
    let filled: Vec<&Snapshot> = recording.frames.iter().filter(|frame| !frame.particles.is_empty()).collect();
    let from = scene.measure.from.unwrap_or(f64::INFINITY);
    let late = filled.iter().position(|frame| frame.time >= from - slack);
    filled[late.unwrap_or(filled.len().saturating_sub(1))..].to_vec()
}
