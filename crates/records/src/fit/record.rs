//! The curve of a record to which coefficients are fitted.

use crate::allan::{Angles, Deviation, Point, curve};
use crate::fit::{Curve, FitError};
use sagnac_theory::allan::Difference;

/// Inverse of the longest averaging time of the fit relative to the record; beyond it, intervals of K come out too
/// short.
const MAX_TAU_PART: usize = 8;

/// Least part of the degrees of freedom of an averaging time that gaps may leave.
const LEFT: f64 = 0.125;

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
    let known: Vec<&Point> =
        points.iter().filter(|point| point.left >= LEFT && point.value.is_some()).collect();
    let variance = |point: &&Point| point.value.map(|value| value * value);
    let (ms, variances) =
        (known.iter().map(|point| point.m as u64).collect(), known.iter().filter_map(variance).collect());
    let curve = Curve::new(angles.step_s, samples as u64, Difference::Second, ms, variances)?;
    let left: Vec<f64> = known.iter().map(|point| point.left).collect();
    Ok(curve.spread_by(angles.spread().clone()).with_left(&left))
}

/// The averaging factors of a fit to a record of `samples` samples.
pub fn factors(samples: usize) -> Vec<usize> {
    (0..usize::BITS).map(|octave| 1 << octave).take_while(|m| MAX_TAU_PART * m <= samples).collect()
}
