//! Eight lanes in AVX2 registers.
//!
//! Sound only where AVX2 is present: [`crate::width::Width::available`] ensures this, and nothing else constructs these
//! words.

use core::arch::x86_64::*;

use crate::sealed::Sealed;
use crate::word::{Factor, PAIRS, PairTable, Wide, Word};

/// Eight lanes of 32 bits.
#[derive(Clone, Copy)]
pub struct Avx2(__m256i);

/// Eight lanes of 64 bits: those of the even words and those of the odd ones, as the multiplier delivers them.
#[derive(Clone, Copy)]
pub struct Avx2Wide {
    even: __m256i,
    odd: __m256i,
}

simd_operators!(
    Avx2,
    __m256i,
    _mm256_add_epi32,
    _mm256_sub_epi32,
    _mm256_mullo_epi32,
    _mm256_xor_si256,
    _mm256_and_si256,
    _mm256_sll_epi32,
    _mm256_srl_epi32
);

const ODD: i32 = 0xAA;

/// Moves the odd words to the even places that the multiplier reads, by shuffles only, because shifts would occupy the
/// multiplier's ports.
#[inline(always)]
fn odd(words: __m256i) -> __m256i {
    instructions! { _mm256_shuffle_epi32::<0b11_11_01_01>(words) }
}

/// Eight lanes for the multiplier: the even words and the odd ones, each in the lower half of 64 bits; the upper halves
/// are arbitrary. Products then need no reordering.
#[derive(Clone, Copy)]
pub struct Avx2Factors {
    even: __m256i,
    odd: __m256i,
}

impl core::ops::BitXor for Avx2Factors {
    type Output = Avx2Factors;
    #[inline(always)]
    fn bitxor(self, other: Avx2Factors) -> Avx2Factors {
        instructions! {
            Avx2Factors {
                even: _mm256_xor_si256(self.even, other.even),
                odd: _mm256_xor_si256(self.odd, other.odd),
            }
        }
    }
}

impl Factor for Avx2Factors {
    #[inline(always)]
    fn splat(x: u32) -> Avx2Factors {
        let words = Avx2::splat(x).0;
        Avx2Factors { even: words, odd: words }
    }

    #[inline(always)]
    fn mulhilo(self, by: Avx2Factors) -> (Avx2Factors, Avx2Factors) {
        instructions! {
            let low = Avx2Factors {
                even: _mm256_mul_epu32(self.even, by.even),
                odd: _mm256_mul_epu32(self.odd, by.odd),
            };
            (Avx2Factors { even: odd(low.even), odd: odd(low.odd) }, low)
        }
    }
}

impl Factor for Avx2 {
    #[inline(always)]
    fn splat(x: u32) -> Avx2 {
        instructions! { Avx2(_mm256_set1_epi32(x as i32)) }
    }

    #[inline(always)]
    fn mulhilo(self, by: Avx2) -> (Avx2, Avx2) {
        instructions! {
            let even = _mm256_mul_epu32(self.0, by.0);
            let odd = _mm256_mul_epu32(odd(self.0), odd(by.0));
            let high = _mm256_blend_epi32::<ODD>(_mm256_shuffle_epi32::<0b11_11_01_01>(even), odd);
            let low = _mm256_blend_epi32::<ODD>(even, _mm256_shuffle_epi32::<0b10_10_00_00>(odd));
            (Avx2(high), Avx2(low))
        }
    }
}

impl Sealed for Avx2 {}

impl Word for Avx2 {
    type Factors = Avx2Factors;
    type Wide = Avx2Wide;
    const LANES: usize = 8;

    #[inline(always)]
    fn iota() -> Avx2 {
        instructions! { Avx2(_mm256_setr_epi32(0, 1, 2, 3, 4, 5, 6, 7)) }
    }

    #[inline(always)]
    fn load(from: &[u32]) -> Avx2 {
        // SAFETY: the slice has the words that are read, and the processor the instruction.
        unsafe { Avx2(_mm256_loadu_si256(from[..8].as_ptr().cast())) }
    }

    #[inline(always)]
    fn store(self, to: &mut [u32]) {
        // SAFETY: the slice has the words that are written, and the processor the instruction.
        unsafe { _mm256_storeu_si256(to[..8].as_mut_ptr().cast(), self.0) }
    }

