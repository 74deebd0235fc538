//! How a method converges on the problem of one step.

use crate::Simulation;
use crate::methods::{Problem, Solver};
use crate::scene::{Precision, SolverMethod};
use crate::solve::{gauge, residual_unit};
use crate::sweep::Residuals;
use crate::world::World;
use serde::{Deserialize, Serialize};
use std::time::Instant;

/// A solve after some iterations.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct ConvergencePoint {
    /// Iterations done.
    pub iterations: u32,
    /// Wall time spent in them, making ready included, measuring left out, s.
    pub seconds: f64,
    /// Natural-map residuals of the state that they left, m/s: see [`SolutionError`](crate::SolutionError).
    pub residuals: Residuals,
}

/// A method that cannot solve the problems of a scene.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{method}: {reason}")]
pub struct UnsuitableMethod {
    /// The method.
    pub method: &'static str,
    /// What it leaves out.
    pub reason: &'static str,
}

impl Simulation {
    /// Solves the contact problem of the next step with a method for so many iterations, and measures after each. The first
    /// point is the state that the solve starts from. The simulation itself stays as it is: a copy takes the step.
    ///
    /// # Errors
    /// [`UnsuitableMethod`] if the method leaves out something that the scene's contacts have, so that it solves another problem.
    pub fn convergence(
        &self,
        method: SolverMethod,
        iterations: u32,
    ) -> Result<Vec<ConvergencePoint>, UnsuitableMethod> {
        self.suits(method)?;
        let mut copy = self.clone();
        copy.settings.method = method;
        let team = copy.team.clone();
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
                // Over-relaxation needs to know whether the residual grows, as often as in a solve of many sweeps.
                method.iterate(&mut problem, gauge(number, false));
                seconds += clock.elapsed().as_secs_f64();
                // Sweeps in single precision work on a copy, and go on from it.
                problem.leave_precision();
                points.push(ConvergencePoint { iterations: number, seconds, residuals: problem.measure().0 });
            }
            Ok(points)
        })
    }

    /// Whether a method can solve the problems of this simulation: the rule by which scenes are checked when they are read.
    ///
    /// # Errors
    /// [`UnsuitableMethod`] with what it leaves out.
    pub fn suits(&self, method: SolverMethod) -> Result<(), UnsuitableMethod> {
        if method == SolverMethod::GaussSeidel {
            return Ok(());
        }
        let reason = match () {
            () if self.relaxation.effects.torques() => "contacts bear torques, which go with gauss-seidel alone",
            () if !self.world.drives.is_empty() => "a wall is driven, which goes with gauss-seidel alone",
            () if self.settings.precision == Precision::Single => "single precision goes with gauss-seidel alone",
            () => return Ok(()),
        };
        Err(UnsuitableMethod { method: method.name(), reason })
    }

    /// Velocity that residuals compare with: g h, or 1 m/s where there is no gravity.
    pub fn residual_unit(&self) -> f64 {
        residual_unit(&self.world, self.settings.step)
    }
}
