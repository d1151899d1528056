//! Coefficients of two records, term by term.

use crate::analysis::compare::estimate::{Estimate, Two};
use crate::analysis::compare::length;
use crate::analysis::compare::{Length, NEAREST};
use crate::analysis::shape::Noise;
use sagnac_records::events::{Event, Events};
use sagnac_records::fit::interval::WITHIN_95;
use sagnac_records::fit::{Curve, Fit, FitError, Fitting, Quantity, Terms, fit_record};
use sagnac_theory::allan::Term;

/// Significance level: differences with a smaller p are significant.
pub const SIGNIFICANT: f64 = 0.05;

/// Least p; 0 would claim that something is impossible.
pub const MIN_P: f64 = 1e-300;

/// A quantity of both records.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Difference {
    /// Quantity, which determines the unit.
    pub quantity: Quantity,
    /// Values; absent where the record does not show the quantity.
    pub values: [Option<f64>; 2],
    /// Upper bounds of the true values, at 97.5 %; absent where the record gives none.
    pub at_most: [Option<f64>; 2],
    /// The second value less the first, where both are known.
    pub difference: Option<f64>,
    /// 95 % interval of the difference; an end is absent where the records do not determine it, both where no record
    /// shows the quantity.
    pub interval: [Option<f64>; 2],
    /// The second value over the first, where both are known.
    pub ratio: Option<f64>,
    /// 95 % interval of the ratio.
    pub ratio_interval: [Option<f64>; 2],
    /// Probability of estimates at least as far apart if the true values are equal; absent where no record shows the
    /// quantity, or an event of one explains it as well.
    pub p: Option<f64>,
}

/// Two fits with the same terms over the τ at which both are described.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Fits {
    pub fits: [Fit; 2],
    /// The fitted curves.
    pub curves: [Curve; 2],
    pub terms: Vec<Term>,
    /// Terms that at least one record shows if its fit may choose.
    shown: Vec<Term>,
    /// Terms that an event of each record explains as well.
    explained: [Vec<Term>; 2],
    /// What the fit and the spectrum of each record show besides its events.
    pub events: [Vec<Event>; 2],
    /// Whether the terms describe the curve of each record; if not, the fit was forced.
    pub described: [bool; 2],
}

impl Fits {
    /// The fits of two records without their events. With [`Terms::Auto`] the terms are those used by the best fit of either record. A
    /// band limit that either needs is fitted to both. Where a spectrum shows a filter and no fit has a band limit, quantization noise
    /// takes up what is left of the filter, whether or not a fit has chosen it, so that N does not.
    ///
    /// # Errors
    /// A curve cannot be fitted, or is described over no range of τ.
    pub(crate) fn of([a, b]: [&Events; 2], asked: &Fitting) -> Result<Fits, FitError> {
        let (a, b) = rayon::join(|| Noise::of(a, asked), || Noise::of(b, asked));
        let mut noise = [a?, b?];
        if !asked.is_forced && noise.iter().any(|one| !one.described.is_described) {
            return Err(FitError::NotDescribed);
        }
        let chosen = noise.each_mut().map(|one| one.judged(one.described.fit.clone(), asked.is_forced));
        let is_found =
            |term: Term| chosen.iter().flat_map(|fit| &fit.process.parts).any(|part| part.term == term);
        let has_filter = noise.iter().any(|one| one.explains(Term::Quantization));
        let is_rest = |term: Term| term == Term::Quantization && has_filter && !is_found(Term::BandLimit);
        let is_used = |term: &Term| is_found(*term) || is_rest(*term);
        let shows = |term: &Term| {
            chosen.iter().any(|fit| fit.coefficient(*term).is_some_and(|found| found.value.is_some()))
        };
        let used: Vec<Term> = Term::EVERY.into_iter().filter(is_used).collect();
        let (terms, shown): (Vec<Term>, Vec<Term>) = match &asked.terms {
            Terms::Given(given) => {
                let limit = used.into_iter().filter(|term| *term == Term::BandLimit);
                (given.iter().copied().chain(limit).collect(), given.clone())
            }
            Terms::Auto(_) => (used.clone(), used.into_iter().filter(shows).collect()),
        };
        let from_s = chosen.iter().map(|fit| fit.tau_range[0]).fold(0.0, f64::max);
        let curves = noise.each_ref().map(|one| {
            let curve = one.described.fitter.curve();
            let is_short = |m: &u64| (*m as f64) * curve.sample_s() < from_s * (1.0 - NEAREST);
            curve.from(curve.ms().partition_point(is_short))
        });
        let given = Terms::Given(terms.clone());
        let (a, b) = rayon::join(|| fit_record(&curves[0], &given), || fit_record(&curves[1], &given));
        let explained = |one: &Noise| terms.iter().copied().filter(|term| one.explains(*term)).collect();
        let explained = noise.each_ref().map(explained);
        let described = noise.each_ref().map(|one| one.described.is_described);
        let events = noise.map(|one| one.shown);
        Ok(Fits { fits: [a?, b?], curves, terms, shown, explained, events, described })
    }

