//! Partition of data among tasks: lane groups, candidates, and the bodies that a stage's tasks may write.
//!
//! The proofs stand here. Every task has its own number and its own place; its candidates and blocks are ranges that follow
//! each other ([`Plan::set`](super::Plan)); and tasks of one stage share no body, because of the boxes that they belong to
//! (`BoxGrid`, tested on whole layouts). So whoever gets a share may use it as its own.

use super::PlannedTask;
use crate::lanes::TaskSlots;
use crate::schedule::Disjoint;

/// Data that tasks of a plan write, by task.
pub(crate) trait TaskShares: Sync {
    /// Part of one task.
    type Share;

    /// True if shares are apart for tasks of one stage alone.
    const IN_STAGES: bool = false;

    /// The share of a task, given its place among all.
    ///
    /// # Safety
    /// Each task of one plan is asked for once while shares that were given live, and where shares are apart in stages alone, tasks of
    /// one stage only.
    unsafe fn share(&self, place: usize, task: &PlannedTask) -> Self::Share;
}

/// An element for each task that can be, by its number: lane groups.
pub(crate) struct ByNumber<'a, T>(Disjoint<'a, T>);

/// An element for each task that there is: sums.
pub(crate) struct ByPlace<'a, T>(Disjoint<'a, T>);

/// Elements from one start to the next, for each task that there is: vectors over contacts.
pub(crate) struct ByStarts<'a, T> {
    parts: Disjoint<'a, T>,
    starts: &'a [usize],
}

/// An element for each block of eight pairs of candidates.
pub(crate) struct ByBlocks<'a, T>(Disjoint<'a, T>);

/// Impulses of candidates, in an array of all: [`TaskSlots`] that are named by candidates.
pub(crate) struct ByCandidates<'a, T>(Disjoint<'a, T>);

/// Bodies, in an array of all: [`TaskSlots`] that are named by bodies.
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

impl<'a, T> ByStarts<'a, T> {
    /// Starts grow from task to task, and the last one ends the last task.
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
        // SAFETY: tasks of a plan have different places.
        unsafe { self.0.at(place) }
    }
}

impl<'a, T: Send> TaskShares for ByStarts<'a, T> {
    type Share = &'a mut [T];

    #[inline(always)]
    unsafe fn share(&self, place: usize, _: &PlannedTask) -> &'a mut [T] {
        // SAFETY: tasks of a plan have different places, and starts are sorted.
        unsafe { self.parts.range(self.starts[place]..self.starts[place + 1]) }
    }
}

impl<'a, T: Send> TaskShares for ByBlocks<'a, T> {
    type Share = &'a mut [T];

    #[inline(always)]
    unsafe fn share(&self, _: usize, task: &PlannedTask) -> &'a mut [T] {
        // SAFETY: blocks of a plan's tasks do not overlap.
        unsafe { self.0.range(task.blocks()) }
    }
}

impl<'a, T: Send + Copy> TaskShares for ByCandidates<'a, T> {
    type Share = TaskSlots<'a, T>;

    #[inline(always)]
    unsafe fn share(&self, _: usize, _: &PlannedTask) -> TaskSlots<'a, T> {
        // SAFETY: candidates of a plan's tasks do not overlap.
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
        // SAFETY: the caller's promise.
        unsafe { (self.0.share(place, task), self.1.share(place, task)) }
    }
}

impl<A: TaskShares, B: TaskShares, C: TaskShares> TaskShares for (A, B, C) {
    type Share = (A::Share, B::Share, C::Share);

    const IN_STAGES: bool = A::IN_STAGES || B::IN_STAGES || C::IN_STAGES;

    #[inline(always)]
    unsafe fn share(&self, place: usize, task: &PlannedTask) -> Self::Share {
        // SAFETY: the caller's promise.
        unsafe { (self.0.share(place, task), self.1.share(place, task), self.2.share(place, task)) }
    }
}

impl<A: TaskShares, const N: usize> TaskShares for [A; N] {
    type Share = [A::Share; N];

    const IN_STAGES: bool = A::IN_STAGES;

    #[inline(always)]
    unsafe fn share(&self, place: usize, task: &PlannedTask) -> Self::Share {
        // SAFETY: the caller's promise.
        self.each_ref().map(|shares| unsafe { shares.share(place, task) })
    }
}

impl<A: TaskShares> TaskShares for Option<A> {
    type Share = Option<A::Share>;

    const IN_STAGES: bool = A::IN_STAGES;

    #[inline(always)]
    unsafe fn share(&self, place: usize, task: &PlannedTask) -> Self::Share {
        // SAFETY: the caller's promise.
        self.as_ref().map(|shares| unsafe { shares.share(place, task) })
    }
}
