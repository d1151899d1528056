//! Telegraph noise: a rate that jumps between two levels at random times.
//!
//! Its spectrum is that of Markov noise, so no deviation and no spectrum shows it; its two levels do. The record is averaged over
//! blocks, and the likelihood of two levels with random times between jumps (a hidden Markov model; Baum and Welch) is compared with
//! that of the best [Gaussian noise](crate::events::gaussian).

use rayon::prelude::*;

use crate::events::gaussian;

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
    let (markov, _) = gaussian::markov(&scaled);
    // Telegraph noise has the spectrum of Markov noise.
    if gaussian::white(&scaled) - markov < MIN_OF_MARKOV {
        return None;
    }
    let (lack, size, jump) = likeliest_levels(&scaled)?;
    let over = |gaussian: f64| gaussian - lack - PENALTY;
    // Flicker noise takes longer.
    let gain = if over(markov) > 0.0 { over(markov.min(gaussian::flicker(&scaled))) } else { over(markov) };
    let is_telegraph = gain > 0.0 && jump * scaled.len() as f64 >= MIN_JUMPS;
    is_telegraph.then_some((gain, Telegraph { size: size * deviation, blocks: 1.0 / jump }))
}

/// The correlation time in blocks of noise whose means over blocks Markov noise or two levels explain better than flicker noise.
pub(crate) fn correlation(values: &[f64]) -> Option<f64> {
    let (scaled, _) = scaled(values)?;
    let flicker = gaussian::flicker(&scaled);
    let (markov, blocks) = gaussian::markov(&scaled);
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
