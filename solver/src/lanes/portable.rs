//! Lanes in plain Rust: the compiler uses the registers of the build target.

// One index is used for several arrays at once.
#![allow(clippy::needless_range_loop)]

use super::{Eight, LANES, Lanes, Line, Number, Octet, Quad, SINGLE_LANES, SingleLanes, Sixteen};
use std::ops::{Add, BitAnd, Div, Mul, Neg, Not, Sub};

/// `N` numbers as an array.
#[derive(Clone, Copy)]
pub struct Portable<T, const N: usize>([T; N]);

/// `N` truth values as an array.
#[derive(Clone, Copy)]
pub struct PortableMask<const N: usize>([bool; N]);

/// Arithmetic with every lane written out: loops over lanes would take an eighth of the compile time of the whole crate.
macro_rules! arithmetic {
    ($real:ty, $count:expr, $($lane:literal)*) => {
        operator!(Portable<$real, $count>, Add, add, |a, b| Portable([$(a.0[$lane] + b.0[$lane]),*]));
        operator!(Portable<$real, $count>, Sub, sub, |a, b| Portable([$(a.0[$lane] - b.0[$lane]),*]));
        operator!(Portable<$real, $count>, Mul, mul, |a, b| Portable([$(a.0[$lane] * b.0[$lane]),*]));
        operator!(Portable<$real, $count>, Div, div, |a, b| Portable([$(a.0[$lane] / b.0[$lane]),*]));
        operator!(Portable<$real, $count>, Neg, neg, |a| Portable([$(-a.0[$lane]),*]));
        operator!(PortableMask<$count>, BitAnd, bitand, |a, b| PortableMask([$(a.0[$lane] & b.0[$lane]),*]));
        operator!(PortableMask<$count>, Not, not, |a| PortableMask([$(!a.0[$lane]),*]));

        number!(
            Portable<$real, $count>, PortableMask<$count>, |a, b, mask|
            splat: Portable([a as $real; $count]),
            sqrt: Portable([$(a.0[$lane].sqrt()),*]),
            abs: Portable([$(a.0[$lane].abs()),*]),
            larger: Portable([$(if a.0[$lane] > b.0[$lane] { a.0[$lane] } else { b.0[$lane] }),*]),
            smaller: Portable([$(if a.0[$lane] < b.0[$lane] { a.0[$lane] } else { b.0[$lane] }),*]),
            below: PortableMask([$(a.0[$lane] < b.0[$lane]),*]),
            at_most: PortableMask([$(a.0[$lane] <= b.0[$lane]),*]),
            select: Portable([$(if mask.0[$lane] { a.0[$lane] } else { b.0[$lane] }),*]),
            all: mask.0 == [true; $count]
        );
    };
}

arithmetic!(f64, LANES, 0 1 2 3 4 5 6 7);
arithmetic!(f32, SINGLE_LANES, 0 1 2 3 4 5 6 7 8 9 10 11 12 13 14 15);

impl Lanes for Portable<f64, LANES> {
    type Single = Portable<f32, SINGLE_LANES>;
    type Kept = ();

    const OVERLAPPED: bool = false;

    #[inline(always)]
    fn load(from: &Eight) -> Self {
        Portable(from.0)
    }

    #[inline(always)]
    fn store(self, to: &mut Eight) {
        to.0 = self.0;
    }

    #[inline(always)]
    fn bits(mask: PortableMask<LANES>) -> u32 {
        let mut bits = 0;
        for lane in 0..LANES {
            bits |= u32::from(mask.0[lane]) << lane;
        }
        bits
    }

    #[inline(always)]
    unsafe fn load_quads<const STRIDE: usize>(base: *const Quad, indices: &[u32; LANES]) -> [Self; 4] {
        let mut out = [Portable([0.0; LANES]); 4];
        for lane in 0..LANES {
            // SAFETY: guaranteed by the caller.
            let quad = unsafe { (*base.add(STRIDE * indices[lane] as usize)).0 };
            for part in 0..4 {
                out[part].0[lane] = quad[part];
            }
        }
        out
    }

