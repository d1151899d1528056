//! Whether two logs have the same noise: differences of curves and densities, the test of all of them together, and the length of
//! two records that is required to distinguish their coefficients.

use std::collections::BTreeMap;

use crate::analysis::compare::estimate::{Estimate, Two};
use crate::analysis::compare::{NEAREST, Ratio};
use crate::analysis::data_sheet::Noise;
use sagnac_records::allan::{Overdispersion, Point};
use sagnac_records::events::{Event, Events};
use sagnac_records::fit::curve::factors;
use sagnac_records::fit::uncertainty::WITHIN_95;
use sagnac_records::fit::{Covariance, Curve, Fit, FitError, Fitting, Quantity, Terms, fit_record, survival};
use sagnac_theory::allan::{self, Estimator, Part, Process, Term, flicker, gaussian};
use statrs::function::gamma::digamma;

/// The test of two records for equal noise.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Same {
    /// Probability of curves at least as far apart if the noise is the same.
    pub p: f64,
    /// Number of averaging times in the test.
    pub times: usize,
    /// Shortest of these times, s.
    pub shortest_s: f64,
    /// Longest of these times, s.
    pub longest_s: f64,
    /// χ² of the logarithms of all ratios, with the covariance between them and as many degrees of freedom as times.
    /// Without a fit it is absent, and p is the least one of a single ratio times the number of ratios (Bonferroni).
    pub chi_squared: Option<f64>,
}

/// Tests by χ² of the logarithms of the ratios at the τ of both fits.
///
/// Under the hypothesis both records have one process, with the squares from which both have the least distance. Its
/// closed form gives the expected logarithms, even where the samplings differ, and their covariance: that of the
/// estimates relative to their means, with mean and variance of the logarithm of a χ² with the same degrees of freedom.
///
/// The deviations beyond those of Gaussian noise that the estimates of a record have in common are added to it.
///
/// What a filter leaves in either record, 1/τ² of quantization noise or of a band limit, is that of its own fit. Because it is
/// fitted, a difference of that shape is taken out of the χ², which has a degree of freedom less.
///
/// `left` is the fraction of the differences of each record that remain despite gaps, for each ratio.
pub(crate) fn by_fits(
    ratios: &[Ratio],
    left: &[[f64; 2]],
    fits: &Fits,
    widening: [f64; 2],
) -> Result<Option<Same>, FitError> {
    let Some(curves) = &fits.curves else { return Ok(None) };
    let is_within = |(point, curve): (&Point, &Curve)| {
        let [from_s, to_s] = curve.tau_range();
        (1.0 - NEAREST) * from_s <= point.tau_s && point.tau_s <= (1.0 + 1e-9) * to_s
    };
    let is_used = |ratio: &Ratio| ratio.value.is_some() && ratio.points.iter().zip(curves).all(is_within);
    let (used, left): (Vec<&Ratio>, Vec<[f64; 2]>) =
        ratios.iter().zip(left).filter(|(ratio, _)| is_used(ratio)).unzip();
    let Some(last) = used.last() else { return Ok(None) };
    let is_of_filter =
        |term: &Term| *term == Term::BandLimit || *term == Term::Quantization && fits.is_explained(*term);
    let (of_filter, of_noise): (Vec<Term>, Vec<Term>) =
        fits.terms.iter().partition(|term| is_of_filter(term));
    let common: Vec<(Term, f64, f64)> =
        of_noise.iter().filter_map(|&term| pooled(fits, term, widening)).collect();
    let mut trace = vec![];
    let mut rows = vec![vec![0.0; used.len()]; used.len()];
    let mut logarithms: Vec<f64> =
        used.iter().filter_map(|ratio| Some(2.0 * libm::log(ratio.value?))).collect();
    // Two records of equal length share the covariance.
    let mut known = None;
    for (i, sign) in [(0, -1.0), (1, 1.0)] {
        let own = fits.fits[i].process.parts.iter().filter(|part| of_filter.contains(&part.term));
        let own = own.map(|part| (part.term, part.square(), part.shape));
        let process = curves[i].process(&common.iter().copied().chain(own).collect::<Vec<_>>());
        let samples = curves[i].samples();
        let ms: Vec<u64> = used.iter().map(|ratio| ratio.points[i].m as u64).collect();
        let of_this = (process.sample_s, samples, ms.clone());
        if known.as_ref().is_none_or(|(of, _)| *of != of_this) {
            let covariance = gaussian::covariance(&process, allan::Difference::Second, samples, &ms);
            known = Some((of_this, covariance));
        }
        let Some((_, covariance)) = &known else { continue };
        let means: Vec<f64> = ms
            .iter()
            .map(|&m| process.expected(Estimator::OVERLAPPING, samples, m).unwrap_or(f64::NAN))
            .collect();
        trace = ms.iter().zip(&means).map(|(&m, mean)| 1.0 / (mean * (m * m) as f64)).collect();
        let relative = |j: usize, k: usize| {
            covariance[j][k] / (means[j] * means[k] * libm::sqrt(left[j][i] * left[k][i]))
        };
        let moments: Vec<(f64, f64)> = (0..ms.len()).map(|j| moments_of_logarithm(relative(j, j))).collect();
        let spread: Vec<f64> = ms.iter().map(|&m| curves[i].spread().at(m)).collect();
        for j in 0..ms.len() {
            logarithms[j] -= sign * (libm::log(means[j]) + moments[j].0);
            for k in 0..ms.len() {
                rows[j][k] += relative(j, k)
                    * libm::sqrt(moments[j].1 / relative(j, j) * moments[k].1 / relative(k, k))
                    + spread[j] * spread[k];
            }
        }
    }
    let covariance = Covariance::new(rows)?;
    let product = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
    let whitened = covariance.whiten(&logarithms);
    let mut chi_squared = product(&whitened, &whitened);
    let mut freedom = used.len();
    if !of_filter.is_empty() {
        let trace = covariance.whiten(&trace);
        let part = product(&whitened, &trace);
        chi_squared -= part * part / product(&trace, &trace);
        freedom -= 1;
    }
    Ok(Some(Same {
        p: survival(chi_squared, freedom).max(MIN_P),
        times: used.len(),
        shortest_s: used[0].tau_s(),
        longest_s: last.tau_s(),
        chi_squared: Some(chi_squared),
    }))
}

