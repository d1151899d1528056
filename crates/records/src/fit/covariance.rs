//! The covariance between the estimates of a curve, prepared for weighting.

use crate::fit::interval::Variance;
use crate::fit::nnls::dot;
use crate::fit::search::Fitted;
use crate::fit::{Curve, FitError};
use sagnac_theory::allan::gaussian::{self, Components};
use sagnac_theory::allan::{Process, Term};
use sagnac_theory::cholesky;

/// Independent variance added to every estimate, relative to its own variance: the least of these values that makes the
/// correlations positive definite.
///
/// Neighbours of a dense curve are nearly the same number, and their difference is known only to the precision of the
/// covariance. Without this addition, the weights of such differences could grow without bound.
const OWN: [f64; 3] = [1e-4, 1e-3, 1e-2];

/// A covariance matrix and the factor of its correlations.
#[derive(Debug, Clone, PartialEq)]
pub struct Covariance {
    rows: Vec<Vec<f64>>,
    deviations: Vec<f64>,
    factor: Vec<Vec<f64>>,
}

impl Covariance {
    /// The covariance given by a symmetric matrix, (″/s)⁴, in the order of the curve.
    ///
    /// # Errors
    /// The matrix is not positive definite even with 1 % added to its diagonal.
    pub fn new(rows: Vec<Vec<f64>>) -> Result<Covariance, FitError> {
        let deviations: Vec<f64> = rows.iter().enumerate().map(|(i, row)| libm::sqrt(row[i])).collect();
        if !deviations.iter().all(|x| x.is_finite() && *x > 0.0) {
            return Err(FitError::NotDefinite);
        }
        let correlation = |i: usize, j: usize| rows[i][j] / (deviations[i] * deviations[j]);
        let with_own = |own: &f64| {
            cholesky::definite(rows.len(), |i, j| correlation(i, j) + if i == j { *own } else { 0.0 })
        };
        let factor = OWN.iter().find_map(with_own).ok_or(FitError::NotDefinite)?;
        Ok(Covariance { rows, deviations, factor })
    }

    /// The covariance of the overlapping estimates of one record of a Gaussian process, in closed form; see
    /// [`gaussian::covariance`].
    ///
    /// # Errors
    /// The process has no noise.
    pub fn of_process(process: &Process, curve: &Curve) -> Result<Covariance, FitError> {
        Covariance::new(gaussian::covariance(process, curve.difference(), curve.samples(), curve.ms()))
    }

    /// The covariance of independent estimates with relative variances 2m/N, a first guess that needs no model.
    ///
    /// A last estimate from very few differences can be 1e4 times too low, and must not be weighted accordingly: it
    /// counts as no lower than the one before it falling as τ⁻², the steepest slope of noise.
    pub(crate) fn of_independent(curve: &Curve) -> Result<Covariance, FitError> {
        let mut values = curve.variances().to_vec();
        for i in 1..values.len() {
            let step = curve.ms()[i - 1] as f64 / curve.ms()[i] as f64;
            values[i] = values[i].max(values[i - 1] * step * step);
        }
        let own = |i: usize| {
            let deviation = values[i] * curve.costs()[i];
            2.0 * curve.ms()[i] as f64 / curve.samples() as f64 * deviation * deviation
        };
        let cell = |i: usize, j: usize| if i == j { own(i) } else { 0.0 };
        let points = curve.ms().len();
        Covariance::new((0..points).map(|i| (0..points).map(|j| cell(i, j)).collect()).collect())
    }

    /// The covariance of simulated curves, one per row, shrunk towards `model`, the covariance of the same process in
    /// closed form.
    ///
    /// A covariance from few realizations is singular or nearly so, and its inverse useless. It is replaced by
    /// (1 − λ)S + λT, where λ, by Ledoit and Wolf (2004), is the fraction of the squared distance between sample S and model T
    /// that is scatter of S, both measured in units of T. Many realizations, or a model that is far off, give S; few
    /// realizations, or a model that fits, give T.
    ///
    /// # Errors
    /// There are fewer than two rows, rows differ in length from the model, or the result is not positive definite.
    pub fn of_realizations(rows: &[Vec<f64>], model: &Covariance) -> Result<Covariance, FitError> {
        let points = model.rows.len();
        if rows.len() < 2 || rows.iter().any(|row| row.len() != points) {
            return Err(FitError::Realizations(rows.len()));
        }
        let count = rows.len() as f64;
        let mean: Vec<f64> =
            (0..points).map(|i| rows.iter().map(|row| row[i]).sum::<f64>() / count).collect();
        let centred: Vec<Vec<f64>> =
            rows.iter().map(|row| row.iter().zip(&mean).map(|(x, mean)| x - mean).collect()).collect();
        let white: Vec<Vec<f64>> = centred.iter().map(|row| model.whiten(row)).collect();
        let of_white = sample_covariance(&white);
        let norm: f64 = of_white.iter().flatten().map(|s| s * s).sum();
        let trace: f64 = (0..points).map(|i| of_white[i][i]).sum();
        let distance = norm - 2.0 * trace + points as f64;
        let length = |row: &Vec<f64>| row.iter().map(|x| x * x).sum::<f64>();
        let fourth: f64 = white.iter().map(|row| length(row) * length(row)).sum();
        let scatter = (fourth / count - norm) / count;
        let lambda = if distance > 0.0 { (scatter / distance).clamp(0.0, 1.0) } else { 1.0 };
        let sample = sample_covariance(&centred);
        let blend = |i: usize, j: usize| (1.0 - lambda) * sample[i][j] + lambda * model.rows[i][j];
        Covariance::new((0..points).map(|i| (0..points).map(|j| blend(i, j)).collect()).collect())
    }

