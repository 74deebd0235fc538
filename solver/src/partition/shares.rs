//! Partition of data among tasks: lane groups, candidates, and the bodies that a stage's tasks may write.
//!
//! This module contains the proofs. Every task has its own number and index; its candidates and blocks are consecutive
//! ranges ([`Plan::set`](super::Plan)); and tasks of one stage share no body, because of their boxes (`BoxGrid`, tested
//! on whole layouts). A task may therefore use its part exclusively.

use super::PlannedTask;
use crate::lanes::TaskSlots;
use crate::schedule::Disjoint;

/// Data that tasks of a plan write, divided by task.
pub(crate) trait TaskShares: Sync {
    /// Part of one task.
    type Share;

    /// True if parts are disjoint only for tasks of one stage.
    const IN_STAGES: bool = false;

    /// Returns the part of a task from its index among all tasks.
    ///
    /// # Safety
    /// Each task of one plan may be passed only once during the lifetime of the returned parts; if parts are disjoint
    /// only within stages, only tasks of one stage.
    unsafe fn share(&self, place: usize, task: &PlannedTask) -> Self::Share;
}

/// One element per possible task, by its number: lane groups.
pub(crate) struct ByNumber<'a, T>(Disjoint<'a, T>);

/// One element per existing task: sums.
pub(crate) struct ByPlace<'a, T>(Disjoint<'a, T>);

/// Elements from one start to the next, for each existing task: vectors over contacts.
pub(crate) struct ByStarts<'a, T> {
    parts: Disjoint<'a, T>,
    starts: &'a [usize],
}

/// One element per block of eight candidate pairs.
pub(crate) struct ByBlocks<'a, T>(Disjoint<'a, T>);

/// Impulses of candidates, in a common array: [`TaskSlots`] with the indices of candidates.
pub(crate) struct ByCandidates<'a, T>(Disjoint<'a, T>);

/// Bodies, in a common array: [`TaskSlots`] with the indices of bodies.
pub(crate) struct ByBodies<'a, T>(Disjoint<'a, T>);

macro_rules! shares_of_a_slice {
    ($($name:ident),*) => { $(
        impl<'a, T> $name<'a, T> {
            pub fn of(slice: &'a mut [T]) -> $name<'a, T> {
                $name(Disjoint::new(slice))
            }
        }
    )* };
}

shares_of_a_slice!(ByNumber, ByPlace, ByBlocks, ByCandidates, ByBodies);

/// Time between two stages, in which no task runs.
pub(crate) struct Between(());

impl Between {
    /// Begins this time.
    ///
    /// # Safety
    /// No task runs before its end.
    pub unsafe fn stages() -> Between {
        Between(())
    }
}

impl<T: Copy> ByBodies<'_, T> {
    /// Returns all bodies between two stages.
    pub fn all<'b>(&'b self, _: &'b Between) -> TaskSlots<'b, T> {
        // SAFETY: no task runs, and the time between two stages outlives the result.
        unsafe { TaskSlots::new(self.0.as_ptr(), self.0.len()) }
    }
}

impl<'a, T> ByStarts<'a, T> {
    /// Creates the partition from increasing starts of the tasks; the last start is the end of the last task.
    pub fn of(slice: &'a mut [T], starts: &'a [usize]) -> ByStarts<'a, T> {
        assert!(starts.is_sorted(), "parts of tasks overlap");
        ByStarts { parts: Disjoint::new(slice), starts }
    }
}

impl TaskShares for () {
    type Share = ();

    unsafe fn share(&self, _: usize, _: &PlannedTask) {}
}

impl<'a, T: Send> TaskShares for ByNumber<'a, T> {
    type Share = &'a mut T;

    #[inline(always)]
    unsafe fn share(&self, _: usize, task: &PlannedTask) -> &'a mut T {
        // SAFETY: tasks of a plan have different numbers.
        unsafe { self.0.at(task.number as usize) }
    }
}

