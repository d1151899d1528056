//! The input of a fit: estimates of the Allan variance of a record at averaging factors, and the covariance between them, prepared
//! for weighting.

use crate::allan::{Angles, Deviation, Overdispersion, Point, curve};
use crate::fit::search::{Fitted, dot};
use crate::fit::uncertainty::Variance;
use sagnac_theory::allan::gaussian::{self, Components};
use sagnac_theory::allan::{Difference, Estimator, Process, Term, continuous_variance, flicker};
use sagnac_theory::cholesky;

/// Estimates of one record, or their mean over many.
#[derive(Debug, Clone, PartialEq)]
pub struct Curve {
    sample_s: f64,
    samples: u64,
    difference: Difference,
    ms: Vec<u64>,
    variances: Vec<f64>,
    octaves: usize,
    spread: Overdispersion,
    /// Standard deviation of each estimate over that of a record without gaps.
    costs: Vec<f64>,
    /// Averaging times of points that are of no record, s; empty for a record.
    taus_s: Vec<f64>,
}

/// Why a curve cannot be fitted.
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
pub enum FitError {
    /// The two lists differ in length.
    #[error("{ms} averaging factors for {variances} variances: a curve needs as many of both")]
    Lengths {
        /// Number of averaging factors.
        ms: usize,
        /// Number of variances.
        variances: usize,
    },
    /// A variance has no logarithm.
    #[error(
        "the variance at m = {m} is {value}: a fit needs finite values above 0; a constant record has none"
    )]
    NotPositive {
        /// Its averaging factor.
        m: u64,
        /// Its value.
        value: f64,
    },
    /// Averaging factors are out of order, or 0; this is the first that does not ascend.
    #[error("averaging factors must ascend from 1; m = {0} does not")]
    NotAscending(u64),
    /// The record has no difference of that length.
    #[error("m = {m} is too long for a record of {samples} samples")]
    TooLong {
        /// The averaging factor.
        m: u64,
        /// Number of samples in the record.
        samples: u64,
    },
    /// There are more unknowns than points.
    #[error(
        "{points} points cannot determine {parameters} parameters: leave out terms or take more averaging factors"
    )]
    TooFewPoints {
        /// Number of variances.
        points: usize,
        /// Number of parameters of the terms.
        parameters: usize,
    },
    /// The list of terms is empty.
    #[error("no terms to fit")]
    NoTerms,
    /// The record has this number of samples, more than the flicker model of the covariance allows.
    #[error("flicker is modelled up to 2^27 samples, and the record has {0}")]
    TooManySamples(u64),
    /// Rounding has corrupted the covariance, as it does where points are too close to each other.
    #[error("the covariance of the estimates is not positive definite")]
    NotDefinite,
    /// The terms describe no range of τ of the curve.
    #[error(
        "model rejected: the fitted terms describe the curve over no range of τ\nfit other terms, or set the range, \
         as in `fit_from = 1s`"
    )]
    NotDescribed,
    /// This number of simulated records gives no covariance.
    #[error("{0} realizations give no covariance: at least two with one estimate for every averaging factor")]
    Realizations(usize),
}

impl Curve {
    /// The `variances`, (″/s)², at the averaging factors `ms` of a record of `samples` rates, one every `sample_s`
    /// seconds.
    ///
    /// # Errors
    /// The lists differ in length, values are not above 0, factors do not ascend or are too long for the record, or the
    /// record is too long for the flicker model.
    pub fn new(
        sample_s: f64,
        samples: u64,
        difference: Difference,
        ms: Vec<u64>,
        variances: Vec<f64>,
    ) -> Result<Curve, FitError> {
        check(&ms, &variances)?;
        if let Some((_, &m)) = std::iter::once(&0).chain(&ms).zip(&ms).find(|(before, m)| before >= m) {
            return Err(FitError::NotAscending(m));
        }
        let estimator = Estimator { difference, ..Estimator::OVERLAPPING };
        if let Some(&m) = ms.iter().find(|&&m| estimator.terms(samples, m) == 0) {
            return Err(FitError::TooLong { m, samples });
        }
        let octaves = flicker::octaves(samples).ok_or(FitError::TooManySamples(samples))?;
        let (spread, costs) = (Overdispersion::default(), vec![1.0; ms.len()]);
        let taus_s = vec![];
        Ok(Curve { sample_s, samples, difference, ms, variances, octaves, spread, costs, taus_s })
    }

