//! The choice of the terms that a curve supports, and of the range of τ over which they describe the curve of a record.
//!
//! # Range of τ
//!
//! A sensor filters its rate, and an Allan curve shows that as a fall below the noise terms at short τ. Terms fitted there would absorb
//! it: a filter of two samples makes a bias instability out of white noise. The shortest τ of the fit is therefore part of
//! the estimate:
//!
//! 1. The [band limit](Term::BandLimit) joins the terms that a fit may choose from. It is exact for any filter at τ beyond its
//!    memory, so nothing of the filter remains in the other terms there.
//! 2. A fit to all octaves without a band limit is the result, unless its χ² is improbable.
//! 3. Otherwise the fit starts at the second of two successive octaves from which its χ² is not improbable. The first of them
//!    guards against a rest of the filter that χ² does not show, but that is worth a standard error of N.
//! 4. If that costs four octaves or more, or the noise at the shortest τ exceeds what the band limit leaves, a fit of all octaves
//!    with a sine or with Markov noise takes precedence if it describes them. Markov noise without white noise does not count,
//!    because that is what a low-pass makes of white noise.
//! 5. If there is none, the fit of all octaves is the result unless its χ² is impossible. Then every coefficient is
//!    [not described](Verdict::NotDescribed).
//!
//! Terms that are given are first fitted without a band limit. A band limit is left out where the variance at the shortest τ is
//! larger than what such a filter leaves, as where noise with a correlation time is added to white noise.

use crate::allan::{Angles, Deviation, Trend};
use crate::fit::curve::{curve_at, factors};
use crate::fit::search::{Basis, Solution, System};
use crate::fit::{Coefficient, Curve, Fit, FitError, Fitter, Verdict};
use sagnac_theory::allan::{Part, Term};

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

/// A subset of terms and how well it describes a curve.
#[derive(Debug, Clone, PartialEq)]
pub struct RankedModel {
    /// The terms, none of which is 0.
    pub terms: Vec<Term>,
    /// Weighted sum of the squared residuals.
    pub chi_squared: f64,
    /// Degrees of freedom of χ²: the number of points less that of parameters.
    pub degrees_of_freedom: usize,
    /// The wavelet information criterion.
    pub criterion: f64,
}

