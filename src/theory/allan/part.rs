//! The parts of a gyro's angle, with the variance of their differences.

use core::f64::consts::{LN_2, PI};

use crate::theory::allan::estimator::Difference;
use crate::theory::allan::{holds, markov};

/// A part of the angle, in ″ and s, sampled as described [above](super).
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Part {
    /// Quantisation noise: a white error of the angles with rms Q.
    Quantisation {
        /// Rms Q, ″.
        q: f64,
    },
    /// Angle random walk.
    AngleRandomWalk {
        /// Coefficient N, ″/√s.
        n: f64,
    },
    /// Flicker of the rate as a sum of octave holds, whose Allan variance is flat at (2 ln2/π)B². A number of octaves
    /// for which there are no [variances](holds::variances) makes it NaN.
    BiasInstability {
        /// Bias instability B, ″/s.
        b: f64,
        /// Number of octaves of holds, of 1, 2, 4, … samples.
        octaves: usize,
    },
    /// Rate random walk.
    RateRandomWalk {
        /// Coefficient K, ″/s^1.5.
        k: f64,
    },
    /// Exponentially correlated rate, whose variance is q_c²T_c/2.
    Markov {
        /// IEEE's coefficient q_c, ″/s^1.5.
        q_c: f64,
        /// Correlation time T_c, s.
        time_s: f64,
    },
    /// Sine of the rate with a random phase.
    Sine {
        /// Amplitude Ω_0, ″/s.
        amplitude: f64,
        /// Frequency f, Hz.
        frequency_hz: f64,
    },
    /// Rate ramp.
    RateRamp {
        /// Coefficient R, ″/s².
        r: f64,
    },
    /// Exponential decay of the rate after the start of the record.
    WarmUp {
        /// Initial rate A, ″/s.
        amplitude: f64,
        /// Time constant T, s.
        time_s: f64,
    },
}

/// The k-th deterministic difference of a record: `first`·e^{−`decay`·k}, ″.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Trend {
    /// Difference at the start, ″.
    pub first: f64,
    /// Decay per sample.
    pub decay: f64,
}

/// Allan variance of a bias instability of 1: 2 ln2/π.
pub const FLAT_LEVEL: f64 = 2.0 * LN_2 / PI;

impl Part {
    /// Variance of a difference of angles `m` samples apart, ″²; 0 for the deterministic ramp and warm-up, which are a
    /// [`Trend`]. The Allan variance is this over 2τ² (A(3), (4)), the Hadamard variance over 6τ².
    ///
    /// It is exact for the sampled process at any m, for every record that is long enough, and so for the mean of
    /// overlapping and non-overlapping differences alike.
    pub fn variance(&self, difference: Difference, sample_s: f64, m: u64) -> f64 {
        let (t0, n) = (sample_s, m as f64);
        let tau = t0 * n;
        let second = difference == Difference::Second;
        match *self {
            // Σc² of the coefficients of the angles.
            Part::Quantisation { q } => q * q * if second { 6.0 } else { 20.0 },
            // Σc² of the coefficients of the increments.
            Part::AngleRandomWalk { n } => n * n * tau * difference.divisor(),
            Part::BiasInstability { b, octaves } => {
                let variances = holds::variances(octaves).unwrap_or_else(|| vec![f64::NAN]);
                let one = |(o, v): (usize, &f64)| v * holds::mean_square(difference, 1 << o, m);
                FLAT_LEVEL * b * b * t0 * t0 * variances.iter().enumerate().map(one).sum::<f64>()
            }
            // Squares of 1, 2, … m, … 2, 1 for the second difference: K²τ/3·(1 + 1/2m²) as Allan variance, and K²τ/6·(1
            // + 1/m²) as Hadamard variance.
            Part::RateRandomWalk { k } => {
                let sum = if second { (2.0 * n * n * n + n) / 3.0 } else { n * n * n + n };
                k * k * t0 * t0 * t0 * sum
            }
            Part::Markov { q_c, time_s } => {
                0.5 * q_c * q_c * time_s * t0 * t0 * markov::mean_square(difference, t0 / time_s, n)
            }
            // The amplitude of the angle is Ω_0/2πf, and every difference multiplies it by 2 sin πfτ.
            Part::Sine { amplitude, frequency_hz } => {
                let step = 2.0 * sine_of_turns(0.5 * frequency_hz * tau);
                let angle = amplitude / (2.0 * PI * frequency_hz);
                0.5 * angle * angle * libm::pow(step * step, if second { 2.0 } else { 3.0 })
            }
            Part::RateRamp { .. } | Part::WarmUp { .. } => 0.0,
        }
    }

