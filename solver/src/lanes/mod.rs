//! SIMD arithmetic of lane groups, eight numbers at a time, in one implementation for every instruction set.
//!
//! A kernel is generic over [`Number`] (arithmetic) and [`Lanes`] (eight numbers, with loads and stores). Kernels are
//! compiled for plain Rust, for AVX2 and for AVX-512F, and the best instruction set of the processor is chosen once at
//! start. Every operation is one correctly rounded IEEE operation per lane, so all instruction sets give the same bits.
//! Fused multiply-add is excluded on purpose: a processor without it would need a library call instead of an
//! instruction. [`docs/kernel.md`](instructions) states the cost, and the instructions that remain.

/// Defines an inlined function, or a method on the operand after `self`.
macro_rules! operation {
    ($method:ident(self $a:ident $(, $b:ident: $kind:ty)?) -> $output:ty, $result:expr) => {
        #[inline(always)]
        fn $method(self $(, $b: $kind)?) -> $output {
            let $a = self;
            $result
        }
    };
    ($method:ident($($operand:ident: $kind:ty),*) -> $output:ty, $result:expr) => {
        #[inline(always)]
        fn $method($($operand: $kind),*) -> $output {
            $result
        }
    };
}

/// Implements an operator of one or two operands of a type.
macro_rules! operator {
    ($kind:ty, $operator:ident, $method:ident, |$a:ident $(, $b:ident)?| $result:expr) => {
        impl $operator for $kind {
            type Output = $kind;
            operation!($method(self $a $(, $b: $kind)?) -> $kind, $result);
        }
    };
}

/// Implements [`Number`] for a type, with its masks: one expression for each operation.
macro_rules! number {
    (
        $lanes:ty, $mask:ty, |$a:ident, $b:ident, $chosen:ident|
        splat: $splat:expr, sqrt: $sqrt:expr, abs: $abs:expr, larger: $larger:expr, smaller: $smaller:expr,
        below: $below:expr, at_most: $at_most:expr, select: $select:expr, all: $all:expr
    ) => {
        impl Number for $lanes {
            type Mask = $mask;
            operation!(splat($a: f64) -> $lanes, $splat);
            operation!(sqrt(self $a) -> $lanes, $sqrt);
            operation!(abs(self $a) -> $lanes, $abs);
            operation!(larger(self $a, $b: $lanes) -> $lanes, $larger);
            operation!(smaller(self $a, $b: $lanes) -> $lanes, $smaller);
            operation!(below(self $a, $b: $lanes) -> $mask, $below);
            operation!(at_most(self $a, $b: $lanes) -> $mask, $at_most);
            operation!(select($chosen: $mask, $a: $lanes, $b: $lanes) -> $lanes, $select);
            operation!(all($chosen: $mask) -> bool, $all);
        }
    };
}

/// Defines the transposition of matrices of four rows of four single-precision numbers, one in each 128 bits.
#[cfg(target_arch = "x86_64")]
macro_rules! transposition {
    ($name:ident, $register:ty, $low:ident $high:ident $low_pairs:ident $high_pairs:ident $to_pairs:ident $from_pairs:ident) => {
        /// Transposes matrices of four rows of four, one in each 128 bits.
        ///
        /// # Safety
        /// The instruction set of the registers.
        #[inline(always)]
        unsafe fn $name([a, b, c, d]: [$register; 4]) -> [$register; 4] {
            // SAFETY: guaranteed by the caller.
            unsafe {
                let (low_a, low_c) = ($to_pairs($low(a, b)), $to_pairs($low(c, d)));
                let (high_a, high_c) = ($to_pairs($high(a, b)), $to_pairs($high(c, d)));
                [
                    $from_pairs($low_pairs(low_a, low_c)),
                    $from_pairs($high_pairs(low_a, low_c)),
                    $from_pairs($low_pairs(high_a, high_c)),
                    $from_pairs($high_pairs(high_a, high_c)),
                ]
            }
        }
    };
}

