//! The distribution of the errors of a navigator in closed form, for the lowered words: wᵀCw with the whole weights.
//!
//! All parts are normal except sines and the part D sin φ of fill residuals. Mean and covariance hold for these too, and
//! their sum over many switches is nearly normal.

use rayon::prelude::*;

use crate::kinds::allan::lower::fixed::Fixed;
use crate::kinds::navigation::lower::{Lowered, LoweredGyro, ROUNDINGS};
use sagnac_theory::navigation::covariance::{Noise, of_angles};
use sagnac_theory::navigation::radial::Radial;

/// The random parts of the lowered words, in LSB and samples.
pub(crate) fn noise(fixed: &Fixed) -> Noise {
    let noise = fixed.noise();
    // Every angle is rounded down to whole LSB.
    let rounded = if fixed.has_angle() { 1.0 / 12.0 } else { 0.0 };
    Noise {
        errors: libm::sqrt(noise.quantization * noise.quantization + rounded),
        white: noise.white,
        octaves: noise.octaves,
        walk: noise.walk,
        markov: noise.markov.map(|markov| [markov.sigma, markov.decay]),
        sine: fixed.wave().map(|sine| [sine.amplitude, sine.turns]),
        jumps: fixed.jumps().map(|jumps| (jumps.interval as usize, jumps.variance)),
    }
}

impl LoweredGyro {
    /// The weights of an error, in its unit per LSB.
    pub(crate) fn weights_of(&self, error: usize) -> Vec<f64> {
        self.weights[error].iter().map(|weight| f64::from(*weight) * self.units[error]).collect()
    }

    /// The mean of an error: that of the angles common to all records.
    fn mean(&self, weights: &[f64]) -> f64 {
        let drift = &self.navigation.recipe().drift;
        let step = |pair: &[u32]| f64::from(pair[1].wrapping_sub(pair[0]) as i32);
        drift.windows(2).zip(weights).map(|(pair, weight)| step(pair) * weight).sum()
    }
}

impl Lowered {
    /// The distribution of an error, or of two together, for each set of coefficients.
    pub fn distributions(&self, errors: &[usize]) -> Vec<Radial> {
        let of_set = |gyros: &[LoweredGyro]| {
            let (mut mean, mut covariance) = ([0.0; 2], [0.0; 3]);
            for gyro in gyros {
                let weights: Vec<Vec<f64>> = errors.iter().map(|error| gyro.weights_of(*error)).collect();
                for (mean, weights) in mean.iter_mut().zip(&weights) {
                    *mean += gyro.mean(weights);
                }
                covariance[0] += gyro.noise.covariance(&weights[0], &weights[0]);
                if let [first, second] = &weights[..] {
                    covariance[1] += gyro.noise.covariance(first, second);
                    covariance[2] += gyro.noise.covariance(second, second);
                }
            }
            Radial { mean, covariance }
        };
        self.gyros.par_chunks(self.of_set).map(of_set).collect()
    }

    /// Bound of the deviation of an error due to rounding in the kernel, in its unit.
    pub fn rounding(&self, error: usize) -> f64 {
        let of_gyro = |gyro: &LoweredGyro| {
            let angles = of_angles(&gyro.weights_of(error));
            ROUNDINGS * angles.iter().map(|weight| libm::fabs(*weight)).sum::<f64>()
        };
        let of_set = |gyros: &[LoweredGyro]| gyros.iter().map(of_gyro).sum();
        self.gyros.chunks(self.of_set).map(of_set).fold(0.0, libm::fmax)
    }
}
