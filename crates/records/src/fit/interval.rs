//! The 95 % interval of the square of a coefficient whose uncertainty grows with it.
//!
//! The variance of a fitted square x̂ is v_0 + v_1x + v_2x² as a function of its true value x. v_2x² is the scatter of
//! the noise itself, which is that of a χ² with 2/v_2 degrees of freedom. A fit that comes out low also claims to be
//! precise, so x̂ ± 2 standard errors at x̂ misses the truth too often. Instead, the interval contains every x for
//! which x̂ is not among the 2.5 % least or greatest outcomes (test inversion), with the quantiles of a normal
//! distribution corrected for the skewness of that χ² (Cornish and Fisher).

/// Number of standard deviations of a normal distribution within which 95 % lie.
pub const WITHIN_95: f64 = 1.959_963_984_540_054;
/// Probability outside them on one side.
const OUTSIDE: f64 = 0.025;
/// Halvings of a bracket, down to rounding.
const HALVINGS: usize = 60;
/// Skewness of χ² with 4 degrees of freedom, up to which the correction is useful; with fewer degrees there is no upper
/// end.
const MAX_SKEWED: f64 = core::f64::consts::SQRT_2;
/// Most doublings in search of an upper end.
const DOUBLINGS: usize = 40;

/// Variance of a fitted square as a function of its true value, by the coefficients `[v_0, v_1, v_2]`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Variance(pub [f64; 3]);

impl Variance {
    /// A variance that is the same at every x.
    pub(crate) fn constant(variance: f64) -> Variance {
        Variance([variance, 0.0, 0.0])
    }

    /// The sum of two variances.
    pub(crate) fn plus(&self, other: &Variance) -> Variance {
        let ([a0, a1, a2], [b0, b1, b2]) = (self.0, other.0);
        Variance([a0 + b0, a1 + b1, a2 + b2])
    }

    pub(crate) fn at(&self, x: f64) -> f64 {
        let [v0, v1, v2] = self.0;
        v0 + x * (v1 + x * v2)
    }

    /// Skewness of the outcomes if x is true; κ_3 of the noise itself is 2v_2²x³.
    pub(crate) fn skewness(&self, x: f64) -> f64 {
        2.0 * self.0[2] * self.0[2] * libm::pow(x / libm::sqrt(self.at(x)), 3.0)
    }

    /// Deviation from the middle, in standard deviations, of the outcome that a normal distribution would have at
    /// `sigmas`, if x is true.
    fn skewed(&self, x: f64, sigmas: f64) -> f64 {
        sigmas + (sigmas * sigmas - 1.0) / 6.0 * self.skewness(x).min(MAX_SKEWED)
    }

    /// The outcome at the quantile `sigmas` if x is true, shifted by `more` standard deviations.
    fn quantile(&self, x: f64, sigmas: f64, more: f64) -> f64 {
        let variance = self.at(x);
        if variance <= 0.0 {
            return x;
        }
        x + libm::sqrt(variance) * (self.skewed(x, sigmas) + more)
    }

    /// Corrections of the lower and the upper quantile, in standard deviations, to those of simulated outcomes whose
    /// mean is the true value; 0 without outcomes.
    pub(crate) fn corrections(&self, mut outcomes: Vec<f64>) -> [f64; 2] {
        outcomes.sort_by(f64::total_cmp);
        let count = outcomes.len() as f64;
        let mean = outcomes.iter().sum::<f64>() / count;
        let truth = mean.max(0.0);
        let deviation = libm::sqrt(self.at(truth));
        if outcomes.is_empty() || deviation <= 0.0 {
            return [0.0; 2];
        }
        // The p(n + 1)-th of the ranks 1 … n, with linear interpolation.
        let quantile = |p: f64| {
            let place = (p * (count + 1.0) - 1.0).clamp(0.0, count - 1.0);
            let (below, part) = (libm::floor(place), place - libm::floor(place));
            let above = libm::fmin(below + 1.0, count - 1.0);
            outcomes[below as usize] * (1.0 - part) + outcomes[above as usize] * part
        };
        let correction = |p: f64, sigmas: f64| (quantile(p) - mean) / deviation - self.skewed(truth, sigmas);
        [correction(OUTSIDE, -WITHIN_95), correction(1.0 - OUTSIDE, WITHIN_95)]
    }

