//! The expected estimates of records, from the words of the kernel.
//!
//! Independent parts add in the mean square of a difference, each by its closed form, and the drift by its table. The
//! kernel rounds the angle, the sine, fill residuals and quantization noise down to whole LSB. Where the angle moves by
//! a normal number of one LSB or more from sample to sample, its rounding is uniform, white and independent of
//! everything else, up to a factor e^{−2π²} and except for the first angle, which is 0. Otherwise, and for the sine and
//! fill residuals, rounding is bounded by |E(D + d)² − ED²| ≤ 2·rms D·d + d², where d is the largest difference that it
//! can make.

use crate::kinds::allan::lower::fixed::TURN;
use crate::kinds::allan::lower::model::{Noise, reach};
use crate::kinds::allan::lower::{Records, drift};
use sagnac_theory::allan::quantizer;

/// The expected estimate for the lowered words, (″/s)².
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Theory {
    /// Expected value; absent where it is not known to 1 %.
    pub value: Option<f64>,
    /// Bound of the deviation of the expected estimate from `value`, due to rounding in the kernel and to readouts
    /// without a closed form.
    pub rounding: f64,
    /// Bound of the deviation of `value` from that of the inputs, due to the rounding of words.
    pub representation: f64,
}

/// Largest ratio of the bound to the value.
const MAX_ROUNDING: f64 = 0.01;

/// Error of the variance of the kernel's normal numbers, with a margin.
const NORMAL_ERROR: f64 = 1e-8;
/// Error of the kernel's sine.
const SINE_ERROR: f64 = 1.0 / 759_250_125.0; // 2^−29.5
/// Error of sums in floating point.
const SUM_ERROR: f64 = 1e-12;

/// Error of both closed forms in floating point, relative.
const REPRESENTATION_ERROR: f64 = 1e-10;

/// A mean square with its bound of error, and that of its deviation from the mean square of the inputs, LSB².
#[derive(Clone, Copy)]
struct Square {
    value: f64,
    error: f64,
    representation: f64,
}

impl Square {
    fn add(&mut self, value: f64, error: f64) {
        self.value += value;
        self.error += error;
    }
}

impl Records {
    /// The expected estimate at `ms()[at]`. For records with drift it takes as long as summing their differences.
    pub fn theory(&self, at: usize) -> Theory {
        let unit = self.variance_of_square(at);
        let Square { value, error, representation } = self.mean_square(at);
        let error = error + SUM_ERROR * value;
        Theory {
            value: (error <= MAX_ROUNDING * value).then_some(value * unit),
            rounding: error * unit,
            representation: (representation + REPRESENTATION_ERROR * value) * unit,
        }
    }

    /// Expected square of the differences at `ms[at]`.
    fn mean_square(&self, at: usize) -> Square {
        let (m, terms) = (self.ms[at], self.terms[at]);
        let (fixed, difference) = (&self.fixed, self.estimator.difference);
        let noise = fixed.noise();
        let stride = self.estimator.stride(m) as usize;
        let [trend, first] = drift::differences(&self.recipe.drift, difference, stride, m as usize, terms);
        let squares: f64 = difference.coefficients().iter().map(|c| c * c).sum();
        // Σ|c| of the difference.
        let reach = reach(difference);

        let mut sum =
            Square { value: trend, error: 0.0, representation: self.representation_bound(m, trend) };
        let random = noise.variance(difference, m);
        sum.add(random, NORMAL_ERROR * random);
        // Numbers that are off by up to ½ from the middle: 2·rms·d + d².
        let off = |sum: &mut Square, mean_square: f64, d: f64| {
            sum.add(0.0, 2.0 * libm::sqrt(mean_square) * d + d * d);
        };
        if fixed.has_angle() {
            if fixed.fresh() >= 1.0 {
                let first = 2.0 * libm::fabs(first) / terms as f64;
                sum.add(squares / 12.0, 1.0 + 1e-7 * libm::sqrt(random) + first);
                sum.representation += squares / 12.0;
            } else {
                let angle = Noise { quantization: 0.0, ..noise.clone() }.variance(difference, m);
                off(&mut sum, libm::pow(libm::sqrt(angle) + libm::sqrt(trend), 2.0), 0.5 * reach);
            }
        }
        if let Some(markov) = noise.markov {
            let alone = Noise { quantization: 0.0, white: 0.0, octaves: vec![], walk: 0.0, ..noise.clone() };
            let variance = alone.variance(difference, m);
            sum.add(0.0, fixed.start_error() * variance);
            // The loss acts on whole units: it is off by up to one unit, and changes by up to that fraction of one in a
            // sample.
            let m = m as f64;
            let changed = fixed.rate_unit() * m * libm::fmin(1.0, -m * libm::expm1(-markov.decay));
            let d = changed * (0.25 * reach);
            off(&mut sum, libm::pow(libm::sqrt(variance) + libm::sqrt(trend), 2.0), d);
        }
        if let Some(jumps) = fixed.jumps() {
            let variance = jumps.mean_square(self.estimator, self.recipe.samples.into(), m);
            sum.add(variance, NORMAL_ERROR * variance);
            off(&mut sum, libm::pow(libm::sqrt(variance) + libm::sqrt(trend), 2.0), 0.5 * reach);
        }
        let mut wave_error = 0.0;
        if let Some(sine) = fixed.wave() {
            let variance = sine.part().map_or(0.0, |part| part.variance(difference, 1.0, m));
            wave_error = 0.5 + SINE_ERROR * sine.amplitude;
            sum.add(variance, 0.0);
            off(&mut sum, variance, reach * wave_error);
        }
        if let Some(pulse) = fixed.pulse_lsb() {
            let readout = self.readout(&noise, pulse, m);
            // The covariance of two errors changes by at most half a pulse per LSB of the rounding between them.
            let angle = if fixed.has_angle() { 1.0 } else { 0.0 };
            let quantization = if fixed.quantization > 0 { 1.0 } else { 0.0 };
            let drift = if self.recipe.drift.is_empty() { 0.0 } else { 1.0 };
            let jumps = if fixed.switching.is_some() { 1.0 } else { 0.0 };
            let between = angle + quantization + drift + jumps + 2.0 * wave_error;
            let pairs = reach * reach - squares;
            sum.add(readout.value, readout.error + 0.5 * pairs * pulse * between);
            sum.representation += self.readout_bound(pulse, pairs, m);
        }
        sum
    }

    /// The contribution of reading whole pulses.
    fn readout(&self, noise: &Noise, pulse: f64, m: u64) -> Square {
        let (fixed, difference) = (&self.fixed, self.estimator.difference);
        let mut process = noise.simple();
        let white = pulse * pulse / 12.0 * difference.coefficients().iter().map(|c| c * c).sum::<f64>();
        let bound = quantizer::white_error(pulse, &process, difference, m);
        process.parts.extend(fixed.wave().and_then(|sine| sine.part()));
        let switches = fixed.switching.is_some();
        let drifts = self.curved || switches || noise.walk > 0.0 || !noise.octaves.is_empty();
        // Whole pulses in the rate per sample do not affect the fractions.
        let rate = (fixed.rate % (pulse * TURN) as u64) as f64 / TURN;
        match quantizer::mean_square(pulse, rate, &process, difference, m).filter(|_| !drifts) {
            Some(value) => Square { value, error: 0.0, representation: 0.0 },
            None => Square { value: white, error: bound, representation: 0.0 },
        }
    }
}
