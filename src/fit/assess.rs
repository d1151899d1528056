//! What a fit says of each coefficient, and how sure it is.

use super::nnls::dot;
use super::search::{Fitted, Solution, System};
use super::{FitError, Term, survival};
use crate::theory::allan::Process;
use crate::theory::cholesky;

/// Standard deviations of a normal distribution within which 95 % lie.
const WITHIN_95: f64 = 1.959_963_984_540_054;
/// Logarithmic step of the derivative by a shape.
const STEP: f64 = 1e-4;

/// How far a coefficient is known. A bound is the upper end of the 95 % interval, so that it fails 2.5 % of the time: a
/// closer one for coefficients that turn out small would spoil the intervals of those that do not.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Verdict {
    /// The 95 % interval of its square does not contain 0.
    Identified,
    /// The best fit has none of it; it is below this.
    AtBoundary { below: f64 },
    /// The curve asks for some of it, but not for sure: it is below this. Without a bound it looks like the other terms
    /// together, or has a shape that the curve does not show.
    NotIdentifiable { below: Option<f64> },
}

/// Correlation time, s, or frequency, Hz, with its 95 % interval.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Shape {
    pub value: f64,
    pub standard_error: f64,
    pub interval: [f64; 2],
}

/// A coefficient, in the unit of its [`Term`]. Value and shape are there only where it is identified.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Coefficient {
    pub term: Term,
    pub value: Option<f64>,
    /// Of the value: that of its square over twice the value.
    pub standard_error: Option<f64>,
    /// Roots of the 95 % interval of the square, which is the one that is nearly normal; from 0 where that reaches below,
    /// and absent where there is no bound.
    pub interval: Option<[f64; 2]>,
    pub shape: Option<Shape>,
    pub verdict: Verdict,
}

/// A fitted curve.
#[derive(Debug, Clone, PartialEq)]
pub struct Fit {
    /// One for each term asked for or tried, in that order.
    pub coefficients: Vec<Coefficient>,
    /// The best fit as a noise model, with all it takes to draw the curve: also terms that are not identified.
    pub process: Process,
    /// Residuals in the measure of the covariance.
    pub chi_squared: f64,
    /// Points less the fitted parameters.
    pub degrees_of_freedom: usize,
}

impl Fit {
    pub fn coefficient(&self, term: Term) -> Option<&Coefficient> {
        self.coefficients.iter().find(|coefficient| coefficient.term == term)
    }

    /// Probability of residuals as large or larger if the model holds; `None` without degrees of freedom.
    ///
    /// Of Gaussian estimates: those of one record at long τ are not, and their χ² scatters more.
    pub fn p_value(&self) -> Option<f64> {
        (self.degrees_of_freedom > 0).then(|| survival(self.chi_squared, self.degrees_of_freedom))
    }
}

/// Judges every one of `terms` from the best fit of those chosen.
///
/// The covariance of squares and logarithms of shapes is the inverse of JᵀC⁻¹J, J being the derivative of the curve. A
/// term that is not in use is judged as if it entered next: by the estimate, possibly negative, that it would have, and that
/// estimate's standard error, where a negative one counts as 0 for the bound.
pub(super) fn assess(system: &System, solution: &Solution, terms: &[Term]) -> Result<Fit, FitError> {
    let used: Vec<Fitted> = solution.terms.iter().copied().filter(|fitted| fitted.square > 0.0).collect();
    let parameters: usize = used.iter().map(|fitted| fitted.term.parameters()).sum();
    let points = system.curve().ms().len();
    let degrees_of_freedom =
        points.checked_sub(parameters).ok_or(FitError::TooFewPoints { points, parameters })?;
    let residual = system.residual(&used);
    let coefficients = terms.iter().map(|&term| coefficient(system, &used, &residual, term)).collect();
    let model: Vec<(Term, f64, f64)> =
        used.iter().map(|fitted| (fitted.term, fitted.square, fitted.shape)).collect();
    Ok(Fit {
        coefficients,
        process: system.curve().process(&model),
        chi_squared: solution.chi_squared,
        degrees_of_freedom,
    })
}

