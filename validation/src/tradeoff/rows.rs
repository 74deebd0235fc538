//! The rows of a trade-off: references, points, the fastest settings.

use super::convergence::Convergence;
use serde::{Deserialize, Serialize};

/// A tolerated deviation of an observable from the converged reference.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Bound {
    /// Name of the observable.
    pub observable: String,
    /// Largest absolute deviation, in the observable's unit.
    pub value: f64,
}

/// Tolerated deviations where none are given.
const USUAL: [(&str, f64); 3] =
    [("dynamic_angle_of_repose", 0.5), ("static_angle_of_repose", 0.5), ("packing_fraction", 0.002)];

impl Bound {
    /// Those that hold where none are given: degrees for angles.
    pub fn usual() -> Vec<Bound> {
        USUAL.iter().map(|&(name, value)| Bound { observable: name.into(), value }).collect()
    }
}

/// One observable of a converged reference of Makadam.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Reference {
    /// Factor on every Young's modulus.
    pub stiffness_factor: f64,
    /// Young's modulus of the grains, Pa.
    pub youngs_modulus: f64,
    /// The finest grid's setting.
    pub setting: String,
    /// Name of the observable.
    pub observable: String,
    /// Its unit; empty where it has none.
    pub unit: String,
    /// Seeds that have it.
    pub seeds: usize,
    /// Mean over seeds on the finest grid: what deviations are taken from.
    pub mean: f64,
    /// Standard deviation over seeds.
    pub standard_deviation: f64,
    /// Standard error of the mean; absent for a single seed.
    pub standard_error: Option<f64>,
    /// Steps of the three grids, coarse to fine, s.
    pub steps: [f64; 3],
    /// Means on the three grids; absent where a grid has not run with all seeds.
    pub grid_means: Option<[f64; 3]>,
    /// What the three grids say of the limit.
    pub convergence: Option<Convergence>,
    /// Mean minus the mean of the reference at the scene's stiffness; absent there.
    pub shift: Option<f64>,
    /// Standard error of the shift, seed by seed.
    pub shift_standard_error: Option<f64>,
}

/// One observable of one configuration against the reference at the same stiffness, seed by seed.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Deviation {
    /// Name of the observable.
    pub observable: String,
    /// Its unit; empty where it has none.
    pub unit: String,
    /// Seeds that the reference has too.
    pub seeds: usize,
    /// Mean over these seeds.
    pub mean: f64,
    /// Its standard error; absent for a single seed.
    pub standard_error: Option<f64>,
    /// Mean of the differences from the reference: the error.
    pub deviation: f64,
    /// Standard error of the deviation; absent for a single seed.
    pub deviation_standard_error: Option<f64>,
    /// 90% interval of the deviation (Student's t over seeds); absent for a single seed.
    pub interval90: Option<[f64; 2]>,
    /// Deviation from the reference at the scene's own stiffness; absent for configurations at that stiffness.
    pub deviation_from_scene: Option<f64>,
    /// Tolerated deviation, if there is one.
    pub bound: Option<f64>,
    /// Whether the deviation lies within the bound.
    pub within: Option<bool>,
    /// Whether its 90% interval does.
    pub interval_within: Option<bool>,
    /// Whether no other setting of the code at this stiffness is both faster and nearer.
    pub on_front: bool,
}

/// A configuration once it has run.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Point {
    /// The code.
    pub code: String,
    /// Its version.
    pub version: String,
    /// Its knobs in words.
    pub setting: String,
    /// The same where there is little room.
    pub short_setting: String,
    /// Factor on every Young's modulus.
    pub stiffness_factor: f64,
    /// Young's modulus of the grains, Pa.
    pub youngs_modulus: f64,
    /// Time step, s.
    pub time_step: f64,
    /// Time step over the Rayleigh step, for explicit codes.
    pub rayleigh_fraction: Option<f64>,
    /// Most iterations of a solve, for Makadam: sweeps, with Gauss-Seidel.
    pub sweeps: Option<u32>,
    /// What is varied beside step and sweeps, for Makadam, such as "single precision"; absent where nothing is.
    pub variation: Option<String>,
    /// Seeds that were run.
    pub seeds: Vec<u64>,
    /// Wall time of the stepping over simulated time on a core of its own, median over seeds
    /// ([`KeptRun::pace`](super::KeptRun::pace)).
    pub wall_seconds_per_simulated_second: f64,
    /// The fastest seed.
    pub wall_seconds_per_simulated_second_least: f64,
    /// The slowest seed.
    pub wall_seconds_per_simulated_second_most: f64,
    /// Smallest share of a core that a run got; absent where the system does not tell.
    pub core_share_least: Option<f64>,
    /// Simulated time of a run, s.
    pub simulated_seconds: f64,
    /// Whether runs were cut short after that time, so that the wall time is extrapolated and there are no deviations.
    pub extrapolated: bool,
    /// Whether it failed with a seed, so that it keeps no bound.
    pub failed: bool,
    /// Whether this is the reference itself, whose deviation is zero by definition.
    pub reference: bool,
    /// Its observables.
    pub deviations: Vec<Deviation>,
    /// Whether all bounds are kept; absent where a bounded observable was not measured or there are no bounds.
    pub within_bounds: Option<bool>,
    /// Whether all 90% intervals lie within the bounds.
    pub intervals_within_bounds: Option<bool>,
}

impl Point {
    /// An observable's deviation.
    pub fn deviation(&self, observable: &str) -> Option<&Deviation> {
        self.deviations.iter().find(|deviation| deviation.observable == observable)
    }
}

/// The fastest setting of a code that keeps all bounds.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Fastest {
    /// The code.
    pub code: String,
    /// Factor on every Young's modulus.
    pub stiffness_factor: f64,
    /// Young's modulus of the grains, Pa.
    pub youngs_modulus: f64,
    /// The setting; absent if none keeps them.
    pub setting: Option<String>,
    /// Its wall time over simulated time.
    pub wall_seconds_per_simulated_second: Option<f64>,
    /// Whether its 90% intervals lie within the bounds too.
    pub intervals_within_bounds: Option<bool>,
    /// Its wall time over that of Makadam's fastest setting at the same stiffness.
    pub ratio_to_makadam: Option<f64>,
    /// Lower end of the 90% interval of this ratio, each setting being the fastest of a sample of the seeds; absent for Makadam, for
    /// a single seed, and where the code keeps the bounds in no sample.
    pub ratio_low: Option<f64>,
    /// Upper end; absent also where the code keeps the bounds in fewer than 95% of the samples.
    pub ratio_high: Option<f64>,
}

/// What a variation of the solver beside step and sweeps comes to, at the scene's stiffness.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Varied {
    /// The axis and its value, such as "single precision".
    pub variation: String,
    /// Settings with it that were run.
    pub settings: usize,
    /// The fastest of them that keeps all bounds; absent if none does or there are no bounds.
    pub setting: Option<String>,
    /// Its wall time over simulated time.
    pub wall_seconds_per_simulated_second: Option<f64>,
    /// Whether its 90% intervals lie within the bounds too.
    pub intervals_within_bounds: Option<bool>,
    /// Its wall time over that of the fastest setting within the bounds that varies step and sweeps alone.
    pub ratio_to_plain: Option<f64>,
}
