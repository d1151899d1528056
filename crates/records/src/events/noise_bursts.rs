//! Noise bursts: stretches of a record in which its white noise is larger.
//!
//! The record is divided into up to 1024 blocks. The loudness of a block is the logarithm of the mean of (r₀ − r₁ − r₂ + r₃)² over
//! successive rates r, to which neither slow noise nor a line at half the sampling rate contributes. A stretch counts by twice the
//! logarithm of the likelihood that its loudness adds to that of a constant one. The scatter of the loudness is that of the record
//! itself, so that noise that is not Gaussian or has a short correlation is no noise burst.

use std::ops::Range;

use rayon::prelude::*;

use crate::allan::Angles;
use crate::events::{Event, What};

/// Most and fewest blocks, fewest samples of a block, and the number of samples from which the loudness of a block is estimated.
const MAX_BLOCKS: usize = 1024;
const MIN_BLOCKS: usize = 32;
const MIN_SAMPLES: usize = 16;
const EXAMINED: usize = 512;
/// Least share of the squares of a block that must be known.
const MIN_SHARE: f64 = 0.25;
/// Most that a square counts, relative to the median of the means of blocks, so that a spike makes no block loud.
const MAX_SQUARE: f64 = 6.0;
/// Squares of the unit of the readout that are added to each mean: rounding adds at most two, which depend on the slow rate.
const OF_ROUNDING: f64 = 5.0;
/// Most standard deviations that the loudness of a block is away from the median.
const FARTHEST: f64 = 3.0;
/// Most neighbouring blocks whose means show the scatter: it is larger there where neighbours are alike.
const MAX_JOINED: usize = 16;
/// Increase of twice the logarithm of the likelihood by a noise burst. The false alarms of records of the noises of docs/dev/numerics.md were
/// counted.
const PENALTY: f64 = 30.0;
/// Least ratio of the variances of a noise burst and of the rest.
const MIN_RATIO: f64 = 1.44;
/// Most noise bursts, neighbours of different size counted separately.
const MAX_BURSTS: usize = 8;

/// The samples of the noise bursts; none if they would be half of the record or more, or angles within it are unknown.
pub(crate) fn stretches(angles: &Angles) -> Vec<Range<usize>> {
    let samples = angles.len().saturating_sub(1);
    let m = samples.div_ceil(MAX_BLOCKS).max(MIN_SAMPLES);
    let loudness = if angles.has_unknown() { vec![] } else { loudness(angles, m) };
    let values: Vec<f64> = loudness.iter().map(|block| block.1).collect();
    let scatter = scatter(&values);
    if scatter <= 0.0 {
        return vec![];
    }
    let middle = median(values);
    let mut left = loudness;
    let mut is_loud = vec![false; samples.div_ceil(m)];
    for _ in 0..MAX_BURSTS {
        let limited = |block: &(usize, f64)| ((block.1 - middle) / scatter).clamp(-FARTHEST, FARTHEST);
        let Some(found) = loudest(&left.iter().map(limited).collect::<Vec<f64>>()) else { break };
        let mean =
            |blocks: &[(usize, f64)]| blocks.iter().map(|block| block.1).sum::<f64>() / blocks.len() as f64;
        let rest = [&left[..found.start], &left[found.end..]].concat();
        if mean(&left[found.clone()]) - mean(&rest) < libm::log(MIN_RATIO) {
            break;
        }
        // A burst begins and ends within a block.
        let [first, last] = [left[found.start].0, left[found.end - 1].0];
        let end = (last + 2).min(is_loud.len());
        is_loud[first.saturating_sub(1)..end].fill(true);
        left.retain(|block| !is_loud[block.0]);
    }
    if 2 * is_loud.iter().filter(|is| **is).count() >= is_loud.len() {
        return vec![];
    }
    let mut start = 0;
    let of = |blocks: &[bool]| {
        let range = start * m..((start + blocks.len()) * m).min(samples);
        start += blocks.len();
        blocks[0].then_some(range)
    };
    is_loud.chunk_by(|a, b| a == b).filter_map(of).collect()
}

