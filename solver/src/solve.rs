//! Iteration loop of a solve: stop criteria and report.

use crate::interrupt::Interrupt;
use crate::lanes::TaskSlots;
use crate::methods::{Problem, Solver};
use crate::partition::Layout;
use crate::scene::{SolverSettings, Stop};
use crate::schedule::Team;
use crate::sweep::{Relaxation, ResidualLevel, Residuals, tell_driven};
use crate::world::World;
use serde::{Deserialize, Serialize};
use std::time::Instant;

/// Reason for the end of a solve.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum StopReason {
    /// No contacts.
    #[default]
    NoContacts,
    /// The requested number of sweeps is complete.
    Sweeps,
    /// The residual is below its bound.
    Residual,
    /// The wall time budget is used up.
    TimeBudget,
    /// The maximum number of sweeps is reached before the residual bound or the time budget.
    MaxSweeps,
    /// The solve was interrupted: see [`interrupt`](crate::interrupt). The step was not taken.
    Interrupted,
}

/// Report of a solve.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct SolveReport {
    /// Number of iterations of the method; for most methods, each is a sweep.
    pub sweeps: u32,
    /// Stop reason.
    pub reason: StopReason,
    /// Residuals of the last measured iteration, m/s: see [`methods`](crate::methods).
    pub residuals: Residuals,
    /// True if over-relaxation fell back to 1.
    pub fell_back: bool,
}

impl SolveReport {
    /// Returns true if the solve reached its bound, or had no contacts. After a fixed number of sweeps or a time budget, convergence is unknown.
    pub fn is_converged(&self) -> bool {
        matches!(self.reason, StopReason::NoContacts | StopReason::Residual)
    }

    /// Converts a solve without convergence to an error.
    ///
    /// # Errors
    /// [`NotConverged`] unless the solve [is converged](SolveReport::is_converged).
    pub fn require_converged(&self) -> Result<(), NotConverged> {
        match self.is_converged() {
            true => Ok(()),
            false => Err(NotConverged { reason: self.reason, sweeps: self.sweeps, residual: self.residuals.rms() }),
        }
    }
}

/// Error of a solve that ended above its bound.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[error("a solve stopped after {sweeps} sweeps ({reason:?}) at a residual of {residual:.3e} m/s, above its bound")]
pub struct NotConverged {
    /// Stop reason.
    pub reason: StopReason,
    /// Number of iterations.
    pub sweeps: u32,
    /// Remaining root mean square residual, m/s.
    pub residual: f64,
}

/// Interval of measurements with a fixed number of sweeps. The last sweep is measured in full; of the first and of every multiple
/// of this number, only the total residual is measured, for over-relaxation.
const MEASURE_EVERY: u32 = 4;

/// Iterates on the contacts of a step until the stop criterion of the settings.
pub(crate) fn solve(
    world: &mut World,
    layout: &mut Layout,
    relaxation: &Relaxation,
    settings: &SolverSettings,
    team: &Team,
    solver: &mut Solver,
    interrupt: &Interrupt,
) -> SolveReport {
    let mut report = SolveReport::default();
    if layout.contacts == 0 {
        return report;
    }
    let start = Instant::now();
    let limit = settings.stop.max_sweeps();
    let mut forecast = match settings.stop {
        Stop::Residual { tolerance, .. } => {
            let tolerance = tolerance * residual_unit(world, settings.step);
            Some(Forecast { tolerance, last: f64::INFINITY, next: f64::INFINITY })
        }
        _ => None,
    };
    // The time is checked after each sweep: any sweep may be the last.
    let timed = matches!(settings.stop, Stop::TimeBudget { .. });
    let (method, workspace) = solver.parts();
    let World { bodies, drives, .. } = world;
    let mut problem = Problem { bodies, drives, layout, relaxation, settings, team, workspace, interrupt };
    method.begin(&mut problem);
    problem.enter_precision();
    report.reason = loop {
        let sweep = report.sweeps + 1;
        let last = timed || sweep == limit;
        let level = forecast.as_ref().map_or_else(|| level(sweep, last), |forecast| forecast.level(last));
        let residuals = method.iterate(&mut problem, level);
        report.sweeps = sweep;
        // Any iteration may have been cut short, including the last one.
        if problem.is_interrupted() {
            break StopReason::Interrupted;
        }
        if let Some(residuals) = residuals {
            report.residuals = residuals;
            report.fell_back = method.fell_back();
            if forecast.as_mut().is_some_and(|forecast| forecast.is_met(residuals.rms(), level)) {
                break StopReason::Residual;
            }
        }
        if sweep >= limit {
            break match settings.stop {
                Stop::Sweeps { .. } => StopReason::Sweeps,
                _ => StopReason::MaxSweeps,
            };
        }
        if matches!(settings.stop, Stop::TimeBudget { seconds, .. } if start.elapsed().as_secs_f64() >= seconds) {
            break StopReason::TimeBudget;
        }
    };
    problem.leave_precision();
    if let Some(ranks) = &layout.ranks {
        ranks.share(TaskSlots::of(&mut world.bodies));
    }
    tell_driven(layout, &world.drives);
    report
}

