//! One number at a time.

use super::Number;

/// Truth value of a scalar.
pub type Truth = bool;

impl Number for f64 {
    type Mask = Truth;

    #[inline(always)]
    fn splat(value: f64) -> f64 {
        value
    }

    #[inline(always)]
    fn sqrt(self) -> f64 {
        f64::sqrt(self)
    }

    #[inline(always)]
    fn abs(self) -> f64 {
        f64::abs(self)
    }

    #[inline(always)]
    fn larger(self, other: f64) -> f64 {
        if self > other { self } else { other }
    }

    #[inline(always)]
    fn smaller(self, other: f64) -> f64 {
        if self < other { self } else { other }
    }

    #[inline(always)]
    fn below(self, other: f64) -> Truth {
        self < other
    }

    #[inline(always)]
    fn at_most(self, other: f64) -> Truth {
        self <= other
    }

    #[inline(always)]
    fn select(mask: Truth, yes: f64, no: f64) -> f64 {
        if mask { yes } else { no }
    }

    #[inline(always)]
    fn all(mask: Truth) -> bool {
        mask
    }
}
