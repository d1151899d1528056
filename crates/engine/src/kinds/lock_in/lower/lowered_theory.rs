//! The angle random walk in closed form from the words of the kernel, beside that of the physical inputs.
//!
//! Words are read as the kernel uses them: the lock-in of a step at a quarter turn, the number of steps of a half-cycle and of a
//! sample, the amplitude of the dither and the noise of the beam. Time is that of the samples, and angles are in the LSB of the
//! table. None of what lowering computed on the way to the words is used.

use core::f64::consts::TAU;

use crate::key::row::{Refusal, shown};
use crate::kinds::lock_in::inputs::THRESHOLD;
use crate::kinds::lock_in::point::Times;
use sagnac_kernel::lock_in::{LockIn as Recipe, ROUND};
use sagnac_theory::lock_in::LockIn;

/// Relative error of the polynomial at a quarter turn, 2^−19.7, and of the steps of a sample, whose last bit is 2^−32 rounds.
const POLYNOMIAL: f64 = 1.3e-6;

/// N of the words, ″/√s, with the bound of its deviation from that of the inputs due to the rounding of words.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct LoweredTheory {
    pub(crate) walk: f64,
    pub(crate) bound: f64,
}

impl LoweredTheory {
    /// The theory of a gyro with dither, whose angles have the LSB `lsb_arcsec`.
    pub(crate) fn new(recipe: &Recipe, times: &Times, lsb_arcsec: f64) -> LoweredTheory {
        let [fraction, whole] = recipe.interval.map(f64::from);
        let steps = f64::from(recipe.samples) * (whole + fraction / WORD) * ROUND as f64;
        let step_s = times.samples as f64 * times.sample_s / steps;
        let half_s = f64::from(recipe.half) * ROUND as f64 * step_s;
        // ″ of a unit of the lock-in and of a turn.
        let unit = lsb_arcsec / libm::exp2(f64::from(recipe.lsb));
        let turn = unit * libm::exp2(32.0 + f64::from(recipe.fine));
        let kick = kick(recipe);
        let dither_frequency = 0.5 / half_s;
        let amplitude = turn * f64::from(recipe.amplitude) / libm::exp2(f64::from(recipe.amplitude_bits));
        let gyro = LockIn {
            threshold: kick * unit / step_s,
            scale_factor: turn,
            dither_rate: TAU * dither_frequency * amplitude,
            dither_frequency,
        };
        // A unit of the word of the beam's noise.
        let of_beam = unit / 16.0 / libm::sqrt(half_s);
        let (lock_in, beam) = (gyro.angle_random_walk(), of_beam * f64::from(recipe.beam));
        // N ∝ c/√A, for the half units of c's terms and of A, which has at least 2^11 units.
        let of_kick = KICK_ROUNDING / kick + POLYNOMIAL;
        let of_amplitude = 0.2501 / f64::from(recipe.amplitude);
        let of_lock_in = (1.0 + of_kick) * (1.0 + of_amplitude) - 1.0;
        LoweredTheory { walk: libm::hypot(lock_in, beam), bound: lock_in * of_lock_in + 0.5 * of_beam }
    }

    /// # Errors
    /// N differs from `physical`, that of the inputs, by more than the rounding of words explains.
    pub(crate) fn check(&self, physical: f64) -> Result<(), Refusal> {
        // A difference that is not a number is refused.
        if (self.walk - physical).abs() <= self.bound {
            return Ok(());
        }
        let found = format!(
            "the angle random walk is {} arcsec/sqrt(s) for the integers that would be sampled and {} arcsec/sqrt(s) for the \
             inputs, which rounding to {} arcsec/sqrt(s) does not explain",
            shown(self.walk),
            shown(physical),
            shown(self.bound)
        );
        Err(Refusal::new(THRESHOLD.name, found, "this is a fault of the program: please report the study"))
    }
}

/// 2^32.
const WORD: f64 = 4_294_967_296.0;

/// Half a unit of each word of [`kick`].
const KICK_ROUNDING: f64 = 0.25 * (1.0 + 1.0 / 4.0 + 1.0 / 16.0 + 1.0 / 64.0);

/// The lock-in of a step at a quarter turn, in its unit: the kernel's polynomial at z = 2^31, where the word of z² is a quarter of a
/// whole one and that of z half of one.
fn kick(recipe: &Recipe) -> f64 {
    0.5 * recipe.kick.iter().rev().fold(0.0, |sum, word| f64::from(*word) - 0.25 * sum)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::key::row::Streams;
    use crate::kinds::lock_in::lower::{Gyros, theory};
    use crate::kinds::lock_in::verify::checked;
    use crate::kinds::lock_in::{Dither, Inputs, Point};
    use sagnac_theory::allan::Estimator;

    /// The words are those of one gyro and the inputs those of another.
    #[test]
    fn words_that_do_not_stand_for_an_input_are_refused_by_name() {
        let point = |inputs: Inputs| {
            let times = Times { sample_s: 0.0025, periods: 1, samples: 4000, ms: vec![1] };
            Point { swept: vec![], inputs, times }
        };
        // Noise of the beam as large as that of lock-in.
        let inputs = Inputs { beam_noise: 0.17, ..checked() };
        let own = point(inputs.clone());
        let gyros = Gyros::new(&own, Estimator::OVERLAPPING, 1, Streams::Independent).unwrap();
        let lowered = LoweredTheory::new(gyros.recipe(), &own.times, gyros.lsb_arcsec());
        let checked = |inputs: Inputs| lowered.check(theory::angle_random_walk(&point(inputs)).unwrap());
        assert_eq!(checked(inputs.clone()), Ok(()));
        let with = |change: fn(&mut Dither)| {
            let mut inputs = inputs.clone();
            inputs.dither.as_mut().into_iter().for_each(change);
            inputs
        };
        let most = 2.0 * lowered.bound / lowered.walk;
        assert!(most < 1e-3, "{most}");
        let changed = [
            ("threshold", Inputs { threshold: 180.0 * 1.002, ..inputs.clone() }),
            ("scale factor", Inputs { scale_factor: 2.0 * 1.004, ..inputs.clone() }),
            ("noise of the beam", Inputs { beam_noise: 0.17 * 1.002, ..inputs.clone() }),
            ("dither rate", with(|dither| dither.rate *= 1.004)),
        ];
        for (name, inputs) in changed {
            let refused = checked(inputs).map_err(|refusal| refusal.key);
            assert_eq!(refused, Err("lock_in.threshold"), "{name}");
        }
    }
}
