//! Loads, stores and transposes of sixteen lanes of single precision in one 512-bit register.

use super::super::{Octet, SINGLE_LANES, SingleLanes, Sixteen};
use super::{Avx512Single, join};
use std::arch::x86_64::*;

transposition!(
    transposed, __m512,
    _mm512_unpacklo_ps _mm512_unpackhi_ps _mm512_unpacklo_pd _mm512_unpackhi_pd _mm512_castps_pd _mm512_castpd_ps
);

/// Returns the lanes of four bodies from the lower halves of two octets' lanes (`UPPER` 0), or from the upper halves:
/// those of the first, then those of the second, alternating by 128 bits.
///
/// # Safety
/// AVX-512F.
#[inline(always)]
unsafe fn merge<const UPPER: i64>(first: Avx512Single, second: Avx512Single) -> __m512 {
    // SAFETY: guaranteed by the caller.
    unsafe {
        let at = 4 * UPPER;
        let order = _mm512_setr_epi64(at, at + 1, at + 8, at + 9, at + 2, at + 3, at + 10, at + 11);
        let (first, second) = (_mm512_castps_pd(first.0), _mm512_castps_pd(second.0));
        _mm512_castpd_ps(_mm512_permutex2var_pd(first, order, second))
    }
}

/// Loads the rows `rows + lane` and `rows + lane + 4` of a group into one register.
///
/// # Safety
/// The requirements of [`SingleLanes::load_octets`] apply.
#[inline(always)]
unsafe fn octet_rows(base: *const Octet, indices: &[u32; SINGLE_LANES], lane: usize) -> __m512 {
    // SAFETY: guaranteed by the caller; an octet has the size and alignment of a quad.
    unsafe {
        let (low, high) = (base.add(indices[lane] as usize), base.add(indices[lane + 4] as usize));
        _mm512_castpd_ps(join(low.cast(), high.cast()))
    }
}

/// Writes rows in the layout of [`octet_rows`].
///
/// # Safety
/// The requirements of [`SingleLanes::store_octets`] apply.
#[inline(always)]
unsafe fn put_octet_rows(base: *mut Octet, indices: &[u32; SINGLE_LANES], lane: usize, rows: __m512) {
    // SAFETY: guaranteed by the caller; octets are aligned to 32 bytes.
    unsafe {
        let rows = _mm512_castps_pd(rows);
        let (low, high) = (base.add(indices[lane] as usize), base.add(indices[lane + 4] as usize));
        _mm256_store_pd(low.cast(), _mm512_castpd512_pd256(rows));
        _mm256_store_pd(high.cast(), _mm512_extractf64x4_pd::<1>(rows));
    }
}

impl SingleLanes for Avx512Single {
    #[inline(always)]
    fn load(from: &Sixteen) -> Avx512Single {
        // SAFETY: see the type; `Sixteen` is aligned to 64 bytes.
        Avx512Single(unsafe { _mm512_load_ps(from.0.as_ptr()) })
    }

    #[inline(always)]
    fn store(self, to: &mut Sixteen) {
        // SAFETY: as in `load`.
        unsafe { _mm512_store_ps(to.0.as_mut_ptr(), self.0) }
    }

    #[inline(always)]
    unsafe fn load_octets(base: *const Octet, indices: &[u32; SINGLE_LANES]) -> [Avx512Single; 8] {
        // SAFETY: guaranteed by the caller.
        unsafe {
            // First and second four numbers of bodies 0 to 3 and of 4 to 7; then those of 8 to 15.
            let (mut low, mut high) = ([_mm512_setzero_ps(); 4], [_mm512_setzero_ps(); 4]);
            for row in 0..4 {
                low[row] = octet_rows(base, indices, row);
                high[row] = octet_rows(base, indices, 8 + row);
            }
            let (low, high) = (transposed(low), transposed(high));
            let mut out = [Avx512Single(low[0]); 8];
            for part in 0..4 {
                out[part] = Avx512Single(_mm512_shuffle_f32x4::<0x88>(low[part], high[part]));
                out[part + 4] = Avx512Single(_mm512_shuffle_f32x4::<0xdd>(low[part], high[part]));
            }
            out
        }
    }

    #[inline(always)]
    unsafe fn store_octets(base: *mut Octet, indices: &[u32; SINGLE_LANES], octets: [Avx512Single; 8]) {
        // SAFETY: guaranteed by the caller.
        unsafe {
            let (mut low, mut high) = ([octets[0].0; 4], [octets[0].0; 4]);
            for part in 0..4 {
                low[part] = merge::<0>(octets[part], octets[part + 4]);
                high[part] = merge::<1>(octets[part], octets[part + 4]);
            }
            let (low, high) = (transposed(low), transposed(high));
            for row in 0..4 {
                put_octet_rows(base, indices, row, low[row]);
                put_octet_rows(base, indices, 8 + row, high[row]);
            }
        }
    }
}
