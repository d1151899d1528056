//! Sixteen lanes in AVX-512 registers.
//!
//! Sound only where AVX-512 F, BW, CD, DQ and VL are present: [`crate::width::Width::available`] ensures this, and
//! nothing else constructs these words.

use core::arch::x86_64::*;

use crate::sealed::Sealed;
use crate::word::{Factor, PAIRS, PairTable, Wide, Word};

/// Sixteen lanes of 32 bits.
#[derive(Clone, Copy)]
pub struct Avx512(__m512i);

/// Sixteen lanes of 64 bits: those of the even words and those of the odd ones, as the multiplier delivers them.
#[derive(Clone, Copy)]
pub struct Avx512Wide {
    even: __m512i,
    odd: __m512i,
}

simd_operators!(
    Avx512,
    __m512i,
    _mm512_add_epi32,
    _mm512_sub_epi32,
    _mm512_mullo_epi32,
    _mm512_xor_si512,
    _mm512_and_si512,
    _mm512_sll_epi32,
    _mm512_srl_epi32
);

const ODD: __mmask16 = 0xAAAA;

/// Moves the odd words to the even places that the multiplier reads.
#[inline(always)]
fn odd(words: __m512i) -> __m512i {
    instructions! { _mm512_srli_epi64::<32>(words) }
}

/// Sixteen lanes for the multiplier: the even words and the odd ones, each in the lower half of 64 bits; the upper
/// halves are arbitrary. Products then need no reordering.
#[derive(Clone, Copy)]
pub struct Avx512Factors {
    even: __m512i,
    odd: __m512i,
}

impl core::ops::BitXor for Avx512Factors {
    type Output = Avx512Factors;
    #[inline(always)]
    fn bitxor(self, other: Avx512Factors) -> Avx512Factors {
        instructions! {
            Avx512Factors {
                even: _mm512_xor_si512(self.even, other.even),
                odd: _mm512_xor_si512(self.odd, other.odd),
            }
        }
    }
}

impl Factor for Avx512Factors {
    #[inline(always)]
    fn splat(x: u32) -> Avx512Factors {
        let words = Avx512::splat(x).0;
        Avx512Factors { even: words, odd: words }
    }

    #[inline(always)]
    fn mulhilo(self, by: Avx512Factors) -> (Avx512Factors, Avx512Factors) {
        instructions! {
            let low = Avx512Factors {
                even: _mm512_mul_epu32(self.even, by.even),
                odd: _mm512_mul_epu32(self.odd, by.odd),
            };
            (Avx512Factors { even: odd(low.even), odd: odd(low.odd) }, low)
        }
    }
}

impl Factor for Avx512 {
    #[inline(always)]
    fn splat(x: u32) -> Avx512 {
        instructions! { Avx512(_mm512_set1_epi32(x as i32)) }
    }

    #[inline(always)]
    fn mulhilo(self, by: Avx512) -> (Avx512, Avx512) {
        instructions! {
            let even = _mm512_mul_epu32(self.0, by.0);
            let odd = _mm512_mul_epu32(odd(self.0), odd(by.0));
            let high = _mm512_mask_shuffle_epi32::<0b11_11_01_01>(odd, !ODD, even);
            // A shuffle instead of a shift, which the compiler would merge with the product into a slow 64-bit one.
            let low = _mm512_mask_shuffle_epi32::<0b10_10_00_00>(even, ODD, odd);
            (Avx512(high), Avx512(low))
        }
    }
}

impl Sealed for Avx512 {}

impl Word for Avx512 {
    type Factors = Avx512Factors;
    type Wide = Avx512Wide;
    const LANES: usize = 16;

    #[inline(always)]
    fn iota() -> Avx512 {
        instructions! { Avx512(_mm512_setr_epi32(0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15)) }
    }

    #[inline(always)]
    fn load(from: &[u32]) -> Avx512 {
        // SAFETY: the slice has the words that are read, and the processor the instruction.
        unsafe { Avx512(_mm512_loadu_si512(from[..16].as_ptr().cast())) }
    }