    /// The matrix, (″/s)⁴.
    pub fn rows(&self) -> &[Vec<f64>] {
        &self.rows
    }

    /// Transforms numbers with this covariance to independent ones of variance 1.
    pub fn whiten(&self, values: &[f64]) -> Vec<f64> {
        let scaled = values.iter().zip(&self.deviations).map(|(x, deviation)| x / deviation).collect();
        cholesky::whiten(&self.factor, scaled)
    }

    /// Converts the coefficients of a linear function of whitened numbers to those of the original numbers.
    pub(crate) fn before_whitening(&self, coefficients: Vec<f64>) -> Vec<f64> {
        let scaled = cholesky::solve_transposed(&self.factor, coefficients);
        scaled.iter().zip(&self.deviations).map(|(x, deviation)| x / deviation).collect()
    }
}

/// The covariance of the estimates of one record as a function of the squares of some terms.
#[derive(Debug)]
pub(crate) struct Growth {
    /// Terms with their shapes.
    terms: Vec<(Term, f64)>,
    components: Components,
    /// What each term of unit square adds to the deviations that the estimates have in common; empty if they have none.
    common: Vec<Vec<f64>>,
    /// Standard deviation of each estimate over that of a record without gaps.
    costs: Vec<f64>,
}

impl Growth {
    pub(crate) fn new(curve: &Curve, terms: &[Fitted]) -> Growth {
        let unit: Vec<(Term, f64, f64)> =
            terms.iter().map(|fitted| (fitted.term, 1.0, fitted.shape)).collect();
        let components =
            Components::new(&curve.process(&unit), curve.difference(), curve.samples(), curve.ms());
        let of_term = |fitted: &Fitted| {
            let column = curve.of_term(fitted.term, 1.0, fitted.shape);
            column.iter().zip(curve.ms()).map(|(x, m)| x * curve.spread().at(*m)).collect()
        };
        let common =
            if curve.spread().most() > 0.0 { terms.iter().map(of_term).collect() } else { Vec::new() };
        let terms = terms.iter().map(|fitted| (fitted.term, fitted.shape)).collect();
        Growth { terms, components, common, costs: curve.costs().to_vec() }
    }

    /// The growth for the averaging factors from the position `start` on.
    pub(crate) fn from(&self, start: usize) -> Growth {
        let common = self.common.iter().map(|of_term| of_term[start..].to_vec()).collect();
        let (terms, components) = (self.terms.clone(), self.components.from(start));
        Growth { terms, components, common, costs: self.costs[start..].to_vec() }
    }

    /// Whether it belongs to these terms and shapes.
    pub(crate) fn is_of(&self, terms: &[Fitted]) -> bool {
        self.terms.iter().copied().eq(terms.iter().map(|fitted| (fitted.term, fitted.shape)))
    }

    /// The covariance for the squares of its terms.
    pub(crate) fn covariance(&self, terms: &[Fitted]) -> Result<Covariance, FitError> {
        let squares: Vec<f64> = terms.iter().map(|fitted| fitted.square).collect();
        let mut rows = self.components.covariance(&squares);
        for (row, own) in rows.iter_mut().zip(&self.costs) {
            row.iter_mut().zip(&self.costs).for_each(|(cell, other)| *cell *= own * other);
        }
        Covariance::new(rows)
    }

    /// Variance of a weighted sum of estimates of Gaussian noise as a function of the square of one term, with the others given.
    pub(crate) fn variance(&self, term: Term, weights: &[f64], square_of: impl Fn(Term) -> f64) -> Variance {
        let scaled: Vec<f64> = weights.iter().zip(&self.costs).map(|(weight, cost)| weight * cost).collect();
        let form = self.components.variance_of(&scaled);
        let mut variance = [0.0; 3];
        for ((a, _), row) in self.terms.iter().zip(&form) {
            for ((b, _), cell) in self.terms.iter().zip(row) {
                let power = usize::from(*a == term) + usize::from(*b == term);
                let others =
                    [a, b].into_iter().filter(|other| **other != term).map(|&other| square_of(other));
                variance[power] += cell * others.product::<f64>();
            }
        }
        Variance(variance)
    }

    /// The variance that the deviations which the estimates have in common add to it.
    pub(crate) fn variance_in_common(
        &self,
        term: Term,
        weights: &[f64],
        square_of: impl Fn(Term) -> f64,
    ) -> Variance {
        let (mut own, mut others) = (0.0, 0.0);
        for ((other, _), of_term) in self.terms.iter().zip(&self.common) {
            let deviation = dot(weights, of_term);
            match *other == term {
                true => own += deviation,
                false => others += square_of(*other) * deviation,
            }
        }
        Variance([others * others, 2.0 * own * others, own * own])
    }
}

/// Mean product of every pair of columns.
fn sample_covariance(rows: &[Vec<f64>]) -> Vec<Vec<f64>> {
    let points = rows.first().map_or(0, Vec::len);
    let mut sums = vec![vec![0.0; points]; points];
    for row in rows {
        for (sums, a) in sums.iter_mut().zip(row) {
            for (sum, b) in sums.iter_mut().zip(row) {
                *sum += a * b;
            }
        }
    }
    let count = rows.len() as f64;
    sums.into_iter().map(|row| row.into_iter().map(|sum| sum / count).collect()).collect()
}
