//! The terms of a fit at the averaging factors of its curves, before weights.

use crate::fit::Curve;
use crate::theory::allan::Term;

/// Columns of one term, each with its shape.
pub(crate) type Columns = Vec<(f64, Vec<f64>)>;

/// Contributions of terms of unit square to each point, (″/s)²; they are the same for all curves of one geometry.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Basis {
    /// The terms with their shapes, evenly spaced in their logarithm; a term without shape has the single shape 1.
    terms: Vec<(Term, Columns)>,
}

impl Basis {
    /// The columns of these terms over a curve.
    pub(crate) fn new(curve: &Curve, terms: &[Term]) -> Basis {
        let of_term = |&term: &Term| {
            let column = |shape: f64| (shape, curve.of_term(term, 1.0, shape));
            (term, shapes(curve, term).into_iter().map(column).collect())
        };
        Basis { terms: terms.iter().map(of_term).collect() }
    }

    /// The basis with every column changed by `change`.
    pub(crate) fn map(&self, change: impl Fn(&[f64]) -> Vec<f64>) -> Basis {
        let of_term = |(term, columns): &(Term, Columns)| {
            (*term, columns.iter().map(|(shape, column)| (*shape, change(column))).collect())
        };
        Basis { terms: self.terms.iter().map(of_term).collect() }
    }

    /// The columns of a term with their shapes; empty for a term outside the basis.
    pub(crate) fn of(&self, term: Term) -> &[(f64, Vec<f64>)] {
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

/// Shortest and longest shape that a curve can resolve: times T_c within its τ, or frequencies with a hump within them;
/// 1 for terms without shape.
/// terms without.
///
/// Markov noise outside this range looks like a random walk or white noise to the curve, and a slower sine like a ramp.
pub(crate) fn shape_range(curve: &Curve, term: Term) -> [f64; 2] {
    term.shape().map_or([1.0; 2], |shape| (shape.range)(curve.tau_range()))
}

/// Grid points of shapes per decade.
pub(crate) fn per_decade(term: Term) -> f64 {
    term.shape().map_or(1.0, |shape| shape.per_decade)
}
