//! The likelihood of the estimated square of a coefficient, for every true value of it.

use crate::fit::interval::Variance;

/// Skewness of a χ² with one degree of freedom, the largest for the noise of one record.
const MAX_SKEWED: f64 = 2.0 * core::f64::consts::SQRT_2;
/// Skewness below which a distribution counts as normal.
const NOT_SKEWED: f64 = 1e-5;
/// Most doublings in search of a true value, then most steps within its bracket down to the precision.
const DOUBLINGS: usize = 60;
const STEPS: usize = 200;
const PRECISION: f64 = 1e-13;
/// Bound of a deviate, so that infinite ones are handled too.
const FARTHEST: f64 = 1e6;

/// The estimate of a square, with its variance as a function of the true value.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Evidence {
    /// At least 0, because a negative estimate says no less than 0.
    estimate: f64,
    variance: Variance,
}

impl Evidence {
    /// An estimate with its variance; one below 0 counts as 0.
    pub fn new(estimate: f64, variance: Variance) -> Evidence {
        Evidence { estimate: estimate.max(0.0), variance }
    }

    /// The same estimate with `times` the variance.
    pub fn widened(&self, times: f64) -> Evidence {
        Evidence { variance: Variance(self.variance.0.map(|v| times * v)), ..*self }
    }

    /// The estimate.
    pub fn estimate(&self) -> f64 {
        self.estimate
    }

    /// The standard normal deviate that is as rare as the estimate if the square is `x`; it falls with x.
    ///
    /// The estimate is taken as a shifted and scaled χ² with the skewness at `x`, which is transformed by its cube root
    /// (Wilson and Hilferty). Unlike the first terms of Cornish and Fisher, this rises everywhere, so that an estimate
    /// far below x is handled too.
    pub fn deviate(&self, x: f64) -> f64 {
        let variance = self.variance.at(x);
        if variance <= 0.0 {
            return if self.estimate > x { f64::INFINITY } else { 0.0 };
        }
        let distance = (self.estimate - x) / libm::sqrt(variance);
        let skewness = self.variance.skewness(x).min(MAX_SKEWED);
        if skewness < NOT_SKEWED {
            return distance;
        }
        let middle = 1.0 - skewness * skewness / 36.0;
        (libm::cbrt(1.0 + 0.5 * skewness * distance) - middle) * 6.0 / skewness
    }

    /// The square for which the estimate has the deviate `deviate`; 0 where it is less for every square, `None` where
    /// it is greater for every square.
    pub fn square_at(&self, deviate: f64) -> Option<f64> {
        if self.deviate(0.0) <= deviate {
            return Some(0.0);
        }
        let step = libm::sqrt(self.variance.at(self.estimate).max(0.0)).max(f64::MIN_POSITIVE);
        let mut high = (0..DOUBLINGS)
            .map(|k| self.estimate + step * (1_u64 << k) as f64)
            .find(|&x| self.deviate(x) <= deviate)?;
        // False position (Illinois): the value at the end that stays is halved.
        let mut low = 0.0;
        let mut above = self.deviate(low).min(FARTHEST) - deviate;
        let mut below = self.deviate(high) - deviate;
        let mut stays = 0;
        for _ in 0..STEPS {
            let middle = (low * below - high * above) / (below - above);
            let found = self.deviate(middle) - deviate;
            if found > 0.0 {
                below *= if stays == 1 { 0.5 } else { 1.0 };
                (low, above, stays) = (middle, found, 1);
            } else {
                above *= if stays == -1 { 0.5 } else { 1.0 };
                (high, below, stays) = (middle, found, -1);
            }
            if found.abs() < PRECISION || high - low < PRECISION * high {
                return Some(middle);
            }
        }
        Some(0.5 * (low + high))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_normal_estimate_is_as_far_as_its_standard_errors() {
        let evidence = Evidence::new(3.0, Variance::constant(0.25));
        assert!((evidence.deviate(2.0) - 2.0).abs() < 1e-12 && (evidence.deviate(4.0) + 2.0).abs() < 1e-12);
        assert!((evidence.square_at(-2.0).unwrap() - 4.0).abs() < 1e-12);
        assert_eq!(evidence.square_at(6.5), Some(0.0));
        assert!((evidence.widened(4.0).deviate(2.0) - 1.0).abs() < 1e-12);
    }

    #[test]
    fn noise_alone_is_a_chi_squared() {
        // SciPy 1.17: norm.ppf(chi2.cdf(ν·x̂/x, ν)) for x̂ = 1.
        let table: [(f64, f64, f64); 6] = [
            (4.0, 0.25, 2.7457),
            (4.0, 4.0, -1.3395),
            (10.0, 0.5, 1.8919),
            (10.0, 3.0, -1.9182),
            (100.0, 0.8, 1.6850),
            (100.0, 1.4, -2.2046),
        ];
        for (degrees, x, expected) in table {
            let found = Evidence::new(1.0, Variance([0.0, 0.0, 2.0 / degrees])).deviate(x);
            assert!((found - expected).abs() < 0.02, "{degrees} degrees, {x}: {found}, not {expected}");
        }
    }

    #[test]
    fn a_square_has_the_deviate_that_it_was_sought_for() {
        for variance in [[0.1, 0.0, 0.0], [0.1, 0.2, 0.05], [1e-6, 1e-3, 0.5], [0.0, 0.3, 2.0]] {
            for estimate in [0.0, 1e-3, 1.0, 30.0] {
                let evidence = Evidence::new(estimate, Variance(variance));
                for deviate in [-1.5, -0.3, 0.0, 0.3, 1.96] {
                    let Some(square) = evidence.square_at(deviate).filter(|square| *square > 0.0) else {
                        continue;
                    };
                    let found = evidence.deviate(square);
                    assert!(
                        (found - deviate).abs() < 1e-9,
                        "{variance:?}, {estimate}: {found}, not {deviate}"
                    );
                }
            }
        }
    }

    #[test]
    fn the_place_of_an_estimate_falls_with_the_true_square() {
        for variance in [[0.1, 0.0, 0.0], [0.1, 0.2, 0.05], [1e-6, 1e-3, 0.5], [0.0, 0.3, 2.0]] {
            for estimate in [0.0, 0.3, 1.0, 30.0] {
                let evidence = Evidence::new(estimate, Variance(variance));
                let places: Vec<f64> =
                    (-60..60).map(|k| evidence.deviate(libm::exp2(f64::from(k) / 4.0))).collect();
                let falls = places.windows(2).all(|pair| pair[1] < pair[0]);
                assert!(falls, "{variance:?}, {estimate}: {places:?}");
            }
        }
    }
}