impl<'a, T: Send> TaskShares for ByPlace<'a, T> {
    type Share = &'a mut T;

    #[inline(always)]
    unsafe fn share(&self, place: usize, _: &PlannedTask) -> &'a mut T {
        // SAFETY: tasks of a plan have different indices.
        unsafe { self.0.at(place) }
    }
}

impl<'a, T: Send> TaskShares for ByStarts<'a, T> {
    type Share = &'a mut [T];

    #[inline(always)]
    unsafe fn share(&self, place: usize, _: &PlannedTask) -> &'a mut [T] {
        // SAFETY: tasks of a plan have different indices, and starts are sorted.
        unsafe { self.parts.range(self.starts[place]..self.starts[place + 1]) }
    }
}

impl<'a, T: Send> TaskShares for ByBlocks<'a, T> {
    type Share = &'a mut [T];

    #[inline(always)]
    unsafe fn share(&self, _: usize, task: &PlannedTask) -> &'a mut [T] {
        // SAFETY: blocks of a plan's tasks are disjoint.
        unsafe { self.0.range(task.blocks()) }
    }
}

impl<'a, T: Send + Copy> TaskShares for ByCandidates<'a, T> {
    type Share = TaskSlots<'a, T>;

    #[inline(always)]
    unsafe fn share(&self, _: usize, _: &PlannedTask) -> TaskSlots<'a, T> {
        // SAFETY: candidates of a plan's tasks are disjoint.
        unsafe { TaskSlots::new(self.0.as_ptr(), self.0.len()) }
    }
}

impl<'a, T: Send + Copy> TaskShares for ByBodies<'a, T> {
    type Share = TaskSlots<'a, T>;

    const IN_STAGES: bool = true;

    #[inline(always)]
    unsafe fn share(&self, _: usize, _: &PlannedTask) -> TaskSlots<'a, T> {
        // SAFETY: tasks of a stage share no body.
        unsafe { TaskSlots::new(self.0.as_ptr(), self.0.len()) }
    }
}

impl<A: TaskShares, B: TaskShares> TaskShares for (A, B) {
    type Share = (A::Share, B::Share);

    const IN_STAGES: bool = A::IN_STAGES || B::IN_STAGES;

    #[inline(always)]
    unsafe fn share(&self, place: usize, task: &PlannedTask) -> Self::Share {
        // SAFETY: guaranteed by the caller.
        unsafe { (self.0.share(place, task), self.1.share(place, task)) }
    }
}

impl<A: TaskShares, B: TaskShares, C: TaskShares> TaskShares for (A, B, C) {
    type Share = (A::Share, B::Share, C::Share);

    const IN_STAGES: bool = A::IN_STAGES || B::IN_STAGES || C::IN_STAGES;

    #[inline(always)]
    unsafe fn share(&self, place: usize, task: &PlannedTask) -> Self::Share {
        // SAFETY: guaranteed by the caller.
        unsafe { (self.0.share(place, task), self.1.share(place, task), self.2.share(place, task)) }
    }
}

impl<A: TaskShares, const N: usize> TaskShares for [A; N] {
    type Share = [A::Share; N];

    const IN_STAGES: bool = A::IN_STAGES;

    #[inline(always)]
    unsafe fn share(&self, place: usize, task: &PlannedTask) -> Self::Share {
        // SAFETY: guaranteed by the caller.
        self.each_ref().map(|shares| unsafe { shares.share(place, task) })
    }
}

impl<A: TaskShares> TaskShares for Option<A> {
    type Share = Option<A::Share>;

    const IN_STAGES: bool = A::IN_STAGES;

    #[inline(always)]
    unsafe fn share(&self, place: usize, task: &PlannedTask) -> Self::Share {
        // SAFETY: guaranteed by the caller.
        self.as_ref().map(|shares| unsafe { shares.share(place, task) })
    }
}
