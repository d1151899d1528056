//! Test whether two curves have the same noise, over all averaging times together.

use statrs::function::gamma::digamma;

use crate::analysis::compare::difference::Fits;
use crate::analysis::compare::{MIN_P, NEAREST, Ratio};
use sagnac_records::allan::Point;
use sagnac_records::fit::{Covariance, Curve, FitError, survival};
use sagnac_theory::allan::{Difference, Estimator, Term, gaussian};

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
    let curves = &fits.curves;
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
            let covariance = gaussian::covariance(&process, Difference::Second, samples, &ms);
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
