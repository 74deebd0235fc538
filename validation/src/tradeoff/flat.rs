//! The rows as they stand in CSV files, one level deep.

use super::rows::{Deviation, Point, Reference};
use serde::Serialize;

/// One observable of one point, as `points.csv` has it; a point without deviations has one row.
#[derive(Clone, Debug, Serialize)]
pub(super) struct PointRow<'a> {
    code: &'a str,
    version: &'a str,
    setting: &'a str,
    stiffness_factor: f64,
    youngs_modulus: f64,
    time_step: f64,
    rayleigh_fraction: Option<f64>,
    sweeps: Option<u32>,
    variation: Option<&'a str>,
    seeds: usize,
    wall_seconds_per_simulated_second: f64,
    wall_seconds_per_simulated_second_least: f64,
    wall_seconds_per_simulated_second_most: f64,
    core_share_least: Option<f64>,
    simulated_seconds: f64,
    extrapolated: bool,
    reference: bool,
    within_bounds: Option<bool>,
    intervals_within_bounds: Option<bool>,
    observable: Option<&'a str>,
    unit: Option<&'a str>,
    mean: Option<f64>,
    standard_error: Option<f64>,
    deviation: Option<f64>,
    deviation_standard_error: Option<f64>,
    interval90_low: Option<f64>,
    interval90_high: Option<f64>,
    deviation_from_scene: Option<f64>,
    bound: Option<f64>,
    within: Option<bool>,
    interval_within: Option<bool>,
    on_front: Option<bool>,
}

/// The rows of a point: one an observable, or one without observables.
pub(super) fn point_rows(point: &Point) -> Vec<PointRow<'_>> {
    match point.deviations.is_empty() {
        true => vec![point_row(point, None)],
        false => point.deviations.iter().map(|deviation| point_row(point, Some(deviation))).collect(),
    }
}

fn point_row<'a>(point: &'a Point, deviation: Option<&'a Deviation>) -> PointRow<'a> {
    PointRow {
        code: &point.code,
        version: &point.version,
        setting: &point.setting,
        stiffness_factor: point.stiffness_factor,
        youngs_modulus: point.youngs_modulus,
        time_step: point.time_step,
        rayleigh_fraction: point.rayleigh_fraction,
        sweeps: point.sweeps,
        variation: point.variation.as_deref(),
        seeds: point.seeds.len(),
        wall_seconds_per_simulated_second: point.wall_seconds_per_simulated_second,
        wall_seconds_per_simulated_second_least: point.wall_seconds_per_simulated_second_least,
        wall_seconds_per_simulated_second_most: point.wall_seconds_per_simulated_second_most,
        core_share_least: point.core_share_least,
        simulated_seconds: point.simulated_seconds,
        extrapolated: point.extrapolated,
        reference: point.reference,
        within_bounds: point.within_bounds,
        intervals_within_bounds: point.intervals_within_bounds,
        observable: deviation.map(|d| d.observable.as_str()),
        unit: deviation.map(|d| d.unit.as_str()),
        mean: deviation.map(|d| d.mean),
        standard_error: deviation.and_then(|d| d.standard_error),
        deviation: deviation.map(|d| d.deviation),
        deviation_standard_error: deviation.and_then(|d| d.deviation_standard_error),
        interval90_low: deviation.and_then(|d| d.interval90).map(|[low, _]| low),
        interval90_high: deviation.and_then(|d| d.interval90).map(|[_, high]| high),
        deviation_from_scene: deviation.and_then(|d| d.deviation_from_scene),
        bound: deviation.and_then(|d| d.bound),
        within: deviation.and_then(|d| d.within),
        interval_within: deviation.and_then(|d| d.interval_within),
        on_front: deviation.map(|d| d.on_front),
    }
}

/// One observable of a reference, as `references.csv` has it.
#[derive(Clone, Debug, Serialize)]
pub(super) struct ReferenceRow<'a> {
    stiffness_factor: f64,
    youngs_modulus: f64,
    setting: &'a str,
    observable: &'a str,
    unit: &'a str,
    seeds: usize,
    mean: f64,
    standard_deviation: f64,
    standard_error: Option<f64>,
    coarse_step: f64,
    middle_step: f64,
    fine_step: f64,
    coarse_mean: Option<f64>,
    middle_mean: Option<f64>,
    fine_mean: Option<f64>,
    observed_order: Option<f64>,
    richardson: Option<f64>,
    safety_factor: Option<f64>,
    grid_convergence_index: Option<f64>,
    shift: Option<f64>,
    shift_standard_error: Option<f64>,
}

impl ReferenceRow<'_> {
    /// The row of a reference.
    pub(super) fn of(reference: &Reference) -> ReferenceRow<'_> {
        let [coarse_step, middle_step, fine_step] = reference.steps;
        let mean = |grid: usize| reference.grid_means.map(|means| means[grid]);
        let convergence = reference.convergence.as_ref();
        ReferenceRow {
            stiffness_factor: reference.stiffness_factor,
            youngs_modulus: reference.youngs_modulus,
            setting: &reference.setting,
            observable: &reference.observable,
            unit: &reference.unit,
            seeds: reference.seeds,
            mean: reference.mean,
            standard_deviation: reference.standard_deviation,
            standard_error: reference.standard_error,
            coarse_step,
            middle_step,
            fine_step,
            coarse_mean: mean(0),
            middle_mean: mean(1),
            fine_mean: mean(2),
            observed_order: convergence.and_then(|c| c.observed_order),
            richardson: convergence.and_then(|c| c.richardson),
            safety_factor: convergence.map(|c| c.safety_factor),
            grid_convergence_index: convergence.map(|c| c.grid_convergence_index),
            shift: reference.shift,
            shift_standard_error: reference.shift_standard_error,
        }
    }
}
