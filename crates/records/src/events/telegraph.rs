//! Telegraph noise: a rate that jumps between two levels at random times.
//!
//! Its spectrum is that of Markov noise, so no deviation and no spectrum shows it; its two levels do. The record is averaged over
//! blocks, and the likelihood of two levels with random times between jumps (a hidden Markov model; Baum and Welch) is compared with
//! that of the best Gaussian noise.
//!
//! # Gaussian noise
//!
//! The likelihood is that of the means of the blocks, of which some may be missing.
//! Each noise is white noise with Markov processes, one of them as slow as the record in place of a random walk. Flicker noise is
//! a row of Markov processes of one variance, each four times as slow as the one before. Kalman's filter gives the likelihood, and a
//! descent along the coordinates its maximum.

use rayon::prelude::*;

/// Increase of twice the logarithm of the likelihood by two levels over Gaussian noise. The false alarms of records of the models of
/// docs/dev/numerics.md were counted.
const PENALTY: f64 = 12.0;
/// Least increase by Markov noise over white noise, without which there are no levels.
const MIN_OF_MARKOV: f64 = 6.0;
/// Increase of twice the logarithm of the likelihood by noise with a correlation time over flicker noise, and the part of the increase by
/// two levels that counts. Of 250 records of an hour with N = 0.3 °/√h, 3 % of those with B = 3 °/h are above it, and 94 % of those with
/// telegraph noise of ±5 °/h and 20 s.
const PENALTY_OF_CORRELATION: f64 = 9.0;
const PART_OF_LEVELS: f64 = 0.3;
/// Least density of a block, far from both levels.
const MIN_DENSITY: f64 = 1e-300;
/// Fewest blocks.
const MIN_BLOCKS: f64 = 32.0;
/// Steps of the iteration, and probabilities of a jump from which it starts.
const STEPS: usize = 40;
const STARTS: [f64; 4] = [0.3, 0.1, 0.03, 0.01];
/// Largest probability of a jump from block to block: without memory, levels describe the distribution of noise that is not Gaussian.
const MAX_JUMPS: f64 = 0.25;
/// Fewest jumps; fewer are steps.
const MIN_JUMPS: f64 = 4.0;

/// Two levels.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Telegraph {
    /// Half the distance of the levels.
    pub size: f64,
    /// Mean number of blocks between jumps.
    pub blocks: f64,
}

/// The levels of the means of blocks, NaN where one is missing, if they explain them better than Gaussian noise, and by how much.
pub(crate) fn levels(values: &[f64]) -> Option<(f64, Telegraph)> {
    let (scaled, deviation) = scaled(values)?;
    let (markov, _) = markov(&scaled);
    // Telegraph noise has the spectrum of Markov noise.
    if white(&scaled) - markov < MIN_OF_MARKOV {
        return None;
    }
    let (lack, size, jump) = likeliest_levels(&scaled)?;
    let over = |gaussian: f64| gaussian - lack - PENALTY;
    // Flicker noise takes longer.
    let gain = if over(markov) > 0.0 { over(markov.min(flicker(&scaled))) } else { over(markov) };
    let is_telegraph = gain > 0.0 && jump * scaled.len() as f64 >= MIN_JUMPS;
    is_telegraph.then_some((gain, Telegraph { size: size * deviation, blocks: 1.0 / jump }))
}

/// The correlation time in blocks of noise whose means over blocks Markov noise or two levels explain better than flicker noise.
pub(crate) fn correlation(values: &[f64]) -> Option<f64> {
    let (scaled, _) = scaled(values)?;
    let flicker = flicker(&scaled);
    let (markov, blocks) = markov(&scaled);
    let (levels, ..) = likeliest_levels(&scaled)?;
    let gain = flicker - markov + PART_OF_LEVELS * (markov - levels);
    (gain > PENALTY_OF_CORRELATION).then_some(blocks)
}

/// Means of blocks about their mean in standard deviations, and the standard deviation; `None` for few blocks.
fn scaled(values: &[f64]) -> Option<(Vec<f64>, f64)> {
    let known = || values.iter().filter(|x| x.is_finite());
    let count = known().count() as f64;
    let mean = known().sum::<f64>() / count;
    let deviation = libm::sqrt(known().map(|x| (x - mean) * (x - mean)).sum::<f64>() / count);
    let is_enough = count >= MIN_BLOCKS && deviation > 0.0 && deviation.is_finite();
    is_enough.then(|| (values.iter().map(|x| (x - mean) / deviation).collect(), deviation))
}

/// The likeliest of the levels that the iteration reaches from its starts.
fn likeliest_levels(scaled: &[f64]) -> Option<(f64, f64, f64)> {
    let found = STARTS.par_iter().map(|&jump| two_levels(scaled, jump)).collect::<Vec<_>>();
    found.into_iter().min_by(|a, b| a.0.total_cmp(&b.0))
}