    /// Ends of the interval of the square for an estimate of it, which may be negative. The lower end is 0 where
    /// nothing is excluded below; the upper one is `None` where the estimate scatters so much that nothing is excluded
    /// above.
    ///
    /// A negative estimate counts as 0 for the upper end. The `corrections` are those of the quantiles.
    pub(crate) fn interval(&self, estimate: f64, corrections: [f64; 2]) -> (f64, Option<f64>) {
        let found = estimate.max(0.0);
        let most = |x: f64| self.quantile(x, WITHIN_95, corrections[1]);
        let least = |x: f64| self.quantile(x, -WITHIN_95, corrections[0]);
        let low = match most(0.0) >= estimate {
            true => 0.0,
            false => bisect(0.0, found, |x| most(x) < found),
        };
        let step = libm::sqrt(self.at(found).max(0.0)).max(f64::MIN_POSITIVE);
        let is_excluded = |x: f64| least(x) > found;
        let beyond = (0..DOUBLINGS).map(|k| found + step * (1_u64 << k) as f64).find(|&x| is_excluded(x));
        (low, beyond.map(|beyond| bisect(found, beyond, |x| !is_excluded(x))))
    }
}

/// The point between `low` and `high` where `is_below` ceases to hold.
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

    const NONE: [f64; 2] = [0.0; 2];

    #[test]
    fn a_constant_variance_gives_two_standard_errors() {
        let (low, high) = Variance::constant(0.25).interval(3.0, NONE);
        assert!((low - (3.0 - 0.5 * WITHIN_95)).abs() < 1e-12, "{low}");
        assert!((high.unwrap() - (3.0 + 0.5 * WITHIN_95)).abs() < 1e-12, "{high:?}");
        let (low, high) = Variance::constant(0.25).interval(-1.0, NONE);
        assert!(low == 0.0 && (high.unwrap() - 0.5 * WITHIN_95).abs() < 1e-12, "{low}, {high:?}");
    }

    #[test]
    fn scatter_of_the_noise_itself_gives_the_interval_of_a_chi_squared() {
        // Quantiles of χ² at 2.5 and 97.5 % over the degrees, from SciPy 1.17.
        let table =
            [(10.0, 0.3246972780236841, 2.048317735029362), (50.0, 0.6471472770837674, 1.4284039173803946)];
        for (degrees, least, most) in table {
            let (low, high) = Variance([0.0, 0.0, 2.0 / degrees]).interval(1.0, NONE);
            assert!((low * most - 1.0).abs() < 0.02, "{degrees}: {low}, not {}", 1.0 / most);
            assert!((high.unwrap() * least - 1.0).abs() < 0.05, "{degrees}: {high:?}, not {}", 1.0 / least);
        }
        // One degree of freedom gives no upper limit.
        assert_eq!(Variance([0.0, 0.0, 2.0]).interval(1.0, NONE).1, None);
    }

    #[test]
    fn simulated_outcomes_give_the_quantiles_where_they_were_and_the_variance_takes_them_on() {
        // Exponential outcomes with the true value 3 and a standard deviation of 0.5, more skewed than any formula
        // here.
        let at = |p: f64| 3.0 - 0.5 * (1.0 + libm::log(1.0 - p));
        let outcomes: Vec<f64> = (1..2000).map(|i| at(f64::from(i) / 2000.0)).collect();
        let [least, most] = [at(OUTSIDE), at(1.0 - OUTSIDE)];
        for variance in [Variance::constant(0.25), Variance([0.0, 0.0, 0.25 / 9.0])] {
            let corrections = variance.corrections(outcomes.clone());
            for (sigmas, expected, more) in
                [(-WITHIN_95, least, corrections[0]), (WITHIN_95, most, corrections[1])]
            {
                let found = variance.quantile(3.0, sigmas, more);
                assert!((found - expected).abs() < 2e-3, "{variance:?}: {found}, not {expected}");
            }
            // The value lies in the interval of an outcome just inside the quantiles, and in none just outside.
            for (outcome, inside) in [(least, 0.01), (most, -0.01)] {
                let covers = |outcome| {
                    let (low, high) = variance.interval(outcome, corrections);
                    low <= 3.0 && high.is_none_or(|high| 3.0 <= high)
                };
                assert!(covers(outcome + inside) && !covers(outcome - inside), "{variance:?}, {outcome}");
            }
        }
        assert_eq!(Variance::constant(0.25).corrections(vec![]), NONE);
    }
}
