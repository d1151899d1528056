//! Sine of a phase in turns by an integer polynomial of six terms.
//!
//! Twin of `shaders/sine.wgsl`. The phase is a word in units of 2^−32 turns; it wraps by itself and needs no range
//! reduction. The error is below 2^−29.5 everywhere, and the result is exact at 0, ¼ and ½ turn (`docs/dev/numerics.md`).

use crate::map::{Block, Map};
use crate::shader::{Part, constants};
use crate::word::Word;
use crate::{Form, part};

constants!(QUARTER_TURN, SINE);

/// Maps a phase to its sine.
pub const FORM: Form = Form::Map(Map::of::<Sine>());

struct Sine;

impl Block for Sine {
    const PART: &'static Part = &part::sine;
    const INPUTS: usize = 1;
    const OUTPUTS: usize = 1;
    const WGSL: &'static str = "y[0] = sine(x[0]);";
    // Only here: the shader's version is generated.
    #[inline(always)]
    fn evaluate<W: Word>(x: [W; 6]) -> [W; 4] {
        [sine(x[0]); 4]
    }
}

/// The sine of a quarter turn: results are in units of 2^−30.
pub const ONE: u32 = 1 << 30;

/// A quarter of a turn, in the units of the phase.
pub const QUARTER_TURN: u32 = 1 << 30;

/// sin(πz/2)/z = S₀ − z²(S₁ − z²(S₂ − …)) for z in [0, 1]; S_k in units of 2^−(31+k).
pub const SINE: [u32; 6] = [3_373_259_426, 2_774_394_665, 684_554_253, 80_430_267, 5_506_306, 235_831];

/// The sine of `phase`, in units of 2^−30; the cosine is the sine a quarter turn ahead.
#[inline(always)]
pub fn sine<W: Word>(phase: W) -> W {
    let half = phase << 1;
    let mirror = half.sar(31);
    let z = (half ^ mirror) - mirror;
    sine_ratio(z).mulhi(z).with_sign(phase)
}

/// sin(πz/2)/z, in units of 2^−31, for z from 0 to 2^31 in the same units: π/2 · sinc of half of z.
#[inline(always)]
pub(crate) fn sine_ratio<W: Word>(z: W) -> W {
    let zz = z.mulhi(z) << 1;
    let mut sum = W::splat(SINE[5]);
    sum = W::splat(SINE[4]) - sum.mulhi(zz);
    sum = W::splat(SINE[3]) - sum.mulhi(zz);
    sum = W::splat(SINE[2]) - sum.mulhi(zz);
    sum = W::splat(SINE[1]) - sum.mulhi(zz);
    W::splat(SINE[0]) - sum.mulhi(zz)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::polynomial::through_chebyshev_points;
    use crate::word::Scalar;

    /// The polynomial in z² through sin(πz/2)/z.
    fn regenerated() -> [u32; 6] {
        let ratio = |zz: f64| libm::sin(libm::sqrt(zz) * core::f64::consts::FRAC_PI_2) / libm::sqrt(zz);
        let polynomial = through_chebyshev_points::<6>(ratio);
        core::array::from_fn(|k| libm::round(libm::fabs(polynomial[k]) * libm::exp2(31.0 + k as f64)) as u32)
    }

    #[test]
    fn the_committed_coefficients_are_those_of_their_formula() {
        assert_eq!(regenerated(), SINE);
    }

    #[test]
    fn quarter_turns_are_exact() {
        for (phase, expected) in [(0, 0), (1 << 30, 1 << 30), (1 << 31, 0), (3 << 30, -(1 << 30))] {
            assert_eq!(sine(Scalar(phase)).0 as i32, expected, "phase {phase:#x}");
        }
    }

    #[test]
    fn the_error_stays_below_its_bound() {
        let unit = f64::from(ONE);
        for k in 0..200_000_u32 {
            let phase = k.wrapping_mul(0x9E37_79B9);
            let exact = libm::sin(f64::from(phase) / libm::exp2(32.0) * 2.0 * core::f64::consts::PI);
            let error = f64::from(sine(Scalar(phase)).0 as i32) / unit - exact;
            assert!(error.abs() < libm::exp2(-29.5), "phase {phase:#x}: error 2^{}", libm::log2(error.abs()));
        }
    }
}
