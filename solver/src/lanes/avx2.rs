//! Lanes in two 256-bit registers.

use super::{Eight, LANES, Lanes, Line, Number, Octet, Quad, SINGLE_LANES, SingleLanes, Sixteen};
use std::arch::x86_64::*;
use std::ops::{Add, BitAnd, Div, Mul, Neg, Not, Sub};

/// Applies an intrinsic to both registers of its operands.
macro_rules! both {
    ($result:ident, $intrinsic:expr $(, $operand:expr)*) => {
        // SAFETY: the types exist only on processors with AVX2.
        $result(unsafe { [$intrinsic($($operand.0[0]),*), $intrinsic($($operand.0[1]),*)] })
    };
}

/// Two registers of numbers of one precision, and masks of the same width.
macro_rules! registers {
    (
        $(#[$about:meta])* $lanes:ident, $mask:ident, $register:ty, $real:ty,
        arithmetic: $add:ident $subtract:ident $multiply:ident $divide:ident $root:ident,
        choice: $larger:ident $smaller:ident $compare:ident $blend:ident $covers:ident,
        bits: $splat:ident $and:ident $and_not:ident $exclusive_or:ident $from_integer:ident
    ) => {
        $(#[$about])*
        #[derive(Clone, Copy)]
        pub struct $lanes([$register; 2]);

        /// Truth values: all bits of a lane set, or none.
        #[derive(Clone, Copy)]
        pub struct $mask([$register; 2]);

        impl $mask {
            /// Returns the mask of all lanes.
            #[inline(always)]
            fn ones() -> $mask {
                // SAFETY: see the type.
                $mask([unsafe { $from_integer(_mm256_set1_epi64x(-1)) }; 2])
            }
        }

        operator!($lanes, Add, add, |a, b| both!($lanes, $add, a, b));
        operator!($lanes, Sub, sub, |a, b| both!($lanes, $subtract, a, b));
        operator!($lanes, Mul, mul, |a, b| both!($lanes, $multiply, a, b));
        operator!($lanes, Div, div, |a, b| both!($lanes, $divide, a, b));
        operator!($lanes, Neg, neg, |a| both!($lanes, $exclusive_or, a, $lanes::splat(-0.0)));
        operator!($mask, BitAnd, bitand, |a, b| both!($mask, $and, a, b));
        operator!($mask, Not, not, |a| both!($mask, $exclusive_or, a, $mask::ones()));

        number!(
            $lanes, $mask, |a, b, mask|
            // SAFETY: see the type.
            splat: $lanes([unsafe { $splat(a as $real) }; 2]),
            sqrt: both!($lanes, $root, a),
            abs: both!($lanes, $and_not, $lanes::splat(-0.0), a),
            larger: both!($lanes, $larger, a, b),
            smaller: both!($lanes, $smaller, a, b),
            below: both!($mask, $compare::<_CMP_LT_OQ>, a, b),
            at_most: both!($mask, $compare::<_CMP_LE_OQ>, a, b),
            select: both!($lanes, $blend, b, a, mask),
            // SAFETY: see the type.
            all: unsafe { $covers($and(mask.0[0], mask.0[1]), $mask::ones().0[0]) == 1 }
        );
    };
}

registers!(
    /// Eight numbers in two registers. Only code that runs with AVX2 creates values: only [`super::Available::run`]
    /// names this type.
    Avx2, Avx2Mask, __m256d, f64,
    arithmetic: _mm256_add_pd _mm256_sub_pd _mm256_mul_pd _mm256_div_pd _mm256_sqrt_pd,
    choice: _mm256_max_pd _mm256_min_pd _mm256_cmp_pd _mm256_blendv_pd _mm256_testc_pd,
    bits: _mm256_set1_pd _mm256_and_pd _mm256_andnot_pd _mm256_xor_pd _mm256_castsi256_pd
);

registers!(
    /// Sixteen single-precision numbers in two registers, with the condition of [`Avx2`].
    Avx2Single, Avx2SingleMask, __m256, f32,
    arithmetic: _mm256_add_ps _mm256_sub_ps _mm256_mul_ps _mm256_div_ps _mm256_sqrt_ps,
    choice: _mm256_max_ps _mm256_min_ps _mm256_cmp_ps _mm256_blendv_ps _mm256_testc_ps,
    bits: _mm256_set1_ps _mm256_and_ps _mm256_andnot_ps _mm256_xor_ps _mm256_castsi256_ps
);

/// Transposes a matrix of four rows of four.
///
/// # Safety
/// AVX2.
#[inline(always)]
unsafe fn transposed(rows: [__m256d; 4]) -> [__m256d; 4] {
    // SAFETY: guaranteed by the caller.
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
    type Single = Avx2Single;
    type Kept = ();

    const OVERLAPPED: bool = false;

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
        // SAFETY: guaranteed by the caller; quads are aligned to 32 bytes.
        unsafe {
            let row = |lane: usize| _mm256_load_pd(base.add(STRIDE * indices[lane] as usize).cast());
            let low = transposed([row(0), row(1), row(2), row(3)]);
            let high = transposed([row(4), row(5), row(6), row(7)]);
            [Avx2([low[0], high[0]]), Avx2([low[1], high[1]]), Avx2([low[2], high[2]]), Avx2([low[3], high[3]])]
        }
    }

    #[inline(always)]
    unsafe fn store_quads<const STRIDE: usize>(base: *mut Quad, indices: &[u32; LANES], quads: [Avx2; 4]) {
        // SAFETY: guaranteed by the caller.
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

    #[inline(always)]
    unsafe fn load_differences<const STRIDE: usize>(
        base: *const Quad,
        first: &[u32; LANES],
        second: &[u32; LANES],
    ) -> [Avx2; 4] {
        // SAFETY: guaranteed by the caller; quads are aligned to 32 bytes.
        unsafe {
            let against = _mm256_setr_pd(-0.0, -0.0, -0.0, 0.0);
            let quad = |place: u32| _mm256_load_pd(base.add(STRIDE * place as usize).cast());
            let mut out = [Avx2([_mm256_setzero_pd(); 2]); 4];
            for side in 0..2 {
                let mut differences = [_mm256_setzero_pd(); 4];
                for (row, difference) in differences.iter_mut().enumerate() {
                    let lane = 4 * side + row;
                    *difference = _mm256_add_pd(_mm256_xor_pd(quad(first[lane]), against), quad(second[lane]));
                }
                let differences = transposed(differences);
                for part in 0..4 {
                    out[part].0[side] = differences[part];
                }
            }
            out
        }
    }

    #[inline(always)]
    unsafe fn load_keeping(base: *const Line, first: &[u32; LANES], second: &[u32; LANES]) -> ([Avx2; 4], [(); 2]) {
        // SAFETY: guaranteed by the caller.
        (unsafe { Self::load_differences::<2>(base.cast(), first, second) }, [(); 2])
    }

    #[inline(always)]
    unsafe fn add_to_kept(base: *mut Line, indices: &[u32; LANES], (): (), half: [Avx2; 3], factor: f64) {
        // SAFETY: guaranteed by the caller.
        unsafe { Self::add_shares::<false>(base, indices, [half; 2], [factor; 2]) };
    }

    #[inline(always)]
    unsafe fn load_pairs(base: *const Line, first: &[u32; LANES], second: &[u32; LANES]) -> [[Avx2; 4]; 2] {
        // SAFETY: guaranteed by the caller; the halves of a line are aligned to 32 bytes.
        unsafe {
            let mut out =
                [Avx2::load_differences::<2>(base.cast(), first, second), [Avx2([_mm256_setzero_pd(); 2]); 4]];
            for side in 0..2 {
                let mut turning = [_mm256_setzero_pd(); 4];
                for (row, sum) in turning.iter_mut().enumerate() {
                    let lane = 4 * side + row;
                    let half = |place: u32| _mm256_load_pd(base.add(place as usize).cast::<f64>().add(4));
                    *sum = _mm256_add_pd(half(first[lane]), half(second[lane]));
                }
                let turning = transposed(turning);
                for part in 0..4 {
                    out[1][part].0[side] = turning[part];
                }
            }
            out
        }
    }

    #[inline(always)]
    unsafe fn add_shares<const WHOLE: bool>(
        base: *mut Line,
        indices: &[u32; LANES],
        halves: [[Avx2; 3]; 2],
        factors: [f64; 2],
    ) {
        // SAFETY: guaranteed by the caller; the halves of a line are aligned to 32 bytes.
        unsafe {
            for side in 0..2 {
                let zero = _mm256_setzero_pd();
                let [[x, y, z], [u, v, w]] = halves;
                let motion = transposed([x.0[side], y.0[side], z.0[side], zero]);
                let turning = transposed([u.0[side], v.0[side], w.0[side], zero]);
                for row in 0..4 {
                    let line: *mut f64 = base.add(indices[4 * side + row] as usize).cast();
                    let own = _mm256_broadcast_sd(&*line.add(3));
                    let scale = _mm256_mul_pd(own, _mm256_set1_pd(factors[0]));
                    _mm256_store_pd(line, _mm256_add_pd(_mm256_load_pd(line), _mm256_mul_pd(motion[row], scale)));
                    if WHOLE {
                        let (line, scale) = (line.add(4), _mm256_mul_pd(own, _mm256_set1_pd(factors[1])));
                        _mm256_store_pd(line, _mm256_add_pd(_mm256_load_pd(line), _mm256_mul_pd(turning[row], scale)));
                    }
                }
            }
        }
    }
}

transposition!(
    transposed_halves, __m256,
    _mm256_unpacklo_ps _mm256_unpackhi_ps _mm256_unpacklo_pd _mm256_unpackhi_pd _mm256_castps_pd _mm256_castpd_ps
);

/// Loads and transposes the octets of four bodies: first numbers of the four in the lower halves, fifth numbers in the upper.
///
/// # Safety
/// The requirements of [`SingleLanes::load_octets`] apply.
#[inline(always)]
unsafe fn four_octets(base: *const Octet, indices: &[u32; SINGLE_LANES], lane: usize) -> [__m256; 4] {
    // SAFETY: guaranteed by the caller; octets are aligned to 32 bytes.
    unsafe {
        let mut rows = [_mm256_setzero_ps(); 4];
        for row in 0..4 {
            rows[row] = _mm256_load_ps(base.add(indices[lane + row] as usize).cast());
        }
        transposed_halves(rows)
    }
}

/// Writes octets in the layout of [`four_octets`].
///
/// # Safety
/// The requirements of [`SingleLanes::store_octets`] apply.
#[inline(always)]
unsafe fn put_four_octets(base: *mut Octet, indices: &[u32; SINGLE_LANES], lane: usize, four: [__m256; 4]) {
    // SAFETY: guaranteed by the caller; octets are aligned to 32 bytes.
    unsafe {
        let rows = transposed_halves(four);
        for row in 0..4 {
            _mm256_store_ps(base.add(indices[lane + row] as usize).cast(), rows[row]);
        }
    }
}

/// Combines the lower (0x20) or upper (0x31) halves of two registers.
///
/// # Safety
/// AVX2.
#[inline(always)]
unsafe fn halves<const WHICH: i32>(a: __m256, b: __m256) -> __m256 {
    // SAFETY: guaranteed by the caller.
    unsafe { _mm256_permute2f128_ps::<WHICH>(a, b) }
}

impl SingleLanes for Avx2Single {
    #[inline(always)]
    fn load(from: &Sixteen) -> Avx2Single {
        // SAFETY: see the type; `Sixteen` is aligned to 64 bytes.
        Avx2Single(unsafe { [_mm256_load_ps(from.0.as_ptr()), _mm256_load_ps(from.0.as_ptr().add(8))] })
    }

    #[inline(always)]
    fn store(self, to: &mut Sixteen) {
        // SAFETY: as in `load`.
        unsafe {
            _mm256_store_ps(to.0.as_mut_ptr(), self.0[0]);
            _mm256_store_ps(to.0.as_mut_ptr().add(8), self.0[1]);
        }
    }

    #[inline(always)]
    unsafe fn load_octets(base: *const Octet, indices: &[u32; SINGLE_LANES]) -> [Avx2Single; 8] {
        // SAFETY: guaranteed by the caller.
        unsafe {
            let (a, b) = (four_octets(base, indices, 0), four_octets(base, indices, 4));
            let (c, d) = (four_octets(base, indices, 8), four_octets(base, indices, 12));
            let mut out = [Avx2Single([a[0]; 2]); 8];
            for part in 0..4 {
                out[part] = Avx2Single([halves::<0x20>(a[part], b[part]), halves::<0x20>(c[part], d[part])]);
                out[part + 4] = Avx2Single([halves::<0x31>(a[part], b[part]), halves::<0x31>(c[part], d[part])]);
            }
            out
        }
    }

    #[inline(always)]
    unsafe fn store_octets(base: *mut Octet, indices: &[u32; SINGLE_LANES], octets: [Avx2Single; 8]) {
        // SAFETY: guaranteed by the caller.
        unsafe {
            for half in 0..2 {
                let (mut low, mut high) = ([octets[0].0[half]; 4], [octets[0].0[half]; 4]);
                for part in 0..4 {
                    let (first, second) = (octets[part].0[half], octets[part + 4].0[half]);
                    low[part] = halves::<0x20>(first, second);
                    high[part] = halves::<0x31>(first, second);
                }
                put_four_octets(base, indices, 8 * half, low);
                put_four_octets(base, indices, 8 * half + 4, high);
            }
        }
    }
}