/// Tests by the least p of all ratios.
pub(crate) fn by_least_p(ratios: &[Ratio]) -> Option<Same> {
    let known: Vec<(&Ratio, f64)> = ratios.iter().filter_map(|ratio| Some((ratio, ratio.p?))).collect();
    let least = known.iter().map(|(_, p)| *p).fold(1.0, f64::min);
    let ([first, ..], last) = (&known[..], known.last()?) else { return None };
    let (shortest_s, longest_s, times) = (first.0.tau_s(), last.0.tau_s(), known.len());
    Some(Same { p: (times as f64 * least).min(1.0), times, shortest_s, longest_s, chi_squared: None })
}

/// A term with the square and the shape from which both records have the least distance.
fn pooled(fits: &Fits, term: Term, widening: [f64; 2]) -> Option<(Term, f64, f64)> {
    let (_, value) = fits.of_term(term, widening)?.distance();
    let shapes: Vec<f64> =
        fits.fits.iter().filter_map(|fit| Some(fit.coefficient(term)?.shape?.value)).collect();
    let shape = match shapes[..] {
        [a, b] => libm::sqrt(a * b),
        [only] => only,
        _ if term.has_shape() => return None,
        _ => 1.0,
    };
    Some((term, value * value, shape))
}

/// Mean and variance of the logarithm of a χ² relative to its mean, by its relative variance 2/ν: ψ(ν/2) − ln(ν/2) and
/// ψ′(ν/2).
fn moments_of_logarithm(relative: f64) -> (f64, f64) {
    let half = 1.0 / relative;
    (digamma(half) - libm::log(half), trigamma(half))
}

