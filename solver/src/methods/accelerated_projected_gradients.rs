//! Accelerated projected gradient descent.
//!
//! After H. Mazhar, T. Heyn, D. Negrut and A. Tasora, *Using Nesterov's method to accelerate multibody dynamics with friction and
//! contact*, ACM Transactions on Graphics 34 (2015), in the metric of the operator's diagonal D:
//!
//! ```text
//! x_k+1     = P(y_k - D^-1 g(y_k) / L)        g(y) = S y - b; L doubles while d.S d > L d.D d, d = x_k+1 - y_k
//! theta_k+1 = (sqrt(theta_k^4 + 4 theta_k^2) - theta_k^2) / 2
//! y_k+1     = x_k+1 + theta_k (1 - theta_k) / (theta_k^2 + theta_k+1) (x_k+1 - x_k)
//! ```
//!
//! with a restart (theta = 1, y = x) where `g.(x_k+1 - x_k) > 0` and L decaying by a tenth an iteration. For the quadratic dual
//! `f(x) - f(y) - g.d` is `d.S d / 2`: the kinetic energy of the change of velocities and a compliant part, so that
//! backtracking evaluates no function and loses no digits.
//!
//! The paper's projection is the orthogonal one onto the cone, which makes the problem convex and lets sliding contacts dilate. Here P
//! is the exact Coulomb law, first the normal impulse and then the disc at that impulse. A fixed point obeys Coulomb, but it
//! minimises no function, so the theory (rate 1/k^2, descent) holds for scenes without friction only; with friction the method is a
//! heuristic that may stall.

use super::problem::State;
use super::{Method, Problem};
use crate::sweep::{ResidualLevel, Residuals};

/// The operator scaled by its diagonal has a trace of one a row, so its largest eigenvalue is no smaller.
const SMALLEST_CURVATURE: f64 = 1.0;

/// It is no larger than the number of contacts of a grain (see `jacobi`): only rounding doubles as far as this.
const LARGEST_CURVATURE: f64 = 1e3;

/// Factor of L after an iteration.
const DECAY: f64 = 0.9;

/// Accelerated projected gradients.
#[derive(Clone, Debug, Default)]
pub(super) struct AcceleratedProjectedGradients {
    /// x of the last iteration.
    last: State,
    /// y, where the gradient is taken.
    ahead: State,
    /// Room for the change of velocities.
    change: State,
    curvature: f64,
    theta: f64,
    momentum: f64,
}

impl Method for AcceleratedProjectedGradients {
    fn begin(&mut self, problem: &mut Problem<'_>) {
        problem.number_groups();
        self.last.fit(problem);
        self.ahead.fit(problem);
        self.change.velocities.clear();
        self.change.velocities.extend_from_slice(problem.bodies);
        (self.curvature, self.theta, self.momentum) = (SMALLEST_CURVATURE, 1.0, 0.0);
        problem.keep(&mut self.last);
    }

    fn iterate(&mut self, problem: &mut Problem<'_>, _: ResidualLevel) -> Option<Residuals> {
        // y = x + momentum (x - last), last = x.
        let here = [1.0, 0.0, 0.0];
        let coefficients = [here, here, [1.0 + self.momentum, -self.momentum, 0.0]];
        problem.transform(&coefficients, &mut self.last, &mut self.ahead);
        let step = loop {
            let step = problem.projected_step(&self.ahead, &self.last.impulses, 1.0 / self.curvature);
            let kinetic = problem.velocity_change(&self.ahead.velocities, &mut self.change.velocities);
            if kinetic + step.compliant <= self.curvature * step.scaled || self.curvature >= LARGEST_CURVATURE {
                break step;
            }
            self.curvature *= 2.0;
        };
        let square = self.theta * self.theta;
        let theta = 0.5 * ((square * square + 4.0 * square).sqrt() - square);
        self.momentum = self.theta * (1.0 - self.theta) / (square + theta);
        self.theta = theta;
        if step.slope > 0.0 {
            (self.theta, self.momentum) = (1.0, 0.0);
        }
        self.curvature = (DECAY * self.curvature).max(SMALLEST_CURVATURE);
        Some(step.residuals)
    }

    fn memory_bytes(&self) -> usize {
        self.last.memory_bytes() + self.ahead.memory_bytes() + self.change.memory_bytes()
    }
}
