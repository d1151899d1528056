//! The generalised covariance of a sampled angle: what gives any two of its differences their covariance.
//!
//! An angle that walks has no covariance, but its differences have: Σ c_i c_j G(k_i − k_j) with G = −V/2, V(n) being the
//! variance of its increment over n samples, or any function that differs by a parabola, which second differences do not see.
//! What is needed is the second difference of G over the shorter of two differences, written so that nothing
//! cancels for lags that are long beside it.

use super::part::FLAT_LEVEL;
use super::{Part, Process, holds, markov};

/// Second differences of G, `m` apart, of a process.
pub(super) struct Kernel<'a> {
    process: &'a Process,
    m: f64,
    /// Variance of the rate of each octave of holds over its length, times t0², ″².
    octaves: Vec<f64>,
}

impl<'a> Kernel<'a> {
    pub(super) fn new(process: &'a Process, m: u64) -> Kernel<'a> {
        let mut octaves = Vec::new();
        for part in &process.parts {
            if let Part::BiasInstability { b, octaves: count } = *part {
                let scale = FLAT_LEVEL * b * b * process.sample_s * process.sample_s;
                let variances = holds::variances(count).unwrap_or_else(|| vec![f64::NAN]);
                octaves.resize(octaves.len().max(variances.len()), 0.0);
                for (o, variance) in variances.into_iter().enumerate() {
                    octaves[o] += scale * variance / (1_u64 << o) as f64;
                }
            }
        }
        Kernel { process, m: m as f64, octaves }
    }

    /// G(n + m) − 2G(n) + G(n − m), ″², at the lag n ≥ 0, less a constant; without the white error of the angles.
    pub(super) fn at(&self, n: f64) -> f64 {
        let (m, t0) = (self.m, self.process.sample_s);
        let parts = self.process.parts.iter().map(|part| match *part {
            // Of −|n|/2.
            Part::AngleRandomWalk { n: walk } => -walk * walk * t0 * (m - n).max(0.0),
            Part::RateRandomWalk { k } => k * k * t0 * t0 * t0 * cubic(m, n),
            Part::Markov { q_c, time_s } => {
                0.5 * q_c * q_c * time_s * t0 * t0 * markov::kernel(t0 / time_s, m, n)
            }
            _ => 0.0,
        });
        // A hold is a random walk of the rate that is taken back after its length.
        let hold = |(o, variance): (usize, &f64)| {
            let length = (1_u64 << o) as f64;
            let taken_back = one_sided_cubic(m, n - length) + one_sided_cubic(m, -n - length);
            2.0 * variance * (cubic(m, n) - taken_back)
        };
        parts.sum::<f64>() + self.octaves.iter().enumerate().map(hold).sum::<f64>()
    }
}

/// Second difference, m apart, of (|n|³ − |n|)/12, n ≥ 0.
fn cubic(m: f64, n: f64) -> f64 {
    match n >= m {
        true => 0.5 * n * m * m,
        false => g(n + m) - 2.0 * g(n) + g(m - n),
    }
}

/// The same of (u³ − u)/12 for u > 0, else 0.
fn one_sided_cubic(m: f64, u: f64) -> f64 {
    match u {
        u if u >= m => 0.5 * u * m * m,
        u if u <= -m => 0.0,
        u => g(u + m) - 2.0 * g(u.max(0.0)),
    }
}

fn g(n: f64) -> f64 {
    (n * n * n - n) / 12.0
}
