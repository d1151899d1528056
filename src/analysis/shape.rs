//! Whether the spectrum of a record has the shape of the noise that a fit to its Allan curve finds.
//!
//! At the octaves of τ an Allan curve hardly tells what a filter, its alias or a hump does to the highest frequencies: it takes that
//! for quantisation noise or for a part of N. The spectrum shows it.

use crate::fit::{Fit, survival};
use crate::spectrum::Density;
use crate::theory::allan::{Process, Term};

/// Number of bands that are compared, and the least number of frequencies of each.
const BANDS: usize = 12;
const LEAST_IN_BAND: usize = 8;
/// Lowest frequency that is compared, in spacings of the density: below, its window mixes slow noise.
const FIRST: usize = 16;
/// Probability of so different a shape, below which it contradicts.
const LEAST_P: f64 = 1e-5;

/// Whether the density of a record has another shape than the terms of a fit to its curve, whatever its level: up to half the sampling
/// rate.
pub(crate) fn contradicts(density: &Density, fit: &Fit) -> bool {
    differs(density, fit, 0.5 / density.step_s, |term| term != Term::BandLimit)
}

/// Whether it differs from those terms of a fit that describe the shortest τ of its range, up to the frequencies of that τ.
/// Quantisation noise and band limit are what filters leave there of the higher frequencies, and no part of that shape.
pub(crate) fn contradicts_range(density: &Density, fit: &Fit) -> bool {
    differs(density, fit, 0.5 / fit.tau_range[0], |term| {
        !matches!(term, Term::Quantisation | Term::BandLimit)
    })
}

fn differs(density: &Density, fit: &Fit, reach: f64, is_meant: impl Fn(Term) -> bool) -> bool {
    let parts = fit.process.parts.iter().copied().filter(|part| is_meant(part.term)).collect();
    let process = Process { parts, ..fit.process };
    let end = density.points.partition_point(|point| point.frequency_hz < 0.999 * reach);
    let width = end.saturating_sub(FIRST) / BANDS;
    if width < LEAST_IN_BAND {
        return false;
    }
    // Logarithms of the ratios of the means, with their variances.
    let band = |i: usize| {
        let places = FIRST + i * width..FIRST + (i + 1) * width;
        let points = &density.points[places.clone()];
        let expected: f64 = points.iter().filter_map(|point| process.density(point.frequency_hz)).sum();
        let found: f64 = points.iter().map(|point| point.value).sum();
        let freedom = density.mean(places)?.freedom;
        (expected > 0.0 && found > 0.0).then(|| (libm::log(found / expected), 2.0 / freedom))
    };
    let Some(bands) = (0..BANDS).map(band).collect::<Option<Vec<(f64, f64)>>>() else { return false };
    let weights: f64 = bands.iter().map(|(_, variance)| 1.0 / variance).sum();
    let level = bands.iter().map(|(ratio, variance)| ratio / variance).sum::<f64>() / weights;
    let chi_squared =
        bands.iter().map(|(ratio, variance)| (ratio - level) * (ratio - level) / variance).sum();
    survival(chi_squared, BANDS - 1) < LEAST_P
}
