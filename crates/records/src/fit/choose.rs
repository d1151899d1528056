//! The choice of the terms that a curve supports.

use crate::allan::Trend;
use crate::fit::FitError;
use crate::fit::search::{Solution, System};
use sagnac_theory::allan::Term;

/// Decrease of χ² that a term must achieve to be chosen.
///
/// The best square of a surplus term is 0 half the time; otherwise it decreases χ² by a χ² with one degree of freedom,
/// which exceeds 4 with a probability of 2.3 %. The skewed estimates of one record stay near that
/// (`tests/library/allan_fit_records.rs`). AIC's penalty of 2 would admit 8 %. BIC's logarithm of the number of points
/// is meaningless where points are correlated and their number is arbitrary.
pub const PENALTY: f64 = 4.0;

/// The same penalty for Markov noise and a sine, whose time or frequency is chosen for the largest decrease.
///
/// In 300 records of 4096 samples of white noise, Markov noise was found in none and a sine in 4
/// (`tests/library/allan_fit_records.rs`).
pub const PENALTY_OF_SHAPE: f64 = 10.0;

/// The penalty for the band limit. It is that of [`LIKELY`], so that the interval of N covers a band limit wherever the curve
/// leaves room for one: every sensor has a filter, and one that does not show may be worth a standard error of N.
pub const PENALTY_OF_LIMIT: f64 = LIKELY;

/// Increase of the penalized χ² without a term that is required for the term to be identified.
///
/// Below it, another term would fit almost equally well, such as a ramp instead of a rate random walk, and the choice
/// between them is a guess. From a random walk that a record barely shows, B would be identified in 11 % of the records
/// without this rule, and is in 5 % with it.
pub const RIVAL: f64 = 2.0;

/// Largest excess of the penalized χ² over the least for a choice of terms to count as likely too. The interval of a
/// coefficient covers its intervals in all likely choices.
///
/// A bias instability that is present but does not show makes N come out larger. Without this rule, intervals of N
/// cover the truth in 92 % of records of 9 h of LGV-1, some of which are fitted without B, and in 85 and 88 % of
/// shorter ones. With it they cover 93 to 95 %, and most are as wide as before. With a limit of 4, which would include
/// all choices that admit a term, they would be wider by half for white noise, and cover its N in 97 %.
pub const LIKELY: f64 = 3.0;

/// The terms of a fit.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Terms {
    /// These terms, whether or not the curve supports them.
    Given(Vec<Term>),
    /// Those of these terms that the curve supports; the others are reported with their bounds.
    Auto(Vec<Term>),
}

impl Terms {
    /// Those of Q, N, B, K, R that a record supports after removal of this trend; a line has removed the ramp.
    pub fn of_model(removed: Trend) -> Terms {
        let gone = |term: &Term| removed == Trend::Linear && *term == Term::RateRamp;
        Terms::Auto(Term::MODEL.into_iter().filter(|term| !gone(term)).collect())
    }

    /// All terms that may enter the fit.
    pub fn all(&self) -> &[Term] {
        let (Terms::Given(terms) | Terms::Auto(terms)) = self;
        terms
    }

    /// These terms and one more.
    pub(crate) fn with(&self, term: Term) -> Terms {
        let more = |terms: &[Term]| [terms, &[term]].concat();
        match self {
            Terms::Given(terms) => Terms::Given(more(terms)),
            Terms::Auto(terms) => Terms::Auto(more(terms)),
        }
    }

    /// Least number of parameters of the fit.
    pub fn fewest_parameters(&self) -> usize {
        match self {
            Terms::Given(terms) => terms.iter().map(|term| term.parameters()).sum(),
            Terms::Auto(_) => 1,
        }
    }

    /// All terms that may enter the fit, each once.
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

/// The outcome of a choice of terms.
pub(crate) struct Choice {
    /// The subset with the least penalized χ².
    pub best: Solution,
    /// Terms of that subset that others could replace.
    pub replaceable: Vec<Term>,
    /// Other likely subsets.
    pub others: Vec<Solution>,
}

impl Choice {
    /// The choice of all `terms`, regardless of their benefit.
    pub(crate) fn given(system: &System, terms: &[Term]) -> Choice {
        Choice { best: system.best(terms), replaceable: Vec::new(), others: Vec::new() }
    }

    /// Compares all subsets of `candidates`.
    ///
    /// Shapes are searched with all terms present, kept while subsets are compared, and searched again for the best
    /// one.
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
            // A subset in which a square is 0 is a smaller subset.
            let set = used(&solution);
            if !sets.contains(&set) {
                sets.push(set);
                others.push(solution);
            }
        }
        Choice { best: system.best(&chosen), replaceable, others }
    }
}

/// All subsets with their penalized χ².
fn scored(system: &System, candidates: &[Term]) -> Vec<(f64, Solution)> {
    let (shaped, plain): (Vec<Term>, Vec<Term>) = candidates.iter().partition(|term| term.has_shape());
    let mut scored = Vec::new();
    let is_cut = system.curve().ms().first().is_some_and(|&m| m > 1);
    for shaped in subsets(&shaped) {
        let with = |plain: &[Term]| [plain, &shaped].concat();
        let full = system.best(&with(&plain));
        let shapes: Vec<f64> = full.terms[plain.len()..].iter().map(|fitted| fitted.shape).collect();
        for plain in subsets(&plain) {
            let shapes = [&vec![1.0; plain.len()][..], &shapes].concat();
            let solution = system.given(&with(&plain), &shapes);
            scored.push((score(&solution, is_cut), solution));
        }
    }
    scored
}

fn used(solution: &Solution) -> Vec<Term> {
    solution.terms.iter().filter(|fitted| fitted.square > 0.0).map(|fitted| fitted.term).collect()
}

/// χ² with the penalties of the terms in use. Where the shortest τ are left out, quantization noise is also what the alias of a filter
/// leaves of the highest frequencies, and as cheap as a band limit.
fn score(solution: &Solution, is_cut: bool) -> f64 {
    let penalty = |term: Term| match term {
        Term::BandLimit => PENALTY_OF_LIMIT,
        Term::Quantization if is_cut => PENALTY_OF_LIMIT,
        _ if term.has_shape() => PENALTY_OF_SHAPE,
        _ => PENALTY,
    };
    let used = solution.terms.iter().filter(|fitted| fitted.square > 0.0);
    solution.chi_squared + used.map(|fitted| penalty(fitted.term)).sum::<f64>()
}

/// All subsets including the empty one, the smallest first among equal ones.
fn subsets(terms: &[Term]) -> Vec<Vec<Term>> {
    let member = |set: usize| (0..terms.len()).filter(move |i| set >> i & 1 == 1);
    (0..1_usize << terms.len()).map(|set| member(set).map(|i| terms[i]).collect()).collect()
}
