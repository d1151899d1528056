//! Uncertainty of each coefficient of a fit.
//!
//! The covariance of the squares and of the logarithms of the shapes is the inverse of JᵀC⁻¹J, where J is the
//! derivative of the curve with respect to them. A term that is not in use is assessed as if it entered next, by the
//! estimate that it would then have, which may be negative.
//!
//! # Interval of a square
//!
//! Its uncertainty grows with the square itself.
//! The variance of a fitted square x̂ is v_0 + v_1x + v_2x² as a function of its true value x. v_2x² is the scatter of
//! the noise itself, which is that of a χ² with 2/v_2 degrees of freedom. A fit that comes out low also claims to be
//! precise, so x̂ ± 2 standard errors at x̂ misses the truth too often. Instead, the 95 % interval contains every x for
//! which x̂ is not among the 2.5 % least or greatest outcomes (test inversion), with the quantiles of a normal
//! distribution corrected for the skewness of that χ² (Cornish and Fisher). [`Evidence`] is the likelihood of the estimated square
//! for every true value of it.

use crate::fit::curve::Growth;
use crate::fit::search::{Fitted, System, dot, shape_range};
use crate::fit::{Coefficient, Fit, FitError, Shape, Verdict};
use sagnac_theory::allan::Term;
use sagnac_theory::cholesky;

/// Logarithmic step of the derivative with respect to a shape.
const STEP: f64 = 1e-4;

/// A best fit, with everything needed to assess its terms.
pub(crate) struct Judge<'a> {
    system: &'a System<'a>,
    /// Terms with squares above 0.
    used: Vec<Fitted>,
    residual: Vec<f64>,
    /// The covariance as a function of the coefficients; without it, the covariance is constant.
    growth: Option<&'a Growth>,
    /// Terms that others could replace almost equally well.
    replaceable: &'a [Term],
    /// Simulated curves of the fit, one per row; without them, estimates are taken as nearly normal.
    realizations: &'a [Vec<f64>],
}

