//! The loop around iterations of a method: when to stop, what to report.

use crate::methods::{Problem, Solver};
use crate::partition::{Layout, STAGES};
use crate::scene::{SolverSettings, Stop};
use crate::schedule::{Disjoint, Phase, Team};
use crate::sweep::{Relaxation, Residuals, TaskResidual};
use crate::world::{Body, World};
use serde::{Deserialize, Serialize};
use std::time::Instant;

/// Why a solve stopped.
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
}

/// What a solve did.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct SolveReport {
    /// Iterations of the method done; for most a sweep each.
    pub sweeps: u32,
    /// Why it stopped.
    pub reason: StopReason,
    /// Residuals of the last iteration that was measured, m/s: see [`methods`](crate::methods).
    pub residuals: Residuals,
    /// Whether over-relaxation fell back to 1.
    pub fell_back: bool,
}

/// Where the number of sweeps is fixed, the first, the last and every sweep whose number this divides are measured.
pub(crate) const MEASURE_EVERY: u32 = 4;

/// Iterates on the contacts of a step until the settings say stop.
pub(crate) fn solve(
    world: &mut World,
    layout: &mut Layout,
    relaxation: &Relaxation,
    settings: &SolverSettings,
    team: &Team,
    solver: &mut Solver,
) -> SolveReport {
    let mut report = SolveReport::default();
    if layout.contacts == 0 {
        return report;
    }
    let start = Instant::now();
    let limit = settings.stop.max_sweeps();
    let tolerance = match settings.stop {
        Stop::Residual { tolerance, .. } => Some(tolerance * residual_unit(world, settings.step)),
        _ => None,
    };
    // A solve that may stop after any sweep must know the residual of each.
    let open_ended = !matches!(settings.stop, Stop::Sweeps { .. });
    let (method, workspace) = solver.parts();
    let mut problem = Problem { bodies: &mut world.bodies, layout, relaxation, settings, team, workspace };
    method.begin(&mut problem);
    loop {
        let sweep = report.sweeps + 1;
        let measure = sweep == 1 || sweep == limit || sweep % MEASURE_EVERY == 0 || open_ended;
        let residuals = method.iterate(&mut problem, measure);
        report.sweeps = sweep;
        if let Some(residuals) = residuals {
            report.residuals = residuals;
            report.fell_back = method.fell_back();
            if tolerance.is_some_and(|tolerance| residuals.rms() <= tolerance) {
                report.reason = StopReason::Residual;
                return report;
            }
        }
        if sweep >= limit {
            report.reason = match settings.stop {
                Stop::Sweeps { .. } => StopReason::Sweeps,
                _ => StopReason::MaxSweeps,
            };
            return report;
        }
        if matches!(settings.stop, Stop::TimeBudget { seconds, .. } if start.elapsed().as_secs_f64() >= seconds) {
            report.reason = StopReason::TimeBudget;
            return report;
        }
    }
}

/// Relaxes every task `inner` times, stage after stage; returns the summed residuals of the last time if there is room
/// for them.
pub(crate) fn sweep_all(
    bodies: &mut [Body],
    layout: &mut Layout,
    relaxation: &Relaxation,
    factor: f64,
    inner: u32,
    residuals: Option<&mut Vec<TaskResidual>>,
    team: &Team,
) -> TaskResidual {
    let (plan, bodies, groups) = (&layout.plan, Disjoint::new(bodies), Disjoint::new(&mut layout.groups));
    let measure = residuals.is_some();
    let mut nowhere = Vec::new();
    let residuals = residuals.unwrap_or(&mut nowhere);
    residuals.clear();
    residuals.resize(if measure { plan.tasks().len() } else { 0 }, TaskResidual::default());
    let parts = Disjoint::new(residuals);
    for stage in 0..STAGES {
        let batches = plan.batches(stage);
        team.each(Phase::Sweep, batches.len(), |batch| {
            for place in batches[batch].clone() {
                // SAFETY: tasks of a stage share no body, and each has its own groups and its own residual.
                unsafe {
                    let groups = groups.at(plan.tasks()[place].number as usize);
                    let mut unused = TaskResidual::default();
                    for time in 1..=inner {
                        let last = measure && time == inner;
                        let residual = if last { parts.at(place) } else { &mut unused };
                        relaxation.sweep(bodies.as_ptr(), groups, factor, last, residual);
                    }
                }
            }
        });
    }
    // Summed in the order of tasks, whoever did them.
    let mut total = TaskResidual::default();
    residuals.iter().for_each(|own| total.merge(own));
    total
}

/// Velocity that residuals are measured against: g h, or 1 m/s where there is no gravity.
pub(crate) fn residual_unit(world: &World, h: f64) -> f64 {
    let gravity = world.gravity.norm();
    if gravity > 0.0 { gravity * h } else { 1.0 }
}
