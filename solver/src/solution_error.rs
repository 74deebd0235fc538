//! How far the state that a step left is from the solution of its contact problem: the same measure for every method.

use crate::Simulation;
use crate::methods::Problem;
use crate::solve::residual_unit;
use crate::sweep::{Residual, Residuals};
use crate::world::World;
use serde::{Deserialize, Serialize};

/// Errors of a solution. Velocities are in m/s and compare with [`SolutionError::unit`].
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct SolutionError {
    /// What one unrelaxed update of each contact by itself would still change, `|change of lambda| D`, m/s: the natural map of
    /// [`methods`](crate::methods). Zero at the solution and nowhere else.
    pub residuals: Residuals,
    /// By how much impulses attract, or leave the Coulomb disc: `-lambda_n D_n` or `(|lambda_t| - mu lambda_n) D_t`, the larger of
    /// the two and never below zero, m/s.
    pub cone: Residual,
    /// Largest overlap of two grains, or of a grain and a wall, over the smaller radius, at the present positions.
    pub largest_overlap: f64,
    /// Velocity that these compare with: g h, or 1 m/s where there is no gravity.
    pub unit: f64,
}

impl SolutionError {
    /// Complementarity `|min(lambda_n D_n, w_n)|`, m/s, with the gap velocity `w_n = u_n + Sigma' lambda_n - q`. It is the normal
    /// part of the natural map: `lambda_n - max(0, lambda_n - w_n / D_n) = min(lambda_n, w_n / D_n)`.
    pub fn complementarity(&self) -> Residual {
        self.residuals.normal
    }

    /// Root mean square residual over the three directions, in units of g h.
    pub fn relative(&self) -> f64 {
        self.residuals.rms() / self.unit
    }
}

impl Simulation {
    /// How far the last step's solve stopped from the solution. To be asked before anything else is done to the simulation.
    pub fn solution_error(&mut self) -> SolutionError {
        let team = self.team.here();
        let Simulation { world, layout, relaxation, settings, solver, interrupt, .. } = self;
        let workspace = &mut solver.workspace;
        let unit = residual_unit(world, settings.step);
        let World { bodies, drives, .. } = world;
        let mut problem = Problem { bodies, drives, layout, relaxation, settings, team: &team, workspace, interrupt };
        let (residuals, cone) = team.enter(|| problem.measure());
        SolutionError { residuals, cone, largest_overlap: self.largest_overlap(), unit }
    }
}
