//! A whole noise model, and the expected values of the estimators of its record.

use crate::allan::estimator::{Difference, Estimator};
use crate::allan::exponential::mean_of_decay;
use crate::allan::part::{Part, Trend};

/// Independent parts of an angle sampled every `sample_s`.
#[derive(Debug, Clone, PartialEq)]
pub struct Process {
    /// Time t0 from one sample to the next, s.
    pub sample_s: f64,
    /// Parts, of which any kind may occur several times.
    pub parts: Vec<Part>,
}

impl Process {
    /// Variance of a difference at `m` of all random parts, ″².
    pub fn variance(&self, difference: Difference, m: u64) -> f64 {
        self.parts.iter().map(|part| part.variance(difference, self.sample_s, m)).sum()
    }

    /// Expected value of an estimator on a record of `samples` rate samples, (″/s)²; `None` where the estimator has no
    /// difference.
    ///
    /// Variances add. Ramp and warm-up are the same in every record, so their differences are added before they are
    /// squared. For a warm-up the number of differences matters: its mean over the M differences at k = 0, s, 2s, … is
    /// a geometric sum.
    pub fn expected(&self, estimator: Estimator, samples: u64, m: u64) -> Option<f64> {
        let terms = estimator.terms(samples, m);
        if terms == 0 {
            return None;
        }
        let (difference, step) = (estimator.difference, estimator.stride(m) as f64);
        let trends: Vec<Trend> =
            self.parts.iter().filter_map(|part| part.trend(difference, self.sample_s, m)).collect();
        let mut mean_square = self.variance(difference, m);
        for a in &trends {
            for b in &trends {
                mean_square += a.first * b.first * mean_of_decay(a.decay + b.decay, step, terms);
            }
        }
        let tau = self.sample_s * m as f64;
        Some(mean_square / (difference.divisor() * tau * tau))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::allan::estimator::Stride;

    #[test]
    fn a_warm_up_beside_a_ramp_is_its_sum_by_definition() {
        let (t0, samples, r, amplitude, time_s) = (0.5, 400_u64, 1e-3, 2.0, 30.0);
        let process =
            Process { sample_s: t0, parts: vec![Part::rate_ramp(r), Part::warm_up(amplitude, time_s)] };
        let angle = |k: u64| {
            let t = t0 * k as f64;
            0.5 * r * t * t - amplitude * time_s * libm::expm1(-t / time_s)
        };
        let thinned = Estimator { stride: Stride::Part(4), ..Estimator::OVERLAPPING };
        for estimator in [Estimator::OVERLAPPING, Estimator::NON_OVERLAPPING, Estimator::HADAMARD, thinned] {
            for m in [1, 2, 9, 50, 130] {
                let terms = estimator.terms(samples, m);
                let difference = |k: u64| -> f64 {
                    let coefficients = estimator.difference.coefficients().iter().enumerate();
                    coefficients.map(|(i, c)| c * angle(k + i as u64 * m)).sum()
                };
                let squares = (0..terms).map(|i| difference(i * estimator.stride(m)).powi(2));
                let tau = t0 * m as f64;
                let mean = squares.sum::<f64>() / terms as f64 / (estimator.difference.divisor() * tau * tau);
                let found = process.expected(estimator, samples, m).unwrap();
                assert!((found / mean - 1.0).abs() < 1e-7, "{estimator:?}, m = {m}: {found}, not {mean}");
            }
            assert_eq!(process.expected(estimator, samples, 201), None);
        }
    }
}