/// The event of a noise burst, with the record without it.
pub(crate) fn event(angles: &Angles, samples: &Range<usize>, without: &Angles) -> Event {
    let added = angles.part(samples.start..samples.end + 1).scatter() - without.scatter();
    Event {
        size: Some(libm::sqrt(added.max(0.0)) / angles.step_s),
        samples: Some([samples.start, samples.end]),
        ..Event::new(What::NoiseBurst)
    }
}

/// The blocks of `m` samples of which enough is known, each with its loudness.
fn loudness(angles: &Angles, m: usize) -> Vec<(usize, f64)> {
    let squares = |block: usize| {
        let rates = angles.rates(block * m..block * m + m.min(EXAMINED));
        let squares = rates.windows(4).map(|r| (r[0] - r[1] - r[2] + r[3]) * (r[0] - r[1] - r[2] + r[3]));
        let squares: Vec<f64> = squares.filter(|square| square.is_finite()).collect();
        (squares.len() as f64 >= MIN_SHARE * rates.len() as f64).then_some((block, squares))
    };
    let count = (angles.len() - 1) / m;
    let blocks: Vec<(usize, Vec<f64>)> = (0..count).into_par_iter().filter_map(squares).collect();
    let mean = |squares: &[f64], most: f64| {
        squares.iter().map(|square| square.min(most)).sum::<f64>() / squares.len() as f64
    };
    let usual = median(blocks.iter().map(|(_, squares)| mean(squares, f64::INFINITY)).collect());
    let is_zero = |square: f64| square < 1e-12 * usual;
    let all = blocks.iter().flat_map(|(_, squares)| squares).copied();
    let unit = all.filter(|&square| !is_zero(square)).fold(f64::INFINITY, f64::min);
    let of = |squares: &[f64]| libm::log(mean(squares, MAX_SQUARE * usual) + OF_ROUNDING * unit);
    blocks.iter().map(|(block, squares)| (*block, of(squares))).collect()
}

/// The standard deviation of the loudness of a block, from the differences of the means of neighbouring blocks; 0 for few blocks.
fn scatter(values: &[f64]) -> f64 {
    let of = |joined: usize| {
        let means: Vec<f64> =
            values.chunks_exact(joined).map(|near| near.iter().sum::<f64>() / joined as f64).collect();
        let steps = means.windows(2).map(|near| libm::fabs(near[1] - near[0])).collect();
        // Of a normal distribution the median of absolute values is 0.6745 standard deviations.
        median(steps) / 0.6745 * libm::sqrt(0.5 * joined as f64)
    };
    let joined = std::iter::successors(Some(1), |joined| Some(2 * joined));
    let is_enough = |joined: &usize| *joined <= MAX_JOINED && values.len() / joined >= MIN_BLOCKS;
    joined.take_while(is_enough).map(of).fold(0.0, f64::max)
}

/// The stretch of values of unit variance whose larger mean adds most to their likelihood, if that is more than the penalty.
fn loudest(values: &[f64]) -> Option<Range<usize>> {
    let count = values.len() as f64;
    let mean = values.iter().sum::<f64>() / count;
    let mut sums = vec![0.0];
    sums.extend(values.iter().scan(0.0, |sum, value| {
        *sum += value - mean;
        Some(*sum)
    }));
    let (mut most, mut found) = (PENALTY, None);
    for start in 0..values.len() {
        for end in start + 1..sums.len() {
            let (sum, length) = (sums[end] - sums[start], (end - start) as f64);
            let gain = sum * sum * count / (length * (count - length));
            if sum > 0.0 && gain > most && length < count {
                (most, found) = (gain, Some(start..end));
            }
        }
    }
    found
}

/// The median of some values, NaN of none.
fn median(mut values: Vec<f64>) -> f64 {
    let middle = values.len() / 2;
    if values.is_empty() { f64::NAN } else { *values.select_nth_unstable_by(middle, f64::total_cmp).1 }
}