/// Minus twice the logarithm of the likelihood of two levels, half their distance and the probability of a jump, from a start.
fn two_levels(values: &[f64], start: f64) -> (f64, f64, f64) {
    let count = values.len();
    let (mut jump, mut middle, mut half, mut variance) = (start, 0.0, 0.8, 0.4);
    let mut lack = f64::INFINITY;
    let mut ahead = vec![[0.0; 2]; count];
    let mut density = vec![[1.0; 2]; count];
    for _ in 0..STEPS {
        let mut logarithm = 0.0;
        let mut state = [0.5; 2];
        for (i, x) in values.iter().enumerate() {
            let before = if i == 0 { state } else { turned(state, jump) };
            if x.is_finite() {
                let of = |level: f64| {
                    let away = x - level;
                    (libm::exp(-0.5 * away * away / variance) / libm::sqrt(variance)).max(MIN_DENSITY)
                };
                density[i] = [of(middle - half), of(middle + half)];
            }
            let joint = [before[0] * density[i][0], before[1] * density[i][1]];
            let sum = (joint[0] + joint[1]).max(f64::MIN_POSITIVE);
            logarithm += libm::log(sum);
            state = [joint[0] / sum, joint[1] / sum];
            ahead[i] = state;
        }
        lack = -2.0 * logarithm;
        // Backwards: the probabilities of the levels and of jumps given the whole record.
        let mut behind = [1.0; 2];
        let (mut jumps, mut weights, mut sums, mut squares) = (0.0, [0.0; 2], [0.0; 2], 0.0);
        for i in (0..count).rev() {
            let joint = [ahead[i][0] * behind[0], ahead[i][1] * behind[1]];
            let sum = (joint[0] + joint[1]).max(f64::MIN_POSITIVE);
            let level = [joint[0] / sum, joint[1] / sum];
            if values[i].is_finite() {
                for (s, level) in level.iter().enumerate() {
                    weights[s] += level;
                    sums[s] += level * values[i];
                }
                squares += values[i] * values[i];
            }
            if i > 0 {
                let next = [density[i][0] * behind[0], density[i][1] * behind[1]];
                let stay = ahead[i - 1][0] * next[0] + ahead[i - 1][1] * next[1];
                let leave = ahead[i - 1][0] * next[1] + ahead[i - 1][1] * next[0];
                jumps += jump * leave / (jump * leave + (1.0 - jump) * stay).max(f64::MIN_POSITIVE);
                behind = turned(next, jump);
                let most = behind[0].max(behind[1]).max(f64::MIN_POSITIVE);
                behind = [behind[0] / most, behind[1] / most];
            }
        }
        let means = [0, 1].map(|s| sums[s] / weights[s].max(1e-9));
        let total = weights[0] + weights[1];
        variance = ((squares - weights[0] * means[0] * means[0] - weights[1] * means[1] * means[1]) / total)
            .max(1e-6);
        (middle, half) = (0.5 * (means[0] + means[1]), 0.5 * (means[1] - means[0]));
        jump = (jumps / (count - 1) as f64).clamp(1e-6, MAX_JUMPS);
    }
    // The constant that the densities leave out is the same in both likelihoods.
    (lack, libm::fabs(half), jump)
}

fn turned(state: [f64; 2], jump: f64) -> [f64; 2] {
    [state[0] * (1.0 - jump) + state[1] * jump, state[1] * (1.0 - jump) + state[0] * jump]
}

/// Number of processes of flicker noise, and the time of the fastest in blocks: the slowest outlasts 2048 blocks.
const FLICKER: usize = 8;
const FASTEST: f64 = 0.3;
/// First and last step of the descent, and the range of its coordinates, all binary logarithms.
const DESCENT_STEPS: [f64; 2] = [2.0, 0.2];
const MIN_LOG2: f64 = -12.0;
const MAX_LOG2: f64 = 20.0;
/// Correlation times from which the descent starts, in blocks.
const DESCENT_STARTS: [f64; 3] = [1.0, 10.0, 100.0];

/// Minus twice the logarithm of the likelihood with the best Markov noise and random walk, and the correlation time in blocks.
fn markov(values: &[f64]) -> (f64, f64) {
    let slow = values.len() as f64;
    let lack = |[time, a, b]: [f64; 3]| lack(values, [libm::exp2(time), slow], [a, b].map(libm::exp2));
    let from = |time: f64| descent([libm::log2(time), -2.0, -6.0], lack);
    let found: Vec<_> = DESCENT_STARTS.par_iter().map(|&time| from(time)).collect();
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
    let mut step = DESCENT_STEPS[0];
    while step >= DESCENT_STEPS[1] {
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
