//! Numbers of twice the precision of `f64`, for sums whose terms cancel.
//!
//! A number is the unevaluated sum of two `f64`. Sums and products are those of Dekker (1971) and Knuth, without fused
//! operations, so the bits are the same on every machine. A sum is wrong by at most 2^−103 of its
//! larger term, a product by 2^−102 of itself, unless numbers underflow.

use core::ops::{Add, Mul, Sub};

/// hi + lo, with |lo| at most half a unit in the last place of hi.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Double {
    hi: f64,
    lo: f64,
}

/// 2^27 + 1, which splits the 53 bits of an `f64` into halves.
const SPLIT: f64 = 134_217_729.0;

impl Double {
    /// The exact product of two numbers below 2^996 in magnitude.
    pub fn product(a: f64, b: f64) -> Double {
        let hi = a * b;
        let ([a1, a2], [b1, b2]) = (halves(a), halves(b));
        Double { hi, lo: ((a1 * b1 - hi) + a1 * b2 + a2 * b1) + a2 * b2 }
    }

    /// The nearest `f64`.
    pub fn value(self) -> f64 {
        self.hi
    }

    /// hi + lo for |hi| ≥ |lo|.
    fn of_sorted(hi: f64, lo: f64) -> Double {
        let sum = hi + lo;
        Double { hi: sum, lo: lo - (sum - hi) }
    }
}

/// The upper and lower half of the bits of a number.
fn halves(x: f64) -> [f64; 2] {
    let scaled = SPLIT * x;
    let upper = scaled - (scaled - x);
    [upper, x - upper]
}

impl From<f64> for Double {
    fn from(hi: f64) -> Double {
        Double { hi, lo: 0.0 }
    }
}

impl From<i128> for Double {
    /// The nearest number; exact up to 2^106.
    fn from(x: i128) -> Double {
        let hi = x as f64;
        Double { hi, lo: (x - hi as i128) as f64 }
    }
}

impl Add for Double {
    type Output = Double;

    fn add(self, other: Double) -> Double {
        let sum = self.hi + other.hi;
        let part = sum - self.hi;
        let lost = (self.hi - (sum - part)) + (other.hi - part);
        Double::of_sorted(sum, lost + self.lo + other.lo)
    }
}

impl Sub for Double {
    type Output = Double;

    fn sub(self, other: Double) -> Double {
        self + Double { hi: -other.hi, lo: -other.lo }
    }
}

impl Mul for Double {
    type Output = Double;

    fn mul(self, other: Double) -> Double {
        let Double { hi, lo } = Double::product(self.hi, other.hi);
        Double::of_sorted(hi, lo + (self.hi * other.lo + self.lo * other.hi))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sums_and_products_keep_thirty_digits() {
        // (1 + 2^−40)(1 − 2^−40) = 1 − 2^−80.
        let tiny = libm::exp2(-40.0);
        let product = Double::product(1.0 + tiny, 1.0 - tiny);
        assert_eq!((product - Double::from(1.0)).value(), -libm::exp2(-80.0));
        let third = Double::from(1.0 / 3.0);
        let rest = Double::from(1.0) - third * Double::from(3.0);
        // The f64 nearest to a third is too small by 2^−54/3.
        assert_eq!(rest.value(), libm::exp2(-54.0));
        let large = (1_i128 << 100) + 1;
        assert_eq!((Double::from(large) - Double::from(1_i128 << 100)).value(), 1.0);
        let square = (third + Double::from(tiny)) * (third - Double::from(tiny));
        let expected = third * third - Double::from(tiny) * Double::from(tiny);
        assert!((square - expected).value().abs() < libm::exp2(-102.0));
    }
}
