//! The power spectral density of the rate of sampled noise, in closed form.
//!
//! All densities are **one-sided**: their integral from 0 to half the sampling rate is the variance of the rate. They
//! are twice the two-sided densities of IEEE Std 952, which has N² for white rate.

use crate::allan::part::Part;
use crate::allan::process::Process;

/// One-sided density of the rate of one part at a frequency up to half the sampling rate, (″/s)²/Hz.
///
/// With t0 = `sample_s` and s = sin πft0 it is 8Q²s²/t0 of quantization, 2N² of white rate, B²/πf of flicker, K²t0²/2s²
/// of a random walk of the rate, and that of the sampled exponential correlation for Markov noise. Where ft0 is small,
/// these are 2(2πf)²Q²t0, 2N², B²/πf, 2K²/(2πf)² and 2q_c²T_c²/(1 + (2πfT_c)²). The rates are means over t0, and those
/// of a random walk or of Markov noise are held over it, as [everywhere](super). Flicker alone is that of the continuous
/// noise.
///
/// `None` for a sine, which is a line, and for a ramp and a warm-up, which are no noise.
pub fn density(part: &Part, sample_s: f64, frequency_hz: f64) -> Option<f64> {
    (part.term.row().density)(part, sample_s, frequency_hz)
}

impl Process {
    /// One-sided density of the rate of all parts that have a [`density`]; `None` where no part has one.
    pub fn density(&self, frequency_hz: f64) -> Option<f64> {
        let parts = self.parts.iter().filter_map(|part| density(part, self.sample_s, frequency_hz));
        parts.reduce(|sum, part| sum + part)
    }
}

#[cfg(test)]
mod tests {
    use core::f64::consts::PI;

    use super::*;
    use crate::allan::estimator::Difference;
    use crate::allan::holds;

    /// Variance of a difference at `m` from the density: ∫ S(f)·(t0²/4s²)·(2 sin πfτ)⁴ df by midpoints.
    fn from_density(part: &Part, t0: f64, m: u64) -> f64 {
        const STEPS: u32 = 400_000;
        let width = 0.5 / t0 / f64::from(STEPS);
        let at = |i: u32| {
            let f = width * (f64::from(i) + 0.5);
            let (one, all) = (libm::sin(PI * f * t0), libm::sin(PI * f * t0 * m as f64));
            let gain = 2.0 * all * all * t0 / one;
            density(part, t0, f).unwrap() * gain * gain
        };
        (0..STEPS).map(at).sum::<f64>() * width
    }

    #[test]
    fn the_integral_of_the_density_is_the_variance_of_differences() {
        let (t0, parts) = (
            0.02,
            [
                Part::quantization(0.3),
                Part::angle_random_walk(0.3),
                Part::rate_random_walk(0.3),
                Part::markov(0.3, 0.1),
            ],
        );
        for part in parts {
            for m in [1, 3, 20] {
                let (found, expected) =
                    (from_density(&part, t0, m), part.variance(Difference::Second, t0, m));
                assert!((found / expected - 1.0).abs() < 1e-8, "{part:?}, m = {m}: {found}, not {expected}");
            }
        }
    }

    #[test]
    fn the_density_of_flicker_is_nearly_that_of_its_holds() {
        let (t0, b) = (0.01, 0.7);
        let part = Part::bias_instability(b, holds::OCTAVES);
        let variances = holds::variances(holds::OCTAVES).unwrap();
        let of_holds = |f: f64| -> f64 {
            let one = |(o, v): (usize, &f64)| {
                let length = f64::from(1_u32 << o);
                let ratio = libm::sin(PI * f * length * t0) / libm::sin(PI * f * t0);
                2.0 * t0 * v / length * ratio * ratio
            };
            let sum: f64 = variances.iter().enumerate().map(one).sum();
            crate::allan::FLAT_LEVEL * b * b * sum
        };
        for turns in [1e-4, 1.3e-3, 0.01, 0.013, 0.017, 0.03, 0.07, 0.09, 0.1] {
            let (found, holds) = (density(&part, t0, turns / t0).unwrap(), of_holds(turns / t0));
            assert!((found / holds - 1.0).abs() < 0.14, "f t0 = {turns}: {found}, holds {holds}");
        }
    }

    #[test]
    fn sampled_densities_are_the_continuous_ones_at_low_frequencies() {
        let (t0, f, omega) = (1e-5, 0.3, 0.6 * PI);
        let table = [
            (Part::quantization(0.2), 2.0 * omega * omega * 0.04 * t0),
            (Part::angle_random_walk(0.2), 0.08),
            (Part::bias_instability(0.2, holds::OCTAVES), 0.04 / (PI * f)),
            (Part::rate_random_walk(0.2), 0.08 / (omega * omega)),
            (Part::markov(0.2, 3.0), 0.08 * 9.0 / (1.0 + 9.0 * omega * omega)),
        ];
        for (part, expected) in table {
            let found = density(&part, t0, f).unwrap();
            assert!((found / expected - 1.0).abs() < 1e-8, "{part:?}: {found}, not {expected}");
        }
        for part in [Part::sine(1.0, 0.1), Part::rate_ramp(1.0), Part::warm_up(1.0, 1.0)] {
            assert_eq!(density(&part, t0, f), None, "{part:?}");
        }
    }
}
