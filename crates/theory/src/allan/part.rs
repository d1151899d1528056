//! The parts of a gyro's angle, with the variance of their differences.

use core::f64::consts::{LN_2, PI};

use crate::allan::estimator::Difference;
use crate::allan::terms::Term;

/// A part of the angle, in ″ and s, sampled as described [above](super).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Part {
    /// Term of which this is a part.
    pub term: Term,
    /// Coefficient; IEEE's q_c for Markov noise.
    pub size: f64,
    /// Time, s, or frequency, Hz; 1 for terms without one.
    pub shape: f64,
    /// Number of octaves of holds of flicker, of 1, 2, 4, … samples; 0 for all other terms.
    pub octaves: usize,
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
    /// The part whose first numbers are its size and shape.
    pub const fn new<const N: usize>(term: Term, numbers: [f64; N]) -> Part {
        Part { term, size: numbers[0], shape: numbers[1], octaves: 0 }
    }

    /// Square of the coefficient, as [`Term::part`] takes it.
    pub fn square(&self) -> f64 {
        (self.term.row().square)(self)
    }

    /// Variance of a difference of angles `m` samples apart, ″²; 0 of the deterministic ramp and warm-up, which are a
    /// [`Trend`]. The Allan variance is this over 2τ² (A(3), (4)), the Hadamard variance over 6τ².
    ///
    /// It is exact for the sampled process at any m, for every record that is long enough, and so for the mean of
    /// overlapping and non-overlapping differences alike.
    pub fn variance(&self, difference: Difference, sample_s: f64, m: u64) -> f64 {
        (self.term.row().variance)(self, difference, sample_s, m)
    }

    /// The differences of a ramp or a warm-up; `None` for random parts.
    pub fn trend(&self, difference: Difference, sample_s: f64, m: u64) -> Option<Trend> {
        (self.term.row().trend)(self, difference, sample_s, m)
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
            near(allan(Part::quantization(0.3), t0, m), 3.0 * 0.09 / (tau * tau), 1e-13, "Q");
            near(allan(Part::angle_random_walk(0.3), t0, m), 0.09 / tau, 1e-13, "N");
            let walk = 0.09 * tau / 3.0 * (1.0 + 0.5 / (n * n));
            near(allan(Part::rate_random_walk(0.3), t0, m), walk, 1e-13, "K");
            near(allan(Part::rate_ramp(0.3), t0, m), 0.09 * tau * tau / 2.0, 1e-13, "R");
            near(allan(Part::bias_instability(0.3, 24), t0, m), FLAT_LEVEL * 0.09, 0.005, "B");
        }
        assert!(allan(Part::bias_instability(1.0, 3), 1.0, 1).is_nan());
    }

    #[test]
    fn a_sine_is_the_mean_over_its_phase() {
        let (t0, f, amplitude) = (0.02, 1.7, 5.0);
        let part = Part::sine(amplitude, f);
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
            }
        }
        // A long τ keeps its digits where fτ is an integer plus one half.
        let long = Part::sine(1.0, 0.5);
        near(allan(long, 1.0, 1_000_001), 1.0 / (PI * PI * 500_000.5 * 500_000.5), 1e-9, "long sine");
    }
}
