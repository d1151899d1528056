//! Which terms a curve supports.

use crate::allan::trend::Trend;
use crate::fit::curve::FitError;
use crate::fit::search::{Solution, System};
use crate::theory::allan::terms::Term;

/// What a term has to take off χ² to be chosen.
///
/// The best square of a surplus term is 0 half the time, and else it takes a χ² of one degree of freedom off: more than
/// 4 with a probability of 2.3 %. The skewed estimates of one record stay near that (`tests/library/allan_fit_records.rs`). AIC's 2
/// would let in 8 %; BIC's logarithm of the number of points has no meaning where points are correlated and as many as
/// one likes.
pub const PENALTY: f64 = 4.0;

/// The same for Markov noise and a sine, whose time or frequency is chosen to take off the most.
///
/// In 300 records of 4096 samples of white noise Markov noise was found in none, a sine in 4 (`tests/library/allan_fit_records.rs`).
pub const PENALTY_OF_SHAPE: f64 = 10.0;

/// By how much χ² with its penalties has to rise without a term for the term to be identified.
///
/// Else another term would do nearly as well, a ramp instead of a random walk of the rate, and which of them is there
/// is a guess: of a random walk that a record barely shows, B would be made in 11 % of the records without this, in 5 %
/// with it.
pub const RIVAL: f64 = 2.0;

/// By how much χ² with its penalties may be above the least for a choice of terms to be likely too: the interval of a
/// coefficient reaches over those that it has in all likely choices.
///
/// A bias instability that is there but does not show makes N come out larger. Without this, intervals of N cover the
/// truth in 92 % of records of 9 h of LGV-1, where B is left out of some, and in 85 and 88 % of shorter ones; with it in 93
/// to 95 %, and most are as wide as before. With all choices that let a term in (4) they would be wider by half for white
/// noise, and cover its N in 97 %.
pub const LIKELY: f64 = 3.0;

/// The terms of a fit.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Terms {
    /// These, whatever the curve says of them.
    Given(Vec<Term>),
    /// Those of these that the curve supports; the others are reported with their bounds.
    Auto(Vec<Term>),
}

impl Terms {
    /// Those of Q, N, B, K, R that a record supports from which this trend was removed: a line has taken the ramp with it.
    pub fn of_model(removed: Trend) -> Terms {
        let gone = |term: &Term| removed == Trend::Linear && *term == Term::RateRamp;
        Terms::Auto(Term::MODEL.into_iter().filter(|term| !gone(term)).collect())
    }

    /// All terms that may enter.
    pub fn all(&self) -> &[Term] {
        let (Terms::Given(terms) | Terms::Auto(terms)) = self;
        terms
    }

    /// Parameters that a fit has at least.
    pub fn fewest_parameters(&self) -> usize {
        match self {
            Terms::Given(terms) => terms.iter().map(|term| term.parameters()).sum(),
            Terms::Auto(_) => 1,
        }
    }

    /// All terms that may enter, each once.
    pub(crate) fn candidates(&self) -> Result<Vec<Term>, FitError> {
        let mut candidates: Vec<Term> = Vec::new();
        for &term in self.all() {
            if !candidates.contains(&term) {
                candidates.push(term);
            }
        }
        if candidates.is_empty() { Err(FitError::NoTerms) } else { Ok(candidates) }
    }
}

/// What is chosen of the terms.
pub(crate) struct Choice {
    /// The subset with the least penalised χ².
    pub best: Solution,
    /// Terms of it that others could replace.
    pub replaceable: Vec<Term>,
    /// Other likely subsets.
    pub others: Vec<Solution>,
}

impl Choice {
    /// All `terms`, whatever they are good for.
    pub(crate) fn given(system: &System, terms: &[Term]) -> Choice {
        Choice { best: system.best(terms), replaceable: Vec::new(), others: Vec::new() }
    }

    /// Compares all subsets of `candidates`.
    ///
    /// Shapes are searched with all terms beside them, kept while subsets are compared, and searched again with the best.
    pub(crate) fn auto(system: &System, candidates: &[Term]) -> Choice {
        let scored = scored(system, candidates);
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
        let mut sets = vec![chosen.clone()];
        let mut others = Vec::new();
        for (_, solution) in scored.into_iter().filter(|(score, _)| *score < least + LIKELY) {
            // A subset with a square of 0 is a smaller one.
            let set = used(&solution);
            if !sets.contains(&set) {
                sets.push(set);
                others.push(solution);
            }
        }
        Choice { best: system.best(&chosen), replaceable, others }
    }
}

/// All subsets with their penalised χ².
fn scored(system: &System, candidates: &[Term]) -> Vec<(f64, Solution)> {
    let (shaped, plain): (Vec<Term>, Vec<Term>) = candidates.iter().partition(|term| term.has_shape());
    let mut scored = Vec::new();
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
    scored
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