#[cfg(target_arch = "x86_64")]
mod avx2;
#[cfg(target_arch = "x86_64")]
mod avx512;
mod portable;
mod slots;

pub(crate) use slots::{Slots, TaskSlots};

#[cfg(doc)]
#[doc = include_str!("../../docs/kernel.md")]
pub mod instructions {}

use bytemuck::{Pod, Zeroable};
use serde::{Deserialize, Serialize};
use std::ops::{Add, BitAnd, Div, Mul, Neg, Not, Sub};

/// Number of contacts in a lane group; part of the algorithm, not of the machine.
pub const LANES: usize = 8;

/// Default prefetch distance in lane groups, for steps that exceed the cache: the bodies of groups this far ahead are
/// fetched, those of a sweep twice as far ahead. Two to eight are about equally good: `docs/memory.md` has the
/// measurements.
pub const PREFETCH: usize = 4;

/// Number of contacts in a single-precision lane group: two groups of eight.
pub const SINGLE_LANES: usize = 2 * LANES;

/// Eight `f64` in memory, one per contact.
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
#[repr(C, align(64))]
pub struct Eight(pub [f64; LANES]);

/// Sixteen `f32` in memory, one per contact.
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
#[repr(C, align(64))]
pub struct Sixteen(pub [f32; SINGLE_LANES]);

/// One or several numbers of one precision, with the operations of the kernels.
pub trait Number:
    Copy + Add<Output = Self> + Sub<Output = Self> + Mul<Output = Self> + Div<Output = Self> + Neg<Output = Self>
{
    /// Truth value per lane.
    type Mask: Copy + BitAnd<Output = Self::Mask> + Not<Output = Self::Mask>;

    /// Sets each lane to the same number, rounded to the precision of the lanes.
    fn splat(value: f64) -> Self;
    /// Returns the correctly rounded square root.
    fn sqrt(self) -> Self;
    /// Returns the magnitude.
    fn abs(self) -> Self;
    /// Returns `self` in lanes where it exceeds `other`, and `other` elsewhere.
    fn larger(self, other: Self) -> Self;
    /// Returns `self` in lanes where it is below `other`, and `other` elsewhere.
    fn smaller(self, other: Self) -> Self;
    /// Returns the mask of the lanes where `self` is below `other`.
    fn below(self, other: Self) -> Self::Mask;
    /// Returns the mask of the lanes where `self` does not exceed `other`.
    fn at_most(self, other: Self) -> Self::Mask;
    /// Returns `yes` in the lanes of the mask, and `no` elsewhere.
    fn select(mask: Self::Mask, yes: Self, no: Self) -> Self;
    /// Returns true if the mask is set in every lane.
    fn all(mask: Self::Mask) -> bool;

    /// Returns zero in each lane.
    #[inline(always)]
    fn zero() -> Self {
        Self::splat(0.0)
    }
}

/// Eight lanes of registers, with loads and stores.
///
/// Records of bodies, spheres and impulses are stored as [`Quad`]s. Eight quads are loaded as aligned halves of cache
/// lines and transposed in registers: gathers were slower on every processor tested.
pub trait Lanes: Number {
    /// Sixteen single-precision lanes in the same registers.
    type Single: SingleLanes;

    /// Halves of eight lines after a read, for a later write; empty if there are too few registers for the halves.
    type Kept: Copy;

    /// True if sweeps gain from several lane groups in flight at a time: registers suffice.
    const OVERLAPPED: bool;

    /// Reads eight numbers.
    fn load(from: &Eight) -> Self;

    /// Writes eight numbers.
    fn store(self, to: &mut Eight);

    /// Returns the lanes of a mask as bits, lane 0 lowest.
    fn bits(mask: Self::Mask) -> u32;

