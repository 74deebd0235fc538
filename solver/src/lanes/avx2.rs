//! Lanes in two 256-bit registers.

use super::{Eight, LANES, Lanes, Number, Quad};
use std::arch::x86_64::*;
use std::ops::{Add, BitAnd, Div, Mul, Neg, Not, Sub};

/// Eight numbers in two registers. Code that makes one runs where AVX2 was found: only [`super::InstructionSet::run`] names
/// this type.
#[derive(Clone, Copy)]
pub struct Avx2([__m256d; 2]);

/// Eight truth values, all bits of a lane set or none.
#[derive(Clone, Copy)]
pub struct Avx2Mask([__m256d; 2]);

macro_rules! both {
    ($a:expr, $b:expr, $intrinsic:expr) => {{
        let (a, b) = ($a, $b);
        // SAFETY: the types exist only where AVX2 does.
        unsafe { [$intrinsic(a[0], b[0]), $intrinsic(a[1], b[1])] }
    }};
}

macro_rules! operator {
    ($operator:ident, $method:ident, $intrinsic:ident) => {
        impl $operator for Avx2 {
            type Output = Avx2;
            #[inline(always)]
            fn $method(self, other: Avx2) -> Avx2 {
                Avx2(both!(self.0, other.0, $intrinsic))
            }
        }
    };
}
operator!(Add, add, _mm256_add_pd);
operator!(Sub, sub, _mm256_sub_pd);
operator!(Mul, mul, _mm256_mul_pd);
operator!(Div, div, _mm256_div_pd);

impl Neg for Avx2 {
    type Output = Avx2;
    #[inline(always)]
    fn neg(self) -> Avx2 {
        Avx2(both!(self.0, Avx2::splat(-0.0).0, _mm256_xor_pd))
    }
}

impl BitAnd for Avx2Mask {
    type Output = Avx2Mask;
    #[inline(always)]
    fn bitand(self, other: Avx2Mask) -> Avx2Mask {
        Avx2Mask(both!(self.0, other.0, _mm256_and_pd))
    }
}

impl Not for Avx2Mask {
    type Output = Avx2Mask;
    #[inline(always)]
    fn not(self) -> Avx2Mask {
        // SAFETY: see the type.
        let ones = unsafe { _mm256_castsi256_pd(_mm256_set1_epi64x(-1)) };
        Avx2Mask(both!(self.0, [ones; 2], _mm256_xor_pd))
    }
}

impl Number for Avx2 {
    type Mask = Avx2Mask;

    #[inline(always)]
    fn splat(value: f64) -> Avx2 {
        // SAFETY: see the type.
        Avx2([unsafe { _mm256_set1_pd(value) }; 2])
    }

    #[inline(always)]
    fn sqrt(self) -> Avx2 {
        // SAFETY: see the type.
        Avx2(unsafe { [_mm256_sqrt_pd(self.0[0]), _mm256_sqrt_pd(self.0[1])] })
    }

    #[inline(always)]
    fn abs(self) -> Avx2 {
        Avx2(both!(Avx2::splat(-0.0).0, self.0, _mm256_andnot_pd))
    }

    #[inline(always)]
    fn larger(self, other: Avx2) -> Avx2 {
        Avx2(both!(self.0, other.0, _mm256_max_pd))
    }

    #[inline(always)]
    fn smaller(self, other: Avx2) -> Avx2 {
        Avx2(both!(self.0, other.0, _mm256_min_pd))
    }

    #[inline(always)]
    fn below(self, other: Avx2) -> Avx2Mask {
        Avx2Mask(both!(self.0, other.0, _mm256_cmp_pd::<_CMP_LT_OQ>))
    }

    #[inline(always)]
    fn at_most(self, other: Avx2) -> Avx2Mask {
        Avx2Mask(both!(self.0, other.0, _mm256_cmp_pd::<_CMP_LE_OQ>))
    }

    #[inline(always)]
    fn select(mask: Avx2Mask, yes: Avx2, no: Avx2) -> Avx2 {
        // SAFETY: see the type.
        Avx2(unsafe {
            [_mm256_blendv_pd(no.0[0], yes.0[0], mask.0[0]), _mm256_blendv_pd(no.0[1], yes.0[1], mask.0[1])]
        })
    }
}

/// A matrix of four rows of four, transposed.
///
/// # Safety
/// AVX2.
#[inline(always)]
unsafe fn transposed(rows: [__m256d; 4]) -> [__m256d; 4] {
    // SAFETY: the caller's promise.
    unsafe {
        let [a, b, c, d] = rows;
        let (even, odd) = (_mm256_unpacklo_pd(a, b), _mm256_unpackhi_pd(a, b));
        let (even_below, odd_below) = (_mm256_unpacklo_pd(c, d), _mm256_unpackhi_pd(c, d));
        [
            _mm256_permute2f128_pd::<0x20>(even, even_below),
            _mm256_permute2f128_pd::<0x20>(odd, odd_below),
            _mm256_permute2f128_pd::<0x31>(even, even_below),
            _mm256_permute2f128_pd::<0x31>(odd, odd_below),
        ]
    }
}

impl Lanes for Avx2 {
    #[inline(always)]
    fn load(from: &Eight) -> Avx2 {
        // SAFETY: see the type; `Eight` is aligned to 64 bytes.
        Avx2(unsafe { [_mm256_load_pd(from.0.as_ptr()), _mm256_load_pd(from.0.as_ptr().add(4))] })
    }

    #[inline(always)]
    fn store(self, to: &mut Eight) {
        // SAFETY: as in `load`.
        unsafe {
            _mm256_store_pd(to.0.as_mut_ptr(), self.0[0]);
            _mm256_store_pd(to.0.as_mut_ptr().add(4), self.0[1]);
        }
    }

    #[inline(always)]
    fn bits(mask: Avx2Mask) -> u32 {
        // SAFETY: see the type.
        unsafe { (_mm256_movemask_pd(mask.0[0]) | _mm256_movemask_pd(mask.0[1]) << 4) as u32 }
    }

    #[inline(always)]
    unsafe fn load_quads<const STRIDE: usize>(base: *const Quad, indices: &[u32; LANES]) -> [Avx2; 4] {
        // SAFETY: the caller's promise; quads are aligned to 32 bytes.
        unsafe {
            let row = |lane: usize| _mm256_load_pd(base.add(STRIDE * indices[lane] as usize).cast());
            let low = transposed([row(0), row(1), row(2), row(3)]);
            let high = transposed([row(4), row(5), row(6), row(7)]);
            [Avx2([low[0], high[0]]), Avx2([low[1], high[1]]), Avx2([low[2], high[2]]), Avx2([low[3], high[3]])]
        }
    }

    #[inline(always)]
    unsafe fn store_quads<const STRIDE: usize>(base: *mut Quad, indices: &[u32; LANES], quads: [Avx2; 4]) {
        // SAFETY: the caller's promise.
        unsafe {
            let [x, y, z, w] = quads.map(|part| part.0);
            for half in 0..2 {
                let rows = transposed([x[half], y[half], z[half], w[half]]);
                for (lane, row) in rows.into_iter().enumerate() {
                    _mm256_store_pd(base.add(STRIDE * indices[4 * half + lane] as usize).cast(), row);
                }
            }
        }
    }
}
