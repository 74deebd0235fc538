//! Measurement code common to all simulators: input frames, output numbers.
//!
//! ```text
//! Recording ─> frames from `measure.from` on ─> View of a frame: down, walls, bulk ─> readings ─> averages over blocks of time
//!                        └─> fields averaged over time ─> free surface ─> angles
//! ```
//!
//! Frames are measured one after the other and summed; none is stored. Memory grows by one number
//! per frame and quantity.
//!
//! Simulators' own estimators are not used: every quantity follows from the two tables of a
//! [`Snapshot`] and from the scene, at the frame's time. This applies to the up direction (against gravity), the weight, and the poses of
//! the walls, from their motion or from the frame. A drum is the cylinder that turns about its own level axis.
//!
//! **Bulk.** Grains with centres, and contacts with points, at least two mean diameters from every wall and
//! from the free surface of their frame; with fewer than 50 such grains, the distance is one diameter. The ends of a periodic axis count as
//! walls; a contact across an end lies between a grain and the nearest image of the other one. A bed without any of the known free
//! surfaces has no bulk, and is not measured.
//!
//! [`catalogue::definitions`] defines each number; `makadam print observables` prints it.
//!
//! ```
//! use makadam_frames::plan::MeasuredScene;
//! use makadam_measure::observables;
//!
//! # let folder = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("../..");
//! let mut scene = MeasuredScene::load(&folder.join("reference-scenes/packing/scene.toml"))?;
//! scene.population[0].count = 100;
//! let mut simulation = makadam::Simulation::new(&scene, 1)?;
//! for _ in 0..400 {
//!     simulation.step();
//! }
//! let frame = simulation.snapshot();
//! for measured in observables::measure_frames(&scene, &[&frame][..])?.unwrap_or_default().measurements {
//!     println!("{} = {:.3} {}", measured.observable, measured.value, measured.unit);
//! }
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

mod balances;
mod bed_surface;
mod bulk;
pub mod catalogue;
mod contact_forces;
pub mod contour;
mod coordination;
mod discharge;
mod driven_wall;
mod drum;
mod drum_flow;
mod dynamic_angle;
mod effort;
pub mod field;
mod force_distribution;
pub mod frames;
mod gauges;
mod holes;
mod intruder;
pub mod line;
mod measurement;
mod mixing;
pub mod packing_fraction;
mod possible;
mod regions;
pub mod setting;
pub mod sphere_volume;
pub mod static_angle;
mod view;
mod wall_loads;
pub mod walls;

pub use force_distribution::{ForceDistribution, ForcePool, force_distribution};
pub use measurement::{Measured, Measurement, Series};
pub use possible::{Unmeasured, impossible, unmeasured};

use bed_surface::{BedSurfaces, NO_MEAN_FIELD, surface};
use catalogue::GROUPS;
use contour::Loop;
use frames::{Frames, Wrapped};
use makadam::snapshot::Snapshot;
use makadam_frames::plan::{MeasuredScene, Observable, moment};
use makadam_frames::recording::Recording;
use measurement::Readings;
use nalgebra::Vector3;
use setting::{Properties, Setting};
use static_angle::HeapFields;
use view::View;

/// Measures a recording: the numbers of [`measured_in`].
pub fn measure(scene: &MeasuredScene, recording: &Recording) -> Vec<Measurement> {
    measured_in(scene, recording).measurements
}

/// Measures a recording: [`measure_frames`] of its [`measured_frames`]; empty without such frames. Numbers that need content missing from the
/// frames are left out.
pub fn measured_in(scene: &MeasuredScene, recording: &Recording) -> Measured {
    let Ok(measured) = measure_frames(scene, &measured_frames(scene, recording)[..]);
    let mut measured = measured.unwrap_or_default();
    measured.measurements.extend(measured_at_times(scene, recording));
    measured.measurements.retain(|one| catalogue::missing(scene, &one.observable, &recording.lacks).is_none());
    measured
}