    /// The Allan variances, (″/s)², at averaging times that rise, s, of noise that is not sampled. The covariance of its points must be
    /// given, for only that of a record follows from its noise.
    ///
    /// # Errors
    /// The lists differ in length, values are not above 0, or times do not rise from above 0.
    pub fn of_points(taus_s: Vec<f64>, variances: Vec<f64>) -> Result<Curve, FitError> {
        let ms: Vec<u64> = (1..=taus_s.len() as u64).collect();
        check(&ms, &variances)?;
        let rises = |pair: (&f64, &f64)| pair.0 < pair.1;
        match std::iter::once(&0.0).chain(&taus_s).zip(&taus_s).position(|pair| !rises(pair)) {
            Some(place) => Err(FitError::NotAscending(place as u64 + 1)),
            None => Ok(Curve {
                sample_s: taus_s.first().copied().unwrap_or(1.0),
                samples: 0,
                difference: Difference::Second,
                costs: vec![1.0; ms.len()],
                spread: Overdispersion::default(),
                octaves: 1,
                ms,
                variances,
                taus_s,
            }),
        }
    }

    /// The curve of a record whose gaps leave these parts of the degrees of freedom.
    fn with_left(self, left: &[f64]) -> Curve {
        Curve { costs: left.iter().map(|left| 1.0 / libm::sqrt(*left)).collect(), ..self }
    }

    /// Standard deviation of each estimate over that of a record without gaps.
    pub(crate) fn costs(&self) -> &[f64] {
        &self.costs
    }

    /// The curve with the spread of its record.
    pub fn spread_by(self, spread: Overdispersion) -> Curve {
        Curve { spread, ..self }
    }

    /// Another curve with the same averaging factors and length.
    ///
    /// # Errors
    /// The number of values differs, or some are not above 0.
    pub fn with(&self, variances: &[f64]) -> Result<Curve, FitError> {
        check(&self.ms, variances)?;
        Ok(Curve { variances: variances.to_vec(), ..self.clone() })
    }

    /// The curve from the position `start` of its averaging factors on.
    pub fn from(&self, start: usize) -> Curve {
        Curve {
            ms: self.ms[start..].to_vec(),
            variances: self.variances[start..].to_vec(),
            spread: self.spread.clone(),
            costs: self.costs[start..].to_vec(),
            taus_s: self.taus_s.get(start..).unwrap_or_default().to_vec(),
            ..*self
        }
    }

    /// Time from one sample to the next, s.
    pub fn sample_s(&self) -> f64 {
        self.sample_s
    }

    /// Number of rates in the record.
    pub fn samples(&self) -> u64 {
        self.samples
    }

    /// The differences of the variances: second, or third for the Hadamard variance.
    pub fn difference(&self) -> Difference {
        self.difference
    }

    /// The averaging factors.
    pub fn ms(&self) -> &[u64] {
        &self.ms
    }

    /// The estimates, (″/s)².
    pub fn variances(&self) -> &[f64] {
        &self.variances
    }

    /// Deviations that the estimates have in common beyond those of Gaussian noise.
    pub fn spread(&self) -> &Overdispersion {
        &self.spread
    }

    /// Shortest and longest τ, s.
    pub fn tau_range(&self) -> [f64; 2] {
        if let [first, .., last] = self.taus_s[..] {
            return [first, last];
        }
        [self.ms.first(), self.ms.last()].map(|m| self.sample_s * m.copied().unwrap_or(1) as f64)
    }

    /// Contribution of a term with the square `square` to each point, (″/s)²; `shape` is that of Markov noise or a
    /// sine.
    pub fn of_term(&self, term: Term, square: f64, shape: f64) -> Vec<f64> {
        let process = self.process(&[(term, square, shape)]);
        if !self.taus_s.is_empty() {
            let at =
                |&tau_s: &f64| process.parts.iter().filter_map(|part| continuous_variance(part, tau_s)).sum();
            return self.taus_s.iter().map(at).collect();
        }
        let estimator = Estimator { difference: self.difference, ..Estimator::OVERLAPPING };
        let at = |&m: &u64| process.expected(estimator, self.samples, m).unwrap_or(f64::NAN);
        self.ms.iter().map(at).collect()
    }

