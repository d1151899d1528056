//! The range of τ over which noise terms describe the curve of a record.
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

use crate::allan::{Angles, Deviation};
use crate::fit::choose::PENALTY;
use crate::fit::record::{curve_at, factors};
use crate::fit::{Coefficient, Curve, Fit, FitError, Fitter, Terms, Verdict};
use sagnac_theory::allan::{Part, Term};

/// Probability of the residuals below which a fit does not describe its curve. It leaves room for the scatter of single records
/// at long τ, which is wider than that of a χ².
pub const MIN_P: f64 = 1e-3;
/// Probability of the residuals below which a fit of all octaves is not the result either. It applies where no fit of a part of
/// them is likely, because a single estimate at long τ that is far off spoils every range.
pub const IMPOSSIBLE_P: f64 = 1e-9;
/// Fewest octaves that show whether a model describes them; any model describes two or three.
pub const MIN_OCTAVES: usize = 5;

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
pub(crate) fn is_at_least(tau_s: f64, other_s: f64) -> bool {
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
