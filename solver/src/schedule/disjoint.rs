//! A slice whose parts are written by tasks that share none of them.

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

    /// One element. In every build an index beyond the slice panics.
    ///
    /// # Safety
    /// Nothing else may use this element while the reference lives.
    #[allow(clippy::mut_from_ref)]
    #[inline(always)]
    pub unsafe fn at(&self, index: usize) -> &mut T {
        if index >= self.len {
            beyond(index, self.len);
        }
        // SAFETY: inside the slice, and the caller's promise.
        unsafe { &mut *self.start.add(index) }
    }

    /// A range of elements.
    ///
    /// # Safety
    /// Nothing else may use these elements while the reference lives.
    #[allow(clippy::mut_from_ref)]
    pub unsafe fn range(&self, range: Range<usize>) -> &mut [T] {
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn parts_are_those_of_the_slice() {
        let mut numbers = [1, 2, 3];
        let parts = Disjoint::new(&mut numbers);
        // SAFETY: no other thread uses the numbers.
        unsafe {
            *parts.at(2) += 10;
            parts.range(0..2)[0] += 20;
        }
        assert_eq!(numbers, [21, 2, 13]);
    }

    #[test]
    #[should_panic(expected = "a task asked for part 3 of 3")]
    fn a_part_beyond_the_slice_is_refused_in_every_build() {
        let mut numbers = [1, 2, 3];
        let parts = Disjoint::new(&mut numbers);
        // SAFETY: no other thread uses the numbers.
        unsafe { *parts.at(3) = 0 };
    }
}
