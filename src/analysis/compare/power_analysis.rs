//! The length of two records that is required to distinguish their coefficients.

use std::collections::BTreeMap;

use crate::analysis::compare::NEAREST;
use crate::analysis::compare::equality_test::two;
use sagnac_records::allan::Overdispersion;
use sagnac_records::fit::curve::factors;
use sagnac_records::fit::{Curve, Fit, Quantity, Terms, fit_record};
use sagnac_theory::allan::{Difference, Estimator, Part, Process, Term, flicker};

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
pub(crate) fn needed(
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
    let curve = Curve::new(process.sample_s, samples, Difference::Second, ms, variances?).ok()?;
    fit_record(&curve.spread_by(spread), terms).ok()
}