impl<'a> Judge<'a> {
    pub(crate) fn new(
        system: &'a System,
        fitted: &[Fitted],
        growth: Option<&'a Growth>,
        replaceable: &'a [Term],
        realizations: &'a [Vec<f64>],
    ) -> Judge<'a> {
        let used: Vec<Fitted> = fitted.iter().copied().filter(|fitted| fitted.square > 0.0).collect();
        let residual = system.residual(&used);
        Judge { system, used, residual, growth, replaceable, realizations }
    }

    /// The fit, with a coefficient for each of `terms`.
    pub(crate) fn fit(&self, terms: &[Term]) -> Result<Fit, FitError> {
        let parameters: usize = self.used.iter().map(|fitted| fitted.term.parameters()).sum();
        let points = self.residual.len();
        let degrees_of_freedom =
            points.checked_sub(parameters).ok_or(FitError::TooFewPoints { points, parameters })?;
        let model: Vec<(Term, f64, f64)> =
            self.used.iter().map(|fitted| (fitted.term, fitted.square, fitted.shape)).collect();
        Ok(Fit {
            coefficients: terms.iter().map(|&term| self.coefficient(term)).collect(),
            process: self.system.curve().process(&model),
            chi_squared: dot(&self.residual, &self.residual),
            degrees_of_freedom,
            tau_range: self.system.curve().tau_range(),
        })
    }

    /// Extends the intervals of identified coefficients to those that they have in this fit. A coefficient that is
    /// uncertain in this fit is not identified.
    pub(crate) fn widen(&self, fit: &mut Fit) {
        let is_used = |term: Term| self.used.iter().any(|fitted| fitted.term == term);
        for found in fit.coefficients.iter_mut().filter(|found| is_used(found.term)) {
            let (Verdict::Identified, Some([low, high])) = (found.verdict, found.interval) else { continue };
            let [least, most] = self.coefficient(found.term).interval.unwrap_or([low, high]);
            let [low, high] = [low.min(least), high.max(most)];
            found.interval = Some([low, high]);
            if low == 0.0 {
                let verdict = Verdict::NotIdentifiable { below: Some(high) };
                *found = Coefficient { value: None, standard_error: None, shape: None, verdict, ..*found };
            }
        }
    }

    fn coefficient(&self, term: Term) -> Coefficient {
        let without_value = |below: Option<f64>, verdict| Coefficient {
            term,
            value: None,
            standard_error: None,
            interval: below.map(|below| [0.0, below]),
            shape: None,
            verdict,
            evidence: None,
        };
        let uncertain = |below| without_value(below, Verdict::NotIdentifiable { below });
        let place = self.used.iter().position(|fitted| fitted.term == term);
        if term.has_shape() && place.is_none() {
            return uncertain(None);
        }
        let mut columns = derivatives(self.system, &self.used);
        let before = &self.used[..place.unwrap_or(self.used.len())];
        let column: usize = before.iter().map(|fitted| fitted.term.parameters()).sum();
        if place.is_none() {
            columns.push(self.system.column(term, 1.0));
        }
        let Some(inverse) = inverse(&columns) else { return uncertain(None) };
        let error = |i: usize| libm::sqrt(inverse[i][i]);
        let row = effects(&inverse[column], &columns);
        let estimate = place.map_or_else(|| dot(&row, &self.residual), |place| self.used[place].square);
        let weights = self.system.weights(row);
        let [gaussian, common] = self.variances(term, estimate, error(column), &weights);
        let variance = gaussian.plus(&common);
        let error_of_square = libm::sqrt(error(column) * error(column) + common.at(estimate));
        let outcomes = self.realizations.iter().map(|row| dot(&weights, row)).collect();
        let (low, high) = variance.interval(estimate, variance.corrections(outcomes));
        let below = high.map(libm::sqrt);
        let is_sure = low > 0.0 && !self.replaceable.contains(&term);
        let coefficient = match (place, high) {
            (None, Some(high)) if estimate <= 0.0 => {
                without_value(below, Verdict::AtBoundary { below: libm::sqrt(high) })
            }
            (Some(place), Some(high)) if is_sure => {
                let shape = self.used[place].shape;
                if term.has_shape() && is_at_the_end(shape, shape_range(self.system.curve(), term)) {
                    return uncertain(None);
                }
                Coefficient {
                    term,
                    value: Some(libm::sqrt(estimate)),
                    standard_error: Some(0.5 * error_of_square / libm::sqrt(estimate)),
                    interval: Some([libm::sqrt(low), libm::sqrt(high)]),
                    shape: term.has_shape().then(|| Shape::new(shape, error(column + 1))),
                    verdict: Verdict::Identified,
                    evidence: None,
                }
            }
            // At another time or frequency the bound would be different.
            _ => uncertain(below.filter(|_| !term.has_shape())),
        };
        Coefficient { evidence: Some(Evidence::new(estimate, variance)), ..coefficient }
    }

    /// Variance of the square of a term as a function of its true value, for Gaussian noise and from the deviations that the
    /// estimates have in common. The weights are those for Gaussian noise alone, because the differences of common deviations
    /// from one averaging time to another are too uncertain.
    fn variances(&self, term: Term, estimate: f64, error: f64, weights: &[f64]) -> [Variance; 2] {
        let known = Variance::constant(error * error);
        let Some(growth) = self.growth else { return [known, Variance::constant(0.0)] };
        let squares = |term: Term| {
            self.used.iter().find(|fitted| fitted.term == term).map_or(0.0, |fitted| fitted.square)
        };
        let of_model = growth.variance(term, weights, squares);
        let at_estimate = of_model.at(estimate.max(0.0));
        // The weights may come from a better covariance than that of the model, of which only the growth is used.
        let scale = error * error / at_estimate;
        let gaussian = if scale.is_finite() { Variance(of_model.0.map(|v| scale * v)) } else { known };
        let common = growth.variance_in_common(term, weights, squares);
        [gaussian, common]
    }
}