    /// Both estimates of a term; `widening` multiplies the variance of each record.
    pub(crate) fn of_term(&self, term: Term, widening: [f64; 2]) -> Option<Two> {
        two(&self.fits, Quantity::Coefficient(term), widening)
    }

    /// Whether an event of a record explains a term as well.
    pub(crate) fn is_explained(&self, term: Term) -> bool {
        self.explained.iter().any(|terms| terms.contains(&term))
    }

    /// The differences of all quantities of the terms.
    pub(crate) fn differences(&self, widening: [f64; 2]) -> Vec<Difference> {
        let difference = |quantity| Some(self.difference(quantity, &two(&self.fits, quantity, widening)?));
        Quantity::all(&self.terms).into_iter().filter_map(difference).collect()
    }

    /// Required lengths of the records for each of `differences`; unknown where the values to distinguish are unknown.
    pub(crate) fn lengths(&self, differences: &[Difference]) -> Vec<Length> {
        let is_open = |found: &&Difference| {
            found.difference.is_some_and(|difference| difference != 0.0)
                || found.p.is_some_and(|p| p < SIGNIFICANT)
        };
        let open: Vec<Quantity> = differences.iter().filter(is_open).map(|found| found.quantity).collect();
        let [a, b] = &self.fits;
        let from_s = self.curves[0].tau_range()[0].max(self.curves[1].tau_range()[0]);
        let mut found =
            length::needed([&a.process, &b.process], &self.curves, from_s, &self.terms, &open).into_iter();
        let of = |difference| match is_open(&difference) {
            true => found.next().unwrap_or(Length::Unknown),
            false => Length::Unknown,
        };
        differences.iter().map(of).collect()
    }

    fn difference(&self, quantity: Quantity, two: &Two) -> Difference {
        let (term, _) = quantity.parts();
        let is_shown = self.shown.contains(&term);
        let value = |i: usize| {
            let is_shown = is_shown && !self.explained[i].contains(&term);
            quantity.of(self.fits[i].coefficient(term).filter(|_| is_shown)?).0
        };
        let values = [value(0), value(1)];
        let both = values[0].zip(values[1]);
        let is_there = values.iter().any(Option::is_some) && !self.is_explained(term);
        let finite = |end: f64| (is_there && end.is_finite()).then_some(end);
        let unbounded = f64::INFINITY;
        let interval = two.interval(WITHIN_95, |a, b| b.unwrap_or(unbounded) - a.unwrap_or(unbounded));
        let ratios = two.interval(WITHIN_95, |a, b| match (a, b) {
            (Some(a), Some(b)) if a > 0.0 => b / a,
            (None, _) => 0.0,
            _ => unbounded,
        });
        Difference {
            quantity,
            values,
            at_most: [two.a.at(-WITHIN_95), two.b.at(-WITHIN_95)],
            difference: both.map(|(a, b)| b - a),
            interval: interval.map(finite),
            ratio: both.map(|(a, b)| b / a),
            ratio_interval: ratios.map(finite),
            p: is_there.then(|| two_sided(two.distance().0)),
        }
    }
}

/// Both estimates of a quantity; `None` where a fit has none.
pub(crate) fn two([a, b]: &[Fit; 2], quantity: Quantity, widening: [f64; 2]) -> Option<Two> {
    let estimate = |fit: &Fit, widening: f64| match quantity {
        Quantity::Coefficient(term) => {
            Some(Estimate::Square(fit.coefficient(term)?.evidence?.widened(widening)))
        }
        Quantity::Shape(term) => {
            let shape = fit.coefficient(term)?.shape?;
            let error = libm::sqrt(widening) * shape.standard_error / shape.value;
            Some(Estimate::Logarithm { value: shape.value, error })
        }
    };
    Some(Two { a: estimate(a, widening[0])?, b: estimate(b, widening[1])? })
}

/// The probability that a normal number is at least this far from its mean, on either side.
fn two_sided(distance: f64) -> f64 {
    libm::erfc(distance / core::f64::consts::SQRT_2).max(MIN_P)
}