    #[inline(always)]
    fn store(self, to: &mut [u32]) {
        // SAFETY: the slice has the words that are written, and the processor the instruction.
        unsafe { _mm512_storeu_si512(to[..16].as_mut_ptr().cast(), self.0) }
    }

    #[inline(always)]
    fn sar(self, n: u32) -> Avx512 {
        instructions! { Avx512(_mm512_sra_epi32(self.0, _mm_cvtsi32_si128(n as i32))) }
    }

    #[inline(always)]
    fn shift_left(self, n: Avx512) -> Avx512 {
        instructions! { Avx512(_mm512_sllv_epi32(self.0, n.0)) }
    }

    #[inline(always)]
    fn shift_right(self, n: Avx512) -> Avx512 {
        instructions! { Avx512(_mm512_srlv_epi32(self.0, n.0)) }
    }

    #[inline(always)]
    fn leading_zeros(self) -> Avx512 {
        instructions! { Avx512(_mm512_lzcnt_epi32(self.0)) }
    }

    #[inline(always)]
    fn mulhi(self, by: Avx512) -> Avx512 {
        instructions! {
            let even = _mm512_mul_epu32(self.0, by.0);
            let odd = _mm512_mul_epu32(odd(self.0), odd(by.0));
            Avx512(_mm512_mask_shuffle_epi32::<0b11_11_01_01>(odd, !ODD, even))
        }
    }

    #[inline(always)]
    fn factors(self) -> Avx512Factors {
        Avx512Factors { even: self.0, odd: odd(self.0) }
    }

    #[inline(always)]
    fn of_factors(factors: Avx512Factors) -> Avx512 {
        instructions! { Avx512(_mm512_mask_shuffle_epi32::<0b10_10_00_00>(factors.even, ODD, factors.odd)) }
    }

    #[inline(always)]
    fn min_signed(self, other: Avx512) -> Avx512 {
        instructions! { Avx512(_mm512_min_epi32(self.0, other.0)) }
    }

    #[inline(always)]
    fn max_signed(self, other: Avx512) -> Avx512 {
        instructions! { Avx512(_mm512_max_epi32(self.0, other.0)) }
    }

    #[inline(always)]
    unsafe fn lookup(table: &PairTable, index: Avx512) -> (Avx512, Avx512) {
        debug_assert_eq!(index.below(PAIRS as u32), 0xffff, "each lane has a pair");
        // SAFETY: the caller guarantees the indices, and the processor has the instructions.
        unsafe {
            // Pairs are fetched as 64-bit words, which takes half the loads of two 32-bit gathers.
            let index = index.0;
            let from = table.as_ptr().cast();
            let low = _mm512_i32gather_epi64::<8>(_mm512_castsi512_si256(index), from);
            let high = _mm512_i32gather_epi64::<8>(_mm512_extracti64x4_epi64::<1>(index), from);
            let firsts = _mm512_setr_epi32(0, 2, 4, 6, 8, 10, 12, 14, 16, 18, 20, 22, 24, 26, 28, 30);
            let seconds = _mm512_setr_epi32(1, 3, 5, 7, 9, 11, 13, 15, 17, 19, 21, 23, 25, 27, 29, 31);
            let first = _mm512_permutex2var_epi32(low, firsts, high);
            let second = _mm512_permutex2var_epi32(low, seconds, high);
            (Avx512(first), Avx512(second))
        }
    }

    #[inline(always)]
    unsafe fn gather(table: &[u32], index: Avx512) -> Avx512 {
        debug_assert_eq!(index.below(table.len() as u32), 0xffff, "each lane has a word");
        // SAFETY: the caller guarantees the indices, and the processor has the instruction.
        unsafe { Avx512(_mm512_i32gather_epi32::<4>(index.0, table.as_ptr().cast())) }
    }

