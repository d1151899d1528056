//! The likelihood of Gaussian noise for the means of the blocks of a record, which may lack some.
//!
//! Each noise is white noise with Markov processes, one of them as slow as the record in place of a random walk. Flicker noise is
//! a row of Markov processes of one variance, each four times as slow as the one before. Kalman's filter gives the likelihood, and a
//! descent along the coordinates its maximum.

use rayon::prelude::*;

/// Number of processes of flicker noise, and the time of the fastest in blocks: the slowest outlasts 2048 blocks.
const FLICKER: usize = 8;
const FASTEST: f64 = 0.3;
/// First and last step of the descent, and the range of its coordinates, all binary logarithms.
const STEPS: [f64; 2] = [2.0, 0.2];
const MIN_LOG2: f64 = -12.0;
const MAX_LOG2: f64 = 20.0;
/// Correlation times from which the descent starts, in blocks.
const STARTS: [f64; 3] = [1.0, 10.0, 100.0];

/// Minus twice the logarithm of the likelihood with the best Markov noise and random walk, and the correlation time in blocks.
pub(crate) fn markov(values: &[f64]) -> (f64, f64) {
    let slow = values.len() as f64;
    let lack = |[time, a, b]: [f64; 3]| lack(values, [libm::exp2(time), slow], [a, b].map(libm::exp2));
    let from = |time: f64| descent([libm::log2(time), -2.0, -6.0], lack);
    let found: Vec<_> = STARTS.par_iter().map(|&time| from(time)).collect();
    let best = found.into_iter().min_by(|a, b| a.0.total_cmp(&b.0));
    best.map_or((f64::INFINITY, 0.0), |(lack, [time, ..])| (lack, libm::exp2(time)))
}

/// Minus twice the logarithm of the likelihood with white noise alone.
pub(crate) fn white(values: &[f64]) -> f64 {
    lack(values, [], [])
}

/// Minus twice the logarithm of the likelihood with the best flicker noise and random walk.
pub(crate) fn flicker(values: &[f64]) -> f64 {
    let mut times = [values.len() as f64; FLICKER + 1];
    (0..FLICKER).for_each(|k| times[k] = FASTEST * libm::exp2(2.0 * k as f64));
    let lack = |[a, b]: [f64; 2]| {
        let mut variances = [libm::exp2(a); FLICKER + 1];
        variances[FLICKER] = libm::exp2(b);
        lack(values, times, variances)
    };
    descent([-4.0, -6.0], lack).0
}

/// The least value that steps along the coordinates reach.
fn descent<const D: usize>(mut at: [f64; D], of: impl Fn([f64; D]) -> f64) -> (f64, [f64; D]) {
    let mut least = of(at);
    let mut step = STEPS[0];
    while step >= STEPS[1] {
        let before = least;
        for (d, way) in (0..D).flat_map(|d| [(d, step), (d, -step)]) {
            let mut next = at;
            next[d] = (at[d] + way).clamp(MIN_LOG2, MAX_LOG2);
            let value = of(next);
            if value < least {
                (least, at) = (value, next);
            }
        }
        step *= if least < before { 1.0 } else { 0.5 };
    }
    (least, at)
}

/// Minus twice the logarithm of the likelihood for white noise of variance 1 and Markov processes of these times and variances,
/// with the scale of all profiled.
fn lack<const S: usize>(values: &[f64], times: [f64; S], variances: [f64; S]) -> f64 {
    let decay = times.map(|time| libm::exp(-1.0 / time));
    let mut x = [0.0; S];
    let mut p = [[0.0; S]; S];
    (0..S).for_each(|i| p[i][i] = variances[i]);
    let (mut squares, mut logarithms, mut count) = (0.0, 0.0, 0.0);
    for value in values {
        if value.is_finite() {
            let towards: [f64; S] = p.map(|row| row.iter().sum());
            let total = towards.iter().sum::<f64>() + 1.0;
            let innovation = value - x.iter().sum::<f64>();
            squares += innovation * innovation / total;
            logarithms += libm::log(total);
            count += 1.0;
            for i in 0..S {
                x[i] += towards[i] / total * innovation;
                (0..S).for_each(|j| p[i][j] -= towards[i] * towards[j] / total);
            }
        }
        for i in 0..S {
            x[i] *= decay[i];
            (0..S).for_each(|j| p[i][j] *= decay[i] * decay[j]);
            p[i][i] += variances[i] * (1.0 - decay[i] * decay[i]);
        }
    }
    count * libm::log(squares / count) + logarithms + count
}
