//! A readout that counts whole pulses: q⌊(θ + u)/q⌋ of the total angle, whose start u is uniform over one pulse q.
//!
//! The error of such a readout is uniform over one pulse at every sample, so it is uncorrelated with the angle, and its
//! variance is q²/12, that of the quantization noise Q = q/√12. It is *not* white: it stays constant while the angle
//! moves by much less than a pulse, and it is a beat where the pulses come at an even rate. The covariance of two
//! errors whose angles differ by Δ is q²·B(Δ/q)/2 with the Bernoulli polynomial B = d² − d + 1/6 of the fractional part
//! d, a series of cosines; its mean over Δ follows from the characteristic function of Δ.

use core::f64::consts::PI;

use crate::allan::estimator::Difference;
use crate::allan::part::{Part, sine_of_turns};
use crate::allan::process::Process;
use crate::allan::terms;

/// Variance, in pulses², of the angle between two samples from which on the series is summed, with fewer than 4e4
/// terms.
const MIN_VARIANCE: f64 = 1e-9;
/// Exponent above which a term is below rounding.
const NEGLIGIBLE: f64 = 40.0;

/// Mean square of a difference of the readout's error at `m`, ″², which is added to that of the angle.
///
/// `lsb` is q, ″; `mean_rate` is the constant rate of the gyro, ″/s, which determines the beat with the pulses. The
/// result is exact for quantization noise before the readout, angle random walk, Markov noise and sines. It is `None`
/// for any other part, whose increments are not those of one Gaussian (the octave holds) or change along the record,
/// and for a sine with less noise than √1e-9 pulses. Then take the white 6q²/12 (20q²/12), with [`white_error`] as its
/// bound.
pub fn mean_square(
    lsb: f64,
    mean_rate: f64,
    process: &Process,
    difference: Difference,
    m: u64,
) -> Option<f64> {
    let pairs = pairs(difference);
    let mut sum = difference.coefficients().iter().map(|c| c * c).sum::<f64>() / 12.0;
    for (apart, weight) in (1..).zip(pairs) {
        let increment = Increment::of(process, apart * m, lsb)?;
        let turns = mean_rate * process.sample_s * (apart * m) as f64 / lsb;
        sum += weight * increment.covariance(turns)?;
    }
    Some(lsb * lsb * sum)
}

/// Bound of the deviation of [`mean_square`] from that of white noise of Q = q/√12, ″², whatever other parts the angle
/// has.
///
/// It follows from the angle random walk, the Markov noise and the white noise before the readout. Other parts are
/// independent of them and can only reduce the correlation of the errors.
pub fn white_error(lsb: f64, process: &Process, difference: Difference, m: u64) -> f64 {
    let bound = |apart: u64| {
        let variance = noise_variance(process, apart * m) / (lsb * lsb);
        // Σ e^{−2π²j²v}/2π²j² is at most its first factor times 1/12.
        libm::exp(-2.0 * PI * PI * variance) / 12.0
    };
    lsb * lsb * (1..).zip(pairs(difference)).map(|(apart, weight)| weight.abs() * bound(apart)).sum::<f64>()
}

/// Twice the sums of the products of coefficients m, 2m, … apart.
fn pairs(difference: Difference) -> Vec<f64> {
    let c = difference.coefficients();
    let at = |apart: usize| 2.0 * c.iter().zip(&c[apart..]).map(|(a, b)| a * b).sum::<f64>();
    (1..c.len()).map(at).collect()
}

/// Variance of the Gaussian part of the angle over n samples, ″².
pub fn noise_variance(process: &Process, n: u64) -> f64 {
    let one = |part: &Part| match (part.term.row().increment)(part, process.sample_s, n) {
        terms::Increment::Normal(variance) => variance,
        _ => 0.0,
    };
    process.parts.iter().map(one).sum()
}

/// The angle over n samples without its mean, in pulses.
struct Increment {
    variance: f64,
    sines: Vec<f64>,
}

