//! Theo1 and ThêoH, which reach averaging times of three quarters of the record.
//!
//! Theo1 at an even factor m averages second differences of several distances over m samples, and has an effective averaging time τ of
//! 0.75 m. Definitions, biases and degrees of freedom: NIST SP 1065 (5.2.15 to 5.2.17 and tables 5 and 9). The
//! biases are those of TFTools too, and the degrees of freedom those of SigmaTau.jl.

use std::ops::Range;

use rayon::prelude::*;

use crate::allan::angles::Solid;
use crate::allan::sums::{Sum, in_lanes, sums};
use crate::allan::total::stride;
use crate::allan::{Angles, Deviation};

/// The shortest factor of Theo1.
pub(crate) const SHORTEST: usize = 10;

/// Most terms at one factor, which take about a second; if there are more, they start at every n-th sample only. Records of up to
/// 65,000 samples keep every term. Those from which the bias is measured are fewer.
const MAX_TERMS: u64 = 1 << 29;
const MAX_OF_BIAS: u64 = 1 << 25;

/// Most pairs of variances from which the bias of Theo1 is measured. SP 1065 takes one for each 30 samples of the record, which is as
/// many up to 1500 samples.
const MAX_PAIRS: usize = 48;

/// Relation of the expected Theo1 variance to the Allan variance at the factor `m`, for noise of the exponent `alpha`. It is within 1 %
/// for noise of the rate, and 7 % too high for white noise of the angle.
pub(crate) fn bias(alpha: i32, m: usize) -> f64 {
    let [a, b, c] = match alpha {
        2.. => [0.09, 0.74, 0.40],
        1 => [0.14, 0.82, 0.30],
        0 => [1.0, 0.0, 0.0],
        -1 => [1.87, -1.05, 0.79],
        _ => [2.70, -1.53, 0.85],
    };
    1.0 / (a + b * libm::pow(m as f64, -c))
}

/// Equivalent degrees of freedom of the Theo1 variance of `angles` angles at the averaging time of `tau` samples.
///
/// Compared with simulated records of 500 samples, they are within 3 % up to a tenth of the record (for the random walk of the rate
/// 11 %), and within 15 % beyond. Beyond a quarter of the record those of a random walk fall to less than one, which no sum of squares
/// has; one is taken then.
pub(crate) fn edf(alpha: i32, angles: usize, tau: f64) -> f64 {
    let (n, r) = (angles as f64, tau);
    let edf = match alpha {
        2.. => 0.86 * (n + 1.0) * (n - 4.0 / 3.0 * r) / (n - r) * (r / (r + 1.14)),
        1 => {
            (4.798 * n * n - 6.374 * n * r + 12.387 * r) / (libm::sqrt(r + 36.6) * (n - r)) * (r / (r + 0.3))
        }
        0 => {
            let power = libm::pow(r, 1.5);
            ((4.1 * n + 0.8) / r - (3.1 * n + 6.5) / n) * (power / (power + 5.2))
        }
        -1 => {
            let cube = r * r * r;
            (2.0 * n * n - 1.3 * n * r - 3.5 * r) / (n * r) * (cube / (cube + 2.3))
        }
        _ => {
            let n4 = 4.4 * n - 1.0;
            let square = (4.4 * n - 3.0) * (4.4 * n - 3.0);
            (4.4 * n - 2.0) / (2.9 * r) * (n4 * n4 - 8.6 * r * n4 + 11.4 * r * r) / square
        }
    };
    edf.max(1.0)
}

/// The sum of Theo1 at the even factor `m`. Work is of the order of the record times `m`, up to [`MAX_TERMS`].
pub(crate) fn theo1(solid: Solid, m: usize) -> Sum {
    thinned(solid, m, MAX_TERMS)
}

fn thinned(Solid { values, runs, .. }: Solid, m: usize, most: u64) -> Sum {
    let half = m / 2;
    let starts = |run: &Range<usize>| run.len().saturating_sub(m);
    let all: usize = runs.iter().map(starts).sum();
    let stride = stride(all, half, most);
    // Roots of the weights 1/(m/2 − δ), in the order of δ.
    let weights: Vec<f64> = (0..half).map(|k| 1.0 / libm::sqrt((half - k) as f64)).collect();
    let of_start = |start: usize| {
        let outer = values[start] + values[start + m];
        let (left, right) = (&values[start + 1..=start + half], &values[start + half..start + m]);
        in_lanes(half, |k| weights[k] * (outer - left[half - 1 - k] - right[k])).squares
    };
    let taken: Vec<usize> =
        runs.iter().flat_map(|run| (run.start..run.start + starts(run)).step_by(stride)).collect();
    let parts: Vec<f64> =
        taken.par_chunks(256).map(|some| some.iter().map(|&start| of_start(start)).sum()).collect();
    let terms = (taken.len() * half) as u64;
    // The sum over the differences of a start is an estimate of its own.
    let squares = half as f64 * parts.iter().sum::<f64>();
    Sum { terms, squares, added: 0.0 }
}

/// Relation of the Theo1 variance to the Allan variance over the averaging times that both have, from which ThêoH is freed.
pub(crate) fn measured_bias(angles: &Angles) -> f64 {
    let pairs = (angles.len() / 30).saturating_sub(2).max(1);
    let step = pairs.div_ceil(MAX_PAIRS);
    let mean_square = |deviation: Deviation, m: usize, sum: Sum| {
        sum.squares / deviation.divisor(sum.terms, deviation.tau(m))
    };
    let ratio = |i: usize| {
        let (m, theo) = (9 + 3 * i, 12 + 4 * i);
        let allan = mean_square(Deviation::Oadev, m, sums(angles, Deviation::Oadev, &[m])[0]);
        allan / mean_square(Deviation::Theo1, theo, thinned(angles.bridged(), theo, MAX_OF_BIAS))
    };
    let ratios: Vec<f64> =
        (0..pairs).step_by(step).map(ratio).filter(|ratio| ratio.is_finite() && *ratio > 0.0).collect();
    if ratios.is_empty() { 1.0 } else { ratios.len() as f64 / ratios.iter().sum::<f64>() }
}
