//! Projected Gauss-Seidel: contacts are relaxed one after another, each with the latest velocities.
//!
//! Boxes and lane groups parallelise the method without changing it: see [`partition`](crate::partition).

use super::{Method, Problem};
use crate::sweep::{ResidualLevel, Residuals};

/// Sweeps, over-relaxed until the residual grows.
#[derive(Clone, Debug, Default)]
pub(super) struct GaussSeidel {
    factor: OverRelaxation,
}

impl Method for GaussSeidel {
    fn begin(&mut self, problem: &mut Problem<'_>) {
        self.factor.begin(problem.settings.over_relaxation);
    }

    fn iterate(&mut self, problem: &mut Problem<'_>, level: ResidualLevel) -> Option<Residuals> {
        let residuals = problem.sweep(self.factor.value, level);
        if let Some(residuals) = &residuals {
            self.factor.watch(residuals.rms());
        }
        residuals
    }

    fn fell_back(&self) -> bool {
        self.factor.fell_back
    }
}

/// Over-relaxation that falls back to 1 for the rest of the solve once the measured residual has grown: factors that accelerate
/// most systems never converge on some.
#[derive(Clone, Debug, Default)]
pub(super) struct OverRelaxation {
    pub value: f64,
    last: f64,
    pub fell_back: bool,
}

impl OverRelaxation {
    /// Starts a solve.
    pub fn begin(&mut self, factor: f64) {
        *self = OverRelaxation { value: factor, last: f64::INFINITY, fell_back: false };
    }

    /// Records a residual, m/s.
    pub fn watch(&mut self, residual: f64) {
        if residual > self.last {
            self.fall_back();
        }
        self.last = residual;
    }

    /// Ends over-relaxation for this solve.
    pub fn fall_back(&mut self) {
        if self.value > 1.0 {
            self.value = 1.0;
            self.fell_back = true;
        }
    }
}
