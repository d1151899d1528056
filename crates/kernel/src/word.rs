//! The arithmetic of the kernels: 32-bit words that wrap, in as many lanes as the processor offers.
//!
//! A kernel is written once over [`Word`]; a backend chooses the width. Every operation is defined on the bits of one
//! lane, so all widths and the shaders (`shaders/word.wgsl`) agree by construction, as tests confirm.

use core::ops::{Add, BitAnd, BitXor, Mul, Shl, Shr, Sub};

use crate::sealed::Sealed;
use crate::shader::constants;

constants!(HALF, PAIRS);

/// Half of a unit in 2^−32 of it; added before a floor, it makes it a rounding.
pub const HALF: u32 = 1 << 31;

/// Number of pairs in a table.
pub const PAIRS: usize = 528;

/// A table of pairs; see [`Word::lookup`].
pub type PairTable = [[u32; 2]; PAIRS];

/// The operations that Philox needs on a word: `^` and full products.
pub trait Factor: Copy + BitXor<Output = Self> {
    /// `x` in every lane.
    fn splat(x: u32) -> Self;
    /// Upper and lower half of the unsigned product.
    fn mulhilo(self, by: Self) -> (Self, Self);
}

/// Lanes of 32-bit words, of this package only: reading without checks relies on their arithmetic. `+ - * ^ & << >>` act on each lane and wrap; `>>` shifts in zeros.
pub trait Word:
    Sealed
    + Factor
    + Add<Output = Self>
    + Sub<Output = Self>
    + Mul<Output = Self>
    + BitAnd<Output = Self>
    + Shl<u32, Output = Self>
    + Shr<u32, Output = Self>
{
    /// The same lanes in the multiplier's layout, for words that are multiplied repeatedly.
    type Factors: Factor;
    /// The same lanes as signed 64-bit numbers.
    type Wide: Wide<Word = Self>;
    /// Number of lanes.
    const LANES: usize;

    /// 0, 1, 2, …, one per lane.
    fn iota() -> Self;
    /// The first `LANES` words of `from`, in order.
    fn load(from: &[u32]) -> Self;
    /// Stores the lanes in order into the first `LANES` places of `to`.
    fn store(self, to: &mut [u32]);
    /// Shift right, repeating the sign bit.
    fn sar(self, n: u32) -> Self;
    /// Shift left by each lane's own count, which is below 32.
    fn shift_left(self, n: Self) -> Self;
    /// Shift right by each lane's own count, which is below 32; shifts in zeros.
    fn shift_right(self, n: Self) -> Self;
    /// Number of zero bits above the highest one bit; the argument must not be 0.
    fn leading_zeros(self) -> Self;
    /// The smaller value, compared as signed numbers.
    fn min_signed(self, other: Self) -> Self;
    /// The larger value, compared as signed numbers.
    fn max_signed(self, other: Self) -> Self;
    /// The word, negated where `sign` is negative.
    #[inline(always)]
    fn with_sign(self, sign: Self) -> Self {
        let sign = sign.sar(31);
        (self ^ sign) - sign
    }
    /// Upper half of the unsigned product.
    fn mulhi(self, by: Self) -> Self;
    /// Converts the lanes to the multiplier's layout.
    fn factors(self) -> Self::Factors;
    /// Converts the lanes back from the multiplier's layout.
    fn of_factors(factors: Self::Factors) -> Self;
    /// The pair at `index`.
    ///
    /// # Safety
    /// Every lane of `index` is below the length of the table.
    unsafe fn lookup(table: &PairTable, index: Self) -> (Self, Self);
    /// The word at `index` of `table`.
    ///
    /// # Safety
    /// Every lane of `index` is below the length of the table, which is below 2^31.
    unsafe fn gather(table: &[u32], index: Self) -> Self;
    /// The signed product.
    fn mul_wide(self, by: Self) -> Self::Wide;
    /// The word, plus `more` where the lanes of `a` and `b` are equal.
    fn add_where_equal(self, more: Self, a: Self, b: Self) -> Self;
    /// Mask of the lanes that are below `n` as unsigned numbers; bit k is lane k.
    fn below(self, n: u32) -> u32;
}

/// Lanes of signed 64-bit numbers; sums wrap.
pub trait Wide: Copy + Add<Output = Self> + Sub<Output = Self> {
    /// The matching 32-bit lanes.
    type Word;

    /// `x` in every lane.
    fn splat(x: i64) -> Self;
    /// Half a unit where the unit is 2^32; see [`HALF`].
    #[inline(always)]
    fn half() -> Self {
        Self::splat(i64::from(HALF))
    }
    /// Bits 32 to 63 of each lane.
    fn high_word(self) -> Self::Word;
    /// Bits `n` to `n` + 31 of each lane; `n` is below 32.
    fn bits_from(self, n: u32) -> Self::Word;
    /// The exact sum of the lanes, each read as unsigned.
    fn total_unsigned(self) -> u128;
    /// The lower and the upper 32 bits of each lane, as 64-bit numbers.
    fn halves(self) -> [Self; 2];
    /// Stores the lanes in order into the first places of `to`.
    fn store(self, to: &mut [u64]);
}

/// One lane: the portable width and the reference for the others.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Scalar(pub u32);

impl Add for Scalar {
    type Output = Scalar;
    #[inline(always)]
    fn add(self, other: Scalar) -> Scalar {
        Scalar(self.0.wrapping_add(other.0))
    }
}

impl Sub for Scalar {
    type Output = Scalar;
    #[inline(always)]
    fn sub(self, other: Scalar) -> Scalar {
        Scalar(self.0.wrapping_sub(other.0))
    }
}

