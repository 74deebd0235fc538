//! What a run will take, from those that have ended: for the order, the time left, and what is cut short.

use super::configuration::{Configuration, Knobs};
use crate::plan::Scene;
use makadam::scene::{SolverMethod, SolverSettings, Stop};
use std::collections::BTreeMap;

/// Time of a grain's step before anything has run, s: of the right order on a processor of the 2020s.
const GUESSES: [(&str, f64); 4] = [("Makadam", 1e-7), ("LIGGGHTS", 3e-7), ("LAMMPS", 5e-7), ("YADE", 9e-7)];

/// Cost of one sweep over the contacts of a grain, over that of everything else in a step of Makadam.
const SWEEP: f64 = 0.17;

/// Sweeps that a solve is expected to take where its residual or its time says when to stop.
const OPEN_ENDED: u32 = 20;

/// Expected wall times.
pub(super) struct Costs {
    scene: Scene,
    grains: f64,
    /// Rayleigh step at the scene's stiffness, s.
    rayleigh_step: f64,
    /// Wall time and expected units of the runs so far, by code.
    known: BTreeMap<String, [f64; 2]>,
}

impl Costs {
    pub(super) fn new(scene: &Scene, grains: usize, rayleigh_step: f64) -> Costs {
        Costs { scene: scene.clone(), grains: grains as f64, rayleigh_step, known: BTreeMap::new() }
    }

    /// Grain steps of a second, those of Makadam weighted by their sweeps.
    fn units(&self, configuration: &Configuration) -> f64 {
        let per_second = match &configuration.knobs {
            Knobs::Solver { settings, .. } => {
                let sweeps = match settings.stop {
                    Stop::Sweeps { sweeps } => sweeps,
                    Stop::Residual { max_sweeps, .. } | Stop::TimeBudget { max_sweeps, .. } => {
                        max_sweeps.min(OPEN_ENDED)
                    }
                };
                (1.0 + SWEEP * f64::from(sweeps) * sweeps_of_iteration(settings)) / settings.step
            }
            // The Rayleigh step goes as the inverse root of the stiffness.
            Knobs::Explicit { rayleigh_fraction } => {
                configuration.stiffness_factor.sqrt() / (rayleigh_fraction * self.rayleigh_step)
            }
        };
        self.grains * per_second
    }

    /// Expected wall time of a run over the scene's whole duration, s.
    pub(super) fn seconds(&self, configuration: &Configuration) -> f64 {
        let each = match self.known.get(&configuration.code) {
            Some([seconds, units]) => seconds / units,
            None => GUESSES.iter().find(|(code, _)| *code == configuration.code).map_or(1e-6, |guess| guess.1),
        };
        each * self.units(configuration) * self.scene.duration
    }

    /// Takes note of a run's wall time over a simulated time, both in s.
    pub(super) fn learn(&mut self, configuration: &Configuration, wall: f64, simulated: f64) {
        let units = self.units(configuration) * simulated;
        let known = self.known.entry(configuration.code.clone()).or_default();
        known[0] += wall;
        known[1] += units;
    }
}

/// Wall time of an iteration over that of a sweep, from `reference-scenes/drum-50k/convergence`; a rough guide, which the runs
/// themselves correct.
fn sweeps_of_iteration(settings: &SolverSettings) -> f64 {
    let inner = f64::from(settings.inner_sweeps.max(1));
    match settings.method {
        SolverMethod::GaussSeidel => inner,
        SolverMethod::NonlinearConjugateGradients => inner + 1.7,
        SolverMethod::Anderson { .. } => inner + 3.9,
        SolverMethod::Jacobi { .. } => 3.9,
        SolverMethod::AcceleratedProjectedGradients | SolverMethod::ProjectedConjugateGradients => 6.0,
    }
}