    #[inline(always)]
    fn sar(self, n: u32) -> Avx2 {
        instructions! { Avx2(_mm256_sra_epi32(self.0, _mm_cvtsi32_si128(n as i32))) }
    }

    #[inline(always)]
    fn shift_left(self, n: Avx2) -> Avx2 {
        instructions! { Avx2(_mm256_sllv_epi32(self.0, n.0)) }
    }

    #[inline(always)]
    fn shift_right(self, n: Avx2) -> Avx2 {
        instructions! { Avx2(_mm256_srlv_epi32(self.0, n.0)) }
    }

    #[inline(always)]
    fn leading_zeros(self) -> Avx2 {
        instructions! {
            // AVX2 has no such instruction. The exponent of the word as a float gives the number, once the bits that
            // could round it up to the next power of two are cleared. A word with its top bit set reads as negative and
            // saturates.
            let top = _mm256_andnot_si256(_mm256_srli_epi32::<8>(self.0), self.0);
            let exponent = _mm256_srli_epi32::<23>(_mm256_castps_si256(_mm256_cvtepi32_ps(top)));
            Avx2(_mm256_subs_epu16(_mm256_set1_epi32(127 + 31), exponent))
        }
    }

    #[inline(always)]
    fn mulhi(self, by: Avx2) -> Avx2 {
        instructions! {
            let even = _mm256_mul_epu32(self.0, by.0);
            let odd = _mm256_mul_epu32(odd(self.0), odd(by.0));
            Avx2(_mm256_blend_epi32::<ODD>(_mm256_shuffle_epi32::<0b11_11_01_01>(even), odd))
        }
    }

    #[inline(always)]
    fn factors(self) -> Avx2Factors {
        Avx2Factors { even: self.0, odd: odd(self.0) }
    }

    #[inline(always)]
    fn of_factors(factors: Avx2Factors) -> Avx2 {
        instructions! {
            Avx2(_mm256_blend_epi32::<ODD>(factors.even, _mm256_shuffle_epi32::<0b10_10_00_00>(factors.odd)))
        }
    }

    #[inline(always)]
    fn min_signed(self, other: Avx2) -> Avx2 {
        instructions! { Avx2(_mm256_min_epi32(self.0, other.0)) }
    }

    #[inline(always)]
    fn max_signed(self, other: Avx2) -> Avx2 {
        instructions! { Avx2(_mm256_max_epi32(self.0, other.0)) }
    }

    #[inline(always)]
    unsafe fn lookup(table: &PairTable, index: Avx2) -> (Avx2, Avx2) {
        debug_assert_eq!(index.below(PAIRS as u32), 0xff, "each lane has a pair");
        // SAFETY: the caller guarantees the indices, and the processor has the instructions.
        unsafe {
            // Pairs are fetched as 64-bit words, which takes half the loads of two 32-bit gathers.
            let index = index.0;
            let from = table.as_ptr().cast();
            let low = _mm256_i32gather_epi64::<8>(from, _mm256_castsi256_si128(index));
            let high = _mm256_i32gather_epi64::<8>(from, _mm256_extracti128_si256::<1>(index));
            // The shuffle works within 128-bit halves; the permutation then puts the quarters in order.
            let pick =
                |firsts: __m256| _mm256_permute4x64_epi64::<0b11_01_10_00>(_mm256_castps_si256(firsts));
            let (low, high) = (_mm256_castsi256_ps(low), _mm256_castsi256_ps(high));
            let first = pick(_mm256_shuffle_ps::<0b10_00_10_00>(low, high));
            let second = pick(_mm256_shuffle_ps::<0b11_01_11_01>(low, high));
            (Avx2(first), Avx2(second))
        }
    }

    #[inline(always)]
    unsafe fn gather(table: &[u32], index: Avx2) -> Avx2 {
        debug_assert_eq!(index.below(table.len() as u32), 0xff, "each lane has a word");
        // SAFETY: the caller guarantees the indices, and the processor has the instruction.
        unsafe { Avx2(_mm256_i32gather_epi32::<4>(table.as_ptr().cast(), index.0)) }
    }

    #[inline(always)]
    fn with_sign(self, sign: Avx2) -> Avx2 {
        // The instruction returns 0 for a sign of 0, so the sign is made odd.
        instructions! { Avx2(_mm256_sign_epi32(self.0, _mm256_or_si256(sign.0, _mm256_set1_epi32(1)))) }
    }

