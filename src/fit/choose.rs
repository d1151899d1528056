//! Which terms a curve supports, and the fit from a record alone.

use super::assess::{Fit, assess};
use super::search::{Solution, System};
use super::{Covariance, Curve, FitError, Term};

/// What a term has to take off χ² to be chosen.
///
/// A surplus term takes off more than x with half the probability that a χ² of one degree of freedom exceeds x, the other half of the
/// time its best square is 0: 4 leaves 2.3 % for Gaussian estimates, and 5 % or less with the skewed ones of long τ
/// in one record. (AIC's 2 would leave 8 %, and BIC's logarithm of the number of points, which
/// are correlated, depends on how densely τ was chosen.)
pub const PENALTY: f64 = 4.0;

/// The same for Markov noise and a sine, whose time or frequency is chosen to take off the most.
pub const PENALTY_OF_SHAPE: f64 = 10.0;

/// The terms of a fit.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Terms {
    /// These, whatever the curve says of them.
    Given(Vec<Term>),
    /// Those of these that the curve supports; the others are reported with their bounds.
    Auto(Vec<Term>),
}

impl Terms {
    /// All terms that may enter, each once.
    fn candidates(&self) -> Result<Vec<Term>, FitError> {
        let (Terms::Given(terms) | Terms::Auto(terms)) = self;
        let mut candidates: Vec<Term> = Vec::new();
        for &term in terms {
            if !candidates.contains(&term) {
                candidates.push(term);
            }
        }
        if candidates.is_empty() { Err(FitError::NoTerms) } else { Ok(candidates) }
    }
}

/// Fits `terms` to a curve whose estimates have this covariance.
///
/// With [`Terms::Auto`] the terms are those of the least χ² + Σ penalty, over all subsets ([`PENALTY`]): all compared with
/// the same covariance, so that a term gains nothing by making points uncertain.
///
/// # Errors
/// No terms, or fewer points than fitted parameters.
pub fn fit(curve: &Curve, covariance: &Covariance, terms: &Terms) -> Result<Fit, FitError> {
    let candidates = terms.candidates()?;
    let system = System::new(curve, covariance);
    let solution = match terms {
        Terms::Given(_) => system.best(&candidates),
        Terms::Auto(_) => choose(&system, &candidates),
    };
    assess(&system, &solution, &candidates)
}

/// Fits `terms` to the overlapping estimates of one record, of which nothing else is known.
///
/// The first weights are those of independent points with relative variances 2m/N. The best fit of all terms gives the covariance in
/// closed form ([`Covariance::of_process`]), that a better fit, and that fit the covariance which counts. To go on from there with simulated
/// realisations of `Fit::process`: [`Covariance::of_realisations`] and [`fit`].
///
/// # Errors
/// As [`fit`], and a curve that is best explained without any noise.
pub fn fit_record(curve: &Curve, terms: &Terms) -> Result<Fit, FitError> {
    let candidates = terms.candidates()?;
    let mut covariance = Covariance::of_independent(curve)?;
    for _ in 0..2 {
        let best = System::new(curve, &covariance).best(&candidates);
        let model: Vec<(Term, f64, f64)> =
            best.terms.iter().map(|fitted| (fitted.term, fitted.square, fitted.shape)).collect();
        covariance = Covariance::of_process(&curve.process(&model), curve)?;
    }
    fit(curve, &covariance, terms)
}

/// The subset of `candidates` with the least penalised χ².
///
/// Shapes are searched with all terms beside them, kept while subsets are compared, and searched again with the best.
fn choose(system: &System, candidates: &[Term]) -> Solution {
    let (shaped, plain): (Vec<Term>, Vec<Term>) = candidates.iter().partition(|term| term.has_shape());
    let mut best: Option<(f64, Solution)> = None;
    for shaped in subsets(&shaped) {
        let with = |plain: &[Term]| [plain, &shaped].concat();
        let full = system.best(&with(&plain));
        let shapes: Vec<f64> = full.terms[plain.len()..].iter().map(|fitted| fitted.shape).collect();
        let scored = subsets(&plain).into_iter().map(|plain| {
            let shapes = [&vec![1.0; plain.len()][..], &shapes].concat();
            let solution = system.given(&with(&plain), &shapes);
            (score(&solution), plain)
        });
        let Some((_, plain)) = scored.min_by(|a, b| a.0.total_cmp(&b.0)) else { continue };
        let solution = system.best(&with(&plain));
        let score = score(&solution);
        if best.as_ref().is_none_or(|(least, _)| score < *least) {
            best = Some((score, solution));
        }
    }
    best.map_or_else(|| system.best(candidates), |(_, solution)| solution)
}

/// χ² with the penalties of the terms in use.
fn score(solution: &Solution) -> f64 {
    let penalty = |term: Term| if term.has_shape() { PENALTY_OF_SHAPE } else { PENALTY };
    let used = solution.terms.iter().filter(|fitted| fitted.square > 0.0);
    solution.chi_squared + used.map(|fitted| penalty(fitted.term)).sum::<f64>()
}

/// All subsets, the smallest first among equals: the empty one too.
fn subsets(terms: &[Term]) -> Vec<Vec<Term>> {
    let member = |set: usize| (0..terms.len()).filter(move |i| set >> i & 1 == 1);
    (0..1_usize << terms.len()).map(|set| member(set).map(|i| terms[i]).collect()).collect()
}
