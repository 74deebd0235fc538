//! Memory that tasks share out among them, so that each has a part that no other has.
//!
//! Here, and where the plan shares out candidates and bodies, is the proof that tasks write no memory of each other: what is handed out
//! is safe to use. [`Disjoint`] is the bare means, for those who know of parts what no type can say.

use std::marker::PhantomData;
use std::ops::Range;

/// Access to single parts of a slice from several threads. The plan of tasks, not the compiler, sees to it that no two
/// tasks of a region touch the same part.
#[derive(Debug)]
pub(crate) struct Disjoint<'a, T> {
    start: *mut T,
    len: usize,
    slice: PhantomData<&'a mut [T]>,
}

// SAFETY: a reference to it hands out exclusive access to elements, as sending `&mut T` would.
unsafe impl<T: Send> Sync for Disjoint<'_, T> {}

impl<'a, T> Disjoint<'a, T> {
    /// Access to the parts of a slice.
    pub fn new(slice: &'a mut [T]) -> Disjoint<'a, T> {
        Disjoint { start: slice.as_mut_ptr(), len: slice.len(), slice: PhantomData }
    }

    /// The first element, for kernels that compute addresses themselves.
    pub fn as_ptr(&self) -> *mut T {
        self.start
    }

    /// Number of elements.
    pub fn len(&self) -> usize {
        self.len
    }

    /// One element. In every build an index beyond the slice panics.
    ///
    /// # Safety
    /// Nothing else may use this element while the reference lives.
    #[inline(always)]
    pub unsafe fn at(&self, index: usize) -> &'a mut T {
        if index >= self.len {
            beyond(index, self.len);
        }
        // SAFETY: inside the slice, and the caller's promise.
        unsafe { &mut *self.start.add(index) }
    }

    /// A range of elements. In every build one that leaves the slice panics.
    ///
    /// # Safety
    /// Nothing else may use these elements while the reference lives.
    #[inline]
    pub unsafe fn range(&self, range: Range<usize>) -> &'a mut [T] {
        assert!(range.start <= range.end && range.end <= self.len);
        // SAFETY: inside the slice, and the caller's promise.
        unsafe { std::slice::from_raw_parts_mut(self.start.add(range.start), range.len()) }
    }
}

/// Kept out of the way of loops that ask for elements.
#[cold]
#[inline(never)]
fn beyond(index: usize, length: usize) -> ! {
    panic!("a task asked for part {index} of {length}")
}

/// Memory that the tasks of a region write, by their number.
pub(crate) trait Shares: Sync {
    /// Share of one task.
    type Share;

    /// The share of a task.
    ///
    /// # Safety
    /// Each number is asked for once while shares that were given live.
    unsafe fn share(&self, number: usize) -> Self::Share;
}

/// An element for each task.
pub(crate) struct Each<'a, T>(Disjoint<'a, T>);

impl<'a, T> Each<'a, T> {
    pub fn of(slice: &'a mut [T]) -> Each<'a, T> {
        Each(Disjoint::new(slice))
    }
}

impl<'a, T: Send> Shares for Each<'a, T> {
    type Share = &'a mut T;

    #[inline(always)]
    unsafe fn share(&self, number: usize) -> &'a mut T {
        // SAFETY: the caller's promise.
        unsafe { self.0.at(number) }
    }
}

/// So many elements for each task, one after the other; the last may get fewer.
pub(crate) struct Runs<'a, T> {
    parts: Disjoint<'a, T>,
    length: usize,
}

impl<'a, T> Runs<'a, T> {
    pub fn of(slice: &'a mut [T], length: usize) -> Runs<'a, T> {
        Runs { parts: Disjoint::new(slice), length }
    }
}

impl<'a, T: Send> Shares for Runs<'a, T> {
    type Share = &'a mut [T];

    #[inline(always)]
    unsafe fn share(&self, number: usize) -> &'a mut [T] {
        let [start, end] = [number, number + 1].map(|number| (number * self.length).min(self.parts.len()));
        // SAFETY: runs of different numbers do not overlap, and the caller's promise.
        unsafe { self.parts.range(start..end) }
    }
}

impl<A: Shares, B: Shares> Shares for (A, B) {
    type Share = (A::Share, B::Share);

    #[inline(always)]
    unsafe fn share(&self, number: usize) -> Self::Share {
        // SAFETY: the caller's promise.
        unsafe { (self.0.share(number), self.1.share(number)) }
    }
}

impl<A: Shares, const N: usize> Shares for [A; N] {
    type Share = [A::Share; N];

    #[inline(always)]
    unsafe fn share(&self, number: usize) -> Self::Share {
        // SAFETY: the caller's promise.
        self.each_ref().map(|shares| unsafe { shares.share(number) })
    }
}