/// All subsets of the terms of a described fit and of Markov noise, the one with the least criterion first.
///
/// The criterion is that of the generalized method of wavelet moments (S. Guerrier, J. Skaloud, Y. Stebler, M.-P. Victoria-Feser,
/// *JASA* 108, 2013, 1021): an unbiased estimate of the χ² that the subset would have for an independent record of the same noise. It is
/// χ² + 2 tr(Ω·cov(ν̂, ν(θ̂))) for the weights Ω, the estimates ν̂ and their fitted values ν(θ̂). The Allan variance is twice the variance of
/// Haar wavelets, and the weights are the inverse of the covariance of the fit, the same for all subsets, so that this is χ² plus twice the
/// number of parameters.
///
/// # Errors
/// The covariance of the fit is not definite.
pub fn ranking(described: &Described) -> Result<Vec<RankedModel>, FitError> {
    let Described { fitter, fit, .. } = described;
    let (curve, mut candidates) = (fitter.curve(), fitter.terms.candidates()?);
    if !candidates.contains(&Term::Markov) {
        candidates.push(Term::Markov);
    }
    let covariance = fitter.covariance(fit)?;
    let basis = Basis::new(curve, &candidates);
    let mut models: Vec<RankedModel> = Vec::new();
    let system = System::new(curve, &covariance, &basis);
    for subset in subsets(&candidates) {
        let solution = system.best(&subset);
        let terms = used(&solution);
        let parameters: usize = terms.iter().map(|term| term.parameters()).sum();
        let Some(degrees_of_freedom) = curve.ms().len().checked_sub(parameters) else { continue };
        if terms.is_empty() || models.iter().any(|model| model.terms == terms) {
            continue;
        }
        let (chi_squared, criterion) = (solution.chi_squared, solution.chi_squared + 2.0 * parameters as f64);
        models.push(RankedModel { terms, chi_squared, degrees_of_freedom, criterion });
    }
    models.sort_by(|a, b| a.criterion.total_cmp(&b.criterion));
    Ok(models)
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

/// Probability of the residuals below which a fit does not describe its curve. It leaves room for the scatter of single records
/// at long τ, which is wider than that of a χ².
pub const MIN_P: f64 = 1e-3;
/// Probability of the residuals below which a fit of all octaves is not the result either. It applies where no fit of a part of
/// them is likely, because a single estimate at long τ that is far off spoils every range.
const IMPOSSIBLE_P: f64 = 1e-9;
/// Fewest octaves that show whether a model describes them; any model describes two or three.
const MIN_OCTAVES: usize = 5;

/// Octaves lost from which on a sine or Markov noise is tried instead.
const LOST: usize = 4;
/// Variance at the shortest τ, over that of white noise behind a low-pass, from which on no filter explains it.
const SURPLUS: f64 = 4.0;
/// Least correlation time of noise that is no filter, in shortest τ.
const MIN_TIME: f64 = 4.0;

/// The terms and the range of τ that a user asks of the fit to a record.
#[derive(Debug, Clone, PartialEq)]
pub struct Fitting {
    /// Terms to fit.
    pub terms: Terms,
    /// Shortest τ of the fit, s; searched for if absent.
    pub from_s: Option<f64>,
    /// Longest τ of the fit, s; an eighth of the record if absent.
    pub to_s: Option<f64>,
    /// Whether coefficients keep their values if the terms do not describe the curve.
    pub is_forced: bool,
}

impl From<Terms> for Fitting {
    fn from(terms: Terms) -> Fitting {
        Fitting { terms, from_s: None, to_s: None, is_forced: false }
    }
}

impl Fitting {
    /// The overlapping Allan variances of a record at the octaves within the range.
    ///
    /// # Errors
    /// It fails where [`curve_of`](crate::fit::curve_of) does, and where fewer octaves than terms are within the range.
    pub fn curve(&self, angles: &Angles) -> Result<Curve, FitError> {
        let samples = angles.len().saturating_sub(1);
        let longest = Deviation::Oadev.largest_factor(angles.len());
        let octaves: Vec<usize> = match self.to_s {
            None => factors(samples),
            Some(_) => (0..usize::BITS - 1).map(|octave| 1 << octave).take_while(|&m| m <= longest).collect(),
        };
        let is_within = |m: &usize| {
            let tau_s = *m as f64 * angles.step_s;
            self.from_s.is_none_or(|from_s| is_at_least(tau_s, from_s))
                && self.to_s.is_none_or(|to_s| is_at_least(to_s, tau_s))
        };
        let within: Vec<usize> = octaves.into_iter().filter(is_within).collect();
        let curve = curve_at(angles, &within)?;
        let (points, parameters) = (curve.ms().len(), self.terms.fewest_parameters());
        if points < parameters { Err(FitError::TooFewPoints { points, parameters }) } else { Ok(curve) }
    }
}

/// Whether a τ is at least another one, up to rounding.
fn is_at_least(tau_s: f64, other_s: f64) -> bool {
    tau_s > other_s * (1.0 - 1e-9)
}

/// A fit with the fitter of its range.
#[derive(Debug)]
pub struct Described {
    /// Fitter of the curve over the range.
    pub fitter: Fitter,
    /// Its fit. If [`Described::is_described`] does not hold, that of all octaves.
    pub fit: Fit,
    /// Whether the fit describes the curve.
    pub is_described: bool,
    /// Whether the shortest τ of the curve agrees with the band limit of the fit, if it has one.
    is_filter: bool,
}

/// Fits the terms over the range of `curve` that they describe.
///
/// # Errors
/// It fails where [`fit_record`](crate::fit::fit_record) does over all octaves.
pub fn describe(curve: &Curve, asked: &Fitting) -> Result<Described, FitError> {
    let filtered = Fitter::new(curve, &asked.terms.with(Term::BandLimit))?;
    let whole = match &asked.terms {
        Terms::Auto(_) => filtered.from(0),
        Terms::Given(_) => Fitter::new(curve, &asked.terms)?,
    };
    let fit = whole.fit_record(curve.variances())?;
    let described = |fitter, fit| {
        let is_filter = is_filter(&fit, curve);
        Described { fitter, fit, is_described: true, is_filter }
    };
    if is_likely(&fit) && !is_limited(&fit) {
        return Ok(described(whole, fit));
    }
    let last = match asked.from_s {
        None => curve.ms().len().saturating_sub(MIN_OCTAVES),
        Some(_) => 0,
    };
    let mut was_likely = last == 0;
    let mut found = None;
    for start in 0..=last {
        let fitter = filtered.from(start);
        // A covariance that is not definite belongs to a model that does not hold there.
        let fit = fitter.fit_record(fitter.curve().variances()).ok().filter(is_likely);
        match fit {
            Some(fit) if was_likely => {
                found = Some((start, described(fitter, fit)));
                break;
            }
            fit => was_likely = fit.is_some(),
        }
    }
    match found {
        Some((start, described)) if start < LOST && described.is_filter => Ok(described),
        found => {
            let other = with_shape(curve, &asked.terms)?.map(|(fitter, fit)| described(fitter, fit));
            let other = other.or(found.map(|(_, described)| described));
            let is_described = fit.p_value().is_some_and(|p| p > IMPOSSIBLE_P);
            Ok(other.unwrap_or(Described { fitter: whole, fit, is_described, is_filter: true }))
        }
    }
}

/// Fits chosen terms over the longest range of `curve` that leaves out the shortest τ and whose fit is likely and `agrees` with what
/// else is known, if any does. Quantization noise and band limit are what is left there of the frequencies above.
pub fn describe_without_shortest(
    curve: &Curve,
    asked: &Fitting,
    agrees: impl Fn(&Fit) -> bool,
) -> Option<Described> {
    let filtered = Fitter::new(curve, &asked.terms.with(Term::BandLimit)).ok()?;
    let starts = 1..=curve.ms().len().saturating_sub(MIN_OCTAVES);
    starts.into_iter().find_map(|start| {
        let fitter = filtered.from(start);
        let fit =
            fitter.fit_record(fitter.curve().variances()).ok().filter(|fit| is_likely(fit) && agrees(fit))?;
        let is_filter = is_filter(&fit, curve);
        Some(Described { fitter, fit, is_described: true, is_filter })
    })
}

/// The fit of chosen terms and of Markov noise to a curve, if it is likely, and both white and slower Markov noise are found.
pub fn with_correlation(curve: &Curve, asked: &Fitting) -> Option<Described> {
    let fitter = Fitter::new(curve, &asked.terms.with(Term::BandLimit).with(Term::Markov)).ok()?;
    let fit = fitter.fit_record(curve.variances()).ok().filter(|fit| is_likely(fit) && is_correlated(fit))?;
    Some(Described { fitter, fit, is_described: true, is_filter: false })
}

/// Whether a fit identifies white noise beside Markov noise that is no filter.
fn is_correlated(fit: &Fit) -> bool {
    let is_slow = |part: &Part| part.term == Term::Markov && part.shape > MIN_TIME * fit.tau_range[0];
    let white = fit.coefficient(Term::AngleRandomWalk).map(|found| found.verdict);
    white == Some(Verdict::Identified) && fit.process.parts.iter().any(is_slow)
}

/// The fitter of white noise, Markov noise and the slow terms of a described fit for the whole curve, if that lowers χ² by more than the
/// price of a term, or the described fit leaves out the shortest τ. What is correlated over several samples and not found adds to N.
pub fn room_for_correlation(curve: &Curve, described: &Described) -> Option<Fitter> {
    let parts = || described.fit.process.parts.iter().map(|part| part.term);
    let slow = parts().filter(|&term| !is_fast(term) && term != Term::Markov);
    let terms = [Term::AngleRandomWalk, Term::Markov].into_iter().chain(slow).collect();
    let fitter = Fitter::new(curve, &Terms::Given(terms)).ok()?;
    if described.fitter.curve().ms() != curve.ms() {
        return Some(fitter);
    }
    // With one covariance, a term gains nothing by making points uncertain.
    let covariance = described.fitter.covariance(&described.fit).ok()?;
    let without = Fitter::new(curve, &Terms::Given(parts().collect())).ok()?;
    let gain = without.least_chi_squared(&covariance) - fitter.least_chi_squared(&covariance);
    (gain > PENALTY).then_some(fitter)
}

/// The interval of N in a fit with Markov noise, if the fit is likely and the noise is no filter.
pub fn white_beside_correlation(fitter: &Fitter) -> Option<[f64; 2]> {
    let fit = fitter.fit_record(fitter.curve().variances()).ok()?;
    let is_room = is_likely(&fit) && is_correlated(&fit);
    fit.coefficient(Term::AngleRandomWalk)?.interval.filter(|_| is_room)
}

/// Whether a term falls with τ at least as fast as white noise.
pub fn is_fast(term: Term) -> bool {
    matches!(term, Term::Quantization | Term::AngleRandomWalk | Term::BandLimit)
}

/// The likeliest fit of chosen terms with a sine or Markov noise to the whole curve, if any describes it.
fn with_shape(curve: &Curve, terms: &Terms) -> Result<Option<(Fitter, Fit)>, FitError> {
    let mut best: Option<(Fitter, Fit)> = None;
    if matches!(terms, Terms::Given(_)) {
        return Ok(best);
    }
    for term in [Term::Sine, Term::Markov] {
        let fitter = Fitter::new(curve, &terms.with(term))?;
        let Some(fit) = fitter.fit_record(curve.variances()).ok().filter(is_likely) else { continue };
        let white = fit.coefficient(Term::AngleRandomWalk).map(|found| found.verdict);
        let is_low_pass = term == Term::Markov && white != Some(Verdict::Identified);
        if !is_low_pass && best.as_ref().is_none_or(|(_, other)| fit.p_value() > other.p_value()) {
            best = Some((fitter, fit));
        }
    }
    Ok(best)
}

/// Whether the variance at the shortest τ of a curve is no more than what the band limit of a fit leaves, as if it were that of a
/// first-order low-pass.
fn is_filter(fit: &Fit, curve: &Curve) -> bool {
    let square = |term: Term| fit.process.parts.iter().find(|part| part.term == term).map(Part::square);
    let terms = square(Term::BandLimit).zip(square(Term::AngleRandomWalk)).zip(curve.variances().first());
    terms.is_none_or(|((limit, white), variance)| {
        let [tau_s, _] = curve.tau_range();
        let x = tau_s * white / (2.0 * limit);
        let left = 1.0 - (3.0 - 4.0 * libm::exp(-x) + libm::exp(-2.0 * x)) / (2.0 * x);
        *variance <= SURPLUS * left * white / tau_s
    })
}

/// Whether a fit contains a band limit.
fn is_limited(fit: &Fit) -> bool {
    fit.process.parts.iter().any(|part| part.term == Term::BandLimit)
}

fn is_likely(fit: &Fit) -> bool {
    fit.p_value().is_none_or(|p| p > MIN_P)
}

impl Described {
    /// Leaves out a band limit that is not identified or is no filter. If the fit does not describe the curve, marks its
    /// coefficients and, unless `is_forced`, takes their values.
    pub fn judged(&self, fit: Fit, is_forced: bool) -> Fit {
        let is_shown = |found: &Coefficient| {
            found.term != Term::BandLimit || self.is_filter && found.verdict == Verdict::Identified
        };
        if self.is_described {
            return Fit { coefficients: fit.coefficients.into_iter().filter(is_shown).collect(), ..fit };
        }
        let is_asked = |found: &Coefficient| found.term != Term::BandLimit;
        let of = |found: Coefficient| match is_forced {
            true => Coefficient { verdict: Verdict::NotDescribed, ..found },
            false => found.without_value(Verdict::NotDescribed),
        };
        Fit { coefficients: fit.coefficients.into_iter().filter(is_asked).map(of).collect(), ..fit }
    }
}
