//! The noise of a record: the power law that it follows at an averaging time, and how far its estimates deviate from those of
//! Gaussian noise.
//!
//! # Power law
//!
//! W. J. Riley and C. A. Greenhall, "Power law noise identification using the lag 1 autocorrelation", EFTF 2004. The
//! record is decimated to groups of τ and differenced until it is stationary. Its lag-1 autocorrelation r then gives δ
//! = r/(1 + r), and with d differences of the angle the exponent is α = 2 − 2(δ + d).
//!
//! # Spread
//!
//! Noise with long tails, noise that comes and goes, and single events make the mean squares of the parts of a record differ by
//! more than those of Gaussian noise with the same autocorrelation do. The estimates of the whole record are as much less certain.
//! As the same events and changes are behind those of all averaging times, the estimates deviate together.

use std::ops::Range;

use rayon::prelude::*;

use crate::allan::sums::{Sum, sums};
use crate::allan::{Angles, Deviation, Unit, distributions, edf};

/// Fewest groups that the identification needs.
pub const MIN_GROUPS: usize = 30;

/// Most groups used, from the middle of the record; with so many, α is known to a few hundredths.
const MAX_GROUPS: usize = 1 << 16;

/// Bound of δ below which a series counts as stationary.
const STATIONARY: f64 = 0.25;

/// The exponent of the spectral density of the rate, S(f) ∝ f^α.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Noise {
    /// 2 … −2 for Allan deviations, 2 … −4 for Hadamard deviations.
    pub alpha: i32,
    /// Whether it was identified at a shorter τ, because here there are fewer than [`MIN_GROUPS`] groups.
    pub carried: bool,
}

impl Noise {
    /// Name for the user, in a curve of this unit.
    pub fn name(self, unit: Unit) -> &'static str {
        let is_acceleration = unit == Unit::Acceleration;
        let of = |rotation, acceleration| if is_acceleration { acceleration } else { rotation };
        match self.alpha {
            2.. => "quantization",
            1 => of("flicker of the angle", "flicker of the velocity"),
            0 => of("angle random walk", "velocity random walk"),
            -1 => "bias instability",
            -2 => of("rate random walk", "acceleration random walk"),
            -3 => of("flicker walk of the rate", "flicker walk of the acceleration"),
            _ => of("random run of the rate", "random run of the acceleration"),
        }
    }
}

/// The noise at the averaging factor `m`, or at the largest power of two below it for which there are enough groups.
///
/// `None` where there are too few even at m = 1, and where nothing varies.
pub(crate) fn noise(angles: &Angles, deviation: Deviation, m: usize) -> Option<Noise> {
    let found = |m: usize| identify(angles, deviation.differences(), m);
    if let Some(alpha) = found(m) {
        return Some(Noise { alpha, carried: false });
    }
    let longest = m.min(angles.len() / MIN_GROUPS).checked_ilog2()?;
    let alpha = (0..=longest).rev().find_map(|octave| found(1 << octave))?;
    Some(Noise { alpha, carried: true })
}

fn identify(angles: &Angles, most: usize, m: usize) -> Option<i32> {
    if angles.len().div_ceil(m) < MIN_GROUPS {
        return None;
    }
    let groups = middle((angles.len() - 1) / m);
    let (mut z, mut d) = if angles.missing() == 0 {
        let known = &angles.values()[groups.start * m..=groups.end * m];
        (without_polynomial(known.iter().step_by(m).copied().collect(), 2), 0)
    } else {
        // The angle after a gap is unknown, so the averages of the rate, its first differences, are used.
        (without_polynomial(averages(angles, groups, m), 1), 1)
    };
    loop {
        let (pairs, r) = autocorrelation(&z)?;
        if pairs + 1 < MIN_GROUPS - d {
            return None;
        }
        // A series that has been differenced once too often has r no lower than −1/2. Anything below is scatter, for
        // which δ would go to infinity.
        let r = r.max(-0.5);
        let delta = r / (1.0 + r);
        if delta < STATIONARY || d >= most {
            let alpha = 2.0 - 2.0 * d as f64 - libm::round(2.0 * delta);
            // Beyond these limits the variance does not converge, and its intervals are meaningless.
            let least = -2.0 * (most as f64 - 1.0);
            return Some(alpha.clamp(least, 2.0) as i32);
        }
        z = z.windows(2).map(|pair| pair[1] - pair[0]).collect();
        d += 1;
    }
}

/// At most [`MAX_GROUPS`] of `groups`, taken from the middle.
fn middle(groups: usize) -> Range<usize> {
    let kept = groups.min(MAX_GROUPS);
    let first = (groups - kept) / 2;
    first..first + kept
}