impl Shape {
    fn new(value: f64, logarithmic_error: f64) -> Shape {
        let factor = libm::exp(WITHIN_95 * logarithmic_error);
        Shape { value, standard_error: value * logarithmic_error, interval: [value / factor, value * factor] }
    }
}

/// Standard errors of the logarithms of the shape of a term, of its square, and of its square if the shape is known; `None` where other
/// parameters can replace them.
pub(crate) fn errors_of_shape(system: &System, fitted: &[Fitted], term: Term) -> Option<[f64; 3]> {
    let used: Vec<Fitted> = fitted.iter().copied().filter(|fitted| fitted.square > 0.0).collect();
    let place = used.iter().position(|fitted| fitted.term == term)?;
    let before: usize = used[..place].iter().map(|fitted| fitted.term.parameters()).sum();
    let inverse = inverse(&derivatives(system, &used))?;
    let [square, shape] = [before, before + 1];
    let known =
        inverse[square][square] - inverse[square][shape] * inverse[square][shape] / inverse[shape][shape];
    let relative = |variance: f64| libm::sqrt(variance) / used[place].square;
    Some([libm::sqrt(inverse[shape][shape]), relative(inverse[square][square]), relative(known)])
}

/// Whether a search ended at a limit of its range instead of at a minimum.
fn is_at_the_end(shape: f64, [low, high]: [f64; 2]) -> bool {
    shape < 1.01 * low || shape > high / 1.01
}

/// Derivative of the curve with respect to the square of each term, followed by that with respect to the logarithm of
/// its shape.
fn derivatives(system: &System, used: &[Fitted]) -> Vec<Vec<f64>> {
    let mut columns = Vec::new();
    for fitted in used {
        columns.push(system.column(fitted.term, fitted.shape));
        if fitted.term.has_shape() {
            let [above, below] =
                [STEP, -STEP].map(|step| system.column(fitted.term, fitted.shape * libm::exp(step)));
            let slope = |(a, b): (&f64, &f64)| fitted.square * (a - b) / (2.0 * STEP);
            columns.push(above.iter().zip(&below).map(slope).collect());
        }
    }
    columns
}

/// The inverse of JᵀJ; `None` where columns depend on each other to working precision.
fn inverse(columns: &[Vec<f64>]) -> Option<Vec<Vec<f64>>> {
    let count = columns.len();
    let lengths: Vec<f64> = columns.iter().map(|column| libm::sqrt(dot(column, column))).collect();
    let cosine = |i: usize, j: usize| dot(&columns[i], &columns[j]) / (lengths[i] * lengths[j]);
    let factor = cholesky::definite(count, cosine)?;
    let row = |i: usize| {
        let unit = (0..count).map(|j| if i == j { 1.0 / lengths[i] } else { 0.0 }).collect();
        cholesky::solve(&factor, unit).iter().zip(&lengths).map(|(x, length)| x / length).collect()
    };
    Some((0..count).map(row).collect())
}

/// A row of (JᵀJ)⁻¹Jᵀ from that of the inverse: the effect of each point on a parameter.
fn effects(inverse: &[f64], columns: &[Vec<f64>]) -> Vec<f64> {
    let points = columns.first().map_or(0, Vec::len);
    let at = |point: usize| inverse.iter().zip(columns).map(|(x, column)| x * column[point]).sum();
    (0..points).map(at).collect()
}

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
    fn skewness(&self, x: f64) -> f64 {
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

/// Skewness of a χ² with one degree of freedom, the largest for the noise of one record.
const MAX_SKEWED_EVIDENCE: f64 = 2.0 * core::f64::consts::SQRT_2;
/// Skewness below which a distribution counts as normal.
const NOT_SKEWED: f64 = 1e-5;
/// Most doublings in search of a true value, then most steps within its bracket down to the precision.
const DOUBLINGS_OF_EVIDENCE: usize = 60;
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
        let skewness = self.variance.skewness(x).min(MAX_SKEWED_EVIDENCE);
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
        let mut high = (0..DOUBLINGS_OF_EVIDENCE)
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
