//! The rows of CSV files, one level deep.

use super::rows::{Point, Reference};
use crate::study::{Table, cells};

/// Points, one row an observable; a point without deviations has one row.
pub(super) fn points(points: &[Point]) -> Table {
    let rows = points.iter().flat_map(|point| {
        let none = point.deviations.is_empty().then_some((point, None));
        none.into_iter().chain(point.deviations.iter().map(move |deviation| (point, Some(deviation))))
    });
    Table::named(
        "code version setting stiffness_factor youngs_modulus time_step rayleigh_fraction sweeps variation seeds \
         wall_seconds_per_simulated_second wall_seconds_per_simulated_second_least wall_seconds_per_simulated_second_most \
         core_share_least simulated_seconds extrapolated failed reference within_bounds intervals_within_bounds \
         observable unit mean standard_error deviation deviation_standard_error interval90_low interval90_high \
         deviation_from_scene bound within interval_within on_front",
    )
    .of(rows, |(point, deviation)| {
        let interval = deviation.and_then(|d| d.interval90);
        cells![
            &point.code,
            &point.version,
            &point.setting,
            point.stiffness_factor,
            point.youngs_modulus,
            point.time_step,
            point.rayleigh_fraction,
            point.sweeps,
            point.variation.as_deref(),
            point.seeds.len(),
            point.wall_seconds_per_simulated_second,
            point.wall_seconds_per_simulated_second_least,
            point.wall_seconds_per_simulated_second_most,
            point.core_share_least,
            point.simulated_seconds,
            point.extrapolated,
            point.failed,
            point.reference,
            point.within_bounds,
            point.intervals_within_bounds,
            deviation.map(|d| &d.observable),
            deviation.map(|d| &d.unit),
            deviation.map(|d| d.mean),
            deviation.and_then(|d| d.standard_error),
            deviation.map(|d| d.deviation),
            deviation.and_then(|d| d.deviation_standard_error),
            interval.map(|[low, _]| low),
            interval.map(|[_, high]| high),
            deviation.and_then(|d| d.deviation_from_scene),
            deviation.and_then(|d| d.bound),
            deviation.and_then(|d| d.within),
            deviation.and_then(|d| d.interval_within),
            deviation.map(|d| d.on_front),
        ]
    })
}

/// References, one row an observable.
pub(super) fn references(references: &[Reference]) -> Table {
    Table::named(
        "stiffness_factor youngs_modulus setting observable unit seeds mean standard_deviation standard_error \
         coarse_step middle_step fine_step coarse_mean middle_mean fine_mean \
         observed_order richardson safety_factor grid_convergence_index shift shift_standard_error",
    )
    .of(references, |reference| {
        let mean = |grid: usize| reference.grid_means.map(|means| means[grid]);
        let convergence = reference.convergence.as_ref();
        cells![
            reference.stiffness_factor,
            reference.youngs_modulus,
            &reference.setting,
            &reference.observable,
            &reference.unit,
            reference.seeds,
            reference.mean,
            reference.standard_deviation,
            reference.standard_error,
            reference.steps[0],
            reference.steps[1],
            reference.steps[2],
            mean(0),
            mean(1),
            mean(2),
            convergence.and_then(|c| c.observed_order),
            convergence.and_then(|c| c.richardson),
            convergence.map(|c| c.safety_factor),
            convergence.map(|c| c.grid_convergence_index),
            reference.shift,
            reference.shift_standard_error,
        ]
    })
}
