//! The loop around sweeps: over-relaxation and its fall-back, when to stop, what to report.

use crate::partition::{Layout, Plan, STAGES, SingleBody, SingleCopy, SingleGroups, TaskGroups};
use crate::scene::{Precision, SolverSettings, Stop};
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
    /// Sweeps done.
    pub sweeps: u32,
    /// Why it stopped.
    pub reason: StopReason,
    /// Residuals of the last sweep, m/s.
    pub residuals: Residuals,
    /// Whether over-relaxation fell back to 1.
    pub fell_back: bool,
}

/// Where the number of sweeps is fixed, the first, the last and every sweep whose number this divides are measured.
const MEASURE_EVERY: u32 = 4;

/// Relaxes the contacts of a step until the settings say stop, in the precision that they ask for.
pub(crate) fn solve(
    world: &mut World,
    layout: &mut Layout,
    single: &mut SingleCopy,
    relaxation: &Relaxation,
    settings: &SolverSettings,
    team: &Team,
    residuals: &mut Vec<TaskResidual>,
) -> SolveReport {
    let (contacts, unit) = (layout.contacts, residual_unit(world, settings.step));
    if contacts == 0 {
        return SolveReport::default();
    }
    match settings.precision {
        Precision::Double => {
            let unknowns = Unknowns::double(&mut world.bodies, &mut layout.groups);
            iterate(&layout.plan, contacts, unit, &unknowns, relaxation, settings, team, residuals)
        }
        Precision::Single => {
            single.take(world, layout, relaxation.instruction_set, team);
            let unknowns = Unknowns::single(single);
            let report = iterate(&layout.plan, contacts, unit, &unknowns, relaxation, settings, team, residuals);
            single.give_back(&mut world.bodies, layout, team);
            report
        }
    }
}

/// What sweeps read and write, in one of the precisions.
pub(crate) enum Unknowns<'a> {
    Double { bodies: Disjoint<'a, Body>, groups: Disjoint<'a, TaskGroups> },
    Single { bodies: Disjoint<'a, SingleBody>, groups: Disjoint<'a, SingleGroups> },
}

impl<'a> Unknowns<'a> {
    pub fn double(bodies: &'a mut [Body], groups: &'a mut [TaskGroups]) -> Unknowns<'a> {
        Unknowns::Double { bodies: Disjoint::new(bodies), groups: Disjoint::new(groups) }
    }

    pub fn single(copy: &'a mut SingleCopy) -> Unknowns<'a> {
        Unknowns::Single { bodies: Disjoint::new(&mut copy.bodies), groups: Disjoint::new(&mut copy.groups) }
    }

    /// Relaxes the task of a number once.
    ///
    /// # Safety
    /// No other task uses the task's groups, or the bodies that they name, meanwhile.
    unsafe fn sweep(
        &self,
        relaxation: &Relaxation,
        task: usize,
        factor: f64,
        measure: bool,
        residual: &mut TaskResidual,
    ) {
        // SAFETY: the caller's promise.
        unsafe {
            match self {
                Unknowns::Double { bodies, groups } => {
                    relaxation.sweep(bodies.as_ptr(), groups.at(task), factor, measure, residual);
                }
                Unknowns::Single { bodies, groups } => {
                    relaxation.sweep_single(bodies.as_ptr(), groups.at(task), factor, measure, residual);
                }
            }
        }
    }
}

/// Sweeps until the settings say stop; residuals are measured in units of `unit` (m/s).
///
/// The residual of a sweep is |delta lambda| S in m/s. If it has grown since it was last measured, over-relaxation falls
/// back to 1 for the rest of the solve: factors that speed up most systems never converge on some.
#[allow(clippy::too_many_arguments)]
fn iterate(
    plan: &Plan,
    contacts: usize,
    unit: f64,
    unknowns: &Unknowns<'_>,
    relaxation: &Relaxation,
    settings: &SolverSettings,
    team: &Team,
    residuals: &mut Vec<TaskResidual>,
) -> SolveReport {
    let mut report = SolveReport::default();
    let inner = settings.inner_sweeps.max(1);
    let start = Instant::now();
    let limit = settings.stop.max_sweeps();
    let tolerance = match settings.stop {
        Stop::Residual { tolerance, .. } => Some(tolerance * unit),
        _ => None,
    };
    // A solve that may stop after any sweep must know the residual of each.
    let open_ended = !matches!(settings.stop, Stop::Sweeps { .. });
    let mut factor = settings.over_relaxation;
    let mut last = f64::INFINITY;
    loop {
        let sweep = report.sweeps + 1;
        let measure = sweep == 1 || sweep == limit || sweep % MEASURE_EVERY == 0 || open_ended;
        let sums = sweep_all(plan, unknowns, relaxation, factor, inner, measure.then_some(&mut *residuals), team);
        report.sweeps = sweep;
        if measure {
            report.residuals = sums.finish(contacts);
            let rms = report.residuals.rms();
            if rms > last && factor > 1.0 {
                factor = 1.0;
                report.fell_back = true;
            }
            last = rms;
            if tolerance.is_some_and(|tolerance| rms <= tolerance) {
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
    plan: &Plan,
    unknowns: &Unknowns<'_>,
    relaxation: &Relaxation,
    factor: f64,
    inner: u32,
    residuals: Option<&mut Vec<TaskResidual>>,
    team: &Team,
) -> TaskResidual {
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
                    let task = plan.tasks()[place].number as usize;
                    let mut unused = TaskResidual::default();
                    for time in 1..=inner {
                        let last = measure && time == inner;
                        let residual = if last { parts.at(place) } else { &mut unused };
                        unknowns.sweep(relaxation, task, factor, last, residual);
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
fn residual_unit(world: &World, h: f64) -> f64 {
    let gravity = world.gravity.norm();
    if gravity > 0.0 { gravity * h } else { 1.0 }
}
