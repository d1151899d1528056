//! Identification of the power law that the noise of a record follows at an averaging time.
//!
//! W. J. Riley and C. A. Greenhall, "Power law noise identification using the lag 1 autocorrelation", EFTF 2004. The
//! record is decimated to groups of τ and differenced until it is stationary. Its lag-1 autocorrelation r then gives δ
//! = r/(1 + r), and with d differences of the angle the exponent is α = 2 − 2(δ + d).

use std::ops::Range;

use crate::allan::{Angles, Deviation, Unit};

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
