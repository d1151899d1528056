//! Whole units of a readout.

use crate::allan::Angles;
use crate::events::{Event, What};

/// Increments that are examined.
const EXAMINED: usize = 1 << 14;
/// Distance from a whole multiple, in units, that rounding may leave.
const ROUNDING: f64 = 1e-3;
/// Size of a unit that matters, in standard deviations of an increment about its neighbourhood.
const MIN_UNIT: f64 = 0.5;

/// Part of equal neighbouring increments from which on pulses are so large: the noise of a sample is below 1.4 pulses.
const COARSE: f64 = 0.2;
/// Difference of neighbouring increments, relative to that of most, which counts as none.
const EQUAL: f64 = 1e-2;

/// The unit of which neighbouring increments differ by whole multiples, if it is not small against the noise.
pub(crate) fn of(angles: &Angles) -> Option<Event> {
    let count = angles.len().saturating_sub(1);
    let stride = (count / EXAMINED).max(1);
    let rates = |i: usize| angles.rates(i..(i + 2).min(count));
    let differences: Vec<f64> = (0..count.saturating_sub(1))
        .step_by(stride)
        .map(|i| libm::fabs(rates(i)[1] - rates(i)[0]))
        .filter(|x| x.is_finite())
        .collect();
    let scatter = libm::sqrt(angles.scatter()) / angles.step_s;
    let noise = 1e-6 * scatter;
    let unit = differences.iter().copied().filter(|x| *x > noise).fold(f64::INFINITY, f64::min);
    let is_whole = |x: &f64| {
        let times = x / unit;
        libm::fabs(times - libm::round(times)) < ROUNDING * times.max(1.0)
    };
    let is_large = unit.is_finite() && unit > MIN_UNIT * scatter;
    (is_large && differences.iter().all(is_whole))
        .then(|| Event { size: Some(unit), ..Event::of(What::Units) })
}

/// Whether many neighbouring increments are equal, as of pulses that are larger than the noise of a sample.
pub(crate) fn is_coarse(angles: &Angles) -> bool {
    let longest = angles.runs().iter().max_by_key(|run| run.len()).cloned().unwrap_or_default();
    let values = &angles.values()[longest.start..longest.end.min(longest.start + EXAMINED)];
    let all: Vec<f64> =
        values.windows(3).map(|x| (x[2] - 2.0 * x[1] + x[0]).abs()).filter(|x| x.is_finite()).collect();
    let mean = all.iter().sum::<f64>() / all.len() as f64;
    let equal = all.iter().filter(|x| **x < EQUAL * mean).count();
    equal as f64 > COARSE * all.len() as f64
}
