//! Deviations of a record: Allan, modified Allan, time, Hadamard, total, Theo1 and parabolic, with intervals, and MTIE.
//!
//! ```text
//! rates, increments or angles ─▶ Angles ─ Taus::factors ─▶ curve ─▶ Points ─ minimum ─▶ in-run bias stability
//! ```
//!
//! 1 ″/s is 1 °/h, so a curve of angles in ″ is in °/h. Sums are in a fixed order and functions are libm's, so values
//! have the same bits on every machine and for any number of threads. The exception is the incomplete gamma function of
//! statrs behind the ends of intervals, which may differ in the last digits.
//!
//! Definitions and test values: W. J. Riley, "Handbook of frequency stability analysis", NIST SP 1065; IEEE Std 952.

pub mod angles;
pub mod deviation;
pub mod distributions;
pub(crate) mod edf;
pub mod hat;
pub mod noise;
pub mod sums;
#[cfg(test)]
mod tests;
mod theo;
mod total;

use rayon::prelude::*;

pub use crate::allan::angles::{Angles, Line, Trend};
pub use crate::allan::deviation::{
    Deviation, MAX_FOR_ALL, MAX_OF_COLUMNS, TauError, Taus, Unit, UnknownDeviation,
};
use crate::allan::edf::edf;
use crate::allan::noise::noise;
pub use crate::allan::noise::{MIN_GROUPS, Noise, Overdispersion};
use crate::allan::sums::{Sum, sums};
use sagnac_theory::allan::Process;
use sagnac_theory::allan::gaussian::freedom;

/// A deviation at one averaging time.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Point {
    /// Averaging factor m, τ in samples; for [`Deviation::Theo1`] τ is 0.75 m.
    pub m: usize,
    /// Averaging time τ, s.
    pub tau_s: f64,
    /// Number of differences averaged, without those that touch a gap.
    pub terms: u64,
    /// The deviation, in the unit of the angle per second, or for [`Deviation::Tdev`] and [`Deviation::Mtie`] in that of the angle. Absent
    /// without terms.
    pub value: Option<f64>,
    /// Noise identified by the lag-1 autocorrelation; absent where the record is too short.
    pub noise: Option<Noise>,
    /// The noise that the interval supposes.
    pub supposes: Supposed,
    /// Equivalent degrees of freedom of the variance for that noise.
    pub edf: Option<f64>,
    /// Part of the degrees of freedom of a record without gaps that gaps leave.
    pub left: f64,
    /// Lower and upper end of the interval.
    pub interval: Option<(f64, f64)>,
}

/// The noise that the interval of a deviation supposes.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Supposed {
    /// The power law of the lag-1 autocorrelation at that τ, as in Stable32.
    PowerLaw,
    /// A noise model of the whole record.
    Model,
    /// The autocorrelation of the differences themselves.
    Differences,
}

impl Supposed {
    /// Name in files.
    pub fn name(self) -> &'static str {
        match self {
            Supposed::PowerLaw => "alpha",
            Supposed::Model => "model",
            Supposed::Differences => "differences",
        }
    }
}

