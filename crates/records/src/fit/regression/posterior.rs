//! The distribution of the coefficients of a regression: a mixture of Student distributions.

use crate::allan::fisher;
use crate::fit::nnls::dot;
use crate::fit::regression::Solution;

/// Least weight of a noise relative to the greatest; the sum of all that have less is far below the precision of an interval.
const MIN_WEIGHT: f64 = 1e-6;
/// Halvings of the bracket of a quantile, and its ends in standard errors.
const HALVINGS: usize = 60;
const FARTHEST: f64 = 40.0;

/// The coefficients under one noise.
#[derive(Debug, Clone)]
pub(crate) struct Known {
    /// Probability of the noise; 0 where it is negligible.
    pub weight: f64,
    pub estimates: Vec<f64>,
    /// Covariance of the estimates.
    pub covariance: Vec<Vec<f64>>,
    pub chi_squared: f64,
}

/// The distribution of the coefficients of a regression.
#[derive(Debug, Clone)]
pub struct Posterior {
    known: Vec<Known>,
    degrees: usize,
}

/// A coefficient, or a sum of coefficients.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Estimate {
    /// Mean of its distribution.
    pub value: f64,
    /// Quantiles of 2.5 and 97.5 %.
    pub interval: [f64; 2],
}

impl Estimate {
    /// Whether the interval does not contain 0.
    pub fn is_identified(&self) -> bool {
        self.interval[0] > 0.0 || self.interval[1] < 0.0
    }
}

impl Posterior {
    pub(super) fn new(logarithms: &[f64], solutions: Vec<Solution>, degrees: usize) -> Posterior {
        let largest = logarithms.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        let relative = logarithms.iter().map(|logarithm| libm::exp(logarithm - largest));
        let weights: Vec<f64> =
            relative.map(|weight| if weight < MIN_WEIGHT { 0.0 } else { weight }).collect();
        let sum: f64 = weights.iter().sum();
        let known = solutions.into_iter().zip(weights).map(|(solution, weight)| {
            let variance = solution.chi_squared / degrees as f64;
            let scaled = |row: Vec<f64>| row.into_iter().map(|cell| variance * cell).collect();
            Known {
                weight: weight / sum,
                estimates: solution.estimates,
                covariance: solution.inverse.into_iter().map(scaled).collect(),
                chi_squared: solution.chi_squared,
            }
        });
        Posterior { known: known.collect(), degrees }
    }

    /// The distribution under a single noise, with another covariance.
    pub(super) fn single(estimates: Vec<f64>, covariance: Vec<Vec<f64>>, degrees: usize) -> Posterior {
        Posterior { known: vec![Known { weight: 1.0, estimates, covariance, chi_squared: 1.0 }], degrees }
    }

    pub(crate) fn known(&self) -> &[Known] {
        &self.known
    }

    /// Degrees of freedom of the Student distributions.
    pub fn degrees(&self) -> usize {
        self.degrees
    }

    /// The number of the most probable noise.
    pub(super) fn mode(&self) -> usize {
        let weights = || self.known.iter().map(|known| known.weight);
        let largest = weights().fold(0.0, f64::max);
        weights().position(|weight| weight == largest).unwrap_or_default()
    }

    /// The mean of each coefficient.
    pub fn means(&self) -> Vec<f64> {
        let count = self.known.first().map_or(0, |known| known.estimates.len());
        (0..count).map(|i| self.known.iter().map(|known| known.weight * known.estimates[i]).sum()).collect()
    }

    /// The coefficient `i`.
    pub fn coefficient(&self, i: usize) -> Estimate {
        let count = self.known.first().map_or(0, |known| known.estimates.len());
        self.sum(&(0..count).map(|j| f64::from(u8::from(i == j))).collect::<Vec<_>>())
    }

    /// The sum of all coefficients times `weights`.
    pub fn sum(&self, weights: &[f64]) -> Estimate {
        let parts: Vec<[f64; 3]> = self
            .known
            .iter()
            .filter(|known| known.weight > 0.0)
            .map(|known| {
                let rows = known.covariance.iter().map(|row| dot(row, weights));
                let variance: f64 = rows.zip(weights).map(|(row, weight)| row * weight).sum();
                [known.weight, dot(&known.estimates, weights), libm::sqrt(variance.max(0.0))]
            })
            .collect();
        let value = parts.iter().map(|[weight, value, _]| weight * value).sum();
        Estimate { value, interval: [0.025, 0.975].map(|p| quantile(&parts, p, self.degrees as f64)) }
    }
}

/// The quantile of a mixture of Student distributions, each with its weight, middle and scale.
fn quantile(parts: &[[f64; 3]], probability: f64, degrees: f64) -> f64 {
    let below = |x: f64| -> f64 {
        let one = |[weight, middle, scale]: &[f64; 3]| weight * student((x - middle) / scale, degrees);
        parts.iter().map(one).sum()
    };
    let end = |sign: f64| parts.iter().map(move |[_, middle, scale]| middle + sign * FARTHEST * scale);
    let (mut low, mut high) =
        (end(-1.0).fold(f64::INFINITY, f64::min), end(1.0).fold(f64::NEG_INFINITY, f64::max));
    for _ in 0..HALVINGS {
        let middle = 0.5 * (low + high);
        if below(middle) < probability { low = middle } else { high = middle }
    }
    0.5 * (low + high)
}

/// Probability that a Student variable is less than `x`; its square has the F distribution.
fn student(x: f64, degrees: f64) -> f64 {
    let farther =
        fisher::tails(x * x, 1.0, degrees).map_or(if x == 0.0 { 1.0 } else { 0.0 }, |tails| tails[1]);
    if x > 0.0 { 1.0 - 0.5 * farther } else { 0.5 * farther }
}