fn coefficient(system: &System, used: &[Fitted], residual: &[f64], term: Term) -> Coefficient {
    let without_value = |below: Option<f64>, verdict| Coefficient {
        term,
        value: None,
        standard_error: None,
        interval: below.map(|below| [0.0, below]),
        shape: None,
        verdict,
    };
    let uncertain = |below| without_value(below, Verdict::NotIdentifiable { below });
    let unknown = uncertain(None);
    let Some(place) = used.iter().position(|fitted| fitted.term == term) else {
        if term.has_shape() {
            return unknown;
        }
        let mut columns = derivatives(system, used);
        columns.push(system.column(term, 1.0));
        let Some(inverse) = Inverse::of(&columns) else { return unknown };
        let (estimate, error) = (inverse.row_times(columns.len() - 1, &columns, residual), inverse.error(columns.len() - 1));
        let below = libm::sqrt(estimate.max(0.0) + WITHIN_95 * error);
        return match estimate > 0.0 {
            true => uncertain(Some(below)),
            false => without_value(Some(below), Verdict::AtBoundary { below }),
        };
    };
    let columns = derivatives(system, used);
    let Some(inverse) = Inverse::of(&columns) else { return unknown };
    let column: usize = used[..place].iter().map(|fitted| fitted.term.parameters()).sum();
    let (square, error) = (used[place].square, inverse.error(column));
    let shape = term.has_shape().then(|| Shape::of(used[place].shape, inverse.error(column + 1)));
    let [low, high] = [square - WITHIN_95 * error, square + WITHIN_95 * error];
    if low <= 0.0 {
        return uncertain(Some(libm::sqrt(high)).filter(|_| !term.has_shape()));
    }
    if shape.is_some_and(|shape| is_at_the_end(shape.value, system.shape_range(term))) {
        return unknown;
    }
    Coefficient {
        term,
        value: Some(libm::sqrt(square)),
        standard_error: Some(0.5 * error / libm::sqrt(square)),
        interval: Some([libm::sqrt(low), libm::sqrt(high)]),
        shape,
        verdict: Verdict::Identified,
    }
}

impl Shape {
    fn of(value: f64, logarithmic_error: f64) -> Shape {
        let factor = libm::exp(WITHIN_95 * logarithmic_error);
        Shape { value, standard_error: value * logarithmic_error, interval: [value / factor, value * factor] }
    }
}

/// Whether a search ended where it had to, and not at a minimum.
fn is_at_the_end(shape: f64, [low, high]: [f64; 2]) -> bool {
    shape < 1.01 * low || shape > high / 1.01
}

/// Derivative of the curve by the square of each term, followed by that of its logarithm of the shape.
fn derivatives(system: &System, used: &[Fitted]) -> Vec<Vec<f64>> {
    let mut columns = Vec::new();
    for fitted in used {
        columns.push(system.column(fitted.term, fitted.shape));
        if fitted.term.has_shape() {
            let [above, below] = [STEP, -STEP].map(|step| system.column(fitted.term, fitted.shape * libm::exp(step)));
            let slope = |(a, b): (&f64, &f64)| fitted.square * (a - b) / (2.0 * STEP);
            columns.push(above.iter().zip(&below).map(slope).collect());
        }
    }
    columns
}

/// The inverse of JᵀJ.
struct Inverse {
    rows: Vec<Vec<f64>>,
}

impl Inverse {
    /// `None` where columns depend on each other to working precision.
    fn of(columns: &[Vec<f64>]) -> Option<Inverse> {
        let count = columns.len();
        let lengths: Vec<f64> = columns.iter().map(|column| libm::sqrt(dot(column, column))).collect();
        let cosine = |i: usize, j: usize| dot(&columns[i], &columns[j]) / (lengths[i] * lengths[j]);
        let factor = cholesky::definite(count, cosine)?;
        let row = |i: usize| {
            let unit = (0..count).map(|j| if i == j { 1.0 / lengths[i] } else { 0.0 }).collect();
            cholesky::solve(&factor, unit).iter().zip(&lengths).map(|(x, length)| x / length).collect()
        };
        Some(Inverse { rows: (0..count).map(row).collect() })
    }

    fn error(&self, i: usize) -> f64 {
        libm::sqrt(self.rows[i][i])
    }

    /// Entry i of (JᵀJ)⁻¹Jᵀr: the step of a parameter towards the least squares.
    fn row_times(&self, i: usize, columns: &[Vec<f64>], residual: &[f64]) -> f64 {
        self.rows[i].iter().zip(columns).map(|(x, column)| x * dot(column, residual)).sum()
    }
}
