//! Damped Jacobi: every contact is relaxed with the velocities of the last iteration. A historical baseline.
//!
//! The method is equivalent to parallel Gauss-Seidel without stages. With the operator S and its diagonal D it converges if the
//! damping is below `2 / lambda_max(D^-1 S)`. This eigenvalue lies between 1 and the largest number of contacts of a grain,
//! because the contribution of each contact to a grain's part of the scaled operator has norm one.

use super::problem::State;
use super::{Method, Problem};
use crate::sweep::{ResidualLevel, Residuals};

/// Damped Jacobi.
#[derive(Clone, Debug)]
pub(super) struct Jacobi {
    damping: f64,
    last: State,
}

impl Jacobi {
    /// Creates the method with the applied fraction of each contact's correction.
    pub fn new(damping: f64) -> Jacobi {
        Jacobi { damping, last: State::default() }
    }
}

impl Method for Jacobi {
    fn begin(&mut self, problem: &mut Problem<'_>) {
        problem.number_groups();
        self.last.fit(problem);
    }

    fn iterate(&mut self, problem: &mut Problem<'_>, _: ResidualLevel) -> Option<Residuals> {
        problem.keep(&mut self.last);
        Some(problem.projected_step(&self.last, &self.last.impulses, self.damping).residuals)
    }

    fn memory_bytes(&self) -> usize {
        self.last.memory_bytes()
    }
}