/// Residual predictor of solves with a residual bound. The report contains the last sweep's residuals in every direction, which
/// cost more than half a sweep. So they are measured only if the next sweep may be the last; other sweeps measure only the total.
struct Forecast {
    /// Bound on the residual, m/s.
    tolerance: f64,
    /// Residual of the last sweep, m/s.
    last: f64,
    /// Expected residual of the next sweep, m/s.
    next: f64,
}

/// Expected residual of the second sweep, as a fraction of the first.
const SECOND_OVER_FIRST: f64 = 0.5;

impl Forecast {
    /// Returns the residual level of the next sweep, which is the last if `last` is set.
    fn level(&self, last: bool) -> ResidualLevel {
        if last || self.next <= self.tolerance { ResidualLevel::Directions } else { ResidualLevel::Total }
    }

    /// Records the residual of a sweep, m/s, and returns true if the solve is complete. After an unexpected pass of the bound,
    /// another sweep follows.
    fn is_met(&mut self, residual: f64, level: ResidualLevel) -> bool {
        // Convergence is approximately linear.
        let share = if self.last.is_finite() { (residual / self.last).min(1.0) } else { SECOND_OVER_FIRST };
        (self.last, self.next) = (residual, residual * share);
        level == ResidualLevel::Directions && residual <= self.tolerance
    }
}

/// Returns the residual level of an iteration, counted from 1; `last` if it may be the last.
pub(crate) fn level(iteration: u32, last: bool) -> ResidualLevel {
    match iteration {
        _ if last => ResidualLevel::Directions,
        1 => ResidualLevel::Total,
        _ if iteration.is_multiple_of(MEASURE_EVERY) => ResidualLevel::Total,
        _ => ResidualLevel::Off,
    }
}

/// Velocity scale of residuals: g h, with the largest g of the run, or 1 m/s without gravity.
pub(crate) fn residual_unit(world: &World, h: f64) -> f64 {
    let gravity = world.field.largest();
    if gravity > 0.0 { gravity * h } else { 1.0 }
}

/// Name of the unit of residuals in a run with this largest gravity (m/s2): g h, or m/s without gravity.
pub fn residual_unit_name(gravity: f64) -> &'static str {
    if gravity > 0.0 { "g h" } else { "m/s" }
}

/// Text of a residual or its bound, in a [unit](residual_unit_name): two significant digits, with an exponent instead of leading
/// zeros.
pub fn residual_text(value: f64, unit: &str) -> String {
    match value {
        _ if !(0.1..1e3).contains(&value) => format!("{value:.1e} {unit}"),
        _ if value < 1.0 => format!("{value:.2} {unit}"),
        _ if value < 10.0 => format!("{value:.1} {unit}"),
        _ => format!("{value:.0} {unit}"),
    }
}