/// A deviation of `angles` at each of the averaging `factors`, with two-sided intervals of this `confidence` p, 0 < p <
/// 1.
///
/// # Method
/// The terms are those of NIST SP 1065 (5.2), and take order N operations for each factor. Those that touch a gap are left out.
/// Where missing samples would leave less than a quarter of them, they are of the means of those samples that are known, at least
/// half of each mean; the white noise that this adds is subtracted, and the degrees of freedom are fewer by the square of its
/// part. The noise is identified by its lag-1 autocorrelation. The equivalent degrees of freedom are those of
/// Greenhall and Riley for that noise and a record without gaps, times the part that gaps leave. The interval
/// is that of χ² with these degrees of freedom.
///
/// Total, modified total and Theo1 deviations are freed of the bias that NIST SP 1065 gives for the identified noise, white noise of
/// the rate where it is unknown, and ThêoH of a bias measured against the Allan deviation. Their degrees of freedom are those of SP
/// 1065, those of the parabolic deviation follow from the covariances of its terms. MTIE has no intervals.
///
/// # Limits
/// Exact intervals need noise of one power law; where two meet, intervals are as good as those of the nearer one. Noise
/// for which the deviation does not converge is treated as the steepest for which it does. With few groups the noise is
/// often identified wrongly; [`suppose`] takes it from the record as a whole.
///
/// # Example
/// ```
/// # use sagnac_records::allan::*;
/// let rates: Vec<f64> = (0..1000).map(|i| f64::from(i * 7919 % 1000)).collect();
/// let angles = Angles::from_increments(&rates, 0.01, 0.01, Trend::None);
/// let factors = Taus::Octave.factors(angles.len(), angles.step_s, Deviation::Oadev)?;
/// let points = curve(&angles, Deviation::Oadev, &factors, 0.95);
/// assert_eq!((points[3].tau_s, points[3].terms), (0.08, 985));
/// # Ok::<(), TauError>(())
/// ```
pub fn curve(angles: &Angles, deviation: Deviation, factors: &[usize], confidence: f64) -> Vec<Point> {
    let sums = sums(angles, deviation, factors);
    let is_theo1 = |m: usize| deviation.at(m, angles.len()).0 == Deviation::Theo1;
    let measured = (deviation == Deviation::Theoh && factors.iter().any(|m| is_theo1(*m)))
        .then(|| theo::measured_bias(angles));
    let points = factors.par_iter().zip(sums).map(|(&m, sum)| {
        let tau_s = deviation.tau(m) * angles.step_s;
        let noise = noise(angles, deviation, deviation.tau(m) as usize);
        let (used, factor) = deviation.at(m, angles.len());
        // Where it is unknown, white noise of the rate is the most likely.
        let bias = measured.filter(|_| is_theo1(m)).unwrap_or_else(|| {
            let alpha = noise.map_or(0, |noise| noise.alpha);
            bias(used, alpha, angles.len(), factor)
        });
        let variance = sum.squares / (used.divisor(sum.terms, tau_s) * bias);
        let scale = if deviation == Deviation::Tdev { tau_s / libm::sqrt(3.0) } else { 1.0 };
        // Less than 0 where what missing samples add is nearly all that there is.
        let value = (sum.terms > 0 && variance >= 0.0).then(|| libm::sqrt(variance) * scale);
        let left = left(angles, used, factor, &sum);
        let edf = noise.and_then(|noise| edf(used, noise.alpha, angles.len(), factor)).map(|edf| edf * left);
        // Terms that start at every n-th sample have no more of them than starts.
        let is_thinned = used == Deviation::Theo1 && sum.terms < used.terms(angles.len(), factor) as u64;
        let starts = sum.terms as f64 / (0.5 * factor as f64);
        let edf = edf.map(|edf| if is_thinned { edf.min(starts) } else { edf });
        let interval = value.zip(edf).and_then(|(value, edf)| interval(value, edf, confidence));
        Point { m, tau_s, terms: sum.terms, value, noise, supposes: Supposed::PowerLaw, edf, left, interval }
    });
    points.collect()
}

/// Relation of the expected estimate to the variance that it is for, at the averaging factor `m` of noise of this exponent.
fn bias(deviation: Deviation, alpha: i32, angles: usize, m: usize) -> f64 {
    match deviation {
        Deviation::Totdev => total::bias(alpha, angles - 1, m),
        Deviation::Mtotdev => total::modified_bias(alpha),
        Deviation::Theo1 => theo::bias(alpha, m),
        _ => 1.0,
    }
}

/// Part of the degrees of freedom of a record without gaps that gaps leave to a sum.
fn left(angles: &Angles, deviation: Deviation, m: usize, sum: &Sum) -> f64 {
    let all = deviation.terms(angles.len(), m);
    if deviation.is_of_differences() {
        return sum.left(all);
    }
    let solid = angles.bridged();
    let found: usize = solid.runs.iter().map(|run| deviation.terms(run.len(), m)).sum();
    solid.share * found as f64 / all.max(1) as f64
}

