//! The input of a fit: estimates of the Allan variance at averaging factors.

use crate::allan::Spread;
use sagnac_theory::allan::{Difference, Estimator, Process, Term, holds};

/// Estimates of one record, or their mean over many.
#[derive(Debug, Clone, PartialEq)]
pub struct Curve {
    sample_s: f64,
    samples: u64,
    difference: Difference,
    ms: Vec<u64>,
    variances: Vec<f64>,
    octaves: usize,
    spread: Spread,
    /// Standard deviation of each estimate over that of a record without gaps.
    costs: Vec<f64>,
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
        let octaves = holds::octaves(samples).ok_or(FitError::TooManySamples(samples))?;
        let (spread, costs) = (Spread::default(), vec![1.0; ms.len()]);
        Ok(Curve { sample_s, samples, difference, ms, variances, octaves, spread, costs })
    }

    /// The curve of a record whose gaps leave these parts of the degrees of freedom.
    pub(crate) fn with_left(self, left: &[f64]) -> Curve {
        Curve { costs: left.iter().map(|left| 1.0 / libm::sqrt(*left)).collect(), ..self }
    }

    /// Standard deviation of each estimate over that of a record without gaps.
    pub(crate) fn costs(&self) -> &[f64] {
        &self.costs
    }

    /// The curve with the spread of its record.
    pub fn spread_by(self, spread: Spread) -> Curve {
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
    pub fn spread(&self) -> &Spread {
        &self.spread
    }

    /// Shortest and longest τ, s.
    pub fn tau_range(&self) -> [f64; 2] {
        [self.ms.first(), self.ms.last()].map(|m| self.sample_s * m.copied().unwrap_or(1) as f64)
    }

    /// Contribution of a term with the square `square` to each point, (″/s)²; `shape` is that of Markov noise or a
    /// sine.
    pub fn of_term(&self, term: Term, square: f64, shape: f64) -> Vec<f64> {
        let process = self.process(&[(term, square, shape)]);
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