impl Mul for Scalar {
    type Output = Scalar;
    #[inline(always)]
    fn mul(self, other: Scalar) -> Scalar {
        Scalar(self.0.wrapping_mul(other.0))
    }
}

impl BitXor for Scalar {
    type Output = Scalar;
    #[inline(always)]
    fn bitxor(self, other: Scalar) -> Scalar {
        Scalar(self.0 ^ other.0)
    }
}

impl BitAnd for Scalar {
    type Output = Scalar;
    #[inline(always)]
    fn bitand(self, other: Scalar) -> Scalar {
        Scalar(self.0 & other.0)
    }
}

impl Shl<u32> for Scalar {
    type Output = Scalar;
    #[inline(always)]
    fn shl(self, n: u32) -> Scalar {
        Scalar(self.0 << n)
    }
}

impl Shr<u32> for Scalar {
    type Output = Scalar;
    #[inline(always)]
    fn shr(self, n: u32) -> Scalar {
        Scalar(self.0 >> n)
    }
}

impl Factor for Scalar {
    #[inline(always)]
    fn splat(x: u32) -> Scalar {
        Scalar(x)
    }

    #[inline(always)]
    fn mulhilo(self, by: Scalar) -> (Scalar, Scalar) {
        let product = u64::from(self.0) * u64::from(by.0);
        (Scalar((product >> 32) as u32), Scalar(product as u32))
    }
}

impl Sealed for Scalar {}

impl Word for Scalar {
    type Factors = Scalar;
    type Wide = ScalarWide;
    const LANES: usize = 1;

    #[inline(always)]
    fn iota() -> Scalar {
        Scalar(0)
    }

    #[inline(always)]
    fn load(from: &[u32]) -> Scalar {
        Scalar(from[0])
    }

    #[inline(always)]
    fn store(self, to: &mut [u32]) {
        to[0] = self.0;
    }

    #[inline(always)]
    fn sar(self, n: u32) -> Scalar {
        Scalar((self.0 as i32 >> n) as u32)
    }

    #[inline(always)]
    fn shift_left(self, n: Scalar) -> Scalar {
        Scalar(self.0 << n.0)
    }

    #[inline(always)]
    fn shift_right(self, n: Scalar) -> Scalar {
        Scalar(self.0 >> n.0)
    }

    #[inline(always)]
    fn leading_zeros(self) -> Scalar {
        Scalar(self.0.leading_zeros())
    }

    #[inline(always)]
    fn mulhi(self, by: Scalar) -> Scalar {
        self.mulhilo(by).0
    }

    #[inline(always)]
    fn factors(self) -> Scalar {
        self
    }

    #[inline(always)]
    fn of_factors(factors: Scalar) -> Scalar {
        factors
    }

    #[inline(always)]
    fn min_signed(self, other: Scalar) -> Scalar {
        Scalar((self.0 as i32).min(other.0 as i32) as u32)
    }

    #[inline(always)]
    fn max_signed(self, other: Scalar) -> Scalar {
        Scalar((self.0 as i32).max(other.0 as i32) as u32)
    }

    #[inline(always)]
    unsafe fn lookup(table: &PairTable, index: Scalar) -> (Scalar, Scalar) {
        debug_assert!((index.0 as usize) < PAIRS, "pair {} of {PAIRS}", index.0);
        // SAFETY: guaranteed by the caller.
        let [first, second] = unsafe { *table.get_unchecked(index.0 as usize) };
        (Scalar(first), Scalar(second))
    }

    #[inline(always)]
    unsafe fn gather(table: &[u32], index: Scalar) -> Scalar {
        debug_assert!((index.0 as usize) < table.len(), "word {} of {}", index.0, table.len());
        // SAFETY: guaranteed by the caller.
        Scalar(unsafe { *table.get_unchecked(index.0 as usize) })
    }

    #[inline(always)]
    fn mul_wide(self, by: Scalar) -> ScalarWide {
        ScalarWide(i64::from(self.0 as i32) * i64::from(by.0 as i32))
    }

    #[inline(always)]
    fn add_where_equal(self, more: Scalar, a: Scalar, b: Scalar) -> Scalar {
        if a == b { self + more } else { self }
    }

    #[inline(always)]
    fn below(self, n: u32) -> u32 {
        u32::from(self.0 < n)
    }
}

/// One lane of 64 bits.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct ScalarWide(pub i64);

impl Add for ScalarWide {
    type Output = ScalarWide;
    #[inline(always)]
    fn add(self, other: ScalarWide) -> ScalarWide {
        ScalarWide(self.0.wrapping_add(other.0))
    }
}

impl Sub for ScalarWide {
    type Output = ScalarWide;
    #[inline(always)]
    fn sub(self, other: ScalarWide) -> ScalarWide {
        ScalarWide(self.0.wrapping_sub(other.0))
    }
}

impl Wide for ScalarWide {
    type Word = Scalar;

    #[inline(always)]
    fn splat(x: i64) -> ScalarWide {
        ScalarWide(x)
    }

    #[inline(always)]
    fn high_word(self) -> Scalar {
        Scalar((self.0 >> 32) as u32)
    }

    #[inline(always)]
    fn bits_from(self, n: u32) -> Scalar {
        Scalar((self.0 >> n) as u32)
    }

    #[inline(always)]
    fn total_unsigned(self) -> u128 {
        u128::from(self.0 as u64)
    }

    #[inline(always)]
    fn halves(self) -> [ScalarWide; 2] {
        [ScalarWide(self.0 & 0xffff_ffff), ScalarWide((self.0 as u64 >> 32) as i64)]
    }

    #[inline(always)]
    fn store(self, to: &mut [u64]) {
        to[0] = self.0 as u64;
    }
}
