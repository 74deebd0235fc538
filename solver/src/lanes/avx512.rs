//! Lanes in one 512-bit register. Only AVX-512F is used, which the Xeon Phi x200 has too.

use super::{Eight, LANES, Lanes, Number, Quad};
use std::arch::x86_64::*;
use std::ops::{Add, BitAnd, Div, Mul, Neg, Not, Sub};

/// Eight numbers in a register. Code that makes one runs where AVX-512F was found: only [`super::InstructionSet::run`]
/// names this type.
#[derive(Clone, Copy)]
pub struct Avx512(__m512d);

/// Eight truth values in a mask register.
#[derive(Clone, Copy)]
pub struct Avx512Mask(__mmask8);

macro_rules! operator {
    ($operator:ident, $method:ident, $intrinsic:ident) => {
        impl $operator for Avx512 {
            type Output = Avx512;
            #[inline(always)]
            fn $method(self, other: Avx512) -> Avx512 {
                // SAFETY: the type exists only where AVX-512F does.
                Avx512(unsafe { $intrinsic(self.0, other.0) })
            }
        }
    };
}
operator!(Add, add, _mm512_add_pd);
operator!(Sub, sub, _mm512_sub_pd);
operator!(Mul, mul, _mm512_mul_pd);
operator!(Div, div, _mm512_div_pd);

impl Neg for Avx512 {
    type Output = Avx512;
    #[inline(always)]
    fn neg(self) -> Avx512 {
        // SAFETY: as above. The floating-point exclusive or belongs to AVX-512DQ; the integer one does the same.
        Avx512(unsafe {
            let sign = _mm512_set1_epi64(i64::MIN);
            _mm512_castsi512_pd(_mm512_xor_epi64(_mm512_castpd_si512(self.0), sign))
        })
    }
}

impl BitAnd for Avx512Mask {
    type Output = Avx512Mask;
    #[inline(always)]
    fn bitand(self, other: Avx512Mask) -> Avx512Mask {
        Avx512Mask(self.0 & other.0)
    }
}

impl Not for Avx512Mask {
    type Output = Avx512Mask;
    #[inline(always)]
    fn not(self) -> Avx512Mask {
        Avx512Mask(!self.0)
    }
}

impl Number for Avx512 {
    type Mask = Avx512Mask;

    #[inline(always)]
    fn splat(value: f64) -> Avx512 {
        // SAFETY: see the type.
        Avx512(unsafe { _mm512_set1_pd(value) })
    }

    #[inline(always)]
    fn sqrt(self) -> Avx512 {
        // SAFETY: see the type.
        Avx512(unsafe { _mm512_sqrt_pd(self.0) })
    }

    #[inline(always)]
    fn abs(self) -> Avx512 {
        // SAFETY: see the type.
        Avx512(unsafe { _mm512_abs_pd(self.0) })
    }

    #[inline(always)]
    fn larger(self, other: Avx512) -> Avx512 {
        // SAFETY: see the type.
        Avx512(unsafe { _mm512_max_pd(self.0, other.0) })
    }

    #[inline(always)]
    fn smaller(self, other: Avx512) -> Avx512 {
        // SAFETY: see the type.
        Avx512(unsafe { _mm512_min_pd(self.0, other.0) })
    }

    #[inline(always)]
    fn below(self, other: Avx512) -> Avx512Mask {
        // SAFETY: see the type.
        Avx512Mask(unsafe { _mm512_cmp_pd_mask::<_CMP_LT_OQ>(self.0, other.0) })
    }

    #[inline(always)]
    fn at_most(self, other: Avx512) -> Avx512Mask {
        // SAFETY: see the type.
        Avx512Mask(unsafe { _mm512_cmp_pd_mask::<_CMP_LE_OQ>(self.0, other.0) })
    }