    /// Returns true if both indices are equal and below `end`.
    #[inline(always)]
    fn share_places(some: [&[u32; LANES]; 2], others: [&[u32; LANES]; 2], end: u32) -> bool {
        let among_others = |place| others.into_iter().flatten().any(|other| other == place);
        some.into_iter().flatten().any(|place| *place < end && among_others(place))
    }

    /// Reads the quads `base + STRIDE indices[lane]` and transposes them.
    ///
    /// # Safety
    /// Each of these quads must be in readable memory.
    unsafe fn load_quads<const STRIDE: usize>(base: *const Quad, indices: &[u32; LANES]) -> [Self; 4];

    /// Transposes and writes the quads `base + STRIDE indices[lane]`.
    ///
    /// # Safety
    /// Each of these quads must be in writable memory, without other accesses during the call.
    unsafe fn store_quads<const STRIDE: usize>(base: *mut Quad, indices: &[u32; LANES], quads: [Self; 4]);

    /// Reads the quads `base + STRIDE first[lane]` and `base + STRIDE second[lane]`, and transposes the differences (second minus
    /// first) of the first three numbers, and the sum of the fourth. Half the transposition of both, and fewer registers.
    ///
    /// # Safety
    /// The requirements of [`load_quads`](Lanes::load_quads) apply.
    unsafe fn load_differences<const STRIDE: usize>(
        base: *const Quad,
        first: &[u32; LANES],
        second: &[u32; LANES],
    ) -> [Self; 4];

    /// Loads differences of the first halves of the lines `base + first[lane]` and `base + second[lane]`, and returns
    /// the halves for [`add_to_kept`](Lanes::add_to_kept).
    ///
    /// # Safety
    /// Each of these lines must be in readable memory.
    unsafe fn load_keeping(
        base: *const Line,
        first: &[u32; LANES],
        second: &[u32; LANES],
    ) -> ([Self; 4], [Self::Kept; 2]);

    /// Does the work of [`add_shares`](Lanes::add_shares) for first halves only, of returned lines that have not changed since.
    ///
    /// # Safety
    /// Each of these lines must be in writable memory, without other accesses during the call.
    unsafe fn add_to_kept(base: *mut Line, indices: &[u32; LANES], kept: Self::Kept, half: [Self; 3], factor: f64);

    /// Loads differences of the first halves of the lines `base + first[lane]` and `base + second[lane]`, and sums of their second halves.
    ///
    /// # Safety
    /// Each of these lines must be in readable memory.
    unsafe fn load_pairs(base: *const Line, first: &[u32; LANES], second: &[u32; LANES]) -> [[Self; 4]; 2];

    /// Reads the lines `base + indices[lane]` and transposes both halves.
    ///
    /// # Safety
    /// Each of these lines must be in readable memory.
    #[inline(always)]
    unsafe fn load_lines(base: *const Line, indices: &[u32; LANES]) -> [[Self; 4]; 2] {
        let quads: *const Quad = base.cast();
        // SAFETY: guaranteed by the caller; a line is two quads.
        unsafe { [Self::load_quads::<2>(quads, indices), Self::load_quads::<2>(quads.add(1), indices)] }
    }

    /// Transposes and writes the lines `base + indices[lane]`.
    ///
    /// # Safety
    /// Each of these lines must be in writable memory, without other accesses during the call.
    #[inline(always)]
    unsafe fn store_lines(base: *mut Line, indices: &[u32; LANES], [first, second]: [[Self; 4]; 2]) {
        let quads: *mut Quad = base.cast();
        // SAFETY: guaranteed by the caller; a line is two quads.
        unsafe {
            Self::store_quads::<2>(quads, indices, first);
            Self::store_quads::<2>(quads.add(1), indices, second);
        }
    }

    /// Adds the transposed `halves` to the first three numbers of each half of the lines `base + indices[lane]`, times
    /// the fourth number of the half and a factor for each half. Unless `WHOLE`, only first halves change.
    ///
    /// # Safety
    /// Each of these lines must be in writable memory, without other accesses during the call.
    unsafe fn add_shares<const WHOLE: bool>(
        base: *mut Line,
        indices: &[u32; LANES],
        halves: [[Self; 3]; 2],
        factors: [f64; 2],
    );
}

