//! Solution verification over three grids: observed order, Richardson's estimate, grid convergence index.
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
//! The time stepping is of first order. Where the observed order is off, or the differences drown in the spread over
//! seeds, there is no estimate, and the index takes p = 1 and F = 3.

use crate::statistics::{mean, standard_error};
use serde::{Deserialize, Serialize};

/// Order of the time stepping.
const FORMAL_ORDER: f64 = 1.0;
/// Observed orders that are taken at their word.
const CREDIBLE: std::ops::RangeInclusive<f64> = 0.5..=2.0;
/// Safety factor where the order was observed, and where it was not.
const SAFETY: [f64; 2] = [1.25, 3.0];

/// What three grids say of the limit.
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
    /// From the values on three grids, coarse to fine, each over the same seeds; absent without seeds.
    pub fn of(grids: [&[f64]; 3]) -> Option<Convergence> {
        let [coarse, middle, fine] = grids;
        if fine.is_empty() || coarse.len() != fine.len() || middle.len() != fine.len() {
            return None;
        }
        let differences = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a - b).collect::<Vec<f64>>();
        let (outer, inner) = (differences(coarse, middle), differences(middle, fine));
        // One seed's noise is not known.
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