/// Measures the observables that the scene compares at times: each in the single frame of its time, if there is one.
fn measured_at_times(scene: &MeasuredScene, recording: &Recording) -> Vec<Measurement> {
    let at_time = |name: &str| {
        let (quantity, time) = moment(name);
        let (time, group) = (time?, catalogue::group_of(quantity)?.0);
        let frame = recording.frames.iter().find(|frame| scene.is_at(time, frame.time, frame.stage))?;
        let mut alone = scene.clone();
        alone.measure.observables = vec![group];
        let Ok(measured) = measure_frames(&alone, &[frame][..]);
        let mut measured = measured?.measurements.into_iter();
        let found = measured.find(|found| found.observable == quantity)?;
        Some(Measurement { observable: name.into(), ..found })
    };
    scene.compare.iter().filter_map(|expectation| at_time(&expectation.observable)).collect()
}

/// Measures frames: the quantities of `scene.measure.observables`, over all frames. `None` without frames, to distinguish a state that
/// was never measured from a state that could not be measured.
///
/// A quantity that cannot be measured (no bulk, no drum, no contacts, grains too far apart or too different in size for a grid of
/// `effort::most` cells) is left out of the list; none is NaN. A quantity of single frames depends only on the frame and the
/// scene: its value over several frames is the mean of the results of [`measure_frames`] for each.
pub fn measure_frames<F: Frames + ?Sized>(scene: &MeasuredScene, frames: &F) -> Result<Option<Measured>, F::Error> {
    let properties = Properties::new(scene);
    Meter::of_frames(&properties, frames)?.finish(&properties, frames)
}

/// Readings of frames, collected frame by frame.
#[derive(Default)]
pub struct Meter {
    readings: Readings,
    refusals: Measured,
    /// Data of the first frame; absent before it.
    span: Option<SpanFacts>,
}

/// Direction of gravity and sense of the drum over the frames of a span.
struct SpanFacts {
    /// Direction against gravity in the first frame.
    up: Option<Vector3<f64>>,
    /// Sense of rotation of the drum in the first frame; 0 without rotation or without a drum.
    sense: f64,
    /// True if all frames have this direction.
    is_steady: bool,
    /// True if the drum turns in all frames, in this sense.
    is_turning: bool,
}

impl Meter {
    /// Reads frames.
    ///
    /// # Errors
    /// Error of a frame that cannot be provided.
    pub fn of_frames<F: Frames + ?Sized>(properties: &Properties<'_>, frames: &F) -> Result<Meter, F::Error> {
        let mut meter = Meter::default();
        Wrapped::new(frames, &properties.scene.domain).visit(0..frames.count(), &mut |frame| {
            if !frame.particles.is_empty() {
                let setting = Setting::new(properties, frame);
                meter.append(Meter::of(&View::new(&setting, frame)));
            }
        })?;
        Ok(meter)
    }

    /// Reads a frame.
    fn of(view: &View<'_>) -> Meter {
        let (mut readings, mut refusals) = (Readings::default(), Measured::default());
        for &group in &view.setting.scene().measure.observables {
            let registered = GROUPS.iter().find(|registered| registered.observable == group);
            if let Some(Err(reason)) = registered.map(|registered| (registered.read)(view, &mut readings)) {
                refusals.refuse(group, &reason);
            }
        }
        let (up, sense) = (view.setting.up, view.setting.sense());
        Meter { readings, refusals, span: Some(SpanFacts { up, sense, is_steady: true, is_turning: sense != 0.0 }) }
    }

    /// Reads a frame, and returns its own results: [`measure_frames`] of this frame alone.
    pub fn read(properties: &Properties<'_>, frame: &Snapshot) -> (Meter, Measured) {
        let frame = frames::wrapped(&properties.scene.domain, frame);
        let setting = Setting::new(properties, &frame);
        if frame.particles.is_empty() {
            let meter = Meter::default();
            let Ok(alone) = meter.finish_with(&setting, &[&*frame][..], None);
            return (meter, alone);
        }
        let view = View::new(&setting, &frame);
        let meter = Meter::of(&view);
        let Ok(alone) = meter.finish_with(&setting, &[&*frame][..], Some(&view));
        (meter, alone)
    }