/// Differences of angles m apart, by the mean of the known increments; NaN where fewer than half of them are known, or an angle is
/// not.
fn averages(angles: &Angles, groups: Range<usize>, m: usize) -> Vec<f64> {
    let (x, runs) = (angles.values(), angles.runs());
    let average = |group: usize| {
        let (start, end) = (group * m, (group + 1) * m);
        if let Some(known) = angles.known() {
            let count = f64::from(known[end] - known[start]);
            return if 2.0 * count < m as f64 { f64::NAN } else { (x[end] - x[start]) * m as f64 / count };
        }
        let run = runs.get(runs.partition_point(|run| run.end <= start));
        let unbroken = run.is_some_and(|run| run.contains(&start) && run.contains(&end));
        if unbroken { x[end] - x[start] } else { f64::NAN }
    };
    groups.map(average).collect()
}

/// `z` less its least-squares polynomial of `degree` 1 or 2; NaN stays NaN.
///
/// The polynomials are orthogonal over evenly spaced positions. With values missing those of degree 2 would not be;
/// callers then use degree 1, for which the mean position of the known values makes them orthogonal.
fn without_polynomial(mut z: Vec<f64>, degree: usize) -> Vec<f64> {
    let known = |z: &[f64]| z.iter().filter(|value| !value.is_nan()).count() as f64;
    let count = known(&z);
    if count < 3.0 {
        return z;
    }
    let places = || (0..z.len()).map(|i| i as f64);
    let middle = places().zip(&z).filter(|(_, value)| !value.is_nan()).map(|(i, _)| i).sum::<f64>() / count;
    let half = 0.5 * z.len() as f64;
    // Positions in −1 … 1, so that fourth powers stay small.
    let place = |i: usize| (i as f64 - middle) / half;
    let mut subtract = |basis: &dyn Fn(usize) -> f64| {
        let (mut product, mut square) = (0.0, 0.0);
        for (i, value) in z.iter().enumerate().filter(|(_, value)| !value.is_nan()) {
            let p = basis(i);
            product += p * value;
            square += p * p;
        }
        let factor = if square > 0.0 { product / square } else { 0.0 };
        z.iter_mut().enumerate().for_each(|(i, value)| *value -= factor * basis(i));
    };
    subtract(&|_| 1.0);
    subtract(&|i| place(i));
    if degree == 2 {
        let n = count;
        let mean_square = (n * n - 1.0) / (12.0 * half * half);
        subtract(&|i| place(i) * place(i) - mean_square);
    }
    z
}

/// The number of pairs of neighbours of which both are known, and the lag-1 autocorrelation.
fn autocorrelation(z: &[f64]) -> Option<(usize, f64)> {
    let known = || z.iter().copied().filter(|value| !value.is_nan());
    let (mut count, mut sum) = (0.0, 0.0);
    known().for_each(|value| {
        count += 1.0;
        sum += value;
    });
    let mean = sum / count;
    let (mut pairs, mut product, mut square) = (0, 0.0, 0.0);
    for pair in z.windows(2) {
        let lagged = (pair[0] - mean) * (pair[1] - mean);
        if !lagged.is_nan() {
            pairs += 1;
            product += lagged;
        }
    }
    known().for_each(|value| square += (value - mean) * (value - mean));
    // Where gaps cost pairs, numerator and denominator are means over their own terms.
    let r = (product / pairs as f64) / (square / (count - 1.0));
    r.is_finite().then_some((pairs, r))
}

/// Number of parts, and how many of them gaps must leave.
const PARTS: usize = 32;
const MIN_PARTS: usize = 16;
/// Fewest degrees of freedom of a part; with them its mean square is nearly normal.
const MIN_FREEDOM: f64 = 32.0;
/// Probability, if the noise is Gaussian, that parts differ by less, from which on their differences count.
const SURE: f64 = 0.999;

/// Relative standard deviations that the Allan variances of a record have beyond those of Gaussian noise, one for each octave of the
/// averaging factor.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Overdispersion(Vec<f64>);

impl Overdispersion {
    /// The spread of the overlapping Allan variances of a record. It is 0 unless the parts differ at some averaging factor more than
    /// those of one in a thousand records of Gaussian noise.
    pub(crate) fn new(angles: &Angles) -> Overdispersion {
        let length = angles.len() / PARTS;
        let octaves: Vec<usize> =
            (0..usize::BITS).map(|octave| 1 << octave).take_while(|m| 2 * m < length).collect();
        if octaves.is_empty() {
            return Overdispersion::default();
        }
        let of_part = |i: usize| sums(&angles.part(i * length..(i + 1) * length), Deviation::Oadev, &octaves);
        let parts: Vec<Vec<Sum>> = (0..PARTS).map(of_part).collect();
        let scatter = |(octave, m): (usize, &usize)| {
            let terms = Deviation::Oadev.terms(angles.len(), *m) as f64;
            let freedom = edf::freedom(angles, Deviation::Oadev, *m)? / terms;
            scatter_of(parts.iter().map(|part| part[octave]).collect(), freedom)
        };
        let found: Vec<Option<Scatter>> = octaves.par_iter().enumerate().map(scatter).collect();
        let found: Vec<Scatter> = found.into_iter().map_while(|scatter| scatter).collect();
        let is_sure = found.iter().any(|scatter| scatter.is_sure);
        Overdispersion(found.iter().map(|scatter| if is_sure { scatter.spread } else { 0.0 }).collect())
    }

