//! Nonlinear conjugate gradients over Gauss-Seidel sweeps.
//!
//! Method of M. Silcowitz-Hansen, S. Niebe and K. Erleben, *A nonsmooth nonlinear conjugate gradient method for interactive
//! contact force problems*, The Visual Computer 26 (2010). The change of a sweep serves as the negative gradient:
//!
//! ```text
//! s_k   = sweep(y_k)              g_k = y_k - s_k
//! beta  = |g_k|^2 / |g_k-1|^2     (Fletcher and Reeves), restart with p = 0 if beta > 1
//! y_k+1 = s_k + beta p            p <- beta p - g_k
//! ```
//!
//! so that p is always `y_k+1 - y_k`. The norm of a gradient is a sweep's residual, |delta lambda| S in m/s: it costs nothing,
//! while impulses of grains of different mass are not comparable. An iteration extrapolates first and then sweeps, so that
//! impulses end inside their cones.

use super::gauss_seidel::OverRelaxation;
use super::problem::State;
use super::{Method, Problem};
use crate::sweep::{ResidualLevel, Residuals};

/// Nonlinear conjugate gradients.
#[derive(Clone, Debug, Default)]
pub(super) struct NonlinearConjugateGradients {
    factor: OverRelaxation,
    /// State before the last sweep.
    point: State,
    /// Displacement from the previous point to `point`.
    direction: State,
    /// Fletcher-Reeves factor; `None` in the first iteration, which has no direction.
    beta: Option<f64>,
    /// Squared residual of the last sweep, m2/s2.
    last: f64,
}

impl Method for NonlinearConjugateGradients {
    fn begin(&mut self, problem: &mut Problem<'_>) {
        problem.number_groups();
        self.factor.begin(problem.settings.over_relaxation);
        self.point.fit(problem);
        self.direction.fit(problem);
        (self.beta, self.last) = (None, f64::INFINITY);
    }

    fn iterate(&mut self, problem: &mut Problem<'_>, _: ResidualLevel) -> Option<Residuals> {
        match self.beta {
            None => {
                // The first direction is the change of the first sweep, computed by the next transform.
                problem.keep(&mut self.point);
                problem.transform(&[[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0; 3]], &mut self.point, &mut self.direction);
            }
            Some(beta) if beta > 1.0 => {
                // Restart: the next sweep starts from here without a direction.
                problem.transform(&[[1.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0; 3]], &mut self.point, &mut self.direction);
                self.factor.fall_back();
            }
            Some(beta) => {
                let extrapolated = [1.0, 0.0, beta];
                let coefficients = [extrapolated, extrapolated, [1.0, -1.0, beta]];
                problem.transform(&coefficients, &mut self.point, &mut self.direction);
            }
        }
        let residuals = problem.sweep(self.factor.value, ResidualLevel::Directions)?;
        let square = residuals.rms() * residuals.rms();
        self.beta = Some(if square > 0.0 { square / self.last } else { 0.0 });
        self.last = square;
        Some(residuals)
    }

    fn fell_back(&self) -> bool {
        self.factor.fell_back
    }

    fn memory_bytes(&self) -> usize {
        self.point.memory_bytes() + self.direction.memory_bytes()
    }
}
