//! Records of eight or sixteen bodies, spheres or impulses, read and written by their slots in an array.
//!
//! Slots are indices in lane groups and candidates, and no type ties them to an array. Their validity follows from
//! three facts: only packing and detection write slots; slots are taken from the present world and candidate list; and
//! groups are rebuilt in each step. Builds with debug assertions check every slot.

use super::{LANES, Lanes, Line, Octet, Quad, SINGLE_LANES, SingleLanes};
use bytemuck::Pod;
use std::marker::PhantomData;

/// Array without concurrent writes, except to slots of other tasks.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Slots<'a, T> {
    base: *const T,
    count: usize,
    array: PhantomData<&'a [T]>,
}

/// Slots of one task in an array, for reading and writing: those in its lane groups and candidates.
#[derive(Clone, Copy, Debug)]
pub(crate) struct TaskSlots<'a, T> {
    base: *mut T,
    count: usize,
    array: PhantomData<&'a mut [T]>,
}

// SAFETY: the array is only read, as a shared slice is.
unsafe impl<T: Sync> Sync for Slots<'_, T> {}

impl<'a, T: Copy> Slots<'a, T> {
    /// Creates slots of a borrowed array.
    #[inline(always)]
    pub fn of(array: &'a [T]) -> Slots<'a, T> {
        Slots { base: array.as_ptr(), count: array.len(), array: PhantomData }
    }

    /// Returns a pointer to the first slot, for prefetching.
    #[inline(always)]
    pub fn as_ptr(self) -> *const T {
        self.base
    }

    #[inline(always)]
    fn check<const N: usize>(self, slots: &[u32; N]) {
        debug_assert!(
            slots.iter().all(|&slot| (slot as usize) < self.count),
            "a slot beyond the last of {}",
            self.count
        );
    }

    /// Returns the number of slots.
    #[inline(always)]
    pub fn count(self) -> u32 {
        self.count as u32
    }

    /// Returns the record in a slot.
    #[inline(always)]
    pub fn get(self, slot: u32) -> T {
        assert!((slot as usize) < self.count, "slot {slot} of {}", self.count);
        // SAFETY: the slot is inside the array.
        unsafe { *self.base.add(slot as usize) }
    }

    /// Reads a record; builds with debug assertions check the slot.
    #[inline(always)]
    pub fn get_trusted(self, slot: u32) -> T {
        self.check(&[slot]);
        // SAFETY: lane groups and candidates contain slots of the array.
        unsafe { *self.base.add(slot as usize) }
    }
}

impl<T: Pod> Slots<'_, T> {
    /// Returns the array as units of `COUNT` per record, for access to these slots. That records consist of such units is asserted at
    /// compile time; builds with debug assertions check the slots.
    #[inline(always)]
    fn units<U, const COUNT: usize, const N: usize>(self, slots: &[&[u32; N]]) -> *const U {
        const { assert!(size_of::<T>() == COUNT * size_of::<U>() && align_of::<T>() >= align_of::<U>()) }
        for some in slots {
            self.check(some);
        }
        self.base.cast()
    }

    /// Reads eight records of one quad, transposed.
    #[inline(always)]
    pub fn load_quads<L: Lanes>(self, slots: &[u32; LANES]) -> [L; 4] {
        // SAFETY: lane groups and candidates contain slots of the array; a record is a quad.
        unsafe { L::load_quads::<1>(self.units::<Quad, 1, _>(&[slots]), slots) }
    }

    /// Reads the first quads of eight records of two, transposed.
    #[inline(always)]
    pub fn load_first_halves<L: Lanes>(self, slots: &[u32; LANES]) -> [L; 4] {
        // SAFETY: as above; a record is two quads.
        unsafe { L::load_quads::<2>(self.units::<Quad, 2, _>(&[slots]), slots) }
    }

    /// Reads the differences of eight records of one quad and eight others, and the sum of their fourth numbers.
    #[inline(always)]
    pub fn load_differences<L: Lanes>(self, first: &[u32; LANES], second: &[u32; LANES]) -> [L; 4] {
        // SAFETY: as above; a record is a quad.
        unsafe { L::load_differences::<1>(self.units::<Quad, 1, _>(&[first, second]), first, second) }
    }

    /// Loads differences of the first quads of records of two.
    #[inline(always)]
    pub fn load_differences_of_halves<L: Lanes>(self, first: &[u32; LANES], second: &[u32; LANES]) -> [L; 4] {
        // SAFETY: as above; a record is two quads.
        unsafe { L::load_differences::<2>(self.units::<Quad, 2, _>(&[first, second]), first, second) }
    }

    /// Loads differences and returns the records for [`TaskSlots::add_to_kept`].
    #[inline(always)]
    pub fn load_keeping<L: Lanes>(self, first: &[u32; LANES], second: &[u32; LANES]) -> ([L; 4], [L::Kept; 2]) {
        // SAFETY: as above; a record is a line.
        unsafe { L::load_keeping(self.units::<Line, 1, _>(&[first, second]), first, second) }
    }

    /// Loads differences of the first quads of records of two, and sums of their second quads.
    #[inline(always)]
    pub fn load_pairs<L: Lanes>(self, first: &[u32; LANES], second: &[u32; LANES]) -> [[L; 4]; 2] {
        // SAFETY: as above; a record is a line.
        unsafe { L::load_pairs(self.units::<Line, 1, _>(&[first, second]), first, second) }
    }