    #[inline(always)]
    fn mul_wide(self, by: Avx2) -> Avx2Wide {
        instructions! {
            Avx2Wide { even: _mm256_mul_epi32(self.0, by.0), odd: _mm256_mul_epi32(odd(self.0), odd(by.0)) }
        }
    }

    #[inline(always)]
    fn add_where_equal(self, more: Avx2, a: Avx2, b: Avx2) -> Avx2 {
        instructions! {
            let more = _mm256_and_si256(more.0, _mm256_cmpeq_epi32(a.0, b.0));
            Avx2(_mm256_add_epi32(self.0, more))
        }
    }

    #[inline(always)]
    fn below(self, n: u32) -> u32 {
        instructions! {
            // There is no unsigned comparison, so both sides are shifted by half the range.
            let half = _mm256_set1_epi32(i32::MIN);
            let n = _mm256_set1_epi32((n ^ (1 << 31)) as i32);
            let below = _mm256_cmpgt_epi32(n, _mm256_xor_si256(self.0, half));
            _mm256_movemask_ps(_mm256_castsi256_ps(below)) as u32
        }
    }
}

impl core::ops::Add for Avx2Wide {
    type Output = Avx2Wide;
    #[inline(always)]
    fn add(self, other: Avx2Wide) -> Avx2Wide {
        instructions! {
            Avx2Wide {
                even: _mm256_add_epi64(self.even, other.even),
                odd: _mm256_add_epi64(self.odd, other.odd),
            }
        }
    }
}

impl core::ops::Sub for Avx2Wide {
    type Output = Avx2Wide;
    #[inline(always)]
    fn sub(self, other: Avx2Wide) -> Avx2Wide {
        instructions! {
            Avx2Wide {
                even: _mm256_sub_epi64(self.even, other.even),
                odd: _mm256_sub_epi64(self.odd, other.odd),
            }
        }
    }
}

impl Avx2Wide {
    #[inline(always)]
    fn lanes(self) -> [u64; 8] {
        let mut lanes = [0; 8];
        // SAFETY: the parts of the array have the words that are written, and the processor the instruction.
        unsafe {
            _mm256_storeu_si256(lanes[..4].as_mut_ptr().cast(), self.even);
            _mm256_storeu_si256(lanes[4..].as_mut_ptr().cast(), self.odd);
        }
        lanes
    }
}

impl Wide for Avx2Wide {
    type Word = Avx2;

    #[inline(always)]
    fn splat(x: i64) -> Avx2Wide {
        instructions! { Avx2Wide { even: _mm256_set1_epi64x(x), odd: _mm256_set1_epi64x(x) } }
    }

    #[inline(always)]
    fn high_word(self) -> Avx2 {
        instructions! { Avx2(_mm256_blend_epi32::<ODD>(_mm256_shuffle_epi32::<0b11_11_01_01>(self.even), self.odd)) }
    }

    #[inline(always)]
    fn bits_from(self, n: u32) -> Avx2 {
        instructions! {
            let n = _mm_cvtsi32_si128(n as i32);
            let (even, odd) = (_mm256_srl_epi64(self.even, n), _mm256_srl_epi64(self.odd, n));
            Avx2(_mm256_blend_epi32::<ODD>(even, _mm256_shuffle_epi32::<0b10_10_00_00>(odd)))
        }
    }

    #[inline(always)]
    fn total_unsigned(self) -> u128 {
        self.lanes().iter().map(|&lane| u128::from(lane)).sum()
    }

    #[inline(always)]
    fn halves(self) -> [Avx2Wide; 2] {
        instructions! {
            let low = _mm256_set1_epi64x(0xffff_ffff);
            [
                Avx2Wide { even: _mm256_and_si256(self.even, low), odd: _mm256_and_si256(self.odd, low) },
                Avx2Wide { even: _mm256_srli_epi64::<32>(self.even), odd: _mm256_srli_epi64::<32>(self.odd) },
            ]
        }
    }

    #[inline(always)]
    fn store(self, to: &mut [u64]) {
        for (k, lane) in self.lanes().into_iter().enumerate() {
            to[2 * (k % 4) + k / 4] = lane;
        }
    }
}
