//! Lanes in plain Rust: the compiler uses whatever registers the build's target has.

// One index runs over several arrays at once.
#![allow(clippy::needless_range_loop)]

use super::{Eight, LANES, Lanes, Number, Quad};
use std::ops::{Add, BitAnd, Div, Mul, Neg, Not, Sub};

/// Eight numbers as an array.
#[derive(Clone, Copy)]
pub struct Portable([f64; LANES]);

/// Eight truth values as an array.
#[derive(Clone, Copy)]
pub struct PortableMask([bool; LANES]);

impl Portable {
    #[inline(always)]
    fn map(self, f: impl Fn(f64) -> f64) -> Portable {
        let mut out = [0.0; LANES];
        for lane in 0..LANES {
            out[lane] = f(self.0[lane]);
        }
        Portable(out)
    }

    #[inline(always)]
    fn zip(self, other: Portable, f: impl Fn(f64, f64) -> f64) -> Portable {
        let mut out = [0.0; LANES];
        for lane in 0..LANES {
            out[lane] = f(self.0[lane], other.0[lane]);
        }
        Portable(out)
    }

    #[inline(always)]
    fn test(self, other: Portable, f: impl Fn(&f64, &f64) -> bool) -> PortableMask {
        let mut out = [false; LANES];
        for lane in 0..LANES {
            out[lane] = f(&self.0[lane], &other.0[lane]);
        }
        PortableMask(out)
    }
}

macro_rules! operator {
    ($operator:ident, $method:ident, $symbol:tt) => {
        impl $operator for Portable {
            type Output = Portable;
            #[inline(always)]
            fn $method(self, other: Portable) -> Portable {
                self.zip(other, |a, b| a $symbol b)
            }
        }
    };
}
operator!(Add, add, +);
operator!(Sub, sub, -);
operator!(Mul, mul, *);
operator!(Div, div, /);

impl Neg for Portable {
    type Output = Portable;
    #[inline(always)]
    fn neg(self) -> Portable {
        self.map(|value| -value)
    }
}

impl BitAnd for PortableMask {
    type Output = PortableMask;
    #[inline(always)]
    fn bitand(self, other: PortableMask) -> PortableMask {
        PortableMask(std::array::from_fn(|lane| self.0[lane] & other.0[lane]))
    }
}

impl Not for PortableMask {
    type Output = PortableMask;
    #[inline(always)]
    fn not(self) -> PortableMask {
        PortableMask(self.0.map(|truth| !truth))
    }
}

impl Number for Portable {
    type Mask = PortableMask;

    #[inline(always)]
    fn splat(value: f64) -> Portable {
        Portable([value; LANES])
    }

    #[inline(always)]
    fn sqrt(self) -> Portable {
        self.map(f64::sqrt)
    }

    #[inline(always)]
    fn abs(self) -> Portable {
        self.map(f64::abs)
    }

    #[inline(always)]
    fn larger(self, other: Portable) -> Portable {
        self.zip(other, |a, b| if a > b { a } else { b })
    }

    #[inline(always)]
    fn smaller(self, other: Portable) -> Portable {
        self.zip(other, |a, b| if a < b { a } else { b })
    }

    #[inline(always)]
    fn below(self, other: Portable) -> PortableMask {
        self.test(other, f64::lt)
    }

    #[inline(always)]
    fn at_most(self, other: Portable) -> PortableMask {
        self.test(other, f64::le)
    }

    #[inline(always)]
    fn select(mask: PortableMask, yes: Portable, no: Portable) -> Portable {
        let mut out = [0.0; LANES];
        for lane in 0..LANES {
            out[lane] = if mask.0[lane] { yes.0[lane] } else { no.0[lane] };
        }
        Portable(out)
    }
}

impl Lanes for Portable {
    #[inline(always)]
    fn load(from: &Eight) -> Portable {
        Portable(from.0)
    }

    #[inline(always)]
    fn store(self, to: &mut Eight) {
        to.0 = self.0;
    }

    #[inline(always)]
    fn bits(mask: PortableMask) -> u32 {
        let mut bits = 0;
        for lane in 0..LANES {
            bits |= u32::from(mask.0[lane]) << lane;
        }
        bits
    }

    #[inline(always)]
    unsafe fn load_quads<const STRIDE: usize>(base: *const Quad, indices: &[u32; LANES]) -> [Portable; 4] {
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
    unsafe fn store_quads<const STRIDE: usize>(base: *mut Quad, indices: &[u32; LANES], quads: [Portable; 4]) {
        for lane in 0..LANES {
            let quad = Quad(std::array::from_fn(|part| quads[part].0[lane]));
            // SAFETY: the caller's promise.
            unsafe { *base.add(STRIDE * indices[lane] as usize) = quad };
        }
    }
}
