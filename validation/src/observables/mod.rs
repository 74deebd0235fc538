//! One measurement code for every simulator: frames in, numbers out.
//!
//! ```text
//! Recording ─> frames from `measure.from` on ─> View of a frame ─> readings ─> averages over blocks of time
//!                        └─> time-smoothed solid fraction ─> free surface ─> angle, bulk
//! ```
//!
//! Frames are [looked at](frames::Frames) one after the other and added up; none is held. What grows with their number is a number
//! a frame and quantity.
//!
//! Nothing is taken from a simulator's own estimators: every quantity follows from the two tables of a
//! [`Snapshot`] and from the scene. Directions come from the scene: up is against
//! gravity, a drum is the cylinder that turns about its own level axis.
//!
//! **Bulk.** Grains whose centres, and contacts whose points, lie at least two mean diameters from every wall and
//! from the free surface. Where fewer than 50 grains a frame are left, one diameter is used. The ends of a periodic axis count as
//! walls; a contact across an end lies there, between a grain and the nearest image of the other one.
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
//! | `mass_flow_rate`, `discharged_mass` | [`discharge`] |
//! | `intruder_height`, `intruder_speed` | [`intruder`] |
//!
//! [`catalogue::definitions`] says of each what it is; `makadam observables` prints it.
//!
//! ```
//! use makadam_validation::{observables, plan::Scene, scenes};
//!
//! let mut scene: Scene = scenes::load(&scenes::find("packing", &[])?)?;
//! scene.population[0].count = 100;
//! let mut simulation = makadam::Simulation::new(&scene, 1)?;
//! for _ in 0..400 {
//!     simulation.step();
//! }
//! let frame = simulation.snapshot();
//! for measured in observables::measure_frames(&scene, &[&frame][..])?.unwrap_or_default() {
//!     println!("{} = {:.3} {}", measured.observable, measured.value, measured.unit);
//! }
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

pub mod balances;
pub mod bed_surface;
pub mod bulk;
pub mod catalogue;
pub mod contact_forces;
pub mod contour;
pub mod coordination;
mod definitions;
pub mod discharge;
pub mod driven_wall;
pub mod drum;
pub mod drum_flow;
pub mod dynamic_angle;
pub mod effort;
pub mod field;
pub mod force_distribution;
pub mod frames;
pub mod intruder;
pub mod line;
pub mod literature;
pub mod measurement;
pub mod mixing;
pub mod neighbours;
pub mod packing_fraction;
pub mod possible;
mod series;
pub mod setting;
pub mod sphere_volume;
pub mod static_angle;
pub mod view;
pub mod walls;

pub use force_distribution::{ForceDistribution, ForcePool, force_distribution};
pub use measurement::Measurement;
pub use neighbours::close_pairs;
pub use possible::{Unmeasured, impossible, unmeasured};
pub use series::Series;

use crate::plan::{Observable, Scene};
use crate::recording::Recording;
use bed_surface::BedFields;
use bulk::Bulk;
use frames::Frames;
use makadam::snapshot::Snapshot;
use measurement::Readings;
use setting::Setting;
use static_angle::HeapFields;
use view::View;

/// Measures a recording: [`measure_frames`] of its [`measured_frames`]; nothing where it has none. What needs something that its frames
/// do not tell is left out.
pub fn measure(scene: &Scene, recording: &Recording) -> Vec<Measurement> {
    let Ok(measured) = measure_frames(scene, &measured_frames(scene, recording)[..]);
    let is_told = |measurement: &Measurement| catalogue::missing(&measurement.observable, &recording.lacks).is_none();
    measured.unwrap_or_default().into_iter().filter(is_told).collect()
}

