//! Contact problem of a step, with the basic operations of the methods.
//!
//! A state is an impulse for each contact, stored in the lane groups, and the resulting velocities, stored in the bodies: `v =
//! v_free + M^-1 G^T lambda`. Velocities are affine in the impulses, so a combination of states with coefficients of sum one
//! applies to both. If a projection changes an impulse, the bodies receive the difference.

use super::group::MeasureTorques;
use super::group::{Block, ContactPass, PassOverTask};
use super::passes::{Combine, Keep, Measure, Step, Transform};
use super::velocities::{self, Coefficients, MOST, sum_of};
use crate::effects::drive::Drive;
use crate::groups::{with_effects, with_tangential};
use crate::interrupt::{Interrupt, polls_interrupt};
use crate::lanes::{Eight, LANES, Slots};
use crate::partition::{ByBodies, ByNumber, ByPlace, ByStarts, Layout, PlannedTask, SingleCopy, TaskShares};
use crate::scene::{Precision, SolverSettings};
use crate::schedule::{Phase, Team};
use crate::sweep::{
    Relaxation, Residual, ResidualLevel, Residuals, SweepOperands, SweepPass, TaskResidual, tell_driven,
};
use crate::world::Body;
use std::marker::PhantomData;
use std::ops::Range;

/// Partial sums of a task over its contacts, separate for each lane.
#[derive(Clone, Debug, Default)]
pub(crate) struct Tally {
    /// Three sums, defined by each kernel.
    pub sums: [Eight; 3],
    /// Natural-map residuals, m/s.
    pub residual: TaskResidual,
    /// Excess of tangential impulses over the Coulomb disc, m/s.
    pub cone: TaskResidual,
}

/// Contacts and bodies of a step, the team of threads, and buffers reused from solve to solve.
pub(crate) struct Problem<'a> {
    pub bodies: &'a mut [Body],
    pub drives: &'a mut [Drive],
    pub layout: &'a mut Layout,
    pub relaxation: &'a Relaxation,
    pub settings: &'a SolverSettings,
    pub team: &'a Team,
    pub workspace: &'a mut Workspace,
    pub interrupt: &'a Interrupt,
}

/// Partial sums of the tasks, and the first index of their vectors.
#[derive(Clone, Debug, Default)]
pub(crate) struct Workspace {
    /// First block of each task in vectors over contacts, and one more.
    pub starts: Vec<usize>,
    /// Bodies and groups of sweeps in single precision.
    pub single: SingleCopy,
    /// Residuals of sweeps.
    residuals: Vec<TaskResidual>,
    pub tallies: Vec<Tally>,
    energies: Vec<[Eight; MOST]>,
}

/// Stored state: an impulse for each contact, N s, and the resulting velocities.
#[derive(Clone, Debug, Default)]
pub(crate) struct State {
    /// Impulses, task after task, pairs before walls.
    pub impulses: Vec<Block>,
    /// Velocities.
    pub velocities: Vec<Body>,
}

impl State {
    /// Resizes for a problem's contacts and bodies; the bodies' masses are set, all other values are meaningless.
    pub fn fit(&mut self, problem: &Problem<'_>) {
        fit(&mut self.impulses, problem);
        self.velocities.clear();
        self.velocities.extend_from_slice(problem.bodies);
    }

    pub fn memory_bytes(&self) -> usize {
        self.impulses.capacity() * size_of::<Block>() + self.velocities.capacity() * size_of::<Body>()
    }
}

/// Resizes a vector over a problem's contacts, with an eighth to spare: the next step may have more contacts.
pub(crate) fn fit(vectors: &mut Vec<Block>, problem: &Problem<'_>) {
    let count = problem.workspace.starts.last().copied().unwrap_or(0);
    if count > vectors.capacity() {
        vectors.reserve_exact(count + count / 8 - vectors.len());
    }
    vectors.resize(count, Block::default());
}

impl Workspace {
    pub fn memory_bytes(&self) -> usize {
        self.single.memory_bytes()
            + self.starts.capacity() * size_of::<usize>()
            + self.residuals.capacity() * size_of::<TaskResidual>()
            + self.tallies.capacity() * size_of::<Tally>()
            + self.energies.capacity() * size_of::<[Eight; MOST]>()
    }
}

/// Result of a projected step.
pub(crate) struct StepSums {
    /// Squared change `d.D d` in the metric of D, the diagonal of the operator, J.
    pub scaled: f64,
    /// Compliant part of `d.S d`, in addition to the kinetic energy, J.
    pub compliant: f64,
    /// Gradient times the change from the last state to the new one, J; positive for a step uphill.
    pub slope: f64,
    /// Natural-map residuals at the start of the step, m/s.
    pub residuals: Residuals,
}

