//! The loop around iterations of a method: when to stop, what to report.

use crate::interrupt::Interrupt;
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
    /// There was no contact.
    #[default]
    NoContacts,
    /// The number of sweeps that was asked for is done.
    Sweeps,
    /// The residual is below its bound.
    Residual,
    /// The wall time is spent.
    TimeBudget,
    /// The most sweeps are done, the residual or the time budget notwithstanding.
    MaxSweeps,
    /// It was asked to: see [`interrupt`](crate::interrupt). The step was not taken.
    Interrupted,
}

/// Report of a solve.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct SolveReport {
    /// Iterations of the method done; for most a sweep each.
    pub sweeps: u32,
    /// Reason for its end.
    pub reason: StopReason,
    /// Residuals of the last iteration that was measured, m/s: see [`methods`](crate::methods).
    pub residuals: Residuals,
    /// True if over-relaxation fell back to 1.
    pub fell_back: bool,
}

impl SolveReport {
    /// Returns true if the solve came to its bound, or had nothing to solve. One that ends after a number of sweeps, or a time, is not known to.
    pub fn is_converged(&self) -> bool {
        matches!(self.reason, StopReason::NoContacts | StopReason::Residual)
    }

    /// Lets nothing that has not converged pass in silence.
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

/// A solve that ended before it came to its bound.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[error("a solve stopped after {sweeps} sweeps ({reason:?}) at a residual of {residual:.3e} m/s, above its bound")]
pub struct NotConverged {
    /// Reason for its end.
    pub reason: StopReason,
    /// Iterations done.
    pub sweeps: u32,
    /// Root mean square residual that was left, m/s.
    pub residual: f64,
}

/// Period of measurements with a fixed number of sweeps: the last sweep is measured, and of the first and every one whose number this divides the
/// total residual is, which over-relaxation watches.
const MEASURE_EVERY: u32 = 4;

/// Iterates on the contacts of a step until the settings say stop.
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
        Stop::Residual { tolerance, .. } => Some(Forecast::new(tolerance * residual_unit(world, settings.step))),
        _ => None,
    };
    // What is spent is known when a sweep is done: any may be the last.
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
        // An iteration may have been cut short, be it the last one.
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
    tell_driven(layout, &world.drives);
    report
}

/// Returns true if a solve that stops at a residual is about to reach it. What it reports is its last sweep in every direction, which costs
/// more than half a sweep; so that is measured where the next sweep may be the last, and only the total elsewhere.
struct Forecast {
    /// Bound on the residual, m/s.
    tolerance: f64,
    /// Residual of the last sweep, m/s.
    last: f64,
    /// Residual that is expected of the next one, m/s.
    next: f64,
}

/// Expected residual of the second sweep over that of the first.
const SECOND_OVER_FIRST: f64 = 0.5;

impl Forecast {
    fn new(tolerance: f64) -> Forecast {
        Forecast { tolerance, last: f64::INFINITY, next: f64::INFINITY }
    }

    /// Residual level of the next sweep, which may have to be the last.
    fn level(&self, last: bool) -> ResidualLevel {
        if last || self.next <= self.tolerance { ResidualLevel::Directions } else { ResidualLevel::Total }
    }

    /// Takes in the residual of a sweep, m/s; whether the solve is done. A sweep that met the bound when nobody expected it is
    /// followed by another.
    fn is_met(&mut self, residual: f64, level: ResidualLevel) -> bool {
        // Convergence is about linear.
        let share = if self.last.is_finite() { (residual / self.last).min(1.0) } else { SECOND_OVER_FIRST };
        (self.last, self.next) = (residual, residual * share);
        level == ResidualLevel::Directions && residual <= self.tolerance
    }
}

/// Residual level of an iteration, counted from 1, which may be the last.
pub(crate) fn level(iteration: u32, last: bool) -> ResidualLevel {
    match iteration {
        _ if last => ResidualLevel::Directions,
        1 => ResidualLevel::Total,
        _ if iteration.is_multiple_of(MEASURE_EVERY) => ResidualLevel::Total,
        _ => ResidualLevel::Off,
    }
}

/// Velocity that residuals are measured against: g h, with the largest g of the run, or 1 m/s where there is no gravity.
pub(crate) fn residual_unit(world: &World, h: f64) -> f64 {
    let gravity = world.field.largest();
    if gravity > 0.0 { gravity * h } else { 1.0 }
}

/// Name of the unit of residuals in a run with this largest gravity (m/s2): g h, or m/s where there is none.
pub fn residual_unit_name(gravity: f64) -> &'static str {
    if gravity > 0.0 { "g h" } else { "m/s" }
}

/// Text of a residual or of a bound on one, in a [unit](residual_unit_name): two significant digits, with an exponent where they would need
/// leading zeros.
pub fn residual_text(value: f64, unit: &str) -> String {
    match value {
        _ if !(0.1..1e3).contains(&value) => format!("{value:.1e} {unit}"),
        _ if value < 1.0 => format!("{value:.2} {unit}"),
        _ if value < 10.0 => format!("{value:.1} {unit}"),
        _ => format!("{value:.0} {unit}"),
    }
}
