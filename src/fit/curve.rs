//! What is fitted: estimates of the Allan variance over averaging factors.

use crate::theory::allan::estimator::{Difference, Estimator};
use crate::theory::allan::holds;
use crate::theory::allan::process::Process;
use crate::theory::allan::terms::Term;

/// Estimates of one record, or their mean over many.
#[derive(Debug, Clone, PartialEq)]
pub struct Curve {
    sample_s: f64,
    samples: u64,
    difference: Difference,
    ms: Vec<u64>,
    variances: Vec<f64>,
    octaves: usize,
}

/// Why a curve cannot be fitted.
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
pub enum FitError {
    /// Two lists that do not belong together.
    #[error("{ms} averaging factors for {variances} variances: a curve needs as many of both")]
    Lengths {
        /// Averaging factors given.
        ms: usize,
        /// Variances given.
        variances: usize,
    },
    /// A variance that has no logarithm.
    #[error(
        "the variance at m = {m} is {value}: a fit needs finite values above 0; a constant record has none"
    )]
    NotPositive {
        /// Its averaging factor.
        m: u64,
        /// What it is.
        value: f64,
    },
    /// Averaging factors out of order, or 0.
    #[error("averaging factors have to ascend from 1; m = {m} does not")]
    NotAscending {
        /// The first that does not ascend.
        m: u64,
    },
    /// No difference of that length is in the record.
    #[error("m = {m} is too long for a record of {samples} samples")]
    TooLong {
        /// The averaging factor.
        m: u64,
        /// Of the record.
        samples: u64,
    },
    /// More unknowns than points.
    #[error(
        "{points} points cannot hold {parameters} parameters: leave out terms or take more averaging factors"
    )]
    TooFewPoints {
        /// Variances given.
        points: usize,
        /// Of the terms asked for.
        parameters: usize,
    },
    /// An empty list of terms.
    #[error("no terms to fit")]
    NoTerms,
    /// More samples than the flicker of the covariance is modelled for.
    #[error("flicker is modelled up to 2^27 samples, and the record has {samples}")]
    TooManySamples {
        /// Of the record.
        samples: u64,
    },
    /// Rounding has spoilt the covariance; points too close to each other do that.
    #[error("the covariance of the estimates is not positive definite")]
    NotDefinite,
    /// Simulated records from which no covariance can be taken.
    #[error(
        "{rows} realisations give no covariance: at least two with one estimate for every averaging factor"
    )]
    Realisations {
        /// That were given.
        rows: usize,
    },
}

impl Curve {
    /// The `variances`, (″/s)², at the averaging factors `ms` of a record of `samples` rates, one each `sample_s`.
    ///
    /// # Errors
    /// Lists of unequal length, values that are not above 0, factors that do not ascend or are too long for the record,
    /// and records too long for the flicker model.
    pub fn new(
        sample_s: f64,
        samples: u64,
        difference: Difference,
        ms: Vec<u64>,
        variances: Vec<f64>,
    ) -> Result<Curve, FitError> {
        check(&ms, &variances)?;
        if let Some(&m) =
            ms.iter().zip(core::iter::once(&0).chain(&ms)).find(|(m, before)| m <= before).map(|pair| pair.0)
        {
            return Err(FitError::NotAscending { m });
        }
        let estimator = Estimator { difference, ..Estimator::OVERLAPPING };
        if let Some(&m) = ms.iter().find(|&&m| estimator.terms(samples, m) == 0) {
            return Err(FitError::TooLong { m, samples });
        }
        let octaves = holds::octaves(samples).ok_or(FitError::TooManySamples { samples })?;
        Ok(Curve { sample_s, samples, difference, ms, variances, octaves })
    }

    /// Another curve of the same averaging factors and length.
    ///
    /// # Errors
    /// Another number of values, or some that are not above 0.
    pub fn with(&self, variances: &[f64]) -> Result<Curve, FitError> {
        check(&self.ms, variances)?;
        Ok(Curve { ms: self.ms.clone(), variances: variances.to_vec(), ..*self })
    }

    /// From one sample to the next, s.
    pub fn sample_s(&self) -> f64 {
        self.sample_s
    }

    /// Rates of the record.
    pub fn samples(&self) -> u64 {
        self.samples
    }

    /// What the variances are of: second differences, or third ones of Hadamard.
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

    /// Shortest and longest τ, s.
    pub fn tau_range(&self) -> [f64; 2] {
        [self.ms.first(), self.ms.last()].map(|m| self.sample_s * m.copied().unwrap_or(1) as f64)
    }

    /// What a term of the square `square` adds to each point, (″/s)²; `shape` is that of Markov noise or a sine.
    pub fn of_term(&self, term: Term, square: f64, shape: f64) -> Vec<f64> {
        let process = self.process(&[(term, square, shape)]);
        let estimator = Estimator { difference: self.difference, ..Estimator::OVERLAPPING };
        let at = |&m: &u64| process.expected(estimator, self.samples, m).unwrap_or(f64::NAN);
        self.ms.iter().map(at).collect()
    }

    /// The model of so many terms with their squares and shapes.
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
        assert_eq!(curve(10, &[2, 2], &[1.0, 1.0]), Err(FitError::NotAscending { m: 2 }));
        assert_eq!(curve(10, &[0, 2], &[1.0, 1.0]), Err(FitError::NotAscending { m: 0 }));
        assert_eq!(curve(10, &[5, 6], &[1.0, 1.0]), Err(FitError::TooLong { m: 6, samples: 10 }));
        assert_eq!(curve(1 << 28, &[5], &[1.0]), Err(FitError::TooManySamples { samples: 1 << 28 }));
        assert_eq!(curve(10, &[1, 5], &[1.0, 1.0]), Ok(()));
    }
}