    #[inline(always)]
    fn with_sign(self, sign: Avx512) -> Avx512 {
        instructions! {
            let negative = _mm512_movepi32_mask(sign.0);
            Avx512(_mm512_mask_sub_epi32(self.0, negative, _mm512_setzero_si512(), self.0))
        }
    }

    #[inline(always)]
    fn mul_wide(self, by: Avx512) -> Avx512Wide {
        instructions! {
            Avx512Wide { even: _mm512_mul_epi32(self.0, by.0), odd: _mm512_mul_epi32(odd(self.0), odd(by.0)) }
        }
    }

    #[inline(always)]
    fn add_where_equal(self, more: Avx512, a: Avx512, b: Avx512) -> Avx512 {
        instructions! { Avx512(_mm512_mask_add_epi32(self.0, _mm512_cmpeq_epi32_mask(a.0, b.0), self.0, more.0)) }
    }

    #[inline(always)]
    fn below(self, n: u32) -> u32 {
        instructions! { u32::from(_mm512_cmplt_epu32_mask(self.0, Avx512::splat(n).0)) }
    }
}

impl core::ops::Add for Avx512Wide {
    type Output = Avx512Wide;
    #[inline(always)]
    fn add(self, other: Avx512Wide) -> Avx512Wide {
        instructions! {
            Avx512Wide {
                even: _mm512_add_epi64(self.even, other.even),
                odd: _mm512_add_epi64(self.odd, other.odd),
            }
        }
    }
}

impl core::ops::Sub for Avx512Wide {
    type Output = Avx512Wide;
    #[inline(always)]
    fn sub(self, other: Avx512Wide) -> Avx512Wide {
        instructions! {
            Avx512Wide {
                even: _mm512_sub_epi64(self.even, other.even),
                odd: _mm512_sub_epi64(self.odd, other.odd),
            }
        }
    }
}

impl Avx512Wide {
    #[inline(always)]
    fn lanes(self) -> [u64; 16] {
        let mut lanes = [0; 16];
        // SAFETY: the parts of the array have the words that are written, and the processor the instruction.
        unsafe {
            _mm512_storeu_si512(lanes[..8].as_mut_ptr().cast(), self.even);
            _mm512_storeu_si512(lanes[8..].as_mut_ptr().cast(), self.odd);
        }
        lanes
    }
}

impl Wide for Avx512Wide {
    type Word = Avx512;

    #[inline(always)]
    fn splat(x: i64) -> Avx512Wide {
        instructions! { Avx512Wide { even: _mm512_set1_epi64(x), odd: _mm512_set1_epi64(x) } }
    }

    #[inline(always)]
    fn high_word(self) -> Avx512 {
        instructions! { Avx512(_mm512_mask_shuffle_epi32::<0b11_11_01_01>(self.odd, !ODD, self.even)) }
    }

    #[inline(always)]
    fn bits_from(self, n: u32) -> Avx512 {
        instructions! {
            let n = _mm_cvtsi32_si128(n as i32);
            let (even, odd) = (_mm512_srl_epi64(self.even, n), _mm512_srl_epi64(self.odd, n));
            Avx512(_mm512_mask_blend_epi32(ODD, even, _mm512_slli_epi64::<32>(odd)))
        }
    }

    #[inline(always)]
    fn total_unsigned(self) -> u128 {
        self.lanes().iter().map(|&lane| u128::from(lane)).sum()
    }

    #[inline(always)]
    fn halves(self) -> [Avx512Wide; 2] {
        instructions! {
            let low = _mm512_set1_epi64(0xffff_ffff);
            [
                Avx512Wide { even: _mm512_and_si512(self.even, low), odd: _mm512_and_si512(self.odd, low) },
                Avx512Wide {
                    even: _mm512_srli_epi64::<32>(self.even),
                    odd: _mm512_srli_epi64::<32>(self.odd),
                },
            ]
        }
    }

    #[inline(always)]
    fn store(self, to: &mut [u64]) {
        for (k, lane) in self.lanes().into_iter().enumerate() {
            to[2 * (k % 8) + k / 8] = lane;
        }
    }
}
