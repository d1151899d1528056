//! How far the rms of an error for the lowered words may be off that for the inputs, and the check that it is not further.
//!
//! Each word is within half its unit of what it stands for, and so is each weight.

use core::f64::consts::{FRAC_1_SQRT_2, PI};

use crate::key::row::{Refusal, shown};
use crate::kinds::allan::lower::fixed::Fixed;
use crate::kinds::navigation::lower::physical_theory::PhysicalTheory;
use crate::kinds::navigation::lower::{Lowered, LoweredGyro};
use crate::sampling;
use sagnac_theory::navigation::covariance::{Noise, of_angles};

/// Largest rounding of an angle common to all records, LSB: that of the angle, and that of the rate of a warm-up.
const DRIFT_ROUNDING: f64 = 1.01;
/// Error of both closed forms in floating point, relative.
const SUM_ERROR: f64 = 1e-9;

/// Bounds of the deviation of the random parts of the words from those of the inputs, in LSB and samples.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Deviation {
    /// The parts by which variances may be off.
    noise: Noise,
    /// Decays of Markov noise whose loss has half a unit less and more than the word.
    decays: Option<[f64; 2]>,
    /// Deviation of the amplitude of a sine, and of its turns per sample.
    sine: [f64; 2],
}

impl Deviation {
    /// The bounds for some words.
    pub(crate) fn of(fixed: &Fixed) -> Deviation {
        let off = fixed.deviation();
        // Every angle is rounded down to whole LSB.
        let rounded = if fixed.has_angle() { 1.0 / 12.0 } else { 0.0 };
        let jumps = fixed.jumps();
        Deviation {
            noise: Noise {
                errors: libm::sqrt(off.quantization * off.quantization + rounded),
                white: off.white,
                octaves: off.octaves,
                walk: off.walk,
                markov: off.markov.map(|markov| [markov.sigma, markov.decay]),
                sine: None,
                jumps: jumps.map(|jumps| (jumps.interval as usize, fixed.jumps_deviation() * jumps.variance)),
            },
            decays: fixed.decays(),
            sine: fixed.wave_deviation(),
        }
    }
}

/// Bounds of the deviation of an error.
#[derive(Debug, Clone, Copy, Default)]
struct Off {
    /// Rms of a deviation of the error.
    rms: f64,
    /// Deviation of its variance.
    variance: f64,
}

impl LoweredGyro {
    /// The bounds for an error with these weights per LSB, in its unit.
    fn off(&self, error: usize, weights: &[f64]) -> Off {
        let Deviation { noise, decays, sine: [amplitude_off, turns_off] } = &self.deviation;
        let angles = of_angles(weights);
        let mut variance = noise.covariance(weights, weights);
        if let Some(([sigma, decay], decays)) = self.noise.markov.zip(*decays) {
            let alone = |decay: f64| {
                Noise { markov: Some([sigma, decay]), ..Noise::default() }.covariance(weights, weights)
            };
            let own = alone(decay);
            // Half a unit is so little that the variance is a line, but for the higher orders in 1/loss.
            variance +=
                2.0 * decays.map(|decay| libm::fabs(alone(decay) - own)).into_iter().fold(0.0, libm::fmax);
        }
        // Each weight is off by up to half a unit.
        let mut rms = 0.5 * self.units[error] * self.increments(weights.len());
        if let Some([amplitude, turns]) = self.noise.sine {
            let one = Noise { sine: Some([1.0, turns]), ..Noise::default() }.covariance(weights, weights);
            let turned =
                angles.iter().enumerate().map(|(k, weight)| k as f64 * libm::fabs(*weight)).sum::<f64>();
            rms += amplitude_off * libm::sqrt(one)
                + FRAC_1_SQRT_2 * (amplitude + amplitude_off) * 2.0 * PI * turns_off * turned;
        }
        if !self.navigation.recipe().drift.is_empty() {
            rms += DRIFT_ROUNDING * angles.iter().map(|weight| libm::fabs(*weight)).sum::<f64>();
        }
        Off { rms, variance }
    }

    /// Bound of the sum of the rms of all increments of the angle, LSB.
    fn increments(&self, samples: usize) -> f64 {
        let Noise { errors, white, octaves, walk, markov, sine, jumps } = &self.noise;
        let square = 2.0 * errors * errors
            + white * white
            + octaves.iter().map(|sigma| sigma * sigma).sum::<f64>()
            + walk * walk * samples as f64
            + markov.map_or(0.0, |[sigma, _]| sigma * sigma)
            + sine.map_or(0.0, |[amplitude, _]| 2.0 * amplitude * amplitude)
            + jumps.map_or(0.0, |(_, variance)| variance);
        let step = |pair: &[u32]| f64::from((pair[1].wrapping_sub(pair[0]) as i32).unsigned_abs());
        let shared: f64 = self.navigation.recipe().drift.windows(2).map(step).sum();
        samples as f64 * libm::sqrt(square) + shared
    }
}

impl Lowered {
    /// Bound of the deviation of the rms of some errors together, `rms` in closed form, from that of the inputs.
    pub(crate) fn representation_bound(&self, errors: &[usize], rms: f64) -> f64 {
        let of_set = |gyros: &[LoweredGyro]| {
            let mut all = Off::default();
            for &error in errors {
                let of_gyros = gyros.iter().map(|gyro| gyro.off(error, &gyro.weights_of(error)));
                let one = of_gyros.fold(Off::default(), |sum, one| Off {
                    rms: sum.rms + one.rms,
                    variance: sum.variance + one.variance,
                });
                all = Off { rms: libm::hypot(all.rms, one.rms), variance: all.variance + one.variance };
            }
            all
        };
        let sets: Vec<Off> = self.gyros.chunks(self.of_set).map(of_set).collect();
        let largest = sets.iter().map(|off| off.rms).fold(0.0, libm::fmax);
        let variance = sets.iter().map(|off| off.variance).sum::<f64>() / sets.len() as f64;
        // |√a − √b| is at most |a − b|/√a, and at most √|a − b|.
        let of_variance = libm::sqrt(variance).min(variance / rms);
        largest + of_variance + SUM_ERROR * rms
    }

    /// Relative difference of the rms of some errors together, `rms` in closed form, from that of the inputs.
    ///
    /// # Errors
    /// The difference exceeds what the rounding of words explains.
    pub(crate) fn representation(
        &self,
        errors: &[usize],
        rms: f64,
        physical: &PhysicalTheory,
    ) -> Result<Option<f64>, Refusal> {
        let (inputs, most) = (physical.rms(errors), self.representation_bound(errors, rms));
        let off = (rms - inputs).abs();
        if off > most || off.is_nan() {
            let found = format!(
                "the error {:?} is {} rms for the integers that would be sampled and {} for the inputs, in \u{2033}, m/s or m, \
                 which rounding to {} does not explain",
                self.errors[errors[0]],
                shown(rms),
                shown(inputs),
                shown(most)
            );
            let help = "this is a fault of the program: please report the study";
            return Err(Refusal::new("noise", found, help));
        }
        Ok(sampling::representation(Some(rms), Some(inputs), most))
    }
}
