//! What a run measures: a row of the table of each frame, and the observables of all that the scene names at the end.

use super::measured::MeasuredFrames;
use crate::commands::Failure;
use crate::observables::{self, unmeasured};
use crate::output::Measured;
use crate::plan::Scene;
use crate::run_frames::StoreWriter;
use makadam::snapshot::Snapshot;
use std::collections::BTreeMap;

/// What a run measured.
pub(super) struct Measurements {
    /// By name.
    pub observables: BTreeMap<String, Measured>,
    /// Why there are none, where the run ended before the state that the scene wants measured.
    pub not_measured: Option<String>,
    /// What the scene measures and has no value of, with why, where anything was measured.
    pub without_value: BTreeMap<String, String>,
}

/// What the frames come to. `complete`: whether the run has reached its last step; `ended`: how long it had gone then, s.
///
/// # Errors
/// [`Failure`] if frames cannot be read back.
pub(super) fn measure(
    scene: &Scene,
    frames: &MeasuredFrames,
    written: &StoreWriter,
    complete: bool,
    ended: f64,
) -> Result<Measurements, Failure> {
    let measured = match scene.measure.from.is_some() || complete {
        true => frames.measure(scene, written)?,
        false => None,
    };
    let Some(measured) = measured else {
        let before = match scene.measure.from {
            Some(from) => format!("measure.from = {from} s"),
            None => "its last step".into(),
        };
        // A run without grains has nothing to measure, however far it came.
        let reached = complete && scene.measure.from.is_none_or(|from| ended >= from);
        let not_measured = match reached {
            true => "there are no grains".into(),
            false => format!("the run ended after {ended:.4} s, before {before}"),
        };
        return Ok(Measurements {
            observables: BTreeMap::new(),
            not_measured: Some(not_measured),
            without_value: BTreeMap::new(),
        });
    };
    let without = unmeasured(scene, &[], &measured).into_iter();
    let without_value = without.map(|one| (one.observable.to_string(), one.reason)).collect();
    let finite = measured.measurements.into_iter().filter(|m| m.value.is_finite());
    let observables =
        finite.map(|m| (m.observable, Measured { value: m.value, standard_error: m.standard_error, unit: m.unit }));
    Ok(Measurements { observables: observables.collect(), not_measured: None, without_value })
}

/// What can be measured of one frame alone.
pub(super) fn instant(scene: &Scene, frame: &Snapshot) -> Vec<(String, f64)> {
    let filled: Vec<&Snapshot> = [frame].into_iter().filter(|frame| !frame.particles.is_empty()).collect();
    let Ok(measured) = observables::measure_frames(scene, &filled[..]);
    let measured = measured.into_iter().flat_map(|measured| measured.measurements);
    measured.filter(|m| m.value.is_finite()).map(|m| (m.observable, m.value)).collect()
}
