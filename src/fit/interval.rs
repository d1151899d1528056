//! The 95 % interval of the square of a coefficient whose uncertainty grows with it.
//!
//! The variance of a fitted square x̂ is v_0 + v_1x + v_2x² in its true value x: v_2x² is the scatter of the noise
//! itself, which is that of a χ² of 2/v_2 degrees of freedom. A fit that comes out low also claims to be precise, so
//! that x̂ ± 2 standard errors at x̂ misses the truth too often. The interval holds instead every x of which x̂ is not
//! among the 2.5 % least or greatest outcomes (test inversion), with the quantiles of a normal distribution corrected
//! for the skewness of that χ² (Cornish and Fisher).

/// Standard deviations of a normal distribution within which 95 % lie.
pub(crate) const WITHIN_95: f64 = 1.959_963_984_540_054;
/// Halvings of a bracket: down to rounding.
const HALVINGS: usize = 60;
/// Skewness of χ² with 4 degrees of freedom, up to which the correction is of use: with fewer there is no upper end.
const MOST_SKEWED: f64 = core::f64::consts::SQRT_2;
/// Doublings in search of an upper end.
const DOUBLINGS: usize = 40;

/// Variance of a fitted square in its true value: `[v_0, v_1, v_2]`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Variance(pub [f64; 3]);

impl Variance {
    /// The same at every x.
    pub(super) fn constant(variance: f64) -> Variance {
        Variance([variance, 0.0, 0.0])
    }

    pub(crate) fn at(&self, x: f64) -> f64 {
        let [v0, v1, v2] = self.0;
        v0 + x * (v1 + x * v2)
    }

    /// Of the outcomes if x is true: κ_3 of the noise itself is 2v_2²x³.
    pub(super) fn skewness(&self, x: f64) -> f64 {
        2.0 * self.0[2] * self.0[2] * libm::pow(x / libm::sqrt(self.at(x)), 3.0)
    }

    /// The outcome that is `sigmas` from the middle if x is true.
    fn quantile(&self, x: f64, sigmas: f64) -> f64 {
        let variance = self.at(x);
        if variance <= 0.0 {
            return x;
        }
        let deviation = libm::sqrt(variance);
        x + deviation * (sigmas + (sigmas * sigmas - 1.0) / 6.0 * self.skewness(x).min(MOST_SKEWED))
    }

    /// Ends of the interval of the square for an estimate of it, which may be negative: the lower one 0 where nothing is
    /// excluded, the upper one `None` where the estimate scatters so much that nothing is.
    ///
    /// A negative estimate counts as 0 for the upper end.
    pub(super) fn interval(&self, estimate: f64) -> (f64, Option<f64>) {
        let found = estimate.max(0.0);
        let low = match self.quantile(0.0, WITHIN_95) >= estimate {
            true => 0.0,
            false => bisect(0.0, found, |x| self.quantile(x, WITHIN_95) < found),
        };
        let step = libm::sqrt(self.at(found).max(0.0)).max(f64::MIN_POSITIVE);
        let is_excluded = |x: f64| self.quantile(x, -WITHIN_95) > found;
        let beyond = (0..DOUBLINGS).map(|k| found + step * (1_u64 << k) as f64).find(|&x| is_excluded(x));
        (low, beyond.map(|beyond| bisect(found, beyond, |x| !is_excluded(x))))
    }
}

/// Where `is_below` ends between low and high.
fn bisect(mut low: f64, mut high: f64, is_below: impl Fn(f64) -> bool) -> f64 {
    for _ in 0..HALVINGS {
        let middle = 0.5 * (low + high);
        if is_below(middle) {
            low = middle;
        } else {
            high = middle;
        }
    }
    0.5 * (low + high)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_constant_variance_gives_two_standard_errors() {
        let (low, high) = Variance::constant(0.25).interval(3.0);
        assert!((low - (3.0 - 0.5 * WITHIN_95)).abs() < 1e-12, "{low}");
        assert!((high.unwrap() - (3.0 + 0.5 * WITHIN_95)).abs() < 1e-12, "{high:?}");
        let (low, high) = Variance::constant(0.25).interval(-1.0);
        assert!(low == 0.0 && (high.unwrap() - 0.5 * WITHIN_95).abs() < 1e-12, "{low}, {high:?}");
    }

    #[test]
    fn scatter_of_the_noise_itself_gives_the_interval_of_a_chi_squared() {
        // Quantiles of χ² at 2.5 and 97.5 % over the degrees, from SciPy 1.17.
        let table =
            [(10.0, 0.3246972780236841, 2.048317735029362), (50.0, 0.6471472770837674, 1.4284039173803946)];
        for (degrees, least, most) in table {
            let (low, high) = Variance([0.0, 0.0, 2.0 / degrees]).interval(1.0);
            assert!((low * most - 1.0).abs() < 0.02, "{degrees}: {low}, not {}", 1.0 / most);
            assert!((high.unwrap() * least - 1.0).abs() < 0.05, "{degrees}: {high:?}, not {}", 1.0 / least);
        }
        // One degree of freedom says nothing of how large it can be.
        assert_eq!(Variance([0.0, 0.0, 2.0]).interval(1.0).1, None);
    }
}