    /// Reads eight records of one line, transposed.
    #[inline(always)]
    pub fn load_lines<L: Lanes>(self, slots: &[u32; LANES]) -> [[L; 4]; 2] {
        // SAFETY: as above; a record is a line.
        unsafe { L::load_lines(self.units::<Line, 1, _>(&[slots]), slots) }
    }

    /// Reads sixteen records of one octet, transposed.
    #[inline(always)]
    pub fn load_octets<S: SingleLanes>(self, slots: &[u32; SINGLE_LANES]) -> [S; 8] {
        // SAFETY: as above; a record is an octet.
        unsafe { S::load_octets(self.units::<Octet, 1, _>(&[slots]), slots) }
    }
}

impl<'a, T: Copy> TaskSlots<'a, T> {
    /// Creates the slots of an array that no task uses.
    pub fn of(array: &'a mut [T]) -> TaskSlots<'a, T> {
        // SAFETY: the borrow excludes all others.
        unsafe { TaskSlots::new(array.as_mut_ptr(), array.len()) }
    }

    /// Creates the slots of a task in an array of a given length.
    ///
    /// # Safety
    /// During the lifetime of the result, no other task uses the slots in the task's lane groups and candidates.
    #[inline(always)]
    pub unsafe fn new(base: *mut T, count: usize) -> TaskSlots<'a, T> {
        TaskSlots { base, count, array: PhantomData }
    }

    /// Returns read access.
    #[inline(always)]
    pub fn to_read(self) -> Slots<'a, T> {
        Slots { base: self.base, count: self.count, array: PhantomData }
    }

    /// Returns a pointer to the first slot, for prefetching.
    #[inline(always)]
    pub fn as_ptr(self) -> *const T {
        self.base
    }

    /// Returns the record in a slot.
    #[inline(always)]
    pub fn get(self, slot: u32) -> T {
        self.to_read().get(slot)
    }

    /// Writes a record into a slot.
    #[inline(always)]
    pub fn set(self, slot: u32, record: T) {
        assert!((slot as usize) < self.count, "slot {slot} of {}", self.count);
        // SAFETY: the slot is inside the array and belongs to the task.
        unsafe { *self.base.add(slot as usize) = record };
    }

    /// Accesses the record in a slot field by field: a load of a whole record directly after stores of its fields would
    /// have to wait for them. Builds with debug assertions check the slot.
    #[inline(always)]
    pub fn with_trusted<R>(self, slot: u32, work: impl FnOnce(&mut T) -> R) -> R {
        self.to_read().check(&[slot]);
        // SAFETY: lane groups and candidates contain slots of their task.
        work(unsafe { &mut *self.base.add(slot as usize) })
    }
}

impl<T: Pod> TaskSlots<'_, T> {
    /// Returns the array as units for writing: see [`Slots::units`].
    #[inline(always)]
    fn units<U, const COUNT: usize, const N: usize>(self, slots: &[&[u32; N]]) -> *mut U {
        self.to_read().units::<U, COUNT, N>(slots).cast_mut()
    }

    /// Writes eight records of one quad.
    #[inline(always)]
    pub fn store_quads<L: Lanes>(self, slots: &[u32; LANES], quads: [L; 4]) {
        // SAFETY: lane groups and candidates contain slots of their task, eight different ones; a record is a quad.
        unsafe { L::store_quads::<1>(self.units::<Quad, 1, _>(&[slots]), slots, quads) }
    }

    /// Writes the first quads of eight records of two.
    #[inline(always)]
    pub fn store_first_halves<L: Lanes>(self, slots: &[u32; LANES], quads: [L; 4]) {
        // SAFETY: as above; a record is two quads.
        unsafe { L::store_quads::<2>(self.units::<Quad, 2, _>(&[slots]), slots, quads) }
    }

    /// Writes eight records of one line.
    #[inline(always)]
    pub fn store_lines<L: Lanes>(self, slots: &[u32; LANES], halves: [[L; 4]; 2]) {
        // SAFETY: as above; a record is a line.
        unsafe { L::store_lines(self.units::<Line, 1, _>(&[slots]), slots, halves) }
    }

    /// Does the work of [`add_shares`](TaskSlots::add_shares) for first halves only, of returned records that have not changed since.
    #[inline(always)]
    pub fn add_to_kept<L: Lanes>(self, slots: &[u32; LANES], kept: L::Kept, half: [L; 3], factor: f64) {
        // SAFETY: as above; a record is a line.
        unsafe { L::add_to_kept(self.units::<Line, 1, _>(&[slots]), slots, kept, half, factor) }
    }

    /// Adds `halves` to the first three numbers of each half of eight records, times their fourth number and a factor
    /// for each half; unless `WHOLE`, to first halves only.
    #[inline(always)]
    pub fn add_shares<L: Lanes, const WHOLE: bool>(self, slots: &[u32; LANES], halves: [[L; 3]; 2], factors: [f64; 2]) {
        // SAFETY: as above; a record is a line.
        unsafe { L::add_shares::<WHOLE>(self.units::<Line, 1, _>(&[slots]), slots, halves, factors) }
    }

    /// Writes sixteen records of one octet.
    #[inline(always)]
    pub fn store_octets<S: SingleLanes>(self, slots: &[u32; SINGLE_LANES], octets: [S; 8]) {
        // SAFETY: as above, sixteen different ones; a record is an octet.
        unsafe { S::store_octets(self.units::<Octet, 1, _>(&[slots]), slots, octets) }
    }
}