    /// The relative standard deviation at the averaging factor `m`. Beyond the longest one for which parts show it, it is that of
    /// the longest one, as of noise whose size changes.
    pub fn at(&self, m: u64) -> f64 {
        let octave = m.max(1).ilog2() as usize;
        self.0.get(octave).or(self.0.last()).copied().unwrap_or(0.0)
    }

    /// That of a record of the same noise that is `times` as long.
    pub fn over(&self, times: f64) -> Overdispersion {
        Overdispersion(self.0.iter().map(|spread| spread / libm::sqrt(times)).collect())
    }

    /// The greatest one.
    pub fn most(&self) -> f64 {
        self.0.iter().copied().fold(0.0, f64::max)
    }
}

/// What the parts of a record show at one averaging factor.
struct Scatter {
    /// Relative standard deviation of the mean of all parts beyond that of Gaussian noise.
    spread: f64,
    is_sure: bool,
}

/// The scatter of the sums of parts, whose noise has `freedom` degrees of freedom per term; `None` where they are too few.
fn scatter_of(mut parts: Vec<Sum>, freedom: f64) -> Option<Scatter> {
    let most = parts.iter().map(|sum| sum.terms).max()?;
    parts.retain(|sum| 2 * sum.terms > most);
    let of_part = freedom * most as f64;
    if of_part < MIN_FREEDOM || parts.len() < MIN_PARTS {
        return None;
    }
    let count = parts.len() as f64;
    let means: Vec<f64> = parts.iter().map(|sum| sum.squares / sum.terms as f64).collect();
    let mean = means.iter().sum::<f64>() / count;
    let squares: f64 = means.iter().map(|x| (x / mean - 1.0) * (x / mean - 1.0)).sum();
    let gaussian = 2.0 / of_part;
    let excess = (squares / (count - 1.0) - gaussian).max(0.0);
    let is_sure = squares / gaussian > distributions::chi_squared_quantile(SURE, count - 1.0)?;
    Some(Scatter { spread: libm::sqrt(excess / count), is_sure })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::allan::Trend;

    fn spread(rates: &[f64]) -> Overdispersion {
        Overdispersion::new(&Angles::from_increments(rates, 1.0, 1.0, Trend::None))
    }

    fn white(count: usize) -> Vec<f64> {
        let numbers = std::iter::successors(Some(1_234_567_890_u64), |n| Some(16807 * n % 2_147_483_647));
        let uniform: Vec<f64> = numbers.map(|n| n as f64 / 2_147_483_647.0 - 0.5).take(12 * count).collect();
        uniform.chunks(12).map(|twelve| twelve.iter().sum()).collect()
    }

    #[test]
    fn gaussian_noise_has_none() {
        assert_eq!(spread(&white(100_000)).most(), 0.0);
        assert_eq!(spread(&white(20)), Overdispersion(vec![]));
    }

    /// Half of the parts have four times the variance: the parts scatter by 0.6 of their mean.
    #[test]
    fn noise_that_comes_and_goes_spreads_by_the_scatter_of_its_parts() {
        let mut rates = white(1 << 17);
        rates.chunks_mut(1 << 12).step_by(2).flatten().for_each(|x| *x *= 2.0);
        let (found, expected) = (spread(&rates), 0.6 / libm::sqrt(31.0));
        for m in [1, 8, 64, 1 << 16] {
            assert!((found.at(m) / expected - 1.0).abs() < 0.1, "{found:?}, not {expected}");
        }
    }

    /// One sample in a hundred is ten times as large: the excess kurtosis is 73.5, and a quadratic form of many such samples with
    /// equal weights has the relative variance of a Gaussian one and 73.5 divided by their number more, whatever the averaging time.
    #[test]
    fn long_tails_spread_all_averaging_times_alike() {
        let mut rates = white(1 << 17);
        let mut places = 1_u64;
        for x in &mut rates {
            places = 16807 * places % 2_147_483_647;
            *x *= if places.is_multiple_of(100) { 10.0 } else { 1.0 };
        }
        let (found, expected) = (spread(&rates), libm::sqrt(73.5 / f64::from(1 << 17)));
        for m in [1, 2, 4, 8, 16] {
            assert!((found.at(m) / expected - 1.0).abs() < 0.15, "{found:?}, not {expected}");
        }
    }
}