impl Problem<'_> {
    /// Returns true if the solve was interrupted.
    pub fn is_interrupted(&self) -> bool {
        // Ranks stop between steps, together.
        self.layout.ranks.is_none() && polls_interrupt(self.settings) && self.interrupt.is_requested()
    }

    /// Numbers the lane groups, as indices of vectors over contacts.
    pub fn number_groups(&mut self) {
        let starts = &mut self.workspace.starts;
        starts.clear();
        let mut next = 0;
        for task in self.layout.plan.tasks() {
            starts.push(next);
            let groups = &self.layout.groups[task.number as usize];
            next += groups.pairs.len() + groups.walls.len();
        }
        starts.push(next);
    }

    /// Runs one Gauss-Seidel sweep; returns its residuals |delta lambda| S, m/s, at the requested level.
    pub fn sweep(&mut self, factor: f64, level: ResidualLevel) -> Option<Residuals> {
        let (inner, precision) = (self.settings.inner_sweeps.max(1), self.settings.precision);
        let polls = polls_interrupt(self.settings) && self.layout.ranks.is_none();
        let interrupt = self.interrupt;
        let pass = SweepPass { factor, inner, stops: || polls && interrupt.is_requested(), level };
        let Workspace { single, residuals, .. } = &mut *self.workspace;
        let Layout { plan, groups, ranks, .. } = &mut *self.layout;
        let operands = match precision {
            Precision::Double => SweepOperands::Double { bodies: self.bodies, groups },
            Precision::Single => SweepOperands::Single(single),
        };
        let mut sums = self.relaxation.sweep_all((plan, ranks.as_ref()), operands, &pass, residuals, self.team);
        if !self.drives.is_empty() {
            let Problem { bodies, drives, layout, relaxation, team, .. } = self;
            let driven = || relaxation.sweep_driven(bodies, layout, drives, factor, level);
            sums.merge(&team.alone(Phase::Sweep, driven));
        }
        (level != ResidualLevel::Off).then(|| sums.finish(self.layout.contacts))
    }

    /// Copies the state for sweeps in single precision.
    pub fn enter_precision(&mut self) {
        if self.settings.precision == Precision::Single {
            let set = self.relaxation.instruction_set;
            self.workspace.single.take(self.bodies, self.layout, set, self.team);
        }
    }

    /// Copies the result of sweeps in single precision back.
    pub fn leave_precision(&mut self) {
        if self.settings.precision == Precision::Single {
            self.workspace.single.give_back(self.bodies, self.layout, self.team);
        }
    }

    /// Stores the present state.
    pub fn keep(&mut self, state: &mut State) {
        state.velocities.copy_from_slice(self.bodies);
        let vectors = ByStarts::of(&mut state.impulses, &self.workspace.starts);
        for_each_group(self.layout, self.relaxation, self.team, vectors, |_, to| Keep { to });
    }

    /// Replaces the present state by a combination of others, with coefficients of sum one.
    pub fn combine(&mut self, coefficients: &[f64], states: &[&State]) {
        let mut velocities: [&[Body]; MOST] = [&[]; MOST];
        for (velocities, state) in velocities.iter_mut().zip(states) {
            *velocities = &state.velocities;
        }
        let set = self.relaxation.instruction_set;
        velocities::combine(self.bodies, coefficients, &velocities[..states.len()], set, self.team);
        let starts = &self.workspace.starts;
        for_each_group(self.layout, self.relaxation, self.team, (), |place, ()| {
            let mut from: [&[Block]; MOST] = [&[]; MOST];
            for (from, state) in from.iter_mut().zip(states) {
                *from = &state.impulses[part(starts, place)];
            }
            Combine { coefficients, from, count: states.len() }
        });
    }

    /// Replaces the present state (first) and two others by combinations of the three.
    pub fn transform(&mut self, coefficients: &Coefficients, second: &mut State, third: &mut State) {
        let bodies = [&mut *self.bodies, &mut second.velocities, &mut third.velocities];
        velocities::transform(bodies, coefficients, self.relaxation.instruction_set, self.team);
        let vectors = [second, third].map(|state| ByStarts::of(&mut state.impulses, &self.workspace.starts));
        for_each_group(self.layout, self.relaxation, self.team, vectors, |_, [second, third]| Transform {
            coefficients,
            second,
            third,
        });
    }

    /// Replaces the present state by the projection of `from - step D^-1 (S from - b)`, D the diagonal of S. The slope is
    /// relative to `last`.
    pub fn projected_step(&mut self, from: &State, last: &[Block], step: f64) -> StepSums {
        self.bodies.copy_from_slice(&from.velocities);
        let Workspace { starts, tallies, .. } = &mut *self.workspace;
        let shares = (ByBodies::of(self.bodies), Tally::of_tasks(tallies, self.layout));
        for_each_group(self.layout, self.relaxation, self.team, shares, |place, (bodies, tally)| {
            let part = part(starts, place);
            let (point, last) = (&from.impulses[part.clone()], &last[part]);
            Step { ahead: Slots::of(&from.velocities), bodies, from: point, last, step, tally }
        });
        let total = Tally::total(tallies);
        let [scaled, compliant, slope] = total.sums();
        StepSums { scaled, compliant, slope, residuals: total.residual.finish(self.layout.contacts) }
    }

    /// Measures the natural-map residuals of the present state, torques included, and the excess of impulses over their cones, m/s.
    pub fn measure(&mut self) -> (Residuals, Residual) {
        tell_driven(self.layout, self.drives);
        let tallies = &mut self.workspace.tallies;
        let bodies = Slots::of(self.bodies);
        let shares = Tally::of_tasks(tallies, self.layout);
        for_each_group(self.layout, self.relaxation, self.team, shares, |_, tally| Measure { bodies, tally });
        if self.relaxation.effects.torques() {
            self.measure_torques();
        }
        let tallies = &self.workspace.tallies;
        let (total, contacts) = (Tally::total(tallies), self.layout.contacts);
        (total.residual.finish(contacts), total.cone.finish(contacts).normal)
    }

    /// Adds the residuals of torques to the partial sums of all tasks.
    fn measure_torques(&mut self) {
        let (plan, groups) = (&self.layout.plan, &self.layout.groups);
        let (bodies, tallies) = (Slots::of(self.bodies), ByPlace::of(&mut self.workspace.tallies));
        let set = self.relaxation.instruction_set;
        plan.run_all(self.team, Phase::Sweep, tallies, |_, task, tally| {
            let groups = &groups[task.number as usize];
            with_effects!(self.relaxation.effects.compiled(), E => {
                set.run(MeasureTorques::<E> { groups, bodies, tally, effects: PhantomData })
            });
        });
    }

    /// Computes `difference = bodies - velocities`, and returns twice its kinetic energy, J.
    pub fn velocity_change(&mut self, velocities: &[Body], difference: &mut [Body]) -> f64 {
        let set = self.relaxation.instruction_set;
        velocities::difference(difference, [self.bodies, velocities], &mut self.workspace.energies, set, self.team)
    }

    /// Returns twice the kinetic energies of one difference of velocities with several, J.
    pub fn products(&mut self, one: &[Body], others: &[&[Body]]) -> [f64; MOST] {
        let set = self.relaxation.instruction_set;
        velocities::products(one, others, &mut self.workspace.energies, set, self.team)
    }
}

