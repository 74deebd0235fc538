//! Convergence of a method on the problem of one step, and the distance of a state from its solution.

use crate::methods::{Problem, Solver};
use crate::scene::SolverMethod;
use crate::solve::{level, residual_unit};
use crate::sweep::{Residual, Residuals};
use crate::world::World;
use crate::{SettingError, Simulation};
use serde::{Deserialize, Serialize};
use std::time::Instant;

/// Solve after a number of iterations.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct ConvergencePoint {
    /// Iterations done.
    pub iterations: u32,
    /// Wall time of the iterations, s, including preparation, without measurements.
    pub seconds: f64,
    /// Natural-map residuals of the resulting state, m/s: see [`SolutionError`](crate::SolutionError).
    pub residuals: Residuals,
}

impl Simulation {
    /// Solves the contact problem of the next step with a method for the given number of iterations, and measures after each. The
    /// first point is the starting state of the solve. The simulation stays unchanged: a copy takes the step.
    ///
    /// # Errors
    /// [`SettingError::Method`] if the method does not support a property of the scene.
    pub fn convergence(&self, method: SolverMethod, iterations: u32) -> Result<Vec<ConvergencePoint>, SettingError> {
        self.goes_with(method)?;
        let mut copy = self.clone();
        copy.settings.method = method;
        let team = copy.team.here();
        team.enter(|| {
            copy.pose_problem(&team);
            let mut solver = Solver::new(method);
            let (method, workspace) = solver.parts();
            let Simulation { world, layout, relaxation, settings, interrupt, .. } = &mut copy;
            let World { bodies, drives, .. } = world;
            let mut problem =
                Problem { bodies, drives, layout, relaxation, settings, team: &team, workspace, interrupt };
            let mut points = Vec::with_capacity(iterations as usize + 1);
            points.push(ConvergencePoint { residuals: problem.measure().0, ..ConvergencePoint::default() });
            let mut seconds = 0.0;
            for number in 1..=iterations {
                let clock = Instant::now();
                if number == 1 {
                    method.begin(&mut problem);
                    problem.enter_precision();
                }
                // Over-relaxation requires the residual as often as in a solve of many sweeps.
                method.iterate(&mut problem, level(number, false));
                seconds += clock.elapsed().as_secs_f64();
                // Sweeps in single precision continue from their own copy.
                problem.leave_precision();
                points.push(ConvergencePoint { iterations: number, seconds, residuals: problem.measure().0 });
            }
            Ok(points)
        })
    }

    /// Velocity scale of residuals: g h, or 1 m/s without gravity.
    pub fn residual_unit(&self) -> f64 {
        residual_unit(&self.world, self.settings.step)
    }
}

/// Errors of a solution. Velocities are in m/s, relative to the scale [`SolutionError::unit`].
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct SolutionError {
    /// Change by one unrelaxed update of each contact by itself, `|change of lambda| D`, m/s: the natural map of
    /// [`methods`](crate::methods). Zero only at the solution.
    pub residuals: Residuals,
    /// Excess of impulses over the cone, m/s: the larger of `-lambda_n D_n` and `(|lambda_t| - mu lambda_n) D_t`, never below
    /// zero.
    pub cone: Residual,
    /// Largest overlap of two grains, or of a grain and a wall, over the smaller radius, at the present positions.
    pub largest_overlap: f64,
    /// Velocity scale of these errors: g h, or 1 m/s without gravity.
    pub unit: f64,
}

impl SolutionError {
    /// Complementarity `|min(lambda_n D_n, w_n)|`, m/s, with the gap velocity `w_n = u_n + Sigma' lambda_n - q`. This is the
    /// normal part of the natural map: `lambda_n - max(0, lambda_n - w_n / D_n) = min(lambda_n, w_n / D_n)`.
    pub fn complementarity(&self) -> Residual {
        self.residuals.normal
    }

    /// Root mean square residual over the three directions, in units of g h.
    pub fn relative(&self) -> f64 {
        self.residuals.rms() / self.unit
    }
}

impl Simulation {
    /// Distance of the last step's solve from the solution; valid until the simulation changes.
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