    #[inline(always)]
    unsafe fn store_quads<const STRIDE: usize>(base: *mut Quad, indices: &[u32; LANES], quads: [Self; 4]) {
        for lane in 0..LANES {
            let quad = Quad(std::array::from_fn(|part| quads[part].0[lane]));
            // SAFETY: guaranteed by the caller.
            unsafe { *base.add(STRIDE * indices[lane] as usize) = quad };
        }
    }

    #[inline(always)]
    unsafe fn load_differences<const STRIDE: usize>(
        base: *const Quad,
        first: &[u32; LANES],
        second: &[u32; LANES],
    ) -> [Self; 4] {
        let mut out = [Portable([0.0; LANES]); 4];
        for lane in 0..LANES {
            // SAFETY: guaranteed by the caller.
            let [a, b] = [first[lane], second[lane]].map(|place| unsafe { &(*base.add(STRIDE * place as usize)).0 });
            for part in 0..4 {
                out[part].0[lane] = if part < 3 { b[part] - a[part] } else { b[part] + a[part] };
            }
        }
        out
    }

    #[inline(always)]
    unsafe fn load_keeping(base: *const Line, first: &[u32; LANES], second: &[u32; LANES]) -> ([Self; 4], [(); 2]) {
        // SAFETY: guaranteed by the caller.
        (unsafe { Self::load_differences::<2>(base.cast(), first, second) }, [(); 2])
    }

    #[inline(always)]
    unsafe fn add_to_kept(base: *mut Line, indices: &[u32; LANES], (): (), half: [Self; 3], factor: f64) {
        // SAFETY: guaranteed by the caller.
        unsafe { Self::add_shares::<false>(base, indices, [half; 2], [factor; 2]) };
    }

    #[inline(always)]
    unsafe fn load_pairs(base: *const Line, first: &[u32; LANES], second: &[u32; LANES]) -> [[Self; 4]; 2] {
        // SAFETY: guaranteed by the caller; a line is two quads.
        let motion = unsafe { Self::load_differences::<2>(base.cast(), first, second) };
        let mut turning = [Portable([0.0; LANES]); 4];
        for lane in 0..LANES {
            // SAFETY: guaranteed by the caller.
            let [a, b] = [first[lane], second[lane]].map(|place| unsafe { &(*base.add(place as usize)).0[1].0 });
            for part in 0..4 {
                turning[part].0[lane] = b[part] + a[part];
            }
        }
        [motion, turning]
    }

    #[inline(always)]
    unsafe fn add_shares<const WHOLE: bool>(
        base: *mut Line,
        indices: &[u32; LANES],
        halves: [[Self; 3]; 2],
        factors: [f64; 2],
    ) {
        for lane in 0..LANES {
            // SAFETY: guaranteed by the caller.
            let line = unsafe { &mut (*base.add(indices[lane] as usize)).0 };
            let own = line[0].0[3];
            for half in 0..if WHOLE { 2 } else { 1 } {
                let scale = own * factors[half];
                for part in 0..3 {
                    line[half].0[part] += halves[half][part].0[lane] * scale;
                }
            }
        }
    }
}

impl SingleLanes for Portable<f32, SINGLE_LANES> {
    #[inline(always)]
    fn load(from: &Sixteen) -> Self {
        Portable(from.0)
    }

    #[inline(always)]
    fn store(self, to: &mut Sixteen) {
        to.0 = self.0;
    }

    #[inline(always)]
    unsafe fn load_octets(base: *const Octet, indices: &[u32; SINGLE_LANES]) -> [Self; 8] {
        let mut out = [Portable([0.0; SINGLE_LANES]); 8];
        for lane in 0..SINGLE_LANES {
            // SAFETY: guaranteed by the caller.
            let octet = unsafe { (*base.add(indices[lane] as usize)).0 };
            for part in 0..8 {
                out[part].0[lane] = octet[part];
            }
        }
        out
    }

    #[inline(always)]
    unsafe fn store_octets(base: *mut Octet, indices: &[u32; SINGLE_LANES], octets: [Self; 8]) {
        for lane in 0..SINGLE_LANES {
            let octet = Octet(std::array::from_fn(|part| octets[part].0[lane]));
            // SAFETY: guaranteed by the caller.
            unsafe { *base.add(indices[lane] as usize) = octet };
        }
    }
}
