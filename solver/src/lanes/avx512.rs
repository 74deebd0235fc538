//! Lanes in one 512-bit register. Only AVX-512F is used, which the Xeon Phi x200 also has.

mod single;

use super::{Eight, LANES, Lanes, Line, Number, Quad};
use std::arch::x86_64::*;
use std::ops::{Add, BitAnd, Div, Mul, Neg, Not, Sub};

/// Applies an intrinsic.
macro_rules! apply {
    ($result:ident, $intrinsic:expr $(, $operand:expr)*) => {
        // SAFETY: the types exist only on processors with AVX-512F.
        $result(unsafe { $intrinsic($($operand),*) })
    };
}

/// Register of numbers of one precision, and its mask register.
macro_rules! register {
    (
        $(#[$about:meta])* $lanes:ident($register:ty), $mask:ident($bits:ty), $real:ty,
        arithmetic: $add:ident $subtract:ident $multiply:ident $divide:ident $root:ident $magnitude:ident,
        choice: $larger:ident $smaller:ident $compare:ident $blend:ident,
        constants: $splat:ident $to_integer:ident $from_integer:ident $splat_integer:ident($sign:expr)
    ) => {
        $(#[$about])*
        #[derive(Clone, Copy)]
        pub struct $lanes($register);

        /// Truth values in a mask register.
        #[derive(Clone, Copy)]
        pub struct $mask($bits);

        operator!($lanes, Add, add, |a, b| apply!($lanes, $add, a.0, b.0));
        operator!($lanes, Sub, sub, |a, b| apply!($lanes, $subtract, a.0, b.0));
        operator!($lanes, Mul, mul, |a, b| apply!($lanes, $multiply, a.0, b.0));
        operator!($lanes, Div, div, |a, b| apply!($lanes, $divide, a.0, b.0));
        // SAFETY: see the type. The floating-point exclusive or belongs to AVX-512DQ; the integer one is equivalent.
        operator!($lanes, Neg, neg, |a| $lanes(unsafe {
            $from_integer(_mm512_xor_si512($to_integer(a.0), $splat_integer($sign)))
        }));
        operator!($mask, BitAnd, bitand, |a, b| $mask(a.0 & b.0));
        operator!($mask, Not, not, |a| $mask(!a.0));

        number!(
            $lanes, $mask, |a, b, mask|
            splat: apply!($lanes, $splat, a as $real),
            sqrt: apply!($lanes, $root, a.0),
            abs: apply!($lanes, $magnitude, a.0),
            larger: apply!($lanes, $larger, a.0, b.0),
            smaller: apply!($lanes, $smaller, a.0, b.0),
            below: apply!($mask, $compare::<_CMP_LT_OQ>, a.0, b.0),
            at_most: apply!($mask, $compare::<_CMP_LE_OQ>, a.0, b.0),
            select: apply!($lanes, $blend, mask.0, b.0, a.0),
            all: !mask.0 == 0
        );
    };
}

register!(
    /// Eight numbers in a register. Only code that runs with AVX-512F creates values: only [`super::Available::run`]
    /// names this type.
    Avx512(__m512d), Avx512Mask(__mmask8), f64,
    arithmetic: _mm512_add_pd _mm512_sub_pd _mm512_mul_pd _mm512_div_pd _mm512_sqrt_pd _mm512_abs_pd,
    choice: _mm512_max_pd _mm512_min_pd _mm512_cmp_pd_mask _mm512_mask_blend_pd,
    constants: _mm512_set1_pd _mm512_castpd_si512 _mm512_castsi512_pd _mm512_set1_epi64(i64::MIN)
);

register!(
    /// Sixteen single-precision numbers in a register, with the condition of [`Avx512`].
    Avx512Single(__m512), Avx512SingleMask(__mmask16), f32,
    arithmetic: _mm512_add_ps _mm512_sub_ps _mm512_mul_ps _mm512_div_ps _mm512_sqrt_ps _mm512_abs_ps,
    choice: _mm512_max_ps _mm512_min_ps _mm512_cmp_ps_mask _mm512_mask_blend_ps,
    constants: _mm512_set1_ps _mm512_castps_si512 _mm512_castsi512_ps _mm512_set1_epi32(i32::MIN)
);

/// Loads two rows of four into one register, the second into its upper half.
///
/// # Safety
/// AVX-512F, and both quads readable.
#[inline(always)]
unsafe fn join(low: *const Quad, high: *const Quad) -> __m512d {
    // SAFETY: guaranteed by the caller; quads are aligned to 32 bytes.
    unsafe {
        let low = _mm512_castpd256_pd512(_mm256_load_pd(low.cast()));
        _mm512_insertf64x4::<1>(low, _mm256_load_pd(high.cast()))
    }
}

/// Pairs the lower and the upper 128 bits of each half: `[a0 a1 b0 b1 | a4 a5 b4 b5]` and `[a2 a3 b2 b3 | ...]`.
///
/// # Safety
/// AVX-512F.
#[inline(always)]
unsafe fn interleave_pairs(a: __m512d, b: __m512d) -> (__m512d, __m512d) {
    // SAFETY: guaranteed by the caller.
    unsafe {
        let low = _mm512_setr_epi64(0, 1, 8, 9, 4, 5, 12, 13);
        let high = _mm512_setr_epi64(2, 3, 10, 11, 6, 7, 14, 15);
        (_mm512_permutex2var_pd(a, low, b), _mm512_permutex2var_pd(a, high, b))
    }
}

impl Lanes for Avx512 {
    type Single = Avx512Single;
    type Kept = [__m512d; 4];

    const OVERLAPPED: bool = true;

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
    fn share_places(some: [&[u32; LANES]; 2], others: [&[u32; LANES]; 2], end: u32) -> bool {
        // SAFETY: see the type; eight indices fill half a register.
        unsafe {
            let half = _mm512_castsi256_si512(_mm256_loadu_si256(others[0].as_ptr().cast()));
            let others = _mm512_inserti64x4::<1>(half, _mm256_loadu_si256(others[1].as_ptr().cast()));
            let known = _mm512_cmplt_epu32_mask(others, _mm512_set1_epi32(end as i32));
            let mut met = 0;
            for places in some {
                for &place in places {
                    met |= _mm512_mask_cmpeq_epi32_mask(known, others, _mm512_set1_epi32(place as i32));
                }
            }
            met != 0
        }
    }

    #[inline(always)]
    unsafe fn load_quads<const STRIDE: usize>(base: *const Quad, indices: &[u32; LANES]) -> [Avx512; 4] {
        // SAFETY: guaranteed by the caller.
        unsafe {
            let row = |lane: usize| base.add(STRIDE * indices[lane] as usize);
            let (a, b) = (join(row(0), row(4)), join(row(1), row(5)));
            let (c, d) = (join(row(2), row(6)), join(row(3), row(7)));
            parts([a, b, c, d])
        }
    }

    #[inline(always)]
    unsafe fn store_quads<const STRIDE: usize>(base: *mut Quad, indices: &[u32; LANES], quads: [Avx512; 4]) {
        // SAFETY: guaranteed by the caller.
        unsafe {
            let [x, y, z, w] = quads;
            let rows = transposed_halves([x.0, y.0, z.0, w.0]);
            for lane in 0..4 {
                let low = base.add(STRIDE * indices[lane] as usize);
                let high = base.add(STRIDE * indices[lane + 4] as usize);
                _mm256_store_pd(low.cast(), _mm512_castpd512_pd256(rows[lane]));
                _mm256_store_pd(high.cast(), _mm512_extractf64x4_pd::<1>(rows[lane]));
            }
        }
    }

    #[inline(always)]
    unsafe fn load_differences<const STRIDE: usize>(
        base: *const Quad,
        first: &[u32; LANES],
        second: &[u32; LANES],
    ) -> [Avx512; 4] {
        // SAFETY: guaranteed by the caller.
        unsafe { differences::<STRIDE>(base, first, second).0 }
    }

    #[inline(always)]
    unsafe fn load_keeping(
        base: *const Line,
        first: &[u32; LANES],
        second: &[u32; LANES],
    ) -> ([Avx512; 4], [[__m512d; 4]; 2]) {
        // SAFETY: guaranteed by the caller; a line is two quads.
        unsafe { differences::<2>(base.cast(), first, second) }
    }

    #[inline(always)]
    unsafe fn add_to_kept(base: *mut Line, indices: &[u32; LANES], kept: [__m512d; 4], half: [Avx512; 3], factor: f64) {
        // SAFETY: guaranteed by the caller.
        unsafe {
            let shares = transposed_halves([half[0].0, half[1].0, half[2].0, _mm512_setzero_pd()]);
            for row in 0..4 {
                let scale = _mm512_mul_pd(_mm512_permutex_pd::<0xff>(kept[row]), _mm512_set1_pd(factor));
                let changed = _mm512_add_pd(kept[row], _mm512_mul_pd(shares[row], scale));
                _mm256_store_pd(base.add(indices[row] as usize).cast(), _mm512_castpd512_pd256(changed));
                _mm256_store_pd(base.add(indices[row + 4] as usize).cast(), _mm512_extractf64x4_pd::<1>(changed));
            }
        }
    }

    #[inline(always)]
    unsafe fn load_pairs(base: *const Line, first: &[u32; LANES], second: &[u32; LANES]) -> [[Avx512; 4]; 2] {
        // SAFETY: guaranteed by the caller.
        unsafe {
            let sign = i64::MIN;
            let against = _mm512_setr_epi64(sign, sign, sign, 0, 0, 0, 0, 0);
            let mut lines = [_mm512_setzero_pd(); LANES];
            for lane in 0..LANES {
                let a = _mm512_load_si512(base.add(first[lane] as usize).cast());
                let b = _mm512_load_pd(base.add(second[lane] as usize).cast());
                lines[lane] = _mm512_add_pd(_mm512_castsi512_pd(_mm512_xor_si512(a, against)), b);
            }
            halves_of(lines)
        }
    }

    #[inline(always)]
    unsafe fn load_lines(base: *const Line, indices: &[u32; LANES]) -> [[Avx512; 4]; 2] {
        // SAFETY: guaranteed by the caller.
        unsafe {
            let mut lines = [_mm512_setzero_pd(); LANES];
            for lane in 0..LANES {
                lines[lane] = _mm512_load_pd(base.add(indices[lane] as usize).cast());
            }
            halves_of(lines)
        }
    }

    #[inline(always)]
    unsafe fn store_lines(base: *mut Line, indices: &[u32; LANES], halves: [[Avx512; 4]; 2]) {
        // SAFETY: guaranteed by the caller.
        unsafe {
            let [[x, y, z, w], [t, u, v, s]] = halves;
            let (first, second) = (transposed_halves([x.0, y.0, z.0, w.0]), transposed_halves([t.0, u.0, v.0, s.0]));
            for row in 0..4 {
                let low = _mm512_shuffle_f64x2::<0b01_00_01_00>(first[row], second[row]);
                let high = _mm512_shuffle_f64x2::<0b11_10_11_10>(first[row], second[row]);
                _mm512_store_pd(base.add(indices[row] as usize).cast(), low);
                _mm512_store_pd(base.add(indices[row + 4] as usize).cast(), high);
            }
        }
    }

    #[inline(always)]
    unsafe fn add_shares<const WHOLE: bool>(
        base: *mut Line,
        indices: &[u32; LANES],
        halves: [[Avx512; 3]; 2],
        factors: [f64; 2],
    ) {
        // SAFETY: guaranteed by the caller.
        unsafe {
            let zero = _mm512_setzero_pd();
            let [[x, y, z], [u, v, w]] = halves;
            let (motion, turning) =
                (transposed_halves([x.0, y.0, z.0, zero]), transposed_halves([u.0, v.0, w.0, zero]));
            if !WHOLE {
                for (row, &both) in motion.iter().enumerate() {
                    let halves = [_mm512_castpd512_pd256(both), _mm512_extractf64x4_pd::<1>(both)];
                    for (lane, share) in [(row, halves[0]), (row + 4, halves[1])] {
                        let line: *mut f64 = base.add(indices[lane] as usize).cast();
                        let scale = _mm256_mul_pd(_mm256_set1_pd(*line.add(3)), _mm256_set1_pd(factors[0]));
                        _mm256_store_pd(line, _mm256_add_pd(_mm256_load_pd(line), _mm256_mul_pd(share, scale)));
                    }
                }
                return;
            }
            let factors = _mm512_insertf64x4::<1>(_mm512_set1_pd(factors[0]), _mm256_set1_pd(factors[1]));
            for row in 0..4 {
                let low = _mm512_shuffle_f64x2::<0b01_00_01_00>(motion[row], turning[row]);
                let high = _mm512_shuffle_f64x2::<0b11_10_11_10>(motion[row], turning[row]);
                for (lane, share) in [(row, low), (row + 4, high)] {
                    let line: *mut f64 = base.add(indices[lane] as usize).cast();
                    let scale = _mm512_mul_pd(_mm512_set1_pd(*line.add(3)), factors);
                    _mm512_store_pd(line, _mm512_add_pd(_mm512_load_pd(line), _mm512_mul_pd(share, scale)));
                }
            }
        }
    }
}

/// Loads the quads `base + STRIDE first[lane]` and `base + STRIDE second[lane]`; returns the parts of their differences, as
/// [`Lanes::load_differences`] does, and the quads.
///
/// # Safety
/// The requirements of [`Lanes::load_quads`] apply.
#[inline(always)]
unsafe fn differences<const STRIDE: usize>(
    base: *const Quad,
    first: &[u32; LANES],
    second: &[u32; LANES],
) -> ([Avx512; 4], [[__m512d; 4]; 2]) {
    // SAFETY: guaranteed by the caller.
    unsafe {
        let sign = i64::MIN;
        let against = _mm512_setr_epi64(sign, sign, sign, 0, sign, sign, sign, 0);
        let quad = |place: u32| base.add(STRIDE * place as usize);
        let (mut a, mut b) = ([_mm512_setzero_pd(); 4], [_mm512_setzero_pd(); 4]);
        let mut differences = a;
        for row in 0..4 {
            a[row] = join(quad(first[row]), quad(first[row + 4]));
            b[row] = join(quad(second[row]), quad(second[row + 4]));
            let turned = _mm512_xor_si512(_mm512_castpd_si512(a[row]), against);
            differences[row] = _mm512_add_pd(_mm512_castsi512_pd(turned), b[row]);
        }
        (parts(differences), [a, b])
    }
}

/// Transposes two matrices of four rows of four, one in each half: eight quads into their parts, and back.
///
/// # Safety
/// AVX-512F.
#[inline(always)]
unsafe fn transposed_halves(rows: [__m512d; 4]) -> [__m512d; 4] {
    // SAFETY: guaranteed by the caller.
    unsafe {
        let [a, b, c, d] = rows;
        let (first, third) = interleave_pairs(_mm512_unpacklo_pd(a, b), _mm512_unpacklo_pd(c, d));
        let (second, fourth) = interleave_pairs(_mm512_unpackhi_pd(a, b), _mm512_unpackhi_pd(c, d));
        [first, second, third, fourth]
    }
}

/// Returns eight lanes of each of the four parts of quads: quad `i` in the lower half of row `i`, quad `i + 4` in the upper half.
///
/// # Safety
/// AVX-512F.
#[inline(always)]
unsafe fn parts(rows: [__m512d; 4]) -> [Avx512; 4] {
    // SAFETY: guaranteed by the caller.
    let [first, second, third, fourth] = unsafe { transposed_halves(rows) };
    [Avx512(first), Avx512(second), Avx512(third), Avx512(fourth)]
}

/// Returns eight lanes of each part of both halves of eight lines.
///
/// # Safety
/// AVX-512F.
#[inline(always)]
unsafe fn halves_of(lines: [__m512d; LANES]) -> [[Avx512; 4]; 2] {
    // SAFETY: guaranteed by the caller.
    unsafe {
        let (mut first, mut second) = ([_mm512_setzero_pd(); 4], [_mm512_setzero_pd(); 4]);
        for row in 0..4 {
            first[row] = _mm512_shuffle_f64x2::<0b01_00_01_00>(lines[row], lines[row + 4]);
            second[row] = _mm512_shuffle_f64x2::<0b11_10_11_10>(lines[row], lines[row + 4]);
        }
        [parts(first), parts(second)]
    }
}