/// Replaces degrees of freedom and intervals of a curve of `angles` by those of `model`, the noise of the whole record with the
/// shortest τ that it describes, s; at shorter τ by those of the autocorrelation of the differences. Where the record scatters more
/// than Gaussian noise, degrees of freedom are as many fewer.
///
/// A point for which neither gives them keeps its own. Gaps count as in [`curve`].
pub fn suppose(
    points: &mut [Point],
    angles: &Angles,
    deviation: Deviation,
    confidence: f64,
    model: Option<&(Process, f64)>,
) {
    let samples = angles.len().saturating_sub(1) as u64;
    let spread = angles.spread();
    points.par_iter_mut().for_each(|point| {
        let m = point.m;
        let (deviation, factor) = deviation.at(m, angles.len());
        let is_known = deviation.is_of_differences();
        let described = model.filter(|(_, from_s)| is_known && point.tau_s > 0.99 * *from_s);
        let by_model = described.and_then(|(process, _)| {
            freedom(process, deviation.estimator(), deviation.is_modified(), samples, m as u64)
        });
        let found = match by_model {
            Some(edf) => Some((edf, Supposed::Model)),
            None if is_known || deviation == Deviation::Pdev => {
                edf::freedom(angles, deviation, factor).map(|edf| (edf, Supposed::Differences))
            }
            None => point.edf.map(|edf| (edf / point.left, Supposed::PowerLaw)),
        };
        let Some((edf, supposes)) = found else { return };
        // The relative variance of an estimate is 2 over its degrees of freedom.
        let edf = 2.0 / (2.0 / (edf * point.left) + spread.at(m as u64) * spread.at(m as u64));
        let interval = point.value.and_then(|value| interval(value, edf, confidence));
        *point = Point { supposes, edf: Some(edf), interval, ..*point };
    });
}

/// The interval of a deviation `value` whose square has `edf` degrees of freedom. `None` for 0, where nothing was
/// resolved.
fn interval(value: f64, edf: f64, confidence: f64) -> Option<(f64, f64)> {
    let end = |probability: f64| {
        let quantile = distributions::chi_squared_quantile(probability, edf)?;
        Some(value * libm::sqrt(edf / quantile)).filter(|end| end.is_finite())
    };
    let tail = 0.5 * (1.0 - confidence);
    (value > 0.0).then_some(())?;
    Some((end(1.0 - tail)?, end(tail)?))
}

/// Shortest record, in τ, whose deviation at τ is likely to be its minimum for another reason than chance.
const MIN_RECORD: usize = 8;

/// The minimum of a curve, which data sheets call in-run bias stability. It is not the bias instability B.
///
/// Averaging times beyond an eighth of the record do not count: estimates there have so few degrees of freedom that the lowest is low by
/// chance.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Minimum {
    /// The lowest point; of equal ones that with the shortest τ.
    pub point: Point,
    /// Whether it is the last point that counts, so that the stability may be better than this record shows.
    pub at_end: bool,
}

impl Minimum {
    /// The minimum of the curve of a record with so many samples; `None` where no point up to an eighth of the record is above 0.
    pub fn from_record(points: &[Point], samples: usize) -> Option<Minimum> {
        Minimum::from_points(&points[..points.partition_point(|point| MIN_RECORD * point.m <= samples)])
    }

    /// The minimum of points that all count; `None` where none is above 0.
    pub fn from_points(points: &[Point]) -> Option<Minimum> {
        let known =
            || points.iter().filter_map(|point| Some((point, point.value.filter(|value| *value > 0.0)?)));
        let (point, _) = known().min_by(|a, b| a.1.total_cmp(&b.1))?;
        let (last, _) = known().next_back()?;
        Some(Minimum { point: *point, at_end: last.tau_s == point.tau_s })
    }
}
