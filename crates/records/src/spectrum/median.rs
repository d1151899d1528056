//! The median of densities.

use core::f64::consts::FRAC_2_PI;

use crate::allan::chi_squared;
use crate::spectrum::NEIGHBOURS;

/// The distribution of the median of densities at neighbouring frequencies, in units of their mean.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Median {
    /// Median of one density.
    pub(crate) factor: f64,
    /// Variance of the median of n densities over its square, times n.
    variance: f64,
}

impl Median {
    /// That of densities with these degrees of freedom; `None` if they have no quantiles.
    ///
    /// The variance of a median of n values is Σ_d C_d/(4f²n) with the density f of one value at its median and the
    /// correlation C_d = (2/π) arcsin ρ_d of the signs of two values, d places apart, around it. The latter is that of
    /// normal values.
    pub(crate) fn new(freedom: f64) -> Option<Median> {
        let median = chi_squared::quantile(0.5, freedom)?;
        let half = 0.5 * freedom;
        let log = (half - 1.0) * libm::log(0.5 * median) - 0.5 * median - libm::lgamma(half);
        // Of χ² itself, whose mean is `freedom`: f times the median is free of the unit.
        let density = 0.5 * libm::exp(log) * median;
        let signs = 1.0 + NEIGHBOURS.map(|c| 2.0 * FRAC_2_PI * libm::asin(c)).iter().sum::<f64>();
        Some(Median { factor: median / freedom, variance: signs / (4.0 * density * density) })
    }

    /// Degrees of freedom of a mean that scatters as much as the median of `count` densities.
    pub(crate) fn freedom(&self, count: usize) -> f64 {
        2.0 * count as f64 / self.variance
    }

    /// The mean of densities by their median, which a few of them cannot change by much however large they are.
    pub(crate) fn mean(&self, mut values: Vec<f64>) -> Option<f64> {
        let middle = values.len() / 2;
        let is_even = values.len().is_multiple_of(2);
        if values.is_empty() {
            return None;
        }
        let (below, upper, _) = values.select_nth_unstable_by(middle, f64::total_cmp);
        let lower = below.iter().copied().filter(|_| is_even).fold(f64::NEG_INFINITY, f64::max);
        let median = if is_even { 0.5 * (lower + *upper) } else { *upper };
        Some(median / self.factor)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_factor_and_the_variance_are_those_of_scipy() {
        // chi2.median(v)/v and Σ_d C_d/(4·(v·chi2.pdf(v·m, v))²)/m² with that m, SciPy 1.17.
        for (freedom, factor, variance) in FROM_SCIPY {
            let found = Median::new(freedom).unwrap();
            assert!((found.factor / factor - 1.0).abs() < 1e-7, "{freedom}: {}", found.factor);
            assert!((found.variance / variance - 1.0).abs() < 1e-7, "{freedom}: {}", found.variance);
        }
    }

    #[test]
    fn the_median_of_an_even_number_is_between_the_middle_ones() {
        let one = Median { factor: 1.0, variance: 1.0 };
        assert_eq!(one.mean(vec![4.0, 1.0, 9.0, 2.0]), Some(3.0));
        assert_eq!(one.mean(vec![4.0, 1.0, 9.0]), Some(4.0));
        assert_eq!(one.mean(vec![]), None);
    }

    const FROM_SCIPY: [(f64, f64, f64); 3] = [
        (2.0, 0.6931471805599455, 3.375497338446589),
        (5.785714285714286, 0.8874347777611452, 0.9703553261931418),
        (28.52112676056338, 0.9767251465076218, 0.1821607320326096),
    ];
}
