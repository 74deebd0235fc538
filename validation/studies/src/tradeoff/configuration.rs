//! Configurations: a code with its settings, and the variations of Makadam's solver: method, precision, warm start, sweeps.

use makadam::scene::{Precision, SolverMethod, SolverSettings, Stop};
use makadam_frames::plan::Scene;
use makadam_view::draw::numbers::compact;
use serde::{Deserialize, Serialize};

/// A code with its settings: a point of the trade-off once it has run.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Configuration {
    /// Name of the code.
    pub code: String,
    /// Factor on every Young's modulus of the scene.
    pub stiffness_factor: f64,
    /// Its settings.
    pub knobs: Knobs,
}

/// Settings of a code.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(tag = "kind", rename_all = "kebab-case")]
pub enum Knobs {
    /// Makadam's solver.
    Solver {
        /// All settings.
        settings: SolverSettings,
        /// The axis that is varied in addition to step and sweeps, and its value, such as "warm start 0".
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

    fn solver(&self) -> Option<(&SolverSettings, Option<&str>)> {
        match &self.knobs {
            Knobs::Solver { settings, variation } => Some((settings, variation.as_deref())),
            Knobs::Explicit { .. } => None,
        }
    }

    /// Time step of Makadam, s; explicit codes derive theirs from the grains.
    pub fn step(&self) -> Option<f64> {
        self.solver().map(|(settings, _)| settings.step)
    }

    /// Most iterations of a solve of Makadam: sweeps, with Gauss-Seidel.
    pub fn sweeps(&self) -> Option<u32> {
        self.solver().map(|(settings, _)| settings.stop.max_sweeps())
    }

    /// The axis that is varied in addition to step and sweeps, and its value, for Makadam.
    pub fn variation(&self) -> Option<&str> {
        self.solver().and_then(|(_, variation)| variation)
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

/// A change of one setting of the solver, in addition to step and sweeps.
pub(super) struct Variation {
    /// The axis and its value, as tables name it.
    pub(super) name: &'static str,
    change: fn(&mut SolverSettings),
    /// Iterations of a solve at which it is run in addition to the scene's own settings. Methods whose iteration costs several sweeps
    /// have fewer, so that wall times overlap with those of sweeps.
    pub(super) iterations: &'static [u32],
}

const fn vary(name: &'static str, iterations: &'static [u32], change: fn(&mut SolverSettings)) -> Variation {
    Variation { name, change, iterations }
}

/// Iterations of methods that cost about a sweep, or need many.
const SWEEPS: &[u32] = &[5, 10, 20];
/// Iterations of methods that cost several sweeps.
const FEW: &[u32] = &[3, 5, 10];
/// Most sweeps of a solve that stops at a residual, up to those of the reference.
const MOST: &[u32] = &[10, 20, 40];

pub(super) const VARIATIONS: [Variation; 15] = [
    vary("warm start 0", SWEEPS, |settings| settings.warm_start = 0.0),
    vary("over-relaxation 1", SWEEPS, |settings| settings.over_relaxation = 1.0),
    vary("2 inner sweeps", FEW, |settings| settings.inner_sweeps = 2),
    vary("4 inner sweeps", &[2, 3, 5], |settings| settings.inner_sweeps = 4),
    vary("residual 0.1", MOST, |settings| settings.stop = down_to(0.1, settings)),
    vary("residual 0.03", MOST, |settings| settings.stop = down_to(0.03, settings)),
    vary("residual 0.01", MOST, |settings| settings.stop = down_to(0.01, settings)),
    vary("residual 0.003", MOST, |settings| settings.stop = down_to(0.003, settings)),
    vary("calm contacts, residual 0.1", MOST, calm_contacts),
    vary("single precision", SWEEPS, |settings| settings.precision = Precision::Single),
    vary("Anderson", FEW, |settings| settings.method = SolverMethod::Anderson { memory: 3 }),
    vary("nonlinear conjugate gradients", FEW, |settings| settings.method = SolverMethod::NonlinearConjugateGradients),
    vary("accelerated projected gradients", FEW, |settings| {
        settings.method = SolverMethod::AcceleratedProjectedGradients
    }),
    vary("Jacobi", SWEEPS, |settings| settings.method = SolverMethod::Jacobi { damping: 0.3 }),
    vary("projected conjugate gradients", FEW, |settings| settings.method = SolverMethod::ProjectedConjugateGradients),
];

/// Stops at a residual, in units of g h, or after the sweeps of the settings.
fn down_to(tolerance: f64, settings: &SolverSettings) -> Stop {
    Stop::Residual { tolerance, max_sweeps: settings.stop.max_sweeps() }
}

/// Settings for long steps, so that packings are no denser than with short ones: overlaps recover over two steps instead of one, and
/// bounces last at least ten steps, because those of speeds below `5 g h` are suppressed. Both shake grains that come to rest.
fn calm_contacts(settings: &mut SolverSettings) {
    /// 5 g on Earth, m/s2.
    const SLOWEST_IMPACT_OVER_STEP: f64 = 50.0;
    settings.damping_steps = 2.0;
    let slowest = SLOWEST_IMPACT_OVER_STEP * settings.step;
    settings.restitution_threshold = Some(settings.restitution_threshold.map_or(slowest, |own| own.max(slowest)));
    settings.stop = down_to(0.1, settings);
}

impl Variation {
    pub(super) fn named(name: &str) -> Option<&'static Variation> {
        VARIATIONS.iter().find(|variation| variation.name == name)
    }

    /// Applies the change to settings; returns none if it changes nothing.
    pub(super) fn apply(&self, settings: &SolverSettings) -> Option<SolverSettings> {
        let mut changed = settings.clone();
        (self.change)(&mut changed);
        (changed != *settings).then_some(changed)
    }
}