/// Measures frames: the quantities of `scene.measure.observables`, over all of them. `None` if there is no frame, so that what
/// was never measured is told from what could not be.
///
/// A quantity that cannot be measured (no bulk, no drum, no contacts, grains too far apart or too unlike for a grid of
/// [`effort::most`] cells) is left out of the list; none is NaN.
///
/// # Errors
/// Where a frame cannot be shown.
pub fn measure_frames<F: Frames + ?Sized>(scene: &Scene, frames: &F) -> Result<Option<Vec<Measurement>>, F::Error> {
    let Some(setting) = setting_of(scene, frames)? else {
        return Ok(None);
    };
    let asks = |observable| scene.measure.observables.contains(&observable);
    let mut measurements = Vec::new();

    let asks_bulk = [Observable::PackingFraction, Observable::CoordinationNumber, Observable::ContactForces];
    let needs_bulk = asks_bulk.into_iter().any(asks);
    let needs_bed = needs_bulk || asks(Observable::DynamicAngleOfRepose) || asks(Observable::DrumFlow);
    let bed = if needs_bed { bed_of(&setting, frames)? } else { None };

    // Quantities of the whole span: they rest on fields averaged over time.
    if let Some(bed) = &bed {
        if asks(Observable::DynamicAngleOfRepose) {
            measurements.extend(dynamic_angle::measure(&setting, bed, frames.count()));
        }
        if asks(Observable::DrumFlow) {
            measurements.extend(drum_flow::measure_span(&setting, bed, frames)?);
        }
    }
    if asks(Observable::Discharge) {
        measurements.extend(discharge::measure(&setting, frames)?);
    }
    let heap = heap_of(&setting, frames)?;
    measurements.extend(heap.iter().flat_map(|heap| static_angle::measure(&setting, heap)));

    // Quantities of single frames, averaged afterwards.
    let bulk = match needs_bulk {
        true => Bulk::new(&setting, bed.as_ref(), heap, frames)?,
        false => Bulk::nowhere(),
    };
    let mut readings = Readings::default();
    frames.each(&mut |frame| {
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
        if asks(Observable::Intruder) {
            intruder::read(&view, &mut readings);
        }
        if asks(Observable::Balances) {
            balances::read(&view, &mut readings);
        }
    })?;
    measurements.extend(readings.averages());
    Ok(Some(measurements))
}

/// The setting at the first frame; `None` if there is none.
fn setting_of<'a, F: Frames + ?Sized>(scene: &'a Scene, frames: &F) -> Result<Option<Setting<'a>>, F::Error> {
    let mut setting = None;
    frames.visit(0..frames.count().min(1), &mut |first| setting = Some(Setting::new(scene, first)))?;
    Ok(setting)
}

/// The bed in a drum, where there is one.
fn bed_of<F: Frames + ?Sized>(setting: &Setting<'_>, frames: &F) -> Result<Option<BedFields>, F::Error> {
    setting.drum.as_ref().map_or(Ok(None), |drum| BedFields::new(setting, drum, frames))
}

/// The heap, where its angle is asked for.
fn heap_of<F: Frames + ?Sized>(setting: &Setting<'_>, frames: &F) -> Result<Option<HeapFields>, F::Error> {
    match setting.scene.measure.observables.contains(&Observable::StaticAngleOfRepose) {
        true => HeapFields::new(setting, frames),
        false => Ok(None),
    }
}

/// Quantities over time, one point a frame, over the whole run: the dynamic angle of repose (degrees) and the height of the intruder (m)
/// where the scene asks for them. Frames in which the bed has no surface yet are left out.
pub fn series(scene: &Scene, recording: &Recording) -> Vec<Series> {
    let asks = |observable| scene.measure.observables.contains(&observable);
    let Some(first) = recording.frames.first() else { return Vec::new() };
    let setting = Setting::new(scene, first);
    let one = |observable: &str, points: Vec<(f64, f64)>| {
        let (time, value): (Vec<f64>, Vec<f64>) = points.into_iter().unzip();
        let (code, seed) = (recording.code.clone(), recording.seed);
        (!time.is_empty()).then(|| Series { code, seed, observable: observable.into(), time, value })
    };
    let angle = || one(dynamic_angle::ANGLE, dynamic_angle::over_time(&setting, &recording.frames));
    let height = || one(intruder::HEIGHT_NAME, intruder::over_time(&setting, &recording.frames));
    let asked = [
        asks(Observable::DynamicAngleOfRepose).then(angle).flatten(),
        asks(Observable::Intruder).then(height).flatten(),
    ];
    asked.into_iter().flatten().collect()
}

/// Frames that are measured: those from `scene.measure.from` on, which are none if the run ended before; the last one where the
/// scene gives no such time.
pub fn measured_frames<'a>(scene: &Scene, recording: &'a Recording) -> Vec<&'a Snapshot> {
    let filled: Vec<&Snapshot> = recording.frames.iter().filter(|frame| !frame.particles.is_empty()).collect();
    let first = match scene.measure.from {
        Some(_) => filled.iter().position(|frame| scene.measure.covers(frame.time)).unwrap_or(filled.len()),
        None => filled.len().saturating_sub(1),
    };
    filled[first..].to_vec()
}
