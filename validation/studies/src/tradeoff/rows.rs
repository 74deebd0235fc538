//! Rows of a trade-off: references, points, the fastest settings; and the verification of a reference over three grids: observed
//! order, Richardson's estimate, grid convergence index.
//!
//! With the step halved twice, and f1, f2, f3 on the fine, middle and coarse grid (Roache, *Verification and validation
//! in computational science and engineering*, 1998; ASME V&V 20):
//!
//! ```text
//! p   = log2((f3 - f2)/(f2 - f1))          observed order
//! f   = f1 + (f1 - f2)/(2^p - 1)           Richardson's estimate of the limit
//! GCI = F |f2 - f1|/(2^p - 1)              F = 1.25
//! ```
//!
//! The time stepping is of first order. Where the observed order is off, or the differences are below the spread over
//! seeds, there is no estimate, and the index takes p = 1 and F = 3.

use makadam_measure::statistics::{mean, standard_error};
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;

/// Tolerated deviation of an observable from the converged reference.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Bound {
    /// Name of the observable.
    pub observable: String,
    /// Largest absolute deviation, in the observable's unit.
    pub value: f64,
}

/// Default deviations.
const USUAL: [(&str, f64); 3] =
    [("dynamic_angle_of_repose", 0.5), ("static_angle_of_repose", 0.5), ("packing_fraction", 0.002)];

impl Bound {
    /// Default bounds; degrees for angles.
    pub fn usual() -> Vec<Bound> {
        USUAL.iter().map(|&(name, value)| Bound { observable: name.into(), value }).collect()
    }
}

/// One observable of a converged reference of Makadam.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[expect(missing_docs, reason = "validation/docs/json.md describes the fields of documents")]
pub struct Reference {
    pub stiffness_factor: f64,
    pub youngs_modulus: f64,
    /// Setting of the finest grid.
    pub setting: String,
    pub observable: String,
    pub unit: String,
    pub seeds: usize,
    /// Mean over seeds on the finest grid, from which deviations are taken.
    pub mean: f64,
    pub standard_deviation: f64,
    pub standard_error: Option<f64>,
    /// Steps of the three grids, coarse to fine, s.
    pub steps: [f64; 3],
    /// Means on the three grids; absent where a grid has not run with all seeds.
    pub grid_means: Option<[f64; 3]>,
    pub convergence: Option<Convergence>,
    /// Mean minus the mean of the reference at the scene's stiffness; absent there.
    pub shift: Option<f64>,
    /// Standard error of the shift, seed by seed.
    pub shift_standard_error: Option<f64>,
}

/// Values of one observable by seed.
pub type Values = BTreeMap<u64, f64>;

/// One observable of one configuration against the reference at the same stiffness, seed by seed.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[expect(missing_docs, reason = "validation/docs/json.md describes the fields of documents")]
pub struct Deviation {
    pub observable: String,
    pub unit: String,
    /// Number of seeds common with the reference.
    pub seeds: usize,
    pub mean: f64,
    pub standard_error: Option<f64>,
    /// Mean of the differences from the reference: the error.
    pub deviation: f64,
    pub deviation_standard_error: Option<f64>,
    /// 90% interval of the deviation (Student's t over seeds); absent for a single seed.
    pub interval90: Option<[f64; 2]>,
    pub bound: Option<f64>,
    pub within: Option<bool>,
    pub interval_within: Option<bool>,
    /// True if no other setting of the code at this stiffness is both faster and nearer.
    pub on_front: bool,
    /// Differences from the reference, by seed.
    #[serde(skip)]
    pub differences: Values,
}

/// Configuration after its run.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[expect(missing_docs, reason = "validation/docs/json.md describes the fields of documents")]
pub struct Point {
    pub code: String,
    pub version: String,
    /// Settings as text.
    pub setting: String,
    pub stiffness_factor: f64,
    pub youngs_modulus: f64,
    pub time_step: f64,
    /// Time step over the Rayleigh step, for explicit codes.
    pub rayleigh_fraction: Option<f64>,
    /// Most iterations of a solve, for Makadam: sweeps, with Gauss-Seidel.
    pub sweeps: Option<u32>,
    /// Variation in addition to step and sweeps, for Makadam, such as "single precision".
    pub variation: Option<String>,
    pub seeds: Vec<u64>,
    /// Processor time of the stepping over simulated time, median over seeds.
    pub wall_seconds_per_simulated_second: f64,
    pub wall_seconds_per_simulated_second_least: f64,
    pub wall_seconds_per_simulated_second_most: f64,
    pub simulated_seconds: f64,
    /// True if a seed failed, so that the setting meets no bound.
    pub failed: bool,
    /// True if this is the reference itself, whose deviation is zero by definition.
    pub reference: bool,
    pub deviations: Vec<Deviation>,
    /// True if all bounds are met; absent where a bounded observable was not measured or there are no bounds.
    pub within_bounds: Option<bool>,
    pub intervals_within_bounds: Option<bool>,
}

