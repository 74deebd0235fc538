//! Lanes in plain Rust: the compiler uses whatever registers the build's target has.

// One index runs over several arrays at once.
#![allow(clippy::needless_range_loop)]

use super::{Eight, LANES, Lanes, Line, Number, Octet, Quad, SINGLE_LANES, SingleLanes, Sixteen};
use std::ops::{Add, BitAnd, Div, Mul, Neg, Not, Sub};

/// `N` numbers as an array.
#[derive(Clone, Copy)]
pub struct Portable<T, const N: usize>([T; N]);

/// `N` truth values as an array.
#[derive(Clone, Copy)]
pub struct PortableMask<const N: usize>([bool; N]);

/// A precision: `f64` or `f32`.
pub trait Real:
    Copy
    + PartialOrd
    + Default
    + Add<Output = Self>
    + Sub<Output = Self>
    + Mul<Output = Self>
    + Div<Output = Self>
    + Neg<Output = Self>
{
    /// The nearest number of this precision.
    fn nearest(value: f64) -> Self;
    /// Correctly rounded square root.
    fn root(self) -> Self;
    /// Magnitude.
    fn magnitude(self) -> Self;
}

macro_rules! real {
    ($real:ty) => {
        impl Real for $real {
            #[inline(always)]
            fn nearest(value: f64) -> $real {
                value as $real
            }

            #[inline(always)]
            fn root(self) -> $real {
                self.sqrt()
            }

            #[inline(always)]
            fn magnitude(self) -> $real {
                self.abs()
            }
        }
    };
}
real!(f64);
real!(f32);

impl<T: Real, const N: usize> Portable<T, N> {
    #[inline(always)]
    fn map(self, f: impl Fn(T) -> T) -> Self {
        let mut out = [T::default(); N];
        for lane in 0..N {
            out[lane] = f(self.0[lane]);
        }
        Portable(out)
    }

    #[inline(always)]
    fn zip(self, other: Self, f: impl Fn(T, T) -> T) -> Self {
        let mut out = [T::default(); N];
        for lane in 0..N {
            out[lane] = f(self.0[lane], other.0[lane]);
        }
        Portable(out)
    }

    #[inline(always)]
    fn test(self, other: Self, f: impl Fn(&T, &T) -> bool) -> PortableMask<N> {
        let mut out = [false; N];
        for lane in 0..N {
            out[lane] = f(&self.0[lane], &other.0[lane]);
        }
        PortableMask(out)
    }
}

macro_rules! operator {
    ($operator:ident, $method:ident, $symbol:tt) => {
        impl<T: Real, const N: usize> $operator for Portable<T, N> {
            type Output = Self;
            #[inline(always)]
            fn $method(self, other: Self) -> Self {
                self.zip(other, |a, b| a $symbol b)
            }
        }
    };
}
operator!(Add, add, +);
operator!(Sub, sub, -);
operator!(Mul, mul, *);
operator!(Div, div, /);

impl<T: Real, const N: usize> Neg for Portable<T, N> {
    type Output = Self;
    #[inline(always)]
    fn neg(self) -> Self {
        self.map(|value| -value)
    }
}

impl<const N: usize> BitAnd for PortableMask<N> {
    type Output = Self;
    #[inline(always)]
    fn bitand(self, other: Self) -> Self {
        PortableMask(std::array::from_fn(|lane| self.0[lane] & other.0[lane]))
    }
}

impl<const N: usize> Not for PortableMask<N> {
    type Output = Self;
    #[inline(always)]
    fn not(self) -> Self {
        PortableMask(self.0.map(|truth| !truth))
    }
}

impl<T: Real, const N: usize> Number for Portable<T, N> {
    type Mask = PortableMask<N>;

    #[inline(always)]
    fn splat(value: f64) -> Self {
        Portable([T::nearest(value); N])
    }

    #[inline(always)]
    fn sqrt(self) -> Self {
        self.map(T::root)
    }

    #[inline(always)]
    fn abs(self) -> Self {
        self.map(T::magnitude)
    }

    #[inline(always)]
    fn larger(self, other: Self) -> Self {
        self.zip(other, |a, b| if a > b { a } else { b })
    }

    #[inline(always)]
    fn smaller(self, other: Self) -> Self {
        self.zip(other, |a, b| if a < b { a } else { b })
    }

    #[inline(always)]
    fn below(self, other: Self) -> PortableMask<N> {
        self.test(other, T::lt)
    }

    #[inline(always)]
    fn at_most(self, other: Self) -> PortableMask<N> {
        self.test(other, T::le)
    }

    #[inline(always)]
    fn select(mask: PortableMask<N>, yes: Self, no: Self) -> Self {
        let mut out = [T::default(); N];
        for lane in 0..N {
            out[lane] = if mask.0[lane] { yes.0[lane] } else { no.0[lane] };
        }
        Portable(out)
    }
}

impl Lanes for Portable<f64, LANES> {
    type Single = Portable<f32, SINGLE_LANES>;

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
            // SAFETY: the caller's promise.
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
            // SAFETY: the caller's promise.
            unsafe { *base.add(STRIDE * indices[lane] as usize) = quad };
        }
    }

    #[inline(always)]
    unsafe fn load_pairs<const WHOLE: bool>(
        base: *const Line,
        first: &[u32; LANES],
        second: &[u32; LANES],
    ) -> [[Self; 4]; 2] {
        let mut out = [[Portable([0.0; LANES]); 4]; 2];
        for lane in 0..LANES {
            // SAFETY: the caller's promise.
            let (a, b) = unsafe { (&(*base.add(first[lane] as usize)).0, &(*base.add(second[lane] as usize)).0) };
            for part in 0..4 {
                let (mine, theirs) = (a[0].0[part], b[0].0[part]);
                out[0][part].0[lane] = if part < 3 { theirs - mine } else { theirs + mine };
                if WHOLE {
                    out[1][part].0[lane] = b[1].0[part] + a[1].0[part];
                }
            }
        }
        out
    }

    #[inline(always)]
    unsafe fn add_shares<const WHOLE: bool>(
        base: *mut Line,
        indices: &[u32; LANES],
        halves: [[Self; 3]; 2],
        factors: [f64; 2],
    ) {
        for lane in 0..LANES {
            // SAFETY: the caller's promise.
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
            // SAFETY: the caller's promise.
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
            // SAFETY: the caller's promise.
            unsafe { *base.add(indices[lane] as usize) = octet };
        }
    }
}