/// Sixteen single-precision lanes. A single-precision body is one [`Octet`].
pub trait SingleLanes: Number {
    /// Reads sixteen numbers.
    fn load(from: &Sixteen) -> Self;

    /// Writes sixteen numbers.
    fn store(self, to: &mut Sixteen);

    /// Reads the octets `base + indices[lane]` and transposes them.
    ///
    /// # Safety
    /// Each of these octets must be in readable memory.
    unsafe fn load_octets(base: *const Octet, indices: &[u32; SINGLE_LANES]) -> [Self; 8];

    /// Transposes and writes the octets `base + indices[lane]`.
    ///
    /// # Safety
    /// Each of these octets must be in writable memory, without other accesses during the call.
    unsafe fn store_octets(base: *mut Octet, indices: &[u32; SINGLE_LANES], octets: [Self; 8]);
}

/// Four numbers that are read together: half a cache line.
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
#[repr(C, align(32))]
pub struct Quad(pub [f64; 4]);

/// Two quads that are read together: a cache line.
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
#[repr(C, align(64))]
pub struct Line(pub [Quad; 2]);

/// Eight single-precision numbers that are read together: half a cache line.
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
#[repr(C, align(32))]
pub struct Octet(pub [f32; 8]);

/// Scalar product.
#[inline(always)]
pub fn dot<N: Number>(a: [N; 3], b: [N; 3]) -> N {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

/// Vector product.
#[inline(always)]
pub fn cross<N: Number>(a: [N; 3], b: [N; 3]) -> [N; 3] {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

/// Returns `a + b`.
#[inline(always)]
pub fn plus<N: Number>(a: [N; 3], b: [N; 3]) -> [N; 3] {
    [a[0] + b[0], a[1] + b[1], a[2] + b[2]]
}

/// Returns `a - b`.
#[inline(always)]
pub fn minus<N: Number>(a: [N; 3], b: [N; 3]) -> [N; 3] {
    [a[0] - b[0], a[1] - b[1], a[2] - b[2]]
}

/// Returns `a` times a number.
#[inline(always)]
pub fn times<N: Number>(a: [N; 3], factor: N) -> [N; 3] {
    [a[0] * factor, a[1] * factor, a[2] * factor]
}

/// Instruction set of the kernels, available on this processor or not: [`Available`] is restricted to available sets.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum InstructionSet {
    /// Instructions of the build target.
    Generic,
    /// 256-bit registers.
    Avx2,
    /// 512-bit registers.
    Avx512,
}

impl InstructionSet {
    /// All instruction sets, from the narrowest to the widest.
    pub const ALL: [InstructionSet; 3] = [InstructionSet::Generic, InstructionSet::Avx2, InstructionSet::Avx512];

    /// Returns the widest instruction set of this processor.
    pub fn detect() -> InstructionSet {
        Available::detect().name()
    }

    /// Returns true if this processor has the instruction set.
    pub fn is_available(self) -> bool {
        self.on_this_processor().is_some()
    }

    /// Returns permission to run kernels with the instruction set, if this processor has it.
    pub fn on_this_processor(self) -> Option<Available> {
        let found = match self {
            InstructionSet::Generic => true,
            #[cfg(target_arch = "x86_64")]
            InstructionSet::Avx2 => is_x86_feature_detected!("avx2"),
            #[cfg(target_arch = "x86_64")]
            InstructionSet::Avx512 => is_x86_feature_detected!("avx512f"),
            #[cfg(not(target_arch = "x86_64"))]
            _ => false,
        };
        found.then_some(Available(self))
    }

    /// Returns the name on the command line.
    pub fn name(self) -> &'static str {
        match self {
            InstructionSet::Generic => "generic",
            InstructionSet::Avx2 => "avx2",
            InstructionSet::Avx512 => "avx512",
        }
    }
}

