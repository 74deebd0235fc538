//! Convergence of a method on the problem of one step, and the distance of a state from the solution.

use crate::methods::{Problem, Solver};
use crate::scene::SolverMethod;
use crate::solve::{level, residual_unit};
use crate::sweep::{Residual, Residuals};
use crate::world::World;
use crate::{SettingError, Simulation};
use serde::{Deserialize, Serialize};
use std::time::Instant;

/// State of a solve after a number of iterations.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct ConvergencePoint {
    /// Number of completed iterations.
    pub iterations: u32,
    /// Wall time of the iterations, with set-up and without measurement, s.
    pub seconds: f64,
    /// Natural-map residuals of the resulting state, m/s: see [`SolutionError`](crate::SolutionError).
    pub residuals: Residuals,
}

impl Simulation {
    /// Solves the contact problem of the next step with a method for n iterations, with a measurement after each. The
    /// first point is the initial state of the solve. The simulation remains unchanged: the step is made by a copy.
    ///
    /// # Errors
    /// [`SettingError::Method`] if the method has no equations for a setting or effect of the scene.
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
                // Over-relaxation depends on the growth of the residual, checked as often as in a solve of many sweeps.
                method.iterate(&mut problem, level(number, false));
                seconds += clock.elapsed().as_secs_f64();
                // Sweeps in single precision work on a copy, and continue from that copy.
                problem.leave_precision();
                points.push(ConvergencePoint { iterations: number, seconds, residuals: problem.measure().0 });
            }
            Ok(points)
        })
    }

    /// Returns the reference velocity of residuals: g h, or 1 m/s without gravity.
    pub fn residual_unit(&self) -> f64 {
        residual_unit(&self.world, self.settings.step)
    }
}

/// Errors of a solution. Velocities are in m/s, with [`SolutionError::unit`] as the reference.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct SolutionError {
    /// Change by one unrelaxed, separate update of each contact, `|change of lambda| D`, m/s: the natural map of
    /// [`methods`](crate::methods). Zero only at the solution.
    pub residuals: Residuals,
    /// Violation of the cone by attractive impulses or outside the Coulomb disc: the larger of `-lambda_n D_n` and
    /// `(|lambda_t| - mu lambda_n) D_t`, at least zero, m/s.
    pub cone: Residual,
    /// Largest overlap of two grains, or of a grain and a wall, over the smaller radius, at the present positions.
    pub largest_overlap: f64,
    /// Reference velocity: g h, or 1 m/s without gravity.
    pub unit: f64,
}

impl SolutionError {
    crate::getters! {
        /// Returns the complementarity `|min(lambda_n D_n, w_n)|`, m/s, with the gap velocity `w_n = u_n + Sigma' lambda_n - q`. It
        /// is the normal part of the natural map: `lambda_n - max(0, lambda_n - w_n / D_n) = min(lambda_n, w_n / D_n)`.
        pub complementarity: Residual = |error| error.residuals.normal;
        /// Returns the root mean square residual over the three directions, in units of g h.
        pub relative: f64 = |error| error.residuals.rms() / error.unit;
    }
}

impl Simulation {
    /// Returns the distance of the last step's solve from the solution; valid until the simulation changes.
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