    /// Appends the readings of later frames.
    pub fn append(&mut self, later: Meter) {
        self.readings.append(later.readings);
        for (group, why) in &later.refusals.refusals {
            self.refusals.refuse(*group, why);
        }
        match (&mut self.span, later.span) {
            (Some(span), Some(later)) => {
                span.is_steady &= later.is_steady && setting::is_one_direction(span.up, later.up);
                span.is_turning &= later.is_turning && span.sense == later.sense;
            }
            (span, later) => *span = later,
        }
    }

    /// Measures the frames read so far; `None` without frames.
    ///
    /// # Errors
    /// Error of a frame that cannot be provided.
    pub fn finish<F: Frames + ?Sized>(
        &self,
        properties: &Properties<'_>,
        frames: &F,
    ) -> Result<Option<Measured>, F::Error> {
        let frames = Wrapped::new(frames, &properties.scene.domain);
        let mut setting: Option<Setting<'_>> = None;
        for number in 0..frames.count() {
            frames.visit_grains(number..number + 1, &mut |frame| setting = Some(Setting::new(properties, frame)))?;
            if frames.grains(number..number + 1) > 0 {
                break;
            }
        }
        setting.map(|setting| self.finish_with(&setting, &frames, None)).transpose()
    }

    /// Measures the frames read so far, with the setting of the first frame that has grains; `view` is the view of a single frame.
    fn finish_with<F: Frames + ?Sized>(
        &self,
        setting: &Setting<'_>,
        frames: &F,
        view: Option<&View<'_>>,
    ) -> Result<Measured, F::Error> {
        let mut measured = Measured::default();
        let span = Span {
            setting,
            is_steady: self.span.as_ref().is_none_or(|span| span.is_steady),
            is_turning: self.span.as_ref().is_some_and(|span| span.is_turning),
            view,
        };
        span.measure(frames, &mut measured)?;
        measured.measurements.extend(self.readings.averages());
        for (group, why) in &self.refusals.refusals {
            measured.refuse(*group, why);
        }
        Ok(measured)
    }
}

/// All measured frames together: quantities from fields averaged over time, or from grain histories.
struct Span<'a> {
    /// Setting of the first frame.
    setting: &'a Setting<'a>,
    is_steady: bool,
    is_turning: bool,
    /// View of a single frame, with its fields; absent for several frames.
    view: Option<&'a View<'a>>,
}

impl Span<'_> {
    fn measure_passages<F: Frames + ?Sized>(&self, frames: &F, measured: &mut Measured) -> Result<(), F::Error> {
        if self.setting.scene().measure.observables.contains(&Observable::Discharge) {
            match discharge::measure(self.setting.properties, frames)? {
                Ok(found) => measured.measurements.extend(found),
                Err(why) => measured.refuse(Observable::Discharge, &why),
            }
        }
        if self.setting.scene().measure.observables.contains(&Observable::Gauges) {
            measured.measurements.extend(gauges::measure(self.setting.properties, frames)?);
        }
        Ok(())
    }

    fn measure<F: Frames + ?Sized>(&self, frames: &F, measured: &mut Measured) -> Result<(), F::Error> {
        const UNSTEADY: &str = "the direction of gravity changes over the measured frames";
        const NOT_ONE_SENSE: &str = "the drum does not turn in one sense in all measured frames";
        let setting = self.setting;
        let asks = |group: &Observable| setting.scene().measure.observables.contains(group);
        // Without grains, nothing but what has passed has a value.
        if setting.diameter <= 0.0 {
            return self.measure_passages(frames, measured);
        }
        let of_bed = [Observable::DynamicAngleOfRepose, Observable::DrumFlow];
        for group in of_bed.iter().chain([&Observable::StaticAngleOfRepose]).filter(|group| asks(group)) {
            if !self.is_steady {
                measured.refuse(*group, UNSTEADY);
            }
        }
        if let Some(drum) = setting.drum.as_ref().filter(|_| self.is_steady && of_bed.iter().any(asks)) {
            let fields = match (self.is_turning, self.view) {
                (false, _) => Err(NOT_ONE_SENSE),
                (true, None) => BedSurfaces::new(setting, drum, frames)?.ok_or(NO_MEAN_FIELD),
                (true, Some(view)) => {
                    let surface = |outline: Option<&Loop>| surface(setting, drum, outline?);
                    view.outline(drum).map(|outline| BedSurfaces { whole: surface(outline), ..Default::default() })
                }
            };
            match fields {
                Err(why) => of_bed.iter().for_each(|group| measured.refuse(*group, why)),
                Ok(bed) => {
                    if asks(&Observable::DynamicAngleOfRepose) {
                        measured.measurements.extend(dynamic_angle::measure(&bed, frames.count()));
                    }
                    if asks(&Observable::DrumFlow) {
                        measured.measurements.extend(drum_flow::measure_flow(setting, drum, &bed, frames)?);
                    }
                }
            }
            if asks(&Observable::DrumFlow) {
                measured.measurements.extend(drum_flow::measure_mixing(setting, drum, frames)?);
            }
        }
        self.measure_passages(frames, measured)?;
        if asks(&Observable::StaticAngleOfRepose) && self.is_steady {
            let found = match self.view {
                Some(view) => view.heap().map_err(String::from).and_then(|heap| static_angle::measure(setting, heap)),
                None => HeapFields::new(setting, frames)?.and_then(|heap| static_angle::measure(setting, &heap)),
            };
            match found {
                Ok(found) => measured.measurements.extend(found),
                Err(why) => measured.refuse(Observable::StaticAngleOfRepose, &why),
            }
        }
        Ok(())
    }
}

