//! Telegraph noise: a rate that jumps between two levels at random times.
//!
//! Its spectrum is that of Markov noise, so no deviation and no spectrum shows it; its two levels do. The record is averaged over
//! blocks, and the likelihood of two levels with random times between jumps (a hidden Markov model; Baum and Welch) is compared with
//! that of the best Gaussian noise of white noise and two Markov processes, the second as slow as the record.

use rayon::prelude::*;

/// Increase of twice the logarithm of the likelihood by two levels over Gaussian noise. The false alarms of records of the models of
/// docs/numerics.md were counted.
const PENALTY: f64 = 12.0;
/// Steps of the iteration, and probabilities of a jump from which it starts.
const STEPS: usize = 40;
const STARTS: [f64; 4] = [0.3, 0.1, 0.03, 0.01];
/// Fewest jumps; fewer are steps.
const LEAST_JUMPS: f64 = 4.0;
/// Variances of Markov noise relative to the white noise of a block, and correlation times in blocks.
const RATIOS: [f64; 6] = [0.0, 0.03, 0.12, 0.5, 2.0, 8.0];
const TIMES: [f64; 7] = [0.5, 1.5, 4.0, 12.0, 36.0, 110.0, 330.0];

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
    let known = values.iter().filter(|x| x.is_finite()).count() as f64;
    let mean = values.iter().filter(|x| x.is_finite()).sum::<f64>() / known;
    let square =
        values.iter().filter(|x| x.is_finite()).map(|x| (x - mean) * (x - mean)).sum::<f64>() / known;
    let deviation = libm::sqrt(square);
    if known < 32.0 || deviation.is_nan() || deviation <= 0.0 {
        return None;
    }
    let scaled: Vec<f64> = values.iter().map(|x| (x - mean) / deviation).collect();
    let found = STARTS.par_iter().map(|&jump| two_levels(&scaled, jump)).collect::<Vec<_>>();
    let (lack, size, jump) = found.into_iter().min_by(|a, b| a.0.total_cmp(&b.0))?;
    let gain = gaussian(&scaled) - lack - PENALTY;
    let is_telegraph = gain > 0.0 && jump * known >= LEAST_JUMPS;
    is_telegraph.then_some((gain, Telegraph { size: size * deviation, blocks: 1.0 / jump }))
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
                    libm::exp(-0.5 * away * away / variance) / libm::sqrt(variance)
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
        jump = (jumps / (count - 1) as f64).clamp(1e-6, 0.5);
    }
    // The constant that the densities leave out is the same in both likelihoods.
    (lack, libm::fabs(half), jump)
}

fn turned(state: [f64; 2], jump: f64) -> [f64; 2] {
    [state[0] * (1.0 - jump) + state[1] * jump, state[1] * (1.0 - jump) + state[0] * jump]
}

/// Minus twice the logarithm of the likelihood of the best Gaussian noise of the grid, by Kalman's filter.
fn gaussian(values: &[f64]) -> f64 {
    let slow = values.len() as f64;
    let grid: Vec<[f64; 3]> = TIMES
        .iter()
        .filter(|time| **time < slow)
        .flat_map(|&time| RATIOS.into_iter().flat_map(move |a| RATIOS.map(move |b| [time, a, b])))
        .collect();
    let all: Vec<f64> =
        grid.into_par_iter().map(|[time, a, b]| filtered(values, [time, slow], [a, b])).collect();
    all.into_iter().fold(f64::INFINITY, f64::min)
}

/// Returns minus twice the logarithm of the likelihood for white noise of variance 1 and two Markov processes of these times and
/// variances, with the scale of all profiled.
fn filtered(values: &[f64], times: [f64; 2], variances: [f64; 2]) -> f64 {
    let decay = times.map(|time| libm::exp(-1.0 / time));
    let added = [0, 1].map(|s| variances[s] * (1.0 - decay[s] * decay[s]));
    let (mut x, mut p) = ([0.0; 2], [variances[0], 0.0, variances[1]]);
    let (mut squares, mut logarithms, mut count) = (0.0, 0.0, 0.0);
    for value in values {
        if value.is_finite() {
            let total = p[0] + 2.0 * p[1] + p[2] + 1.0;
            let innovation = value - x[0] - x[1];
            squares += innovation * innovation / total;
            logarithms += libm::log(total);
            count += 1.0;
            let gain = [(p[0] + p[1]) / total, (p[1] + p[2]) / total];
            x = [x[0] + gain[0] * innovation, x[1] + gain[1] * innovation];
            p = [
                p[0] - gain[0] * gain[0] * total,
                p[1] - gain[0] * gain[1] * total,
                p[2] - gain[1] * gain[1] * total,
            ];
        }
        x = [decay[0] * x[0], decay[1] * x[1]];
        p = [
            decay[0] * decay[0] * p[0] + added[0],
            decay[0] * decay[1] * p[1],
            decay[1] * decay[1] * p[2] + added[1],
        ];
    }
    count * libm::log(squares / count) + logarithms + count
}