/// ψ′ by its recurrence up to 10 and the asymptotic series (Abramowitz and Stegun 6.4.12), accurate to 1e-12.
fn trigamma(x: f64) -> f64 {
    let (mut x, mut sum) = (x, 0.0);
    while x < 10.0 {
        sum += 1.0 / (x * x);
        x += 1.0;
    }
    let y = 1.0 / (x * x);
    let series = y * (1.0 / 6.0 - y * (1.0 / 30.0 - y * (1.0 / 42.0 - y * (1.0 / 30.0 - y * 5.0 / 66.0))));
    sum + (1.0 + 0.5 / x + series) / x
}

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
    /// The fitted curves, if both are of records.
    pub curves: Option<[Curve; 2]>,
    pub terms: Vec<Term>,
    /// Terms that at least one record shows if its fit may choose.
    pub(super) shown: Vec<Term>,
    /// Terms that an event of each record explains as well.
    pub(super) explained: [Vec<Term>; 2],
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
    pub(crate) fn new([a, b]: [&Events; 2], asked: &Fitting) -> Result<Fits, FitError> {
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
        Ok(Fits { fits: [a?, b?], curves: Some(curves), terms, shown, explained, events, described })
    }

    /// Both estimates of a term; `widening` multiplies the variance of each record.
    pub(crate) fn of_term(&self, term: Term, widening: [f64; 2]) -> Option<Two> {
        two(&self.fits, Quantity::Coefficient(term), widening)
    }

    /// Whether an event of a record explains a term as well.
    pub(crate) fn is_explained(&self, term: Term) -> bool {
        self.explained.iter().any(|terms| terms.contains(&term))
    }

    /// The differences of all quantities of the terms. Of sides that are no records, one may lack a term.
    pub(crate) fn differences(&self, widening: [f64; 2]) -> Vec<Difference> {
        let difference = |quantity| match two(&self.fits, quantity, widening) {
            Some(two) => Some(self.difference(quantity, &two)),
            None => self.alone(quantity).filter(|_| self.curves.is_none()),
        };
        Quantity::all(&self.terms).into_iter().filter_map(difference).collect()
    }

    /// Required lengths of the records for each of `differences`; unknown where the values to distinguish are unknown, or a side is no
    /// record.
    pub(crate) fn lengths(&self, differences: &[Difference]) -> Vec<Length> {
        let is_open = |found: &&Difference| {
            found.difference.is_some_and(|difference| difference != 0.0)
                || found.p.is_some_and(|p| p < SIGNIFICANT)
        };
        let open: Vec<Quantity> = differences.iter().filter(is_open).map(|found| found.quantity).collect();
        let Some(curves) = &self.curves else { return vec![Length::Unknown; differences.len()] };
        let [a, b] = &self.fits;
        let from_s = curves[0].tau_range()[0].max(curves[1].tau_range()[0]);
        let mut found = needed([&a.process, &b.process], curves, from_s, &self.terms, &open).into_iter();
        let of = |difference| match is_open(&difference) {
            true => found.next().unwrap_or(Length::Unknown),
            false => Length::Unknown,
        };
        differences.iter().map(of).collect()
    }

    /// The value of a quantity in a fit; `None` where its record does not show it.
    fn value(&self, i: usize, quantity: Quantity) -> Option<f64> {
        let (term, _) = quantity.parts();
        let is_shown = self.shown.contains(&term) && !self.explained[i].contains(&term);
        quantity.of(self.fits[i].coefficient(term).filter(|_| is_shown)?).0
    }

    /// A quantity that one side lacks, so that nothing can be compared; `None` where no side shows it.
    fn alone(&self, quantity: Quantity) -> Option<Difference> {
        let values = [0, 1].map(|i| self.value(i, quantity));
        values.iter().any(Option::is_some).then_some(Difference {
            quantity,
            values,
            at_most: [None; 2],
            difference: None,
            interval: [None; 2],
            ratio: None,
            ratio_interval: [None; 2],
            p: None,
        })
    }

    fn difference(&self, quantity: Quantity, two: &Two) -> Difference {
        let (term, _) = quantity.parts();
        let values = [0, 1].map(|i| self.value(i, quantity));
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

/// Distance of 1.96 standard deviations for p = 5 %, plus 1.28, so that 90 % of records have at least that distance.
const DISTANCE: f64 = 1.959_963_984_540_054 + 1.281_551_565_544_600_4;

/// Tried lengths: 2^5 to 2^26 samples of the shorter step, this many per octave.
const MIN_LOG2: u32 = 5;
const MAX_LOG2: u32 = 26;
const STEPS: u32 = 32;

/// The length that each of two equally long records must have for a difference to be significant at 5 % in 90 % of
/// comparisons, if the true values are the estimated ones.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Length {
    /// The required length of each record to 2 %, s.
    Needed(f64),
    /// More than the longest tried length, s.
    Beyond(f64),
    /// The values found are equal, or one is unknown and the difference not significant.
    Unknown,
}

