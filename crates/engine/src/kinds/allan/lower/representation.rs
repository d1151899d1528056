//! How far the expected estimates of the words may be off those of the inputs, and the check that they are not further.
//!
//! Each word is within half its unit of what it stands for. A part whose standard deviation is off by a fraction ε adds at
//! most var[(1 + ε)² − 1]; what moves the angle itself by a deviation of rms d adds 2·rms·d + d².

use core::f64::consts::{FRAC_1_SQRT_2, PI};

use crate::key::row::{Refusal, shown};
use crate::kinds::allan::lower::Records;
use crate::kinds::allan::lower::fixed::TURN;
use crate::kinds::allan::lower::model::{Markov, Noise, Sine, reach};
use crate::kinds::allan::lower::physical_theory::PhysicalTheory;
use crate::kinds::allan::lower::theory::Theory;
use crate::sampling;
use sagnac_base::quantity::number::significant;
use sagnac_theory::allan::quantizer;

/// Largest rounding of an angle of the table of drift, LSB: half a unit, and that of the sums in floating point.
const DRIFT_ROUNDING: f64 = 0.51;

impl Records {
    /// Relative difference of a theoretical value at `ms()[at]` from the closed form of the inputs, where there is one.
    ///
    /// # Errors
    /// The difference exceeds what the rounding of words explains.
    pub(crate) fn representation(
        &self,
        at: usize,
        theory: &Theory,
        physical: &PhysicalTheory,
    ) -> Result<Option<f64>, Refusal> {
        let m = self.ms()[at];
        let Some((words, inputs)) = theory.value.zip(physical.variance(m)) else { return Ok(None) };
        let most = theory.representation + inputs.error;
        let off = (words - inputs.value).abs();
        if off > most || off.is_nan() {
            let found = format!(
                "the variance at an averaging time of {} s is {} (arcsec/s)^2 for the integers that would be sampled and {} \
                 (arcsec/s)^2 for the inputs, which rounding to {} does not explain",
                significant(self.sample_s * m as f64, 6),
                shown(words),
                shown(inputs.value),
                shown(most)
            );
            let help = "this is a fault of the program: please report the study";
            return Err(Refusal::new("noise", found, help));
        }
        Ok(sampling::representation(Some(words), Some(inputs.value), most))
    }

    /// Bound of the deviation of the mean square at `m` except that of the readout, where the mean square of what all
    /// records share is `trend`, LSB².
    pub(crate) fn representation_bound(&self, m: u64, trend: f64) -> f64 {
        let (fixed, difference) = (&self.fixed, self.estimator.difference);
        let off = |mean_square: f64, d: f64| 2.0 * libm::sqrt(mean_square) * d + d * d;
        let deviation = fixed.deviation();
        let mut sum = deviation.variance(difference, m);
        if let Some((markov, decays)) = fixed.noise().markov.zip(fixed.decays()) {
            let alone = |decay: f64| {
                let markov = Some(Markov { decay, ..markov });
                Noise { quantization: 0.0, white: 0.0, octaves: vec![], walk: 0.0, markov }
                    .variance(difference, m)
            };
            let own = alone(markov.decay);
            // Half a unit is so little that the variance is a line, but for the higher orders in 1/loss.
            sum += 2.0 * decays.map(|decay| libm::fabs(alone(decay) - own)).into_iter().fold(0.0, libm::fmax);
        }
        if let Some(jumps) = fixed.jumps() {
            let variance = jumps.mean_square(self.estimator, self.recipe.samples.into(), m);
            sum += fixed.jumps_deviation() * variance;
        }
        if let Some(sine) = fixed.wave() {
            let spans = difference.spans() as f64;
            let variance = sine.part().map_or(0.0, |part| part.variance(difference, 1.0, m));
            let [amplitude, turns] = fixed.wave_deviation();
            // The difference of a unit amplitude is |2 sin πfm|^spans.
            let d = FRAC_1_SQRT_2
                * (amplitude * Sine { amplitude: 1.0, ..sine }.largest(difference, m)
                    + (sine.amplitude + amplitude)
                        * spans
                        * libm::exp2(spans - 1.0)
                        * 2.0
                        * PI
                        * m as f64
                        * turns);
            sum += off(variance, d);
        }
        if !self.recipe.drift.is_empty() {
            sum += off(trend, DRIFT_ROUNDING * reach(difference));
        }
        sum
    }

    /// Bound of the deviation of the contribution of reading whole pulses, LSB², where the products of the coefficients of
    /// a difference add up to `pairs` in magnitude.
    pub(crate) fn readout_bound(&self, pulse: f64, pairs: f64, m: u64) -> f64 {
        let (fixed, difference) = (&self.fixed, self.estimator.difference);
        let samples = (difference.spans() * m) as f64;
        let of_noise = |noise: &Noise| quantizer::noise_variance(&noise.simple(), difference.spans() * m);
        let noise = fixed.noise();
        let [amplitude, turns] = fixed.wave_deviation();
        let of_sine = fixed
            .wave()
            .map_or(0.0, |sine| 2.0 * amplitude + (sine.amplitude + amplitude) * 2.0 * PI * samples * turns);
        // The covariance of two errors changes by at most half a pulse per LSB of the angle between them.
        let between = fixed.simple_deviation() * libm::sqrt(of_noise(&noise))
            + libm::sqrt(of_noise(&fixed.deviation()))
            + of_sine
            + 0.5 * samples / TURN
            // Both sides take the angle between two readings in f64.
            + 32.0 * f64::EPSILON * libm::fabs(fixed.rate.cast_signed() as f64 / TURN) * samples;
        // Both are that near to white noise.
        let white = 2.0 * quantizer::white_error(pulse, &fixed.less().simple(), difference, m);
        libm::fmin(0.5 * pairs * pulse * between, white)
    }
}