    /// The noise model of terms with their squares and shapes.
    pub fn process(&self, terms: &[(Term, f64, f64)]) -> Process {
        let part = |&(term, square, shape): &(Term, f64, f64)| term.part(square, shape, self.octaves);
        Process { sample_s: self.sample_s, parts: terms.iter().map(part).collect() }
    }
}

/// Whether each averaging factor has a variance.
fn check(ms: &[u64], variances: &[f64]) -> Result<(), FitError> {
    if ms.len() != variances.len() {
        return Err(FitError::Lengths { ms: ms.len(), variances: variances.len() });
    }
    let is_positive = |x: f64| x.is_finite() && x > 0.0;
    match ms.iter().zip(variances).find(|(_, value)| !is_positive(**value)) {
        Some((&m, &value)) => Err(FitError::NotPositive { m, value }),
        None => Ok(()),
    }
}

/// Inverse of the longest averaging time of the fit relative to the record; beyond it, intervals of K come out too
/// short.
const MAX_TAU_PART: usize = 8;

/// Least part of the degrees of freedom of an averaging time that gaps may leave.
const LEFT: f64 = 0.125;

/// The overlapping Allan variances at the octaves of τ up to an eighth of a record, for [`crate::fit::fit_record`].
///
/// # Errors
/// The variance of the record is 0, or the record is too long for the flicker model.
pub fn curve_of(angles: &Angles) -> Result<Curve, FitError> {
    curve_at(angles, &factors(angles.len().saturating_sub(1)))
}

/// The overlapping Allan variances of a record at those of the averaging factors for which gaps leave enough differences.
///
/// # Errors
/// It fails where [`curve_of`] does.
pub(crate) fn curve_at(angles: &Angles, factors: &[usize]) -> Result<Curve, FitError> {
    let samples = angles.len().saturating_sub(1);
    let points = curve(angles, Deviation::Oadev, factors, 0.95);
    let known: Vec<&Point> =
        points.iter().filter(|point| point.left >= LEFT && point.value.is_some()).collect();
    let variance = |point: &&Point| point.value.map(|value| value * value);
    let (ms, variances) =
        (known.iter().map(|point| point.m as u64).collect(), known.iter().filter_map(variance).collect());
    let curve = Curve::new(angles.step_s, samples as u64, Difference::Second, ms, variances)?;
    let left: Vec<f64> = known.iter().map(|point| point.left).collect();
    Ok(curve.spread_by(angles.spread().clone()).with_left(&left))
}

/// The averaging factors of a fit to a record of `samples` samples.
pub fn factors(samples: usize) -> Vec<usize> {
    (0..usize::BITS).map(|octave| 1 << octave).take_while(|m| MAX_TAU_PART * m <= samples).collect()
}

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

    /// The covariance of independent points with these standard deviations, (″/s)².
    ///
    /// # Errors
    /// A deviation is not above 0.
    pub fn of_deviations(deviations: &[f64]) -> Result<Covariance, FitError> {
        let points = deviations.len();
        let cell = |i: usize, j: usize| if i == j { deviations[i] * deviations[i] } else { 0.0 };
        Covariance::new((0..points).map(|i| (0..points).map(|j| cell(i, j)).collect()).collect())
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_no_curve_is_refused_with_its_reason() {
        let curve = |samples, ms: &[u64], variances: &[f64]| {
            Curve::new(1.0, samples, Difference::Second, ms.to_vec(), variances.to_vec()).map(|_| ())
        };
        assert_eq!(curve(10, &[1, 2], &[1.0]), Err(FitError::Lengths { ms: 2, variances: 1 }));
        assert_eq!(curve(10, &[1, 2], &[1.0, 0.0]), Err(FitError::NotPositive { m: 2, value: 0.0 }));
        assert_eq!(curve(10, &[2, 2], &[1.0, 1.0]), Err(FitError::NotAscending(2)));
        assert_eq!(curve(10, &[0, 2], &[1.0, 1.0]), Err(FitError::NotAscending(0)));
        assert_eq!(curve(10, &[5, 6], &[1.0, 1.0]), Err(FitError::TooLong { m: 6, samples: 10 }));
        assert_eq!(curve(1 << 28, &[5], &[1.0]), Err(FitError::TooManySamples(1 << 28)));
        assert_eq!(curve(10, &[1, 5], &[1.0, 1.0]), Ok(()));
    }
}