/// The lengths for each of `quantities`, for records of two `processes` with the samplings and spreads of these `curves`, fitted
/// with `terms` from τ = `from_s` on.
///
/// The closed-form curve of each process is fitted with the covariance of the estimates of a record of that length, up
/// to an eighth of it. The fit is then the process itself, with the uncertainty of such a record. The uncertainty falls
/// faster than the square root of the length, because longer τ become available.
fn needed(
    processes: [&Process; 2],
    curves: &[Curve; 2],
    from_s: f64,
    terms: &[Term],
    quantities: &[Quantity],
) -> Vec<Length> {
    let mut search = Search { processes, curves, from_s, terms, fits: BTreeMap::new() };
    let mut open: Vec<usize> = (0..quantities.len()).collect();
    let mut lengths = vec![Length::Beyond(search.length(MAX_LOG2 * STEPS)); quantities.len()];
    for octave in MIN_LOG2..=MAX_LOG2 {
        let at = octave * STEPS;
        open.retain(|&i| {
            let is_reached = search.distance(at, quantities[i]).is_some_and(|found| found >= DISTANCE);
            if is_reached {
                lengths[i] = Length::Needed(search.between(at, quantities[i]));
            }
            !is_reached
        });
        if open.is_empty() {
            break;
        }
    }
    lengths
}

struct Search<'a> {
    processes: [&'a Process; 2],
    curves: &'a [Curve; 2],
    from_s: f64,
    terms: &'a [Term],
    /// Fits by the logarithm of the length.
    fits: BTreeMap<u32, Option<[Fit; 2]>>,
}

impl Search<'_> {
    fn length(&self, at: u32) -> f64 {
        libm::exp2(f64::from(at) / f64::from(STEPS))
            * self.curves[0].sample_s().min(self.curves[1].sample_s())
    }

    /// The distance between the expected estimates of a quantity.
    fn distance(&mut self, at: u32, quantity: Quantity) -> Option<f64> {
        let length = self.length(at);
        let (processes, curves, from_s, terms) = (self.processes, self.curves, self.from_s, self.terms);
        let fits = self.fits.entry(at).or_insert_with(|| {
            let terms = Terms::Given(terms.to_vec());
            let fit = |i: usize| {
                let samples = libm::round(length / curves[i].sample_s()) as u64;
                let spread = curves[i].spread().over(samples as f64 / curves[i].samples() as f64);
                expected(processes[i], samples, spread, from_s, &terms)
            };
            let (a, b) = rayon::join(|| fit(0), || fit(1));
            Some([a?, b?])
        });
        Some(two(fits.as_ref()?, quantity, [1.0; 2])?.distance().0)
    }

    /// The shortest sufficient length within an octave below one that is sufficient.
    fn between(&mut self, enough: u32, quantity: Quantity) -> f64 {
        let (mut low, mut high) = ((enough - STEPS).max(MIN_LOG2 * STEPS), enough);
        while high - low > 1 {
            let middle = (low + high) / 2;
            if self.distance(middle, quantity).is_some_and(|found| found >= DISTANCE) {
                high = middle;
            } else {
                low = middle;
            }
        }
        self.length(high)
    }
}

/// The fit of the expected curve of records of `samples` samples with this spread from τ = `from_s` on.
pub(crate) fn expected(
    process: &Process,
    samples: u64,
    spread: Overdispersion,
    from_s: f64,
    terms: &Terms,
) -> Option<Fit> {
    let octaves = flicker::octaves(samples)?;
    let of_length = |part: &Part| Part { octaves, ..*part };
    let process =
        Process { sample_s: process.sample_s, parts: process.parts.iter().map(of_length).collect() };
    let is_short = |m: &u64| (*m as f64) * process.sample_s < from_s * (1.0 - NEAREST);
    let ms: Vec<u64> = factors(samples as usize).into_iter().map(|m| m as u64).skip_while(is_short).collect();
    let variances: Option<Vec<f64>> =
        ms.iter().map(|&m| process.expected(Estimator::OVERLAPPING, samples, m)).collect();
    let curve = Curve::new(process.sample_s, samples, allan::Difference::Second, ms, variances?).ok()?;
    fit_record(&curve.spread_by(spread), terms).ok()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn moments_are_those_of_scipy() {
        // SciPy 1.17: polygamma(1, x).
        let table = [
            (0.5, 4.93480220054468),
            (1.0, 1.6449340668482266),
            (2.5, 0.4903577561002349),
            (30.0, 0.033895060357739946),
        ];
        for (x, expected) in table {
            assert!((trigamma(x) / expected - 1.0).abs() < 1e-12, "{x}: {}", trigamma(x));
        }
        let (mean, variance) = moments_of_logarithm(1e-7);
        assert!((mean + 0.5e-7).abs() < 1e-13 && (variance / 1e-7 - 1.0).abs() < 1e-6, "{mean}, {variance}");
    }
}
