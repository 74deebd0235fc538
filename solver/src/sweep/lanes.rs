//! Eight numbers treated alike: the arithmetic of a lane group.
//!
//! Every operation is a plain IEEE operation a lane, so the compiler may use registers of any width without changing a
//! bit of the result. No fused multiply-add is written here, and the compiler is not allowed to invent one.

// One index runs over several arrays at once: lanes and axes.
#![allow(clippy::needless_range_loop)]

use crate::world::LANES;
use std::ops::{Add, Div, Mul, Neg, Sub};

/// Eight `f64`, one a contact.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[repr(C, align(64))]
pub struct Lanes(pub [f64; LANES]);

/// Eight truth values, one a contact.
#[derive(Clone, Copy, Debug)]
pub struct LaneMask([bool; LANES]);

impl Lanes {
    /// The same number in each lane.
    #[inline(always)]
    pub fn splat(value: f64) -> Lanes {
        Lanes([value; LANES])
    }

    #[inline(always)]
    fn map(self, f: impl Fn(f64) -> f64) -> Lanes {
        let mut out = [0.0; LANES];
        for lane in 0..LANES {
            out[lane] = f(self.0[lane]);
        }
        Lanes(out)
    }

    #[inline(always)]
    fn zip(self, other: Lanes, f: impl Fn(f64, f64) -> f64) -> Lanes {
        let mut out = [0.0; LANES];
        for lane in 0..LANES {
            out[lane] = f(self.0[lane], other.0[lane]);
        }
        Lanes(out)
    }

    /// Correctly rounded square root.
    #[inline(always)]
    pub fn sqrt(self) -> Lanes {
        self.map(f64::sqrt)
    }

    /// Magnitude.
    #[inline(always)]
    pub fn abs(self) -> Lanes {
        self.map(f64::abs)
    }

    /// The larger of each lane and zero.
    #[inline(always)]
    pub fn at_least_zero(self) -> Lanes {
        self.map(|value| if value > 0.0 { value } else { 0.0 })
    }

    /// The larger of the two, lane by lane.
    #[inline(always)]
    pub fn larger(self, other: Lanes) -> Lanes {
        self.zip(other, |a, b| if a > b { a } else { b })
    }

    /// Lanes of `self` that do not exceed those of `other`.
    #[inline(always)]
    pub fn at_most(self, other: Lanes) -> LaneMask {
        let mut out = [false; LANES];
        for lane in 0..LANES {
            out[lane] = self.0[lane] <= other.0[lane];
        }
        LaneMask(out)
    }

    /// `yes` where the mask holds, `no` elsewhere.
    #[inline(always)]
    pub fn select(mask: LaneMask, yes: Lanes, no: Lanes) -> Lanes {
        let mut out = [0.0; LANES];
        for lane in 0..LANES {
            out[lane] = if mask.0[lane] { yes.0[lane] } else { no.0[lane] };
        }
        Lanes(out)
    }

    /// Sum over the lanes, in one fixed order.
    pub fn sum(self) -> f64 {
        let [a, b, c, d, e, f, g, h] = self.0;
        ((a + b) + (c + d)) + ((e + f) + (g + h))
    }

    /// Largest lane.
    pub fn max(self) -> f64 {
        self.0.iter().copied().fold(0.0, f64::max)
    }
}

macro_rules! lane_operator {
    ($operator:ident, $method:ident, $symbol:tt) => {
        impl $operator for Lanes {
            type Output = Lanes;
            #[inline(always)]
            fn $method(self, other: Lanes) -> Lanes {
                self.zip(other, |a, b| a $symbol b)
            }
        }
    };
}
lane_operator!(Add, add, +);
lane_operator!(Sub, sub, -);
lane_operator!(Mul, mul, *);
lane_operator!(Div, div, /);

impl Neg for Lanes {
    type Output = Lanes;
    #[inline(always)]
    fn neg(self) -> Lanes {
        self.map(|value| -value)
    }
}

/// Scalar product of two vectors of lanes.
#[inline(always)]
pub fn dot(a: [Lanes; 3], b: [Lanes; 3]) -> Lanes {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

/// Vector product of two vectors of lanes.
#[inline(always)]
pub fn cross(a: [Lanes; 3], b: [Lanes; 3]) -> [Lanes; 3] {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}
