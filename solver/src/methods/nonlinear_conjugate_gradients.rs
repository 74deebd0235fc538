//! Nonlinear conjugate gradients over Gauss-Seidel sweeps.
//!
//! After M. Silcowitz-Hansen, S. Niebe and K. Erleben, *A nonsmooth nonlinear conjugate gradient method for interactive contact
//! force problems*, The Visual Computer 26 (2010). The change of a sweep stands for the negative gradient:
//!
//! ```text
//! s_k   = sweep(y_k)              g_k = y_k - s_k
//! beta  = |g_k|^2 / |g_k-1|^2     (Fletcher and Reeves), restart with p = 0 where beta > 1
//! y_k+1 = s_k + beta p            p <- beta p - g_k
//! ```
//!
//! so that p is always `y_k+1 - y_k`. Gradients are measured as a sweep's residual, |delta lambda| S in m/s: it comes free, and
//! impulses of grains of different mass would not compare. An iteration extrapolates first and then sweeps, so that it leaves
//! impulses inside their cones.

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
    /// From the point before it to it.
    direction: State,
    /// Fletcher and Reeves's factor; absent in the first iteration, which has no direction.
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
                // The first direction is the first sweep's change, which the next transform makes of it.
                problem.keep(&mut self.point);
                problem.transform(&[[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0; 3]], &mut self.point, &mut self.direction);
            }
            Some(beta) if beta > 1.0 => {
                // Restart: the next sweep goes from here without a direction.
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
