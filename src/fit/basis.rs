//! The terms of a fit at the averaging factors of its curves, before weights.

use crate::fit::curve::Curve;
use crate::theory::allan::terms::Term;

/// Columns of one term, one for each shape.
pub type Columns = Vec<(f64, Vec<f64>)>;

/// What terms of unit square add to each point, (″/s)²: the same for all curves of one geometry.
#[derive(Debug, Clone, PartialEq)]
pub struct Basis {
    /// Of each term its shapes, evenly spaced in their logarithm; the only one of a term without shape is 1.
    terms: Vec<(Term, Columns)>,
}

impl Basis {
    /// The columns of these terms over a curve.
    pub fn new(curve: &Curve, terms: &[Term]) -> Basis {
        let of_term = |&term: &Term| {
            let column = |shape: f64| (shape, curve.of_term(term, 1.0, shape));
            (term, shapes(curve, term).into_iter().map(column).collect())
        };
        Basis { terms: terms.iter().map(of_term).collect() }
    }

    /// The same with every column changed.
    pub fn map(&self, change: impl Fn(&[f64]) -> Vec<f64>) -> Basis {
        let of_term = |(term, columns): &(Term, Columns)| {
            (*term, columns.iter().map(|(shape, column)| (*shape, change(column))).collect())
        };
        Basis { terms: self.terms.iter().map(of_term).collect() }
    }

    /// The columns of a term with their shapes; none of a term that it does not have.
    pub fn of(&self, term: Term) -> &[(f64, Vec<f64>)] {
        self.terms.iter().find(|(other, _)| *other == term).map_or(&[], |(_, columns)| columns)
    }
}

fn shapes(curve: &Curve, term: Term) -> Vec<f64> {
    if !term.has_shape() {
        return vec![1.0];
    }
    let [low, high] = shape_range(curve, term);
    let count = libm::ceil(libm::log10(high / low) * per_decade(term)).max(1.0);
    (0..=count as u32).map(|i| low * libm::pow(high / low, f64::from(i) / count)).collect()
}

/// Shortest and longest shape that a curve can tell: times T_c within its τ, frequencies with a hump within them; 1 of
/// terms without.
///
/// Markov noise beyond is a random walk or white to the curve, a slower sine a ramp.
pub fn shape_range(curve: &Curve, term: Term) -> [f64; 2] {
    term.shape().map_or([1.0; 2], |shape| (shape.range)(curve.tau_range()))
}

/// Points of the grid of shapes for each factor of ten.
pub fn per_decade(term: Term) -> f64 {
    term.shape().map_or(1.0, |shape| shape.per_decade)
}
