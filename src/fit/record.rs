//! The curve of a record to which coefficients are fitted.

use crate::allan::{Angles, Deviation, Point, curve};
use crate::fit::{Curve, FitError};
use crate::theory::allan::Difference;

/// Inverse of the longest averaging time of the fit relative to the record; beyond it, intervals of K come out too
/// short.
const LONGEST: usize = 8;

/// Inverse of the fewest differences of an averaging time that gaps may leave over. With fewer, as where many single samples are
/// missing, intervals that suppose a record without gaps are far too short.
const LEFT: u64 = 8;

/// The overlapping Allan variances at the octaves of τ up to an eighth of a record, for [`crate::fit::fitter::fit_record`].
///
/// # Errors
/// The variance of the record is 0, or the record is too long for the flicker model.
pub fn curve_of(angles: &Angles) -> Result<Curve, FitError> {
    curve_at(angles, &factors(angles.len().saturating_sub(1)))
}

/// The overlapping Allan variances of a record at those of the averaging factors for which gaps leave enough differences.
///
/// # Errors
/// It fails where [`curve_of`] does.
pub(crate) fn curve_at(angles: &Angles, factors: &[usize]) -> Result<Curve, FitError> {
    let samples = angles.len().saturating_sub(1);
    let points = curve(angles, Deviation::Oadev, factors, 0.95);
    let is_left = |point: &&Point| LEFT * point.terms >= Deviation::Oadev.terms(angles.len(), point.m) as u64;
    let square = |point: &Point| Some((point.m as u64, point.value? * point.value?));
    let known: Vec<(u64, f64)> = points.iter().filter(is_left).filter_map(square).collect();
    let (ms, variances) = known.into_iter().unzip();
    let curve = Curve::new(angles.step_s, samples as u64, Difference::Second, ms, variances)?;
    Ok(curve.spread_by(angles.spread().clone()))
}

/// The averaging factors of a fit to a record of `samples` samples.
pub(crate) fn factors(samples: usize) -> Vec<usize> {
    (0..usize::BITS).map(|octave| 1 << octave).take_while(|m| LONGEST * m <= samples).collect()
}