/// Instruction set that this processor has. Kernels run only through this type, and only a query of the processor
/// creates a value ([`InstructionSet::on_this_processor`]).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Available(InstructionSet);

impl Available {
    /// Returns the widest instruction set of this processor.
    pub fn detect() -> Available {
        let widest = InstructionSet::ALL.into_iter().rev().find_map(InstructionSet::on_this_processor);
        widest.unwrap_or(Available(InstructionSet::Generic))
    }

    /// Returns the instruction set.
    pub fn name(self) -> InstructionSet {
        self.0
    }

    /// Runs a kernel with the instruction set.
    pub fn run<K: Kernel>(self, kernel: K) -> K::Output {
        match self.0 {
            // SAFETY: this processor has the set: only a query of the processor creates a value of this type.
            #[cfg(target_arch = "x86_64")]
            InstructionSet::Avx512 => unsafe { run_avx512(kernel) },
            // SAFETY: as above.
            #[cfg(target_arch = "x86_64")]
            InstructionSet::Avx2 => unsafe { run_avx2(kernel) },
            _ => kernel.run::<portable::Portable<f64, LANES>>(),
        }
    }
}

/// Loop over lane groups, compiled once for each instruction set.
pub trait Kernel {
    /// Result type.
    type Output;

    /// Runs the loop; `#[inline(always)]` in every implementation, so that the loop is compiled for the registers of its caller.
    fn run<L: Lanes>(self) -> Self::Output;
}

#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx512f")]
fn run_avx512<K: Kernel>(kernel: K) -> K::Output {
    kernel.run::<avx512::Avx512>()
}

#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx2")]
fn run_avx2<K: Kernel>(kernel: K) -> K::Output {
    kernel.run::<avx2::Avx2>()
}

number!(
    f64, bool, |a, b, mask|
    splat: a, sqrt: f64::sqrt(a), abs: f64::abs(a), larger: if a > b { a } else { b }, smaller: if a < b { a } else { b },
    below: a < b, at_most: a <= b, select: if mask { a } else { b }, all: mask
);

/// Returns the lanes of a bit mask, the lowest first.
#[inline(always)]
pub(crate) fn lanes_of(mask: u8) -> impl Iterator<Item = usize> {
    let mut left = mask;
    std::iter::from_fn(move || {
        let lane = (left != 0).then(|| left.trailing_zeros() as usize)?;
        left &= left - 1;
        Some(lane)
    })
}

/// Prefetches the records at several indices, each at most as long as a cache line.
#[inline(always)]
pub(crate) fn prefetch_places<T>(records: *const T, places: &[u32]) {
    for &place in places {
        prefetch(records.wrapping_add(place as usize).cast());
    }
}

/// Prefetches the first bytes of a record that begins with a cache line.
#[inline(always)]
pub(crate) fn prefetch_lines<T>(record: *const T, bytes: usize) {
    let lines: *const Eight = record.cast();
    for line in 0..bytes.div_ceil(size_of::<Eight>()) {
        prefetch(lines.wrapping_add(line).cast());
    }
}

/// Prefetches contiguous records.
#[inline(always)]
pub(crate) fn prefetch_range<T>(records: &[T]) {
    prefetch_lines(records.as_ptr(), size_of_val(records));
}

/// Prefetches the cache line at an address, which may be outside the memory of this program.
#[inline(always)]
pub(crate) fn prefetch(address: *const i8) {
    #[cfg(target_arch = "x86_64")]
    // SAFETY: prefetching reads nothing, and every x86-64 processor supports it.
    unsafe {
        use std::arch::x86_64::{_MM_HINT_T0, _mm_prefetch};
        _mm_prefetch::<_MM_HINT_T0>(address);
    }
    #[cfg(not(target_arch = "x86_64"))]
    let _ = address;
}
