//! Sweeps over all tasks, stage after stage.

use super::{Relaxation, ResidualLevel, TaskResidual};
use crate::partition::{ByBodies, ByNumber, ByPlace, Plan, SingleCopy, TaskGroups, TaskShares};
use crate::schedule::{Phase, Team};
use crate::world::Body;

/// What sweeps read and write, in one of the precisions.
pub(crate) enum SweepOperands<'a> {
    Double { bodies: &'a mut [Body], groups: &'a mut [TaskGroups] },
    Single(&'a mut SingleCopy),
}

/// How often tasks are relaxed before the next one's turn, and how closely the last time is looked at.
pub(crate) struct SweepPass<F> {
    /// Relaxation factor.
    pub factor: f64,
    /// Times that each task is relaxed.
    pub inner: u32,
    /// Whether to leave out the times that are left; asked where there are several.
    pub stops: F,
    /// What is measured the last time.
    pub level: ResidualLevel,
}

impl Relaxation {
    /// Relaxes every task as the pass says, stage after stage; returns the summed residuals of the last time, with `residuals` for room.
    pub(crate) fn sweep_all(
        &self,
        plan: &Plan,
        operands: SweepOperands<'_>,
        pass: &SweepPass<impl Fn() -> bool + Sync>,
        residuals: &mut Vec<TaskResidual>,
        team: &Team,
    ) -> TaskResidual {
        let factor = pass.factor;
        match operands {
            SweepOperands::Double { bodies, groups } => {
                let shares = (ByBodies::of(bodies), ByNumber::of(groups));
                pass.run(plan, shares, residuals, team, |(bodies, groups), level, residual| {
                    self.sweep(*bodies, groups, factor, level, residual);
                })
            }
            SweepOperands::Single(copy) => {
                let shares = (ByBodies::of(&mut copy.bodies), ByNumber::of(&mut copy.groups));
                pass.run(plan, shares, residuals, team, |(bodies, groups), level, residual| {
                    self.sweep_single(*bodies, groups, factor, level, residual);
                })
            }
        }
    }
}

impl<F: Fn() -> bool + Sync> SweepPass<F> {
    fn run<S: TaskShares>(
        &self,
        plan: &Plan,
        shares: S,
        residuals: &mut Vec<TaskResidual>,
        team: &Team,
        sweep: impl Fn(&mut S::Share, ResidualLevel, &mut TaskResidual) + Sync,
    ) -> TaskResidual {
        let measured = self.level != ResidualLevel::Off;
        residuals.clear();
        residuals.resize(if measured { plan.tasks().len() } else { 0 }, TaskResidual::default());
        let shares = (shares, measured.then(|| ByPlace::of(residuals)));
        plan.run_stages(
            team,
            Phase::Sweep,
            |_| {},
            shares,
            |_, _, (mut own, mut residual)| {
                let mut unused = TaskResidual::default();
                for time in 1..=self.inner {
                    if self.inner > 1 && (self.stops)() {
                        break;
                    }
                    match &mut residual {
                        Some(residual) if time == self.inner => sweep(&mut own, self.level, residual),
                        _ => sweep(&mut own, ResidualLevel::Off, &mut unused),
                    }
                }
            },
        );
        // Summed in the order of tasks, whoever did them.
        let mut total = TaskResidual::default();
        residuals.iter().for_each(|own| total.merge(own));
        total
    }
}
