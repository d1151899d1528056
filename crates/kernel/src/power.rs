//! Logarithms and powers to base 2 by integer polynomials.
//!
//! Twin of `shaders/power.wgsl`. An exponential e^{−t/τ} is 2^{−t·log2(e)/τ}, whose exponent is a fixed-point number;
//! its whole part is a shift. The error of the logarithm is between −2^−25.9 and 2^−30, that of the power below 2^−30;
//! both are exact at the powers of two (`docs/dev/numerics.md`).

use crate::map::{Block, Map};
use crate::shader::{Part, constants};
use crate::word::Word;
use crate::{Form, part};

constants!(LOG_BITS, MAX_MINUS, EXP2_ONE, LOG2, EXP2);

/// Maps a number to its logarithm, a fraction to its power and an exponent to its power.
pub const FORM: Form = Form::Map(Map::of::<Power>());

struct Power;

impl Block for Power {
    const PART: &'static Part = &part::power;
    const INPUTS: usize = 1;
    const OUTPUTS: usize = 3;
    const WGSL: &'static str = "y[0] = log2_word(max(x[0], 1u)); y[1] = exp2_fraction(x[0]); \
                                y[2] = exp2_minus(min(x[0] >> 1u, MAX_MINUS));";
    // Only here: the shader's version is generated.
    #[inline(always)]
    fn evaluate<W: Word>(x: [W; 6]) -> [W; 4] {
        // 0 has no logarithm; it is replaced by 1.
        let some = x[0].add_where_equal(W::splat(1), x[0], W::splat(0));
        let minus = (x[0] >> 1).min_signed(W::splat(MAX_MINUS));
        [log2_word(some), exp2_fraction(x[0]), exp2_minus(minus), x[0]]
    }
}

/// Fractional bits of a logarithm.
pub(crate) const LOG_BITS: u32 = 26;

/// The largest number that [`exp2_minus`] takes: 31.
pub(crate) const MAX_MINUS: u32 = 31 << LOG_BITS;

/// 1 in the unit of powers.
pub(crate) const EXP2_ONE: u32 = 1 << 31;

/// (log2(1+u) − u)/(u(1 − u)) = L₀ − u(L₁ − u(L₂ − …)) for u in [0, 1]; in units of 2^−32.
pub(crate) const LOG2: [u32; 10] = [
    1_901_360_707,
    1_196_800_156,
    868_533_718,
    679_031_022,
    548_994_830,
    433_096_715,
    301_886_450,
    162_293_311,
    56_438_408,
    9_189_629,
];

/// (1 + u − 2^u)/(u(1 − u)) = E₀ + u(E₁ + u(E₂ + …)) for u in [0, 1]; in units of 2^−32.
pub(crate) const EXP2: [u32; 6] = [1_317_922_820, 286_158_105, 47_766_341, 6_473_286, 708_058, 93_032];

/// The logarithm of `x` ≥ 1, read as unsigned: in units of 2^−26, from 0 to below 32.
#[inline(always)]
pub(crate) fn log2_word<W: Word>(x: W) -> W {
    let octave = x.leading_zeros();
    let u = x.shift_left(octave) << 1;
    let mut sum = W::splat(LOG2[9]);
    sum = W::splat(LOG2[8]) - sum.mulhi(u);
    sum = W::splat(LOG2[7]) - sum.mulhi(u);
    sum = W::splat(LOG2[6]) - sum.mulhi(u);
    sum = W::splat(LOG2[5]) - sum.mulhi(u);
    sum = W::splat(LOG2[4]) - sum.mulhi(u);
    sum = W::splat(LOG2[3]) - sum.mulhi(u);
    sum = W::splat(LOG2[2]) - sum.mulhi(u);
    sum = W::splat(LOG2[1]) - sum.mulhi(u);
    sum = W::splat(LOG2[0]) - sum.mulhi(u);
    let fraction = u + between(u).mulhi(sum);
    // Floored, because rounding could reach 32 and thereby the sign bit.
    ((W::splat(31) - octave) << LOG_BITS) + (fraction >> (32 - LOG_BITS))
}

/// 2^u for a fraction u in units of 2^−32: in units of 2^−31, from 2^31 to below 2^32.
#[inline(always)]
pub(crate) fn exp2_fraction<W: Word>(u: W) -> W {
    let mut sum = W::splat(EXP2[5]);
    sum = W::splat(EXP2[4]) + sum.mulhi(u);
    sum = W::splat(EXP2[3]) + sum.mulhi(u);
    sum = W::splat(EXP2[2]) + sum.mulhi(u);
    sum = W::splat(EXP2[1]) + sum.mulhi(u);
    sum = W::splat(EXP2[0]) + sum.mulhi(u);
    W::splat(EXP2_ONE) + ((u - between(u).mulhi(sum)) >> 1)
}

/// 2^−x for x in units of 2^−26, from 0 to [`MAX_MINUS`]: in units of 2^−31, floored.
#[inline(always)]
pub(crate) fn exp2_minus<W: Word>(x: W) -> W {
    let whole = (x + W::splat((1 << LOG_BITS) - 1)) >> LOG_BITS;
    exp2_fraction((W::splat(0) - x) << (32 - LOG_BITS)).shift_right(whole)
}

