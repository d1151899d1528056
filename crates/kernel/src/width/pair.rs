//! Two words as one of twice as many lanes. A kernel whose steps wait for one another then has two chains of them, which the
//! processor works on at the same time.

use core::ops::{Add, BitAnd, BitXor, Mul, Shl, Shr, Sub};

use crate::sealed::Sealed;
use crate::word::{Factor, PairTable, Wide, Word};

/// Lanes of the first word, then those of the second.
#[derive(Debug, Clone, Copy)]
pub struct Pair<T>([T; 2]);

impl<T: Copy> Pair<T> {
    #[inline(always)]
    fn with<U, R>(self, other: Pair<U>, of: impl Fn(T, U) -> R) -> Pair<R>
    where
        U: Copy,
    {
        Pair([of(self.0[0], other.0[0]), of(self.0[1], other.0[1])])
    }

    #[inline(always)]
    fn each<R>(self, of: impl Fn(T) -> R) -> Pair<R> {
        Pair([of(self.0[0]), of(self.0[1])])
    }
}

impl<T> Sealed for Pair<T> {}

/// Implements operators, word by word.
macro_rules! operators {
    ($($trait:ident, $method:ident;)+) => {$(
        impl<T: $trait<Output = T> + Copy> $trait for Pair<T> {
            type Output = Pair<T>;
            #[inline(always)]
            fn $method(self, other: Pair<T>) -> Pair<T> {
                self.with(other, |a, b| a.$method(b))
            }
        }
    )+};
}

operators! {
    Add, add;
    Sub, sub;
    Mul, mul;
    BitXor, bitxor;
    BitAnd, bitand;
}

impl<T: Shl<u32, Output = T> + Copy> Shl<u32> for Pair<T> {
    type Output = Pair<T>;
    #[inline(always)]
    fn shl(self, n: u32) -> Pair<T> {
        self.each(|a| a << n)
    }
}

impl<T: Shr<u32, Output = T> + Copy> Shr<u32> for Pair<T> {
    type Output = Pair<T>;
    #[inline(always)]
    fn shr(self, n: u32) -> Pair<T> {
        self.each(|a| a >> n)
    }
}

impl<T: Factor> Factor for Pair<T> {
    #[inline(always)]
    fn splat(x: u32) -> Pair<T> {
        Pair([T::splat(x); 2])
    }

    #[inline(always)]
    fn mulhilo(self, by: Pair<T>) -> (Pair<T>, Pair<T>) {
        let [(high_0, low_0), (high_1, low_1)] = self.with(by, T::mulhilo).0;
        (Pair([high_0, high_1]), Pair([low_0, low_1]))
    }
}

impl<W: Word> Word for Pair<W> {
    type Factors = Pair<W::Factors>;
    type Wide = Pair<W::Wide>;
    const LANES: usize = 2 * W::LANES;

    #[inline(always)]
    fn iota() -> Pair<W> {
        Pair([W::iota(), W::iota() + W::splat(W::LANES as u32)])
    }

    #[inline(always)]
    fn load(from: &[u32]) -> Pair<W> {
        Pair([W::load(from), W::load(&from[W::LANES..])])
    }

    #[inline(always)]
    fn store(self, to: &mut [u32]) {
        self.0[0].store(to);
        self.0[1].store(&mut to[W::LANES..]);
    }

    #[inline(always)]
    fn sar(self, n: u32) -> Pair<W> {
        self.each(|a| a.sar(n))
    }

    #[inline(always)]
    fn shift_left(self, n: Pair<W>) -> Pair<W> {
        self.with(n, W::shift_left)
    }

    #[inline(always)]
    fn shift_right(self, n: Pair<W>) -> Pair<W> {
        self.with(n, W::shift_right)
    }

    #[inline(always)]
    fn leading_zeros(self) -> Pair<W> {
        self.each(W::leading_zeros)
    }

    #[inline(always)]
    fn min_signed(self, other: Pair<W>) -> Pair<W> {
        self.with(other, W::min_signed)
    }

    #[inline(always)]
    fn max_signed(self, other: Pair<W>) -> Pair<W> {
        self.with(other, W::max_signed)
    }

    #[inline(always)]
    fn with_sign(self, sign: Pair<W>) -> Pair<W> {
        self.with(sign, W::with_sign)
    }

    #[inline(always)]
    fn mulhi(self, by: Pair<W>) -> Pair<W> {
        self.with(by, W::mulhi)
    }

    #[inline(always)]
    fn factors(self) -> Pair<W::Factors> {
        self.each(W::factors)
    }

    #[inline(always)]
    fn of_factors(factors: Pair<W::Factors>) -> Pair<W> {
        factors.each(W::of_factors)
    }

    #[inline(always)]
    unsafe fn lookup(table: &PairTable, index: Pair<W>) -> (Pair<W>, Pair<W>) {
        // SAFETY: guaranteed by the caller.
        let [(first_0, second_0), (first_1, second_1)] =
            index.each(|index| unsafe { W::lookup(table, index) }).0;
        (Pair([first_0, first_1]), Pair([second_0, second_1]))
    }

    #[inline(always)]
    unsafe fn gather(table: &[u32], index: Pair<W>) -> Pair<W> {
        // SAFETY: guaranteed by the caller.
        index.each(|index| unsafe { W::gather(table, index) })
    }

    #[inline(always)]
    fn mul_wide(self, by: Pair<W>) -> Pair<W::Wide> {
        self.with(by, W::mul_wide)
    }

    #[inline(always)]
    fn add_where_equal(self, more: Pair<W>, a: Pair<W>, b: Pair<W>) -> Pair<W> {
        let add = |k: usize| self.0[k].add_where_equal(more.0[k], a.0[k], b.0[k]);
        Pair([add(0), add(1)])
    }

    #[inline(always)]
    fn below(self, n: u32) -> u32 {
        self.0[0].below(n) | self.0[1].below(n) << W::LANES
    }
}

impl<V: Wide> Wide for Pair<V> {
    type Word = Pair<V::Word>;

    #[inline(always)]
    fn splat(x: i64) -> Pair<V> {
        Pair([V::splat(x); 2])
    }

    #[inline(always)]
    fn high_word(self) -> Pair<V::Word> {
        self.each(V::high_word)
    }

    #[inline(always)]
    fn bits_from(self, n: u32) -> Pair<V::Word> {
        self.each(|a| a.bits_from(n))
    }

    #[inline(always)]
    fn total_unsigned(self) -> u128 {
        self.0[0].total_unsigned() + self.0[1].total_unsigned()
    }

    #[inline(always)]
    fn halves(self) -> [Pair<V>; 2] {
        let [[low_0, high_0], [low_1, high_1]] = self.each(V::halves).0;
        [Pair([low_0, low_1]), Pair([high_0, high_1])]
    }

    #[inline(always)]
    fn store(self, to: &mut [u64]) {
        let half = to.len() / 2;
        let (first, second) = to.split_at_mut(half);
        self.0[0].store(first);
        self.0[1].store(second);
    }
}
