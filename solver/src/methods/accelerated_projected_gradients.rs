//! Accelerated projected gradient descent.
//!
//! Method of H. Mazhar, T. Heyn, D. Negrut and A. Tasora, *Using Nesterov's method to accelerate multibody dynamics with friction
//! and contact*, ACM Transactions on Graphics 34 (2015), in the metric of the operator's diagonal D:
//!
//! ```text
//! x_k+1     = P(y_k - D^-1 g(y_k) / L)        g(y) = S y - b; L doubles while d.S d > L d.D d, d = x_k+1 - y_k
//! theta_k+1 = (sqrt(theta_k^4 + 4 theta_k^2) - theta_k^2) / 2
//! y_k+1     = x_k+1 + theta_k (1 - theta_k) / (theta_k^2 + theta_k+1) (x_k+1 - x_k)
//! ```
//!
//! with a restart (theta = 1, y = x) if `g.(x_k+1 - x_k) > 0`, and L decaying by a tenth per iteration. For the quadratic dual,
//! `f(x) - f(y) - g.d` is `d.S d / 2`: the kinetic energy of the change of velocities and a compliant part. So backtracking
//! evaluates no function and loses no digits.
//!
//! The paper projects orthogonally onto the cone, which makes the problem convex and lets sliding contacts dilate. Here P is the
//! exact Coulomb law, first the normal impulse and then the disc at that impulse. A fixed point satisfies Coulomb's law but
//! minimises no function, so the theory (rate 1/k^2, descent) holds only without friction; with friction the method is a
//! heuristic that may stall.

use super::problem::State;
use super::{Method, Problem};
use crate::sweep::{ResidualLevel, Residuals};

/// Lower bound of the largest eigenvalue: the operator scaled by its diagonal has a trace of one per row.
const SMALLEST_CURVATURE: f64 = 1.0;

/// Upper bound of L. The eigenvalue is at most the number of contacts of a grain (see `jacobi`): only rounding errors reach this bound.
const LARGEST_CURVATURE: f64 = 1e3;

/// Factor of L after an iteration.
const DECAY: f64 = 0.9;

/// Accelerated projected gradients.
#[derive(Clone, Debug, Default)]
pub(super) struct AcceleratedProjectedGradients {
    /// Point x of the last iteration.
    last: State,
    /// Point y of the gradient.
    ahead: State,
    /// Buffer for the change of velocities.
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
        // Update y = x + momentum (x - last), last = x.
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
