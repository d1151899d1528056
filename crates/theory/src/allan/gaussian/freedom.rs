//! Equivalent degrees of freedom of one estimate of a variance, from the covariance of its differences.
//!
//! An estimate is the mean of M squares (d + p)², where d is Gaussian with the autocovariance c(l) and p is the deterministic part.
//! Its variance is Σ (M − |l|)(2c(l)² + 4c(l)p(l))/M² over all lags l, and 2E²/variance are the degrees of freedom of the χ²
//! with the same mean and variance (Satterthwaite).

use crate::allan::estimator::{Estimator, Stride};
use crate::allan::gaussian::{Pair, Products, covariance};
use crate::allan::process::Process;

/// Points over which a modified variance averages the angle within τ; its covariance is smooth enough for so few.
const AVERAGED: u64 = 32;
/// Lags up to which differences of the angle are correlated, in their own lengths.
const FOLLOWED: f64 = 8.0;

/// Equivalent degrees of freedom of the estimate at `m` from one record of `samples` samples; `is_modified` if the angle is
/// averaged over τ. `None` where the record has no difference, and for a process that has no noise.
pub fn freedom(
    process: &Process,
    estimator: Estimator,
    is_modified: bool,
    samples: u64,
    m: u64,
) -> Option<f64> {
    let found = match (is_modified, estimator.stride) {
        (true, _) => of_averages(process, estimator, samples, m)?,
        (false, Stride::Sample) => {
            let mean = process.expected(estimator, samples, m)?;
            2.0 * mean * mean / covariance(process, estimator.difference, samples, &[m])[0][0]
        }
        (false, _) => {
            let terms = estimator.terms(samples, m) as f64;
            let stride = estimator.stride(m) as f64;
            let own = Own::new(process, estimator, samples, m, [stride, 1.0]);
            own.freedom(terms, |k| if k == 0.0 { terms } else { 2.0 * (terms - k).max(0.0) })
        }
    };
    Some(found).filter(|freedom| freedom.is_finite() && *freedom > 0.0)
}

/// Equivalent degrees of freedom of a modified variance, whose differences are those of angles averaged over m samples.
fn of_averages(process: &Process, estimator: Estimator, samples: u64, m: u64) -> Option<f64> {
    let span = (estimator.difference.spans() + 1) * m;
    let terms = (samples + 2).checked_sub(span).filter(|terms| *terms > 0)? as f64;
    let parts = m.min(AVERAGED);
    let step = m as f64 / parts as f64;
    // A mean of few points has the scatter of one over all m if each point scatters as a mean over a step.
    let own = Own::new(process, estimator, samples, m, [step; 2]).averaged(parts as usize);
    // Pairs of terms whose lag rounds to a lag of the grid.
    let pairs_within = |lag: f64| {
        let lag = lag.clamp(0.0, terms);
        2.0 * lag * terms - lag * lag
    };
    Some(own.freedom(terms, |k| pairs_within((k + 0.5) * step) - pairs_within((k - 0.5) * step)))
}

/// Autocovariance c and products p of the differences at lags 0, 1, 2, … of a grid.
struct Own(Vec<[f64; 2]>);

impl Own {
    /// The differences at `m` over lags of `step` samples, each of which stands for `width` lags.
    fn new(process: &Process, estimator: Estimator, samples: u64, m: u64, [step, width]: [f64; 2]) -> Own {
        let difference = estimator.difference;
        let pair = Pair::new(process, difference, samples, m, m);
        let span = (difference.spans() * m) as f64;
        let most = (FOLLOWED * span / step).min(samples as f64 / step);
        let coefficients = difference.coefficients();
        let shared = |shift: usize| {
            coefficients.iter().zip(coefficients.iter().skip(shift)).map(|(a, b)| a * b).sum::<f64>()
        };
        let count = process.parts.len();
        let mut products = Products { noise: vec![0.0; count], steady: vec![0.0; count] };
        let at = |k: u32| {
            let lag = f64::from(k) * step;
            let times = libm::round(lag / m as f64);
            let meets =
                if libm::fabs(lag - times * m as f64) < 0.25 { shared(times as usize) / width } else { 0.0 };
            pair.products(lag, width, meets, &mut products);
            [products.noise.iter().sum(), products.steady.iter().sum()]
        };
        Own((0..=most as u32).map(at).collect())
    }

    /// Autocovariance and products of means of `parts` successive differences of the grid.
    fn averaged(&self, parts: usize) -> Own {
        let reach = self.0.len().saturating_sub(parts).max(1);
        let square = (parts * parts) as f64;
        let at = |k: usize, kind: usize| {
            let near = |u: usize| self.0.get(u).map_or(0.0, |own| own[kind]);
            let both = |u: usize| near(k + u) + near(k.abs_diff(u));
            let sum: f64 = (1..parts).map(|u| (parts - u) as f64 * both(u)).sum();
            (parts as f64 * near(k) + sum) / square
        };
        Own((0..reach).map(|k| [at(k, 0), at(k, 1)]).collect())
    }

    /// Degrees of freedom of the mean square of `terms` differences, with the number of pairs at each lag.
    fn freedom(&self, terms: f64, pairs: impl Fn(f64) -> f64) -> f64 {
        let [noise, steady] = self.0[0];
        let mean = noise + steady;
        let at = |(k, [c, p]): (u32, &[f64; 2])| pairs(f64::from(k)) * (2.0 * c * c + 4.0 * c * p);
        2.0 * mean * mean * terms * terms / (0..).zip(&self.0).map(at).sum::<f64>()
    }
}
