//! Uncertainty of each coefficient of a fit.
//!
//! The covariance of the squares and of the logarithms of the shapes is the inverse of JᵀC⁻¹J, where J is the
//! derivative of the curve with respect to them. A term that is not in use is assessed as if it entered next, by the
//! estimate that it would then have, which may be negative.

use crate::fit::covariance::Growth;
use crate::fit::evidence::Evidence;
use crate::fit::interval::{Variance, WITHIN_95};
use crate::fit::nnls::dot;
use crate::fit::search::{Fitted, System, shape_range};
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
                    shape: term.has_shape().then(|| Shape::of(shape, error(column + 1))),
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
    fn of(value: f64, logarithmic_error: f64) -> Shape {
        let factor = libm::exp(WITHIN_95 * logarithmic_error);
        Shape { value, standard_error: value * logarithmic_error, interval: [value / factor, value * factor] }
    }
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