/// Applies a pass to the lane groups of every task, stage after stage if bodies are written: `make` creates the pass of a task
/// from its index and its data.
pub(crate) fn for_each_group<V: ContactPass, S: TaskShares>(
    layout: &mut Layout,
    relaxation: &Relaxation,
    team: &Team,
    shares: S,
    make: impl Fn(usize, S::Share) -> V + Sync,
) {
    let (plan, shares) = (&layout.plan, (ByNumber::of(&mut layout.groups), shares));
    let set = relaxation.instruction_set;
    let pass = |place: usize, _: &PlannedTask, (groups, share)| {
        // Stored and combined states contain no torques: scenes with torques allow no method other than Gauss-Seidel.
        with_tangential!(relaxation.effects, E => {
            set.run(PassOverTask::<V, E> { groups, pass: make(place, share), effects: PhantomData })
        });
    };
    match S::IN_STAGES {
        true => plan.run_stages(team, Phase::Sweep, |_, _, _| {}, shares, pass),
        false => plan.run_all(team, Phase::Sweep, shares, pass),
    }
}

impl Tally {
    /// Returns empty partial sums, one per task.
    pub fn of_tasks<'a>(tallies: &'a mut Vec<Tally>, layout: &Layout) -> ByPlace<'a, Tally> {
        tallies.clear();
        tallies.resize(layout.plan.tasks().len(), Tally::default());
        ByPlace::of(tallies)
    }

    /// Returns the total of all tasks, in task order.
    pub fn total(tallies: &[Tally]) -> Tally {
        let mut total = Tally::default();
        for tally in tallies {
            for (sum, own) in total.sums.iter_mut().zip(&tally.sums) {
                for lane in 0..LANES {
                    sum.0[lane] += own.0[lane];
                }
            }
            total.residual.merge(&tally.residual);
            total.cone.merge(&tally.cone);
        }
        total
    }

    /// Returns the three sums.
    pub fn sums(&self) -> [f64; 3] {
        [0, 1, 2].map(|index| sum_of(self.sums[index].0))
    }
}

/// Returns the blocks of a task in vectors over contacts.
#[inline]
pub(crate) fn part(starts: &[usize], place: usize) -> Range<usize> {
    starts[place]..starts[place + 1]
}