impl Increment {
    fn of(process: &Process, n: u64, lsb: f64) -> Option<Increment> {
        let mut sines = Vec::new();
        for part in &process.parts {
            match (part.term.row().increment)(part, process.sample_s, n) {
                terms::Increment::Sine(peak) => sines.push(peak / lsb),
                terms::Increment::Normal(_) => (),
                terms::Increment::Other => return None,
            }
        }
        Some(Increment { variance: noise_variance(process, n) / (lsb * lsb), sines })
    }

    /// Mean of B/2 for a mean of `turns` pulses: Σ cos(2πj·turns)·φ(2πj)/(2π²j²).
    fn covariance(&self, turns: f64) -> Option<f64> {
        if self.variance == 0.0 && self.sines.is_empty() {
            let d = turns - libm::floor(turns);
            return Some(0.5 * (d * d - d + 1.0 / 6.0));
        }
        if self.variance < MIN_VARIANCE {
            return None;
        }
        let exponent = |j: f64| 2.0 * PI * PI * j * j * self.variance;
        let terms = (1..).map(f64::from).take_while(|&j| exponent(j) < NEGLIGIBLE);
        let sum = terms.map(|j| {
            let beat = sine_of_turns(0.25 + j * (turns - libm::round(turns)));
            let sines: f64 = self.sines.iter().map(|peak| libm::j0(2.0 * PI * j * peak)).product();
            beat * sines * libm::exp(-exponent(j)) / (2.0 * PI * PI * j * j)
        });
        Some(sum.sum())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn process(parts: Vec<Part>) -> Process {
        Process { sample_s: 1.0, parts }
    }

    #[test]
    fn without_noise_it_is_the_mean_over_the_start() {
        let (q, rate) = (0.38, 15.041);
        for m in [1, 2, 7, 50] {
            for difference in [Difference::Second, Difference::Third] {
                let starts = 100_000;
                let error = |start: f64, k: u64| {
                    let angle = rate * (k * m) as f64 + start;
                    q * libm::floor(angle / q) - angle
                };
                let square = |i: u32| {
                    let start = q * (f64::from(i) + 0.5) / f64::from(starts);
                    let terms = difference.coefficients().iter().enumerate();
                    let value: f64 = terms.map(|(k, c)| c * error(start, k as u64)).sum();
                    value * value
                };
                let mean = (0..starts).map(square).sum::<f64>() / f64::from(starts);
                let found = mean_square(q, rate, &process(vec![]), difference, m).unwrap();
                // With 1e5 starts, a jump is off by up to half a start.
                assert!((found - mean).abs() < 1e-4 * q * q, "{difference:?}, m = {m}: {found}, not {mean}");
            }
        }
    }

    #[test]
    fn a_frozen_readout_has_no_error_and_a_lively_one_is_white() {
        let (q, white) = (1.0, 6.0 / 12.0);
        let still = process(vec![Part::angle_random_walk(1e-4)]);
        let found = mean_square(q, 0.0, &still, Difference::Second, 1).unwrap();
        // Σ|c·c|·E|Δ|: errors differ only where a pulse comes, which has the probability E|Δ|/q.
        assert!(found > 0.0 && found < 5e-4, "{found}");
        assert!(white_error(q, &still, Difference::Second, 1) > white - found);
        let lively = process(vec![Part::angle_random_walk(2.0)]);
        let found = mean_square(q, 0.3, &lively, Difference::Second, 1).unwrap();
        assert!((found - white).abs() < 1e-15, "{found}");
        assert!(white_error(q, &lively, Difference::Second, 1) < 1e-15);
        let found = mean_square(q, 0.3, &lively, Difference::Third, 1).unwrap();
        assert!((found - 20.0 / 12.0).abs() < 1e-15, "{found}");
    }

    #[test]
    fn what_has_no_closed_form_is_said() {
        let flicker = process(vec![Part::angle_random_walk(1.0), Part::bias_instability(1.0, 24)]);
        assert_eq!(mean_square(1.0, 0.0, &flicker, Difference::Second, 1), None);
        let sine = process(vec![Part::sine(1.0, 0.1)]);
        assert_eq!(mean_square(1.0, 0.0, &sine, Difference::Second, 1), None);
    }
}
