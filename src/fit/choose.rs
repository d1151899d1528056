//! Which terms a curve supports, and the fit from a record alone.

use super::assess::Judge;
use super::growth::Growth;
use super::search::{Solution, System};
use super::{Covariance, Curve, Fit, FitError, Term};

/// What a term has to take off χ² to be chosen.
///
/// The best square of a surplus term is 0 half the time, and else it takes a χ² of one degree of freedom off: more than
/// 4 with a probability of 2.3 %. The skewed estimates of one record stay near that (`tests/allan_fit_records.rs`). AIC's 2
/// would let in 8 %; BIC's logarithm of the number of points has no meaning where points are correlated and as many as
/// one likes.
pub const PENALTY: f64 = 4.0;

/// The same for Markov noise and a sine, whose time or frequency is chosen to take off the most.
///
/// In 300 records of 4096 samples of white noise Markov noise was found in none, a sine in 4 (`tests/allan_fit_records.rs`).
pub const PENALTY_OF_SHAPE: f64 = 10.0;

/// By how much χ² with its penalties has to rise without a term for the term to be identified.
///
/// Else another term would do nearly as well, a ramp instead of a random walk of the rate, and which of them is there
/// is a guess: of a random walk that a record barely shows, B would be made in 11 % of the records without this, in 5 %
/// with it.
pub const RIVAL: f64 = 2.0;

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

/// Where the covariance between the estimates comes from, and with it what errors a coefficient has.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Errors {
    /// It is known, and the same whatever the coefficients are: intervals are ± 1.96 standard errors of the square.
    Known,
    /// It is that of one record of the fitted model, so that a coefficient that came out low seems precise: intervals
    /// hold the values at which the outcome would not be a rare one, with the covariance of a record of that value.
    OfModel,
}

/// Fits `terms` to a curve whose estimates have this covariance.
///
/// With [`Terms::Auto`] the terms are those of the least χ² + Σ penalty, over all subsets ([`PENALTY`]): all compared
/// with the same covariance, so that a term gains nothing by making points uncertain.
///
/// # Errors
/// No terms, or fewer points than fitted parameters.
pub fn fit(curve: &Curve, covariance: &Covariance, terms: &Terms, errors: Errors) -> Result<Fit, FitError> {
    fit_with(curve, covariance, terms, errors, None)
}

/// Fits `terms` to the overlapping estimates of one record, of which nothing else is known.
///
/// Estimates at m above N/8 are so few differences that a low one of all of them is not rare: with them intervals of K
/// cover the truth in 86 to 92 % of records instead of 94 to 96 %. Q, N and B of a gyro without K lose nothing by them,
/// and a ramp is best seen there.
///
/// The first weights are those of independent points with relative variances 2m/N. The best fit of all terms gives the
/// covariance in closed form, that a better fit, and that fit the covariance which counts. To go on from there with
/// simulated realisations of `Fit::process`: [`Covariance::of_realisations`] and [`fit`].
///
/// # Errors
/// As [`fit`], and a curve that is best explained without any noise.
pub fn fit_record(curve: &Curve, terms: &Terms) -> Result<Fit, FitError> {
    let candidates = terms.candidates()?;
    let mut covariance = Covariance::of_independent(curve)?;
    let mut growth: Option<Growth> = None;
    for _ in 0..2 {
        let best = System::new(curve, &covariance).best(&candidates);
        let shapes: Vec<(Term, f64)> = best.terms.iter().map(|fitted| (fitted.term, fitted.shape)).collect();
        let squares: Vec<f64> = best.terms.iter().map(|fitted| fitted.square).collect();
        let of_these = growth.take().filter(|growth| growth.is_of(&shapes));
        let of_these = of_these.unwrap_or_else(|| Growth::new(curve, shapes));
        covariance = of_these.covariance(&squares)?;
        growth = Some(of_these);
    }
    fit_with(curve, &covariance, terms, Errors::OfModel, growth)
}

fn fit_with(
    curve: &Curve,
    covariance: &Covariance,
    terms: &Terms,
    errors: Errors,
    growth: Option<Growth>,
) -> Result<Fit, FitError> {
    let candidates = terms.candidates()?;
    let system = System::new(curve, covariance);
    let (solution, replaceable) = match terms {
        Terms::Given(_) => (system.best(&candidates), Vec::new()),
        Terms::Auto(_) => choose(&system, &candidates),
    };
    let shape = |&term: &Term| {
        let fitted = solution.terms.iter().find(|fitted| fitted.term == term);
        (term, fitted.map_or(system.shape_range(term)[0], |fitted| fitted.shape))
    };
    let growth = (errors == Errors::OfModel).then(|| {
        let shapes: Vec<(Term, f64)> = candidates.iter().map(shape).collect();
        let of_these = growth.filter(|growth| growth.is_of(&shapes));
        of_these.unwrap_or_else(|| Growth::new(curve, shapes))
    });
    Judge::new(&system, &solution.terms, growth.as_ref(), &replaceable).fit(&candidates)
}

/// The subset of `candidates` with the least penalised χ², and those of its terms that others could replace.
///
/// Shapes are searched with all terms beside them, kept while subsets are compared, and searched again with the best.
fn choose(system: &System, candidates: &[Term]) -> (Solution, Vec<Term>) {
    let (shaped, plain): (Vec<Term>, Vec<Term>) = candidates.iter().partition(|term| term.has_shape());
    let mut scored: Vec<(f64, Solution)> = Vec::new();
    for shaped in subsets(&shaped) {
        let with = |plain: &[Term]| [plain, &shaped].concat();
        let full = system.best(&with(&plain));
        let shapes: Vec<f64> = full.terms[plain.len()..].iter().map(|fitted| fitted.shape).collect();
        for plain in subsets(&plain) {
            let shapes = [&vec![1.0; plain.len()][..], &shapes].concat();
            let solution = system.given(&with(&plain), &shapes);
            scored.push((score(&solution), solution));
        }
    }
    let least = scored.iter().map(|(score, _)| *score).fold(f64::INFINITY, f64::min);
    let chosen = scored
        .iter()
        .find(|(score, _)| *score <= least)
        .map_or(candidates.to_vec(), |(_, solution)| used(solution));
    let is_rival = |term: Term, (score, solution): &(f64, Solution)| {
        *score < least + RIVAL && !used(solution).contains(&term)
    };
    let replaceable =
        chosen.iter().copied().filter(|&term| scored.iter().any(|other| is_rival(term, other))).collect();
    (system.best(&chosen), replaceable)
}

fn used(solution: &Solution) -> Vec<Term> {
    solution.terms.iter().filter(|fitted| fitted.square > 0.0).map(|fitted| fitted.term).collect()
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
