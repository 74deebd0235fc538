//! One way to run one code.

use crate::draw::numbers::compact;
use crate::plan::Scene;
use makadam::scene::{SolverMethod, SolverSettings, Stop};
use serde::{Deserialize, Serialize};

/// One way to run one code: a point of the trade-off once it has run.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Configuration {
    /// Name of the code.
    pub code: String,
    /// Factor on every Young's modulus of the scene.
    pub stiffness_factor: f64,
    /// What the code lets one choose.
    pub knobs: Knobs,
}

/// What a code lets one choose.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(tag = "kind", rename_all = "kebab-case")]
pub enum Knobs {
    /// Makadam's solver.
    Solver {
        /// All settings.
        settings: SolverSettings,
        /// The axis that is varied beside step and sweeps, and its value, such as "warm start 0".
        variation: Option<String>,
    },
    /// An explicit code's time step.
    Explicit {
        /// Time step over the Rayleigh step.
        rayleigh_fraction: f64,
    },
}

impl Configuration {
    /// The scene as this configuration runs it, its stiffness scaled.
    pub fn scene(&self, scene: &Scene) -> Scene {
        let mut scene = scene.with_stiffness_factor(self.stiffness_factor);
        if let Knobs::Solver { settings, .. } = &self.knobs {
            scene.solver = settings.clone();
        }
        scene
    }

    /// Time step over the Rayleigh step, for explicit codes.
    pub fn rayleigh_fraction(&self) -> Option<f64> {
        match self.knobs {
            Knobs::Explicit { rayleigh_fraction } => Some(rayleigh_fraction),
            Knobs::Solver { .. } => None,
        }
    }

    /// Time step, s; explicit codes have theirs from the grains.
    pub fn step(&self) -> Option<f64> {
        match &self.knobs {
            Knobs::Solver { settings, .. } => Some(settings.step),
            Knobs::Explicit { .. } => None,
        }
    }

    /// Most iterations of a solve, for Makadam: sweeps, with Gauss-Seidel.
    pub fn sweeps(&self) -> Option<u32> {
        match &self.knobs {
            Knobs::Solver { settings, .. } => Some(settings.stop.max_sweeps()),
            Knobs::Explicit { .. } => None,
        }
    }

    /// The axis that is varied beside step and sweeps, and its value, for Makadam.
    pub fn variation(&self) -> Option<&str> {
        match &self.knobs {
            Knobs::Solver { variation, .. } => variation.as_deref(),
            Knobs::Explicit { .. } => None,
        }
    }

    /// The knobs in a few words: "0.5 ms × 10 sweeps, warm start 0", or "20% of the Rayleigh step".
    pub fn setting(&self) -> String {
        match &self.knobs {
            Knobs::Solver { settings, variation } => {
                let bound = match settings.stop {
                    Stop::Sweeps { .. } => "",
                    Stop::Residual { .. } | Stop::TimeBudget { .. } => "at most ",
                };
                let sweeps = settings.stop.max_sweeps();
                let varied = variation.as_ref().map_or(String::new(), |variation| format!(", {variation}"));
                // An iteration of the other methods is no sweep, and inner sweeps make it several.
                let plain = settings.method == SolverMethod::GaussSeidel && settings.inner_sweeps <= 1;
                let unit = if plain { "sweeps" } else { "iterations" };
                format!("{} ms × {bound}{sweeps} {unit}{varied}", compact(1e3 * settings.step))
            }
            Knobs::Explicit { rayleigh_fraction } => {
                format!("{}% of the Rayleigh step", compact(100.0 * rayleigh_fraction))
            }
        }
    }

    /// The knobs where there is little room: "0.5×10", or "20%".
    pub fn short_setting(&self) -> String {
        match &self.knobs {
            Knobs::Solver { settings, variation } => {
                let varied = variation.as_ref().map_or(String::new(), |variation| format!(", {variation}"));
                let sweeps = match settings.stop {
                    Stop::Sweeps { sweeps } => format!("×{sweeps}"),
                    Stop::Residual { max_sweeps, .. } => format!("≤{max_sweeps}"),
                    Stop::TimeBudget { .. } => String::new(),
                };
                format!("{} ms{sweeps}{varied}", compact(1e3 * settings.step))
            }
            Knobs::Explicit { rayleigh_fraction } => format!("{}%", compact(100.0 * rayleigh_fraction)),
        }
    }
}
