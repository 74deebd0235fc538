//! Partition of memory among tasks into disjoint parts.
//!
//! This module, and the partition of candidates and bodies by the plan, contain the proof that tasks never write to the
//! same memory; their parts are safe to use. [`Disjoint`] is the unsafe primitive for parts that no type can describe.

use std::marker::PhantomData;
use std::ops::Range;

/// Access to disjoint parts of a slice from several threads. The plan of tasks, not the compiler, guarantees that no
/// two tasks of a region access the same part.
#[derive(Debug)]
pub(crate) struct Disjoint<'a, T> {
    start: *mut T,
    len: usize,
    slice: PhantomData<&'a mut [T]>,
}

// SAFETY: a shared reference gives exclusive access to elements, as sending `&mut T` would.
unsafe impl<T: Send> Sync for Disjoint<'_, T> {}

impl<'a, T> Disjoint<'a, T> {
    /// Creates the access to the parts of a slice.
    pub fn new(slice: &'a mut [T]) -> Disjoint<'a, T> {
        Disjoint { start: slice.as_mut_ptr(), len: slice.len(), slice: PhantomData }
    }

    /// Returns a pointer to the first element, for kernels that compute addresses.
    pub fn as_ptr(&self) -> *mut T {
        self.start
    }

    /// Returns the number of elements.
    pub fn len(&self) -> usize {
        self.len
    }

    /// Returns one element. In every build, an index beyond the slice panics.
    ///
    /// # Safety
    /// No other access to this element may occur during the lifetime of the reference.
    #[inline(always)]
    pub unsafe fn at(&self, index: usize) -> &'a mut T {
        if index >= self.len {
            beyond(index, self.len);
        }
        // SAFETY: the index is inside the slice, and the caller guarantees exclusive access.
        unsafe { &mut *self.start.add(index) }
    }

    /// Returns a range of elements. In every build, a range beyond the slice panics.
    ///
    /// # Safety
    /// No other access to these elements may occur during the lifetime of the reference.
    #[inline]
    pub unsafe fn range(&self, range: Range<usize>) -> &'a mut [T] {
        assert!(range.start <= range.end && range.end <= self.len);
        // SAFETY: the range is inside the slice, and the caller guarantees exclusive access.
        unsafe { std::slice::from_raw_parts_mut(self.start.add(range.start), range.len()) }
    }
}

/// Panics outside the loops that access elements, so that these remain small.
#[cold]
#[inline(never)]
fn beyond(index: usize, length: usize) -> ! {
    panic!("a task asked for part {index} of {length}")
}

/// Memory that the tasks of a region write, by task number.
pub(crate) trait Shares: Sync {
    /// Part of one task.
    type Share;

    /// Returns the part of a task.
    ///
    /// # Safety
    /// Each number may be passed only once during the lifetime of the returned parts.
    unsafe fn share(&self, number: usize) -> Self::Share;
}

/// One element per task.
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
        // SAFETY: guaranteed by the caller.
        unsafe { self.0.at(number) }
    }
}

/// A fixed number of consecutive elements per task; the last task may have fewer.
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
        // SAFETY: runs of different numbers are disjoint; the caller guarantees distinct numbers.
        unsafe { self.parts.range(start..end) }
    }
}

impl<A: Shares, B: Shares> Shares for (A, B) {
    type Share = (A::Share, B::Share);

    #[inline(always)]
    unsafe fn share(&self, number: usize) -> Self::Share {
        // SAFETY: guaranteed by the caller.
        unsafe { (self.0.share(number), self.1.share(number)) }
    }
}

impl<A: Shares, const N: usize> Shares for [A; N] {
    type Share = [A::Share; N];

    #[inline(always)]
    unsafe fn share(&self, number: usize) -> Self::Share {
        // SAFETY: guaranteed by the caller.
        self.each_ref().map(|shares| unsafe { shares.share(number) })
    }
}
