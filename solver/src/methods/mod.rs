//! Methods for the contact problem of a step: one file each, behind one trait.
//!
//! ```text
//! problem   contacts laid out by `constrain`, bodies, threads; a state is impulses and the corresponding velocities
//! method    one iteration, from a state to a better one
//! loop      `solve`: iterates, stops, reports
//! ```
//!
//! A solution is a fixed point of relaxing each contact by itself,
//!
//! ```text
//! lambda_n = max(0, lambda_n - w_n / D_n)                 w_n = u_n + Sigma' lambda_n - q    D_n = S_n + Sigma'
//! lambda_t = P_{|.| <= mu lambda_n}[lambda_t - u_t / D_t]                                    D_t = S_t
//! ```
//!
//! that is, complementarity and Coulomb's law. All methods seek this point only. The residual of a state has the same definition
//! for all: `|change of lambda| D`, in m/s, for the normal and two tangential directions.
//!
//! | method | an iteration is | state in addition to impulses and velocities |
//! | --- | --- | --- |
//! | Gauss-Seidel | a sweep | none |
//! | Anderson | a sweep and a combination of the last m + 1 | 2 m + 3 velocities, m + 1 impulses |
//! | nonlinear conjugate gradients | a sweep and a step along the last direction | 2 of each |
//! | accelerated projected gradients | one or more projected steps with all velocities frozen | 3 velocities, 2 impulses |
//! | Jacobi | one such step | 1 of each |
//! | projected conjugate gradients | a step along a direction, three passes over contacts | 1 velocity, 2 impulses |
//!
//! Every pass over contacts is a kernel over lane groups, and every sum follows the order of tasks or of chunks of bodies. So the
//! results of all methods are bitwise reproducible.

mod accelerated_projected_gradients;
mod anderson;
mod gauss_seidel;
mod group;
mod jacobi;
mod nonlinear_conjugate_gradients;
mod passes;
mod problem;
mod projected_conjugate_gradients;
mod velocities;

pub(crate) use problem::{Problem, Workspace};

use crate::scene::{SolverMethod, SolverSettings};
use crate::sweep::{ResidualLevel, Residuals};
use accelerated_projected_gradients::AcceleratedProjectedGradients;
use anderson::Anderson;
use gauss_seidel::GaussSeidel;
use jacobi::Jacobi;
use nonlinear_conjugate_gradients::NonlinearConjugateGradients;
use projected_conjugate_gradients::ProjectedConjugateGradients;

/// One iteration of a method, and its memory.
pub(crate) trait Method {
    /// Prepares a new problem.
    fn begin(&mut self, problem: &mut Problem<'_>);

    /// Advances a state to a better one whose impulses lie in their cones.
    ///
    /// Residuals (m/s) are by-products of the iteration: |delta lambda| S of a sweep, or the natural map after a gradient. A
    /// method may omit residuals beyond the requested level.
    fn iterate(&mut self, problem: &mut Problem<'_>, level: ResidualLevel) -> Option<Residuals>;

    /// Returns true if over-relaxation fell back to 1 in this solve.
    fn fell_back(&self) -> bool {
        false
    }

    /// Memory of the method, bytes.
    fn memory_bytes(&self) -> usize {
        0
    }
}

/// Method with its buffers, reused from solve to solve.
#[derive(Clone, Debug)]
enum Chosen {
    GaussSeidel(GaussSeidel),
    Anderson(Box<Anderson>),
    NonlinearConjugateGradients(NonlinearConjugateGradients),
    AcceleratedProjectedGradients(AcceleratedProjectedGradients),
    Jacobi(Jacobi),
    ProjectedConjugateGradients(ProjectedConjugateGradients),
}

/// Method of a scene, and its workspace.
#[derive(Clone, Debug)]
pub(crate) struct Solver {
    chosen: Chosen,
    pub workspace: Workspace,
}

impl Solver {
    /// Creates the method of the settings.
    pub fn new(method: SolverMethod) -> Solver {
        let chosen = match method {
            SolverMethod::GaussSeidel => Chosen::GaussSeidel(GaussSeidel::default()),
            SolverMethod::Anderson { memory } => Chosen::Anderson(Box::new(Anderson::new(memory))),
            SolverMethod::NonlinearConjugateGradients => {
                Chosen::NonlinearConjugateGradients(NonlinearConjugateGradients::default())
            }
            SolverMethod::AcceleratedProjectedGradients => {
                Chosen::AcceleratedProjectedGradients(AcceleratedProjectedGradients::default())
            }
            SolverMethod::Jacobi { damping } => Chosen::Jacobi(Jacobi::new(damping)),
            SolverMethod::ProjectedConjugateGradients => {
                Chosen::ProjectedConjugateGradients(ProjectedConjugateGradients::default())
            }
        };
        Solver { chosen, workspace: Workspace::default() }
    }

    /// Returns the method and its workspace.
    pub fn parts(&mut self) -> (&mut dyn Method, &mut Workspace) {
        let method: &mut dyn Method = match &mut self.chosen {
            Chosen::GaussSeidel(method) => method,
            Chosen::Anderson(method) => method.as_mut(),
            Chosen::NonlinearConjugateGradients(method) => method,
            Chosen::AcceleratedProjectedGradients(method) => method,
            Chosen::Jacobi(method) => method,
            Chosen::ProjectedConjugateGradients(method) => method,
        };
        (method, &mut self.workspace)
    }

    pub fn memory_bytes(&self) -> usize {
        let method: &dyn Method = match &self.chosen {
            Chosen::GaussSeidel(method) => method,
            Chosen::Anderson(method) => method.as_ref(),
            Chosen::NonlinearConjugateGradients(method) => method,
            Chosen::AcceleratedProjectedGradients(method) => method,
            Chosen::Jacobi(method) => method,
            Chosen::ProjectedConjugateGradients(method) => method,
        };
        method.memory_bytes() + self.workspace.memory_bytes()
    }
}

impl SolverSettings {
    /// Number of sweeps over all contacts per iteration.
    pub(crate) fn sweeps_per_iteration(&self) -> u32 {
        match self.method {
            SolverMethod::GaussSeidel | SolverMethod::Anderson { .. } | SolverMethod::NonlinearConjugateGradients => {
                self.inner_sweeps.max(1)
            }
            SolverMethod::AcceleratedProjectedGradients
            | SolverMethod::Jacobi { .. }
            | SolverMethod::ProjectedConjugateGradients => 1,
        }
    }
}