    #[inline(always)]
    fn select(mask: Avx512Mask, yes: Avx512, no: Avx512) -> Avx512 {
        // SAFETY: see the type.
        Avx512(unsafe { _mm512_mask_blend_pd(mask.0, no.0, yes.0) })
    }
}

/// Two rows of four in one register, the second in its upper half.
///
/// # Safety
/// AVX-512F, and both quads readable.
#[inline(always)]
unsafe fn join(low: *const Quad, high: *const Quad) -> __m512d {
    // SAFETY: the caller's promise; quads are aligned to 32 bytes.
    unsafe {
        let low = _mm512_castpd256_pd512(_mm256_load_pd(low.cast()));
        _mm512_insertf64x4::<1>(low, _mm256_load_pd(high.cast()))
    }
}

/// Pairs of the lower and of the upper 128 bits of each half: `[a0 a1 b0 b1 | a4 a5 b4 b5]` and `[a2 a3 b2 b3 | ...]`.
///
/// # Safety
/// AVX-512F.
#[inline(always)]
unsafe fn interleave_pairs(a: __m512d, b: __m512d) -> (__m512d, __m512d) {
    // SAFETY: the caller's promise.
    unsafe {
        let low = _mm512_setr_epi64(0, 1, 8, 9, 4, 5, 12, 13);
        let high = _mm512_setr_epi64(2, 3, 10, 11, 6, 7, 14, 15);
        (_mm512_permutex2var_pd(a, low, b), _mm512_permutex2var_pd(a, high, b))
    }
}

impl Lanes for Avx512 {
    #[inline(always)]
    fn load(from: &Eight) -> Avx512 {
        // SAFETY: see the type; `Eight` is aligned to 64 bytes.
        Avx512(unsafe { _mm512_load_pd(from.0.as_ptr()) })
    }

    #[inline(always)]
    fn store(self, to: &mut Eight) {
        // SAFETY: as in `load`.
        unsafe { _mm512_store_pd(to.0.as_mut_ptr(), self.0) }
    }

    #[inline(always)]
    fn bits(mask: Avx512Mask) -> u32 {
        u32::from(mask.0)
    }

    #[inline(always)]
    unsafe fn load_quads<const STRIDE: usize>(base: *const Quad, indices: &[u32; LANES]) -> [Avx512; 4] {
        // SAFETY: the caller's promise.
        unsafe {
            let row = |lane: usize| base.add(STRIDE * indices[lane] as usize);
            let (a, b) = (join(row(0), row(4)), join(row(1), row(5)));
            let (c, d) = (join(row(2), row(6)), join(row(3), row(7)));
            let (first, third) = interleave_pairs(_mm512_unpacklo_pd(a, b), _mm512_unpacklo_pd(c, d));
            let (second, fourth) = interleave_pairs(_mm512_unpackhi_pd(a, b), _mm512_unpackhi_pd(c, d));
            [Avx512(first), Avx512(second), Avx512(third), Avx512(fourth)]
        }
    }

    #[inline(always)]
    unsafe fn store_quads<const STRIDE: usize>(base: *mut Quad, indices: &[u32; LANES], quads: [Avx512; 4]) {
        // SAFETY: the caller's promise.
        unsafe {
            let put = |lane: usize, rows: __m512d| {
                let low = base.add(STRIDE * indices[lane] as usize);
                let high = base.add(STRIDE * indices[lane + 4] as usize);
                _mm256_store_pd(low.cast(), _mm512_castpd512_pd256(rows));
                _mm256_store_pd(high.cast(), _mm512_extractf64x4_pd::<1>(rows));
            };
            let [x, y, z, w] = quads.map(|part| part.0);
            let (a, c) = interleave_pairs(_mm512_unpacklo_pd(x, y), _mm512_unpacklo_pd(z, w));
            let (b, d) = interleave_pairs(_mm512_unpackhi_pd(x, y), _mm512_unpackhi_pd(z, w));
            put(0, a);
            put(1, b);
            put(2, c);
            put(3, d);
        }
    }
}