    /// The differences of a ramp or a warm-up; `None` for random parts.
    pub fn trend(&self, difference: Difference, sample_s: f64, m: u64) -> Option<Trend> {
        let tau = sample_s * m as f64;
        match *self {
            Part::RateRamp { r } => Some(Trend {
                first: if difference == Difference::Second { r * tau * tau } else { 0.0 },
                decay: 0.0,
            }),
            // θ = AT(1 − e^{−t/T}): each difference multiplies e^{−t/T} by e^{−τ/T} − 1.
            Part::WarmUp { amplitude, time_s } => {
                let power = f64::from(difference.spans() as u32);
                let first = -amplitude * time_s * libm::pow(libm::expm1(-tau / time_s), power);
                Some(Trend { first, decay: sample_s / time_s })
            }
            _ => None,
        }
    }

    /// Largest |difference| of the deterministic parts and of a sine, ″; 0 for noise.
    ///
    /// Together with 16 standard deviations of the noise it must fit into a word.
    pub fn largest(&self, difference: Difference, sample_s: f64, m: u64) -> f64 {
        match self {
            Part::Sine { .. } => libm::sqrt(2.0 * self.variance(difference, sample_s, m)),
            _ => self.trend(difference, sample_s, m).map_or(0.0, |trend| trend.first.abs()),
        }
    }
}

/// sin 2πx without the loss of digits for large x.
pub(crate) fn sine_of_turns(x: f64) -> f64 {
    libm::sin(2.0 * PI * (x - libm::round(x)))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn allan(part: Part, sample_s: f64, m: u64) -> f64 {
        let tau = sample_s * m as f64;
        let trend =
            part.trend(Difference::Second, sample_s, m).map_or(0.0, |trend| trend.first * trend.first);
        (part.variance(Difference::Second, sample_s, m) + trend) / (2.0 * tau * tau)
    }

    fn near(found: f64, expected: f64, tolerance: f64, what: &str) {
        assert!((found / expected - 1.0).abs() < tolerance, "{what}: {found}, not {expected}");
    }

    #[test]
    fn each_part_has_its_law() {
        for (t0, m) in [(0.01, 1), (0.01, 37), (2.0, 4), (1.0, 100_000)] {
            let (n, tau) = (m as f64, t0 * m as f64);
            near(allan(Part::Quantisation { q: 0.3 }, t0, m), 3.0 * 0.09 / (tau * tau), 1e-13, "Q");
            near(allan(Part::AngleRandomWalk { n: 0.3 }, t0, m), 0.09 / tau, 1e-13, "N");
            let walk = 0.09 * tau / 3.0 * (1.0 + 0.5 / (n * n));
            near(allan(Part::RateRandomWalk { k: 0.3 }, t0, m), walk, 1e-13, "K");
            near(allan(Part::RateRamp { r: 0.3 }, t0, m), 0.09 * tau * tau / 2.0, 1e-13, "R");
            near(allan(Part::BiasInstability { b: 0.3, octaves: 24 }, t0, m), FLAT_LEVEL * 0.09, 0.005, "B");
        }
        assert!(allan(Part::BiasInstability { b: 1.0, octaves: 3 }, 1.0, 1).is_nan());
    }

    #[test]
    fn a_sine_is_the_mean_over_its_phase() {
        let (t0, f, amplitude) = (0.02, 1.7, 5.0);
        let part = Part::Sine { amplitude, frequency_hz: f };
        for difference in [Difference::Second, Difference::Third] {
            for m in [1, 3, 11, 100] {
                let angle = |k: usize, turns: f64| {
                    -amplitude / (2.0 * PI * f)
                        * libm::cos(2.0 * PI * (f * t0 * (k as u64 * m) as f64 + turns))
                };
                let square = |turns: f64| {
                    let value: f64 =
                        difference.coefficients().iter().enumerate().map(|(k, c)| c * angle(k, turns)).sum();
                    value * value
                };
                let mean = (0..16).map(|i| square(f64::from(i) / 16.0)).sum::<f64>() / 16.0;
                near(part.variance(difference, t0, m), mean, 1e-9, "sine");
                let peak = (0..4000).map(|i| square(f64::from(i) / 4000.0)).fold(0.0, f64::max);
                near(part.largest(difference, t0, m), libm::sqrt(peak), 1e-6, "peak of a sine");
            }
        }
        // A long τ keeps its digits where fτ is an integer plus one half.
        let long = Part::Sine { amplitude: 1.0, frequency_hz: 0.5 };
        near(allan(long, 1.0, 1_000_001), 1.0 / (PI * PI * 500_000.5 * 500_000.5), 1e-9, "long sine");
    }
}
