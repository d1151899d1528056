//! The covariance of the estimates as a function of the coefficients of the model.

use crate::fit::interval::Variance;
use crate::fit::{Curve, FitError};
use crate::theory::allan::Term;
use crate::theory::allan::gaussian::Components;

/// The covariance of the estimates of one record as a function of the squares of some terms.
#[derive(Debug)]
pub(crate) struct Growth {
    /// Terms with their shapes.
    terms: Vec<(Term, f64)>,
    components: Components,
}

impl Growth {
    pub(crate) fn new(curve: &Curve, terms: Vec<(Term, f64)>) -> Growth {
        let unit: Vec<(Term, f64, f64)> = terms.iter().map(|&(term, shape)| (term, 1.0, shape)).collect();
        let components =
            Components::new(&curve.process(&unit), curve.difference(), curve.samples(), curve.ms());
        Growth { terms, components }
    }

    /// Whether it belongs to these terms and shapes.
    pub(crate) fn is_of(&self, terms: &[(Term, f64)]) -> bool {
        self.terms == terms
    }

    /// The covariance for the squares of the terms, in order.
    pub(crate) fn covariance(&self, squares: &[f64]) -> Result<crate::fit::covariance::Covariance, FitError> {
        crate::fit::covariance::Covariance::new(self.components.covariance(squares))
    }

    /// Variance of a weighted sum of estimates as a function of the square of one term, with the others given.
    pub(crate) fn variance(&self, term: Term, weights: &[f64], square_of: impl Fn(Term) -> f64) -> Variance {
        let form = self.components.variance_of(weights);
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
}