/// u(1 − u) for a fraction u: at most ¼, and 0 at both ends, so that neighbouring octaves meet.
#[inline(always)]
fn between<W: Word>(u: W) -> W {
    u.mulhi(u ^ W::splat(!0))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::philox::{philox, schedule};
    use crate::polynomial::through_chebyshev_points;
    use crate::word::Scalar;

    fn words<const N: usize>(polynomial: [f64; N]) -> [u32; N] {
        polynomial.map(|coefficient| libm::round(libm::fabs(coefficient) * libm::exp2(32.0)) as u32)
    }

    #[test]
    fn the_committed_coefficients_are_those_of_their_formulas() {
        let log2 = |u: f64| (libm::log1p(u) / core::f64::consts::LN_2 - u) / (u * (1.0 - u));
        let exp2 = |u: f64| (1.0 + u - libm::exp2(u)) / (u * (1.0 - u));
        assert_eq!(words(through_chebyshev_points(log2)), LOG2);
        assert_eq!(words(through_chebyshev_points(exp2)), EXP2);
    }

    #[test]
    fn powers_of_two_are_exact() {
        for k in 0..32 {
            assert_eq!(log2_word(Scalar(1 << k)).0, k << LOG_BITS, "log2 of 2^{k}");
            assert_eq!(exp2_minus(Scalar(k << LOG_BITS)).0, 1 << (31 - k), "2^-{k}");
        }
        assert_eq!(exp2_fraction(Scalar(0)).0, 1 << 31);
    }

    /// Least and greatest of a set of errors.
    #[derive(Debug, Clone, Copy)]
    struct Range(f64, f64);

    impl Range {
        const EMPTY: Range = Range(f64::INFINITY, f64::NEG_INFINITY);
        fn add(&mut self, error: f64) {
            *self = Range(self.0.min(error), self.1.max(error));
        }
    }

    /// Random words, the same in every run.
    fn random(count: u32) -> impl Iterator<Item = u32> {
        let keys = schedule([Scalar(5); 2]);
        (0..count).flat_map(move |n| philox([n, 0, 0, u32::MAX].map(Scalar), keys).map(|word| word.0))
    }

    #[test]
    fn the_logarithm_stays_within_its_bounds_in_all_octaves() {
        let mut range = Range::EMPTY;
        let mut check = |x: u32| {
            range.add(f64::from(log2_word(Scalar(x)).0) / libm::exp2(26.0) - libm::log2(f64::from(x)));
        };
        for octave in 0..32 {
            let end = ((1_u64 << (octave + 1)) - 1) as u32;
            for step in 0..1 << octave.min(15) {
                check((1 << octave) + step);
                check(end - step);
            }
        }
        random(1 << 20).enumerate().for_each(|(n, word)| check((word >> (n % 32)).max(1)));
        println!("log2: error {:.4e} … 2^{:.3}", range.0 * libm::exp2(26.0), libm::log2(range.1));
        assert!(-1.08 * libm::exp2(-26.0) < range.0 && range.1 < libm::exp2(-30.0), "{range:?}");
    }

    #[test]
    fn the_power_stays_within_its_bound() {
        let mut range = Range::EMPTY;
        let mut check = |u: u32| {
            let exact = libm::exp2(f64::from(u) / libm::exp2(32.0));
            range.add(f64::from(exp2_fraction(Scalar(u)).0) / libm::exp2(31.0) - exact);
        };
        (0..1 << 16).for_each(|step: u32| {
            check(step);
            check(!step);
        });
        random(1 << 20).for_each(&mut check);
        println!("exp2: error −2^{:.3} … 2^{:.3}", libm::log2(-range.0), libm::log2(range.1));
        assert!(-libm::exp2(-30.0) < range.0 && range.1 < libm::exp2(-30.0), "{range:?}");
    }

    #[test]
    fn powers_of_negative_numbers_are_floored_to_their_unit() {
        for word in random(1 << 18).chain([0, 1, 2, (1 << 27) + 1]) {
            let x = (word >> 1).min(MAX_MINUS);
            let exact = libm::exp2(-f64::from(x) / libm::exp2(26.0));
            let error = f64::from(exp2_minus(Scalar(x)).0) / libm::exp2(31.0) - exact;
            // Twice the exact value is at least the power of the fraction.
            let bound = libm::exp2(-30.0) * exact;
            assert!((-bound - libm::exp2(-31.0)..bound).contains(&error), "{x}: error {error}");
        }
    }

    #[test]
    fn neither_goes_back_by_more_than_a_unit() {
        for start in random(1 << 16) {
            for (x, step) in (0..16).map(|step| ((start & !15).max(16) + step, step)).take(15) {
                let (here, next) = (log2_word(Scalar(x)).0, log2_word(Scalar(x + 1)).0);
                assert!(next + 1 >= here, "log2 of {x}: {here}, then {next}");
                let u = (start & !15) + step;
                let (here, next) = (exp2_fraction(Scalar(u)).0, exp2_fraction(Scalar(u + 1)).0);
                assert!(next + 1 >= here, "2^{u}: {here}, then {next}");
            }
        }
    }
}