impl Point {
    /// Returns true if the point is a setting of a code at a stiffness.
    pub(super) fn is_of(&self, code: &str, stiffness_factor: f64) -> bool {
        self.code == code && self.stiffness_factor == stiffness_factor
    }

    /// Returns the deviation of an observable.
    pub fn deviation(&self, observable: &str) -> Option<&Deviation> {
        self.deviations.iter().find(|deviation| deviation.observable == observable)
    }
}

/// Fastest setting of a code that meets all bounds.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[expect(missing_docs, reason = "validation/docs/json.md describes the fields of documents")]
pub struct Fastest {
    pub code: String,
    pub stiffness_factor: f64,
    pub youngs_modulus: f64,
    /// Setting; absent if none meets them.
    pub setting: Option<String>,
    pub wall_seconds_per_simulated_second: Option<f64>,
    pub intervals_within_bounds: Option<bool>,
    /// Wall time over that of Makadam's fastest setting at the same stiffness.
    pub ratio_to_makadam: Option<f64>,
    /// Lower end of the 90% interval of this ratio, with the fastest settings of each sample of the seeds. Absent for Makadam, for
    /// a single seed, and where the code meets the bounds in no sample.
    pub ratio_low: Option<f64>,
    /// Upper end; absent also where the code meets the bounds in fewer than 95% of the samples.
    pub ratio_high: Option<f64>,
}

/// Order of the time stepping.
const FORMAL_ORDER: f64 = 1.0;
/// Range of credible observed orders.
const CREDIBLE: std::ops::RangeInclusive<f64> = 0.5..=2.0;
/// Safety factor where the order was observed, and where it was not.
const SAFETY: [f64; 2] = [1.25, 3.0];

/// Estimate of the limit from three grids.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Convergence {
    /// Observed order; absent unless the differences have one sign and exceed their standard errors over seeds.
    pub observed_order: Option<f64>,
    /// Richardson's estimate of the limit; absent unless the observed order is credible.
    pub richardson: Option<f64>,
    /// Safety factor of the index.
    pub safety_factor: f64,
    /// Grid convergence index: half the width of a band about the fine grid's value, in the observable's unit.
    pub grid_convergence_index: f64,
}

impl Convergence {
    /// Estimates from the values on three grids, coarse to fine, each over the same seeds; absent without seeds.
    pub fn of(grids: [&[f64]; 3]) -> Option<Convergence> {
        let [coarse, middle, fine] = grids;
        if fine.is_empty() || coarse.len() != fine.len() || middle.len() != fine.len() {
            return None;
        }
        let differences = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a - b).collect::<Vec<f64>>();
        let (outer, inner) = (differences(coarse, middle), differences(middle, fine));
        // The noise of a single seed is not known.
        let audible = |steps: &[f64]| standard_error(steps).is_none_or(|error| mean(steps).abs() > error);
        let (step_out, step_in) = (mean(&outer), mean(&inner));
        let ratio = step_out / step_in;
        let observed_order =
            (ratio > 0.0 && ratio.is_finite() && audible(&outer) && audible(&inner)).then(|| ratio.log2());
        let credible = observed_order.filter(|order| CREDIBLE.contains(order));
        let (order, safety_factor) = match credible {
            Some(order) => (order, SAFETY[0]),
            None => (FORMAL_ORDER, SAFETY[1]),
        };
        let reach = step_in / (order.exp2() - 1.0);
        Some(Convergence {
            observed_order,
            richardson: credible.map(|_| mean(fine) - reach),
            safety_factor,
            grid_convergence_index: safety_factor * reach.abs(),
        })
    }
}