/// Returns quantities over time, one point per frame, over the whole run: the dynamic angle of repose (degrees), the height of the intruder
/// (m) and the grains in regions, if the scene requests them. Frames without a bed surface are left out.
pub fn series(scene: &MeasuredScene, recording: &Recording) -> Vec<Series> {
    let asks = |observable| scene.measure.observables.contains(&observable);
    let properties = Properties::new(scene);
    let one = |observable: &str, points: Vec<(f64, f64)>| {
        let (time, value): (Vec<f64>, Vec<f64>) = points.into_iter().unzip();
        let (code, seed) = (recording.code.clone(), recording.seed);
        (!time.is_empty()).then(|| Series { code, seed, observable: observable.into(), time, value })
    };
    let angle = || one("dynamic_angle_of_repose", dynamic_angle::over_time(&properties, &recording.frames));
    let height = || one("intruder_height", intruder::over_time(&properties, &recording.frames));
    let asked = [
        asks(Observable::DynamicAngleOfRepose).then(angle).flatten(),
        asks(Observable::Intruder).then(height).flatten(),
    ];
    let count = |index: usize| {
        let name = format!("grain_count({})", scene.measure.region[index].name);
        one(&name, regions::over_time(&properties, &recording.frames, index))
    };
    let regions = (0..scene.measure.region.len()).filter(|_| asks(Observable::Regions)).filter_map(count);
    asked.into_iter().flatten().chain(regions).collect()
}

/// Returns true if a frame with this number of grains can be measured: frames without grains state what passed sinks and gauges.
pub fn counts(scene: &MeasuredScene, grains: usize) -> bool {
    grains > 0 || !scene.remove.is_empty() || !scene.gauge.is_empty()
}

/// Returns the measured frames: the frames of the measured stage from `scene.measure.from` on, none if the run ended before; without `from`,
/// the last frame.
pub fn measured_frames<'a>(scene: &MeasuredScene, recording: &'a Recording) -> Vec<&'a Snapshot> {
    let is_filled = |frame: &&Snapshot| counts(scene, frame.particles.len()) && scene.is_of_measured_stage(frame.stage);
    let filled: Vec<&Snapshot> = recording.frames.iter().filter(is_filled).collect();
    let first = match scene.measure.from {
        Some(_) => filled.iter().position(|frame| scene.covers(frame.time, frame.stage)).unwrap_or(filled.len()),
        None => filled.len().saturating_sub(1),
    };
    filled[first..].to_vec()
}
