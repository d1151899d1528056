//! Tallies: identities, blocks of trials, shares of a run, and the statistics of their sums.
//!
//! Two blocks nest or are disjoint, so a set of rows folds to one answer in any order, however it was written.
//!
//! ```
//! use sagnac_engine::tally::Share;
//!
//! let shares = [1, 2, 3].map(|number| Share::new(number, 3).unwrap().trials(1_000_000, 0));
//! assert!(shares[0].end == shares[1].start && shares[1].end == shares[2].start && shares[2].end == 1_000_000);
//! assert_eq!("2/3".parse::<Share>()?, Share::new(2, 3).unwrap());
//! # Ok::<(), sagnac_engine::tally::ShareError>(())
//! ```

use core::fmt;
use core::ops::Range;
use core::str::FromStr;
use std::cell::Cell;

use sha2::{Digest, Sha256};

use sagnac_kernel::moments::{BIN_BITS, BINS, Moments, level_edge};

/// The first 128 bits of a SHA-256.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct Id(pub [u8; 16]);

impl Id {
    /// The identity of a text.
    pub fn from_text(text: &str) -> Id {
        Id::of_bytes(text.as_bytes())
    }

    /// The identity of a sequence of words.
    pub fn of_words(words: impl IntoIterator<Item = u32>) -> Id {
        let words = words.into_iter();
        let mut bytes = Vec::with_capacity(4 * words.size_hint().0);
        words.for_each(|word| bytes.extend_from_slice(&word.to_le_bytes()));
        Id::of_bytes(&bytes)
    }

    fn of_bytes(bytes: &[u8]) -> Id {
        let mut id = [0; 16];
        id.copy_from_slice(&Sha256::digest(bytes)[..16]);
        Id(id)
    }

    /// The first 64 bits as a key for random words.
    pub fn key(&self) -> [u32; 2] {
        let [a, b, c, d, e, f, g, h, ..] = self.0;
        [u32::from_le_bytes([a, b, c, d]), u32::from_le_bytes([e, f, g, h])]
    }
}

impl fmt::Display for Id {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.0.iter().try_for_each(|byte| write!(f, "{byte:02x}"))
    }
}

/// The trials `first .. first + 2^log2`; `first` is a multiple of 2^log2.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct Block {
    /// Number of the first trial.
    pub first: u64,
    /// log2 of the number of trials.
    pub log2: u32,
}

impl Block {
    /// Number of trials.
    pub fn trials(&self) -> u64 {
        1 << self.log2
    }

    /// Number of the first trial after the block.
    pub fn end(&self) -> u64 {
        self.first + self.trials()
    }

    /// Whether the block is valid: aligned, with trial numbers that fit.
    pub fn is_aligned(&self) -> bool {
        self.log2 < 63 && self.first.is_multiple_of(1 << self.log2) && self.first < 1 << 63
    }
}

/// log2 of the largest block; losing a larger one would cost minutes.
const MAX_LOG2: u32 = 26;

/// log2 of the smallest base block; storing and reading a smaller one costs more than sampling it.
const MIN_LOG2: u32 = 10;

/// log2 of a study's base block. From 2^15 trials on, a point has 32 to 63 blocks.
pub(crate) fn base_log2(trials: u64) -> u32 {
    (trials / 32).max(1).ilog2().clamp(MIN_LOG2, MAX_LOG2)
}

/// log2 of the steps, some milliseconds, below which storing and reading a row costs more than resampling it.
const QUICK: u32 = 18;

/// log2 of the largest rows of a study with this many trials of this many steps each: its base block, or what is
/// sampled in no time. Thousands of points then have few rows.
pub(crate) fn row_log2(trials: u64, steps: u64) -> u32 {
    base_log2(trials).max(QUICK.saturating_sub(steps.max(1).ilog2()))
}

/// The fewest blocks of at most 2^`largest` trials that make up `range`, in order.
pub fn cover(range: Range<u64>, largest: u32) -> Vec<Block> {
    let mut blocks = Vec::new();
    let mut first = range.start;
    while first < range.end {
        let log2 = (range.end - first).ilog2().min(first.trailing_zeros()).min(largest);
        blocks.push(Block { first, log2 });
        first += 1 << log2;
    }
    blocks
}

/// The blocks that lie in no other one, in order: a complete larger block replaces its parts.
pub fn fold<T>(mut rows: Vec<(Block, T)>) -> Vec<(Block, T)> {
    rows.sort_by_key(|(block, _)| (block.first, core::cmp::Reverse(block.log2)));
    let mut end = 0;
    rows.retain(|(block, _)| {
        let outer = block.first >= end;
        end = end.max(block.end());
        outer
    });
    rows
}

/// The parts of `trials` that no held block covers, in order.
pub fn missing(held: &[Block], trials: Range<u64>) -> Vec<Range<u64>> {
    let mut gaps = Vec::new();
    let mut end = trials.start;
    for (block, ()) in fold(held.iter().map(|&block| (block, ())).collect()) {
        gaps.push(end..block.first.min(trials.end));
        end = end.max(block.end());
    }
    gaps.push(end..trials.end);
    gaps.retain(|gap| gap.start < gap.end);
    gaps
}

/// One of several equal parts of the trials of every point.
///
/// The trials of a share follow from the study alone, so the shares of a study are disjoint, make up the whole, and can
/// be sampled anywhere, in any order and repeatedly.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Share {
    index: u64,
    of: u64,
}

/// log2 of the parts to which a share's ends are rounded; a sixteenth more or less work costs less than rows of odd
/// lengths.
const GRAIN: u32 = 4;

impl Share {
    /// The whole study.
    pub const WHOLE: Share = Share { index: 0, of: 1 };

    /// The most shares of a study.
    pub const MAX: u64 = 1 << 16;

    /// Share `number` of `of`, counted from 1; `None` where the numbers are out of range.
    pub fn new(number: u64, of: u64) -> Option<Share> {
        ((1..=of).contains(&number) && of <= Share::MAX).then(|| Share { index: number - 1, of })
    }

    /// Number of this share, counted from 1.
    pub fn number(&self) -> u64 {
        self.index + 1
    }

    /// Number of shares.
    pub fn of(&self) -> u64 {
        self.of
    }

    /// Whether the share is the whole study.
    pub fn is_whole(&self) -> bool {
        self.of == 1
    }

    /// Its part of the first `trials` trials of a point, the `turn`th of the study. Points take turns, so that with few
    /// trials of many points all shares get equally many.
    pub fn trials(&self, trials: u64, turn: usize) -> Range<u64> {
        let index = (self.index + turn as u64) % self.of;
        let grain = (trials / self.of).max(1).ilog2().saturating_sub(GRAIN);
        let start = |index: u64| match index {
            index if index == self.of => trials,
            index => {
                ((u128::from(trials) * u128::from(index) / u128::from(self.of)) as u64) >> grain << grain
            }
        };
        start(index)..start(index + 1)
    }
}

impl fmt::Display for Share {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "share {} of {}", self.number(), self.of)
    }
}

/// The error for a text that names no share.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("expected I/N, share I of N, from 1/N to N/N with N up to {}", Share::MAX)]
pub struct ShareError;

impl FromStr for Share {
    type Err = ShareError;

    fn from_str(text: &str) -> Result<Share, ShareError> {
        let (number, of) = text.split_once('/').ok_or(ShareError)?;
        let number = number.parse().map_err(|_| ShareError)?;
        Share::new(number, of.parse().map_err(|_| ShareError)?).ok_or(ShareError)
    }
}

/// The probability whose quantile is reported: 99.73 %, three standard deviations of a normal distribution.
pub(crate) const LEVEL: f64 = 0.9973;

/// Half the width of a 95 % interval in standard errors.
pub const NORMAL_95: f64 = 1.959_963_985;

/// Estimates of an error in the unit of the tally's scale. A value is absent where the trials do not determine it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Estimates {
    /// Mean error, signed.
    pub mean: f64,
    /// Root mean square, the mean included.
    pub rms: f64,
    /// Standard error of `rms`, √(Var(E²)/n) / (2 rms); 0 where every trial has the same error, absent for one trial
    /// and where the histogram does not determine it.
    pub rms_se: Option<f64>,
    /// Largest |error| seen.
    pub max: f64,
    /// The level below which 99.73 % of |error| stay.
    pub p99_73: Option<Quantile>,
}

/// A quantile of |error| and its 95 % interval from order statistics, widened to the edges of bins.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Quantile {
    /// The quantile, in the unit of the scale.
    pub value: f64,
    /// Lower end of the interval; absent where the trials are too few to bound it.
    pub low: Option<f64>,
    /// Upper end of the interval; absent where the trials are too few to bound it.
    pub high: Option<f64>,
}

impl Estimates {
    /// The estimates of a tally whose histogram starts at level `bin_base`, with `scale` as the size of one unit of the
    /// tally.
    ///
    /// `None` without trials.
    pub fn new(tally: &Moments, bin_base: u32, scale: f64) -> Option<Estimates> {
        if tally.count == 0 {
            return None;
        }
        let n = tally.count as f64;
        let second = tally.square as f64 / n;
        let rms = libm::sqrt(second);
        let max = f64::from(tally.least.unsigned_abs().max(tally.greatest.unsigned_abs()));
        let edges = Edges { base: bin_base, max };
        let filled = filled(tally);
        let rms_se = variance_of_square(tally, &filled, edges).filter(|_| tally.count > 1).map(|variance| {
            // Where every error is 0, so is the variance.
            if variance == 0.0 { 0.0 } else { libm::sqrt(variance / n) / (2.0 * rms) }
        });
        Some(Estimates {
            mean: tally.sum as f64 / n * scale,
            rms: rms * scale,
            rms_se: rms_se.map(|se| se * scale),
            max: max * scale,
            p99_73: quantile(tally.count, &filled, edges).map(|q| Quantile {
                value: q.value * scale,
                low: q.low.map(|x| x * scale),
                high: q.high.map(|x| x * scale),
            }),
        })
    }
}

/// The edges of the bins of a tally.
#[derive(Clone, Copy)]
struct Edges {
    base: u32,
    max: f64,
}

impl Edges {
    /// Lower and upper edge of a bin; the last one ends at the largest |error|.
    fn of(self, bin: usize) -> (f64, f64) {
        let edge = |bin: usize| level_edge(self.base + bin as u32 - 1) as f64;
        // An error of 0 is counted at the lowest level, as if it were 1.
        let low = if bin == 0 || self.base + bin as u32 == 1 { 0.0 } else { edge(bin) };
        let high = if bin == BINS - 1 { self.max } else { edge(bin + 1) };
        (low.min(self.max), high.min(self.max))
    }
}

/// Mean and variance of the error. The sums are taken as integers about the integer nearest to the mean, so that a
/// small variance beside a large mean does not cancel, and that of a constant is exactly 0.
fn mean_and_variance(tally: &Moments) -> (f64, f64) {
    let n = i128::from(tally.count);
    let near = (2 * tally.sum + n).div_euclid(2 * n);
    // With errors below 2^29 every term is below 2^124.
    let square = tally.square as i128 - 2 * near * tally.sum + n * near * near;
    let rest = (tally.sum - n * near) as f64 / n as f64;
    (near as f64 + rest, square as f64 / n as f64 - rest * rest)
}

/// Var(E²). The sums give it for a narrow distribution; otherwise the histogram contributes.
///
/// With E = m + d and σ² the variance of d, it is 4m²σ² + 4m⟨d³⟩ + ⟨d⁴⟩ − σ⁴; m and σ² are exact.
///
/// - If σ is below a bin's width at m, |m|/128, ⟨d³⟩ and ⟨d⁴⟩ are taken as those of a normal distribution, 0 and 3σ⁴. A
///   skewness γ would change the result by γσ/|m|, less than 0.8 % of γ.
/// - Otherwise, if all errors have one sign, ⟨d³⟩ and ⟨d⁴⟩ are those of the histogram.
/// - Otherwise it is the mean of (E² − ⟨E²⟩)² over the histogram. A distribution that reaches across 0 is wide, and its
///   bins, 1/128 of |E| wide, change the result by less than 0.1 %.
///
/// `None` without a histogram where one is needed, where its bins give no variance although there is some, and where
/// too much of the variance may come from errors beyond them.
fn variance_of_square(tally: &Moments, filled: &[Filled], edges: Edges) -> Option<f64> {
    let (mean, variance) = mean_and_variance(tally);
    let mean = mean.abs();
    if variance == 0.0 {
        return Some(0.0);
    }
    let narrow = mean / f64::from(1 << BIN_BITS);
    let first_order = 4.0 * mean * mean * variance;
    if variance < narrow * narrow {
        return Some(first_order + 2.0 * variance * variance);
    }
    let result = if tally.least < 0 && tally.greatest > 0 {
        let second = tally.square as f64 / tally.count as f64;
        histogram_mean(tally.count, filled, edges, |x, v, k| {
            let t = x * x - second;
            t * t + (4.0 * x * x + 2.0 * t) * v + k
        })
    } else {
        let third = histogram_mean(tally.count, filled, edges, |x, v, _| {
            let d = x - mean;
            d * d * d + 3.0 * d * v
        });
        let fourth = histogram_mean(tally.count, filled, edges, |x, v, k| {
            let d = x - mean;
            d * d * d * d + 6.0 * d * d * v + k
        });
        first_order + 4.0 * mean * third + fourth - variance * variance
    };
    // The contribution of the open bin to the fourth moment, if all its errors are as large as the largest.
    let open = tally.bins.last().filter(|_| is_open(BINS - 1, edges)).map_or(0.0, |&count| {
        let (low, high) = edges.of(BINS - 1);
        count as f64 / tally.count as f64 * (libm::pow(high, 4.0) - libm::pow(low, 4.0))
    });
    (result > 0.0 && !tally.bins.is_empty() && open <= OPEN_PART * result).then_some(result)
}

/// Largest part of the variance of E² that errors beyond the histogram may contribute; its root is then known to 10 %.
const OPEN_PART: f64 = 0.2;

/// Mean of a function over the histogram, each bin taken as evenly filled with integers. `of` receives the mean of a
/// bin and its second and fourth central moments.
fn histogram_mean(n: u64, filled: &[Filled], edges: Edges, of: impl Fn(f64, f64, f64) -> f64) -> f64 {
    let sum: f64 = filled
        .iter()
        .map(|&(bin, count)| {
            let (low, high) = edges.of(bin);
            // The upper edge belongs to the next bin, except for the largest |error| of all.
            let last = if high < edges.max { high - 1.0 } else { edges.max };
            let square = (last - low + 1.0) * (last - low + 1.0);
            let (second, fourth) = ((square - 1.0) / 12.0, (square - 1.0) * (3.0 * square - 7.0) / 240.0);
            count as f64 * of(0.5 * (low + last), second, fourth)
        })
        .sum();
    sum / n as f64
}

/// A bin that is not empty, and its count.
type Filled = (usize, u64);

/// The bins that are not empty, listed once because many are: the histogram is read several times.
fn filled(tally: &Moments) -> Vec<Filled> {
    let mut filled = vec![(0, 0); tally.bins.len()];
    let mut length = 0;
    // Each bin is written and an empty one is overwritten: which are empty is random where trials are few, and a branch
    // that cannot be predicted takes longer.
    for (bin, &count) in tally.bins.iter().enumerate() {
        filled[length] = (bin, count);
        length += usize::from(count > 0);
    }
    filled.truncate(length);
    filled
}

/// The quantile at [`LEVEL`]; `None` without a histogram.
fn quantile(n: u64, filled: &[Filled], edges: Edges) -> Option<Quantile> {
    // Of n trials about n (1 − level) lie above the quantile; in 95 % of all cases their number is between these two.
    let (fewest, most) = central_interval(n, 1.0 - LEVEL);
    let ranks = [LEVEL * n as f64, n.saturating_sub(most) as f64, (n - fewest + 1) as f64];
    let [value, low, high] = bins_of_ranks(filled, ranks);
    let (bin, within) = value.filter(|&(bin, _)| !is_open(bin, edges))?;
    let (a, b) = edges.of(bin);
    Some(Quantile {
        value: a + (b - a) * within,
        low: low.filter(|_| most < n).map(|(bin, _)| edges.of(bin).0),
        high: high.filter(|_| fewest > 0).map(|(bin, _)| edges.of(bin).1),
    })
}

/// Whether the bin is the open last one and reaches so far that the values in it are unknown.
fn is_open(bin: usize, edges: Edges) -> bool {
    let (low, high) = edges.of(bin);
    bin == BINS - 1 && high > low * (1.0 + 1.0 / f64::from(1 << BIN_BITS))
}

/// For each rank the bin that holds the `rank`-th smallest |error|, and the relative position of that error in the bin.
fn bins_of_ranks<const N: usize>(filled: &[Filled], ranks: [f64; N]) -> [Option<(usize, f64)>; N] {
    let mut found = [None; N];
    let mut below = 0.0;
    for &(bin, count) in filled {
        let count = count as f64;
        for (found, rank) in found.iter_mut().zip(ranks) {
            if found.is_none() && below + count >= rank {
                *found = Some((bin, ((rank - below) / count).clamp(0.0, 1.0)));
            }
        }
        below += count;
    }
    found
}

/// Deviation of an estimate from its closed form in standard errors; `proven` bounds the additional error of rounding.
/// `None` where that bound is too wide for the comparison to say anything.
///
/// ```
/// use sagnac_engine::tally::z_score;
///
/// assert_eq!(z_score(1.02, 1.0, 0.01, 0.0), Some(2.0000000000000018));
/// assert_eq!(z_score(1.02, 1.0, 0.0, 0.0), None);
/// ```
pub fn z_score(value: f64, theory: f64, se: f64, proven: f64) -> Option<f64> {
    let sigma = libm::hypot(se, proven);
    (sigma > 0.0 && (proven <= se || proven <= 0.05 * theory)).then(|| (value - theory) / sigma)
}

/// The least and the greatest number of successes in 95 % of all cases, of `n` trials with success probability `p`; at
/// most 2.5 % of the cases lie outside on either side.
///
/// The last result is cached, because it takes as long as thousands of trials, and most rows of a table have as many
/// trials as the one before.
pub(crate) fn central_interval(n: u64, p: f64) -> (u64, u64) {
    thread_local! {
        static LAST: Cell<((u64, f64), (u64, u64))> = const { Cell::new(((0, 0.0), (0, 0))) };
    }
    let (known, interval) = LAST.get();
    if known == (n, p) {
        return interval;
    }
    let interval = computed(n, p);
    LAST.set(((n, p), interval));
    interval
}

/// The 95 % interval of a probability after `successes` in `n` trials (Wilson).
pub(crate) fn proportion_interval(successes: u64, n: u64) -> (f64, f64) {
    let (part, n) = (successes as f64 / n as f64, n as f64);
    let square = NORMAL_95 * NORMAL_95 / n;
    let middle = part + 0.5 * square;
    let half = libm::sqrt(square * (part * (1.0 - part) + 0.25 * square));
    (((middle - half) / (1.0 + square)).max(0.0), ((middle + half) / (1.0 + square)).min(1.0))
}

fn computed(n: u64, p: f64) -> (u64, u64) {
    let mean = n as f64 * p;
    let sd = libm::sqrt(mean * (1.0 - p));
    if mean > 10_000.0 {
        let half = 1.959_963_985 * sd + 0.5;
        return (libm::floor(mean - half) as u64, (libm::ceil(mean + half) as u64).min(n));
    }
    let log_factorial = |k: u64| libm::lgamma(k as f64 + 1.0);
    let probability = |k: u64| {
        let choose = log_factorial(n) - log_factorial(k) - log_factorial(n - k);
        libm::exp(choose + k as f64 * libm::log(p) + (n - k) as f64 * libm::log1p(-p))
    };
    let (mut below, mut fewest) = (0.0, None);
    for k in 0..=n {
        below += probability(k);
        if fewest.is_none() && below > 0.025 {
            fewest = Some(k);
        }
        if below >= 0.975 {
            return (fewest.unwrap_or(0), k);
        }
    }
    (fewest.unwrap_or(0), n)
}

#[cfg(test)]
mod tests {
    use super::*;
    use sagnac_kernel::moments::{bin, level};
    use sagnac_kernel::word::Scalar;

    #[test]
    fn a_cover_is_the_range_itself_in_aligned_blocks() {
        for (range, largest) in
            [(0..1_000_000, 14), (5..6, 3), (1_000_000..10_000_000, 18), (7..7, 4), (3..1000, 26)]
        {
            let blocks = cover(range.clone(), largest);
            let mut at = range.start;
            for block in &blocks {
                assert_eq!(block.first, at);
                assert_eq!(block.first % block.trials(), 0, "{block:?} is not aligned");
                assert!(block.log2 <= largest);
                at = block.end();
            }
            assert_eq!(at, range.end.max(range.start));
        }
        assert_eq!(cover(0..1 << 20, 14).len(), 64);
    }

    #[test]
    fn what_is_sampled_in_no_time_has_few_rows() {
        assert_eq!(cover(0..100_000, row_log2(100_000, 1)).len(), 6);
        assert_eq!(row_log2(100_000, 1 << 10), base_log2(100_000));
        assert_eq!(row_log2(1 << 40, 1), base_log2(1 << 40));
        assert_eq!(row_log2(1, 0), QUICK);
    }

    #[test]
    fn folding_keeps_the_outermost_blocks_in_any_order() {
        let block = |first, log2| (Block { first, log2 }, ());
        let rows = vec![block(4, 1), block(0, 2), block(2, 1), block(8, 0), block(0, 0), block(4, 1)];
        let kept: Vec<Block> = fold(rows).into_iter().map(|row| row.0).collect();
        assert_eq!(kept, [block(0, 2).0, block(4, 1).0, block(8, 0).0]);
    }

    #[test]
    fn what_is_missing_and_what_is_held_make_up_the_whole() {
        let held = [Block { first: 4, log2: 2 }, Block { first: 4, log2: 1 }, Block { first: 16, log2: 0 }];
        assert_eq!(missing(&held, 0..20), [0..4, 8..16, 17..20]);
        assert_eq!(missing(&held, 0..6), [Range { start: 0, end: 4 }]);
        assert_eq!(missing(&held, 2..12), [2..4, 8..12]);
        assert_eq!(missing(&held, 5..8), []);
        assert_eq!(missing(&held, 20..30), [Range { start: 20, end: 30 }]);
        assert_eq!(missing(&[], 0..3), [Range { start: 0, end: 3 }]);
        assert_eq!(missing(&cover(0..1000, 5), 0..1000), []);
        assert_eq!(missing(&cover(0..2000, 5), 0..1000), []);
    }

    #[test]
    fn a_study_of_many_trials_has_32_to_63_base_blocks_and_none_has_small_ones() {
        for trials in [1 << 15, 100_000, 1_000_000, 1_000_000_000] {
            let blocks = trials >> base_log2(trials);
            assert!((32..64).contains(&blocks), "{trials} trials: {blocks}");
        }
        assert_eq!([1, 1000, (1 << 15) - 1].map(base_log2), [MIN_LOG2; 3]);
        assert_eq!(base_log2(1 << 40), MAX_LOG2);
    }

    fn all(of: u64) -> impl Iterator<Item = Share> {
        (1..=of).filter_map(move |number| Share::new(number, of))
    }

    #[test]
    fn shares_are_disjoint_and_make_up_the_whole() {
        for of in [1, 2, 7, 64, 1000] {
            for trials in [1, 5, 63, 64, 1000, 1_000_000, (1 << 40) - 1] {
                for turn in [0, 1, 100] {
                    let mut parts: Vec<_> = all(of).map(|share| share.trials(trials, turn)).collect();
                    parts.sort_by_key(|part| (part.start, part.end));
                    let mut at = 0;
                    for part in parts {
                        assert_eq!(part.start, at, "{trials} trials in {of} shares");
                        at = part.end;
                    }
                    assert_eq!(at, trials);
                }
            }
        }
        assert_eq!(Share::WHOLE.trials(1000, 3), 0..1000);
    }

    #[test]
    fn shares_are_equal_but_for_an_eighth_and_points_take_turns() {
        for of in [2, 7, 64] {
            for share in all(of) {
                let part = share.trials(1_000_000, 0);
                let wanted = 1_000_000 / of;
                assert!((part.end - part.start).abs_diff(wanted) <= wanted / 8, "{share}: {part:?}");
                // With 3 trials per point.
                let few: u64 =
                    (0..of as usize).map(|turn| share.trials(3, turn)).map(|t| t.end - t.start).sum();
                assert_eq!(few, 3);
            }
        }
    }

    #[test]
    fn shares_are_written_as_i_of_n() {
        assert_eq!("2/7".parse(), Ok(Share { index: 1, of: 7 }));
        assert_eq!("2/7".parse::<Share>().unwrap().to_string(), "share 2 of 7");
        for text in ["0/4", "5/4", "1/0", "1", "1/4/4", "a/b", "-1/4", "1/65537", "", "/"] {
            assert_eq!(text.parse::<Share>(), Err(ShareError), "{text}");
        }
    }

    fn tally_of(errors: impl IntoIterator<Item = i32>, base: u32) -> Moments {
        let mut tally = Moments::empty(true);
        for error in errors {
            tally.count += 1;
            tally.sum += i128::from(error);
            tally.square += (i64::from(error) * i64::from(error)) as u128;
            tally.least = tally.least.min(error);
            tally.greatest = tally.greatest.max(error);
            tally.bins[bin(Scalar(error as u32), base).0 as usize] += 1;
        }
        tally
    }

    #[test]
    fn the_standard_error_of_the_rms_is_that_of_a_sine_and_not_of_a_normal_distribution() {
        let n = 100_000;
        let sine =
            (0..n).map(|k| (1e6 * libm::sin(f64::from(k) / f64::from(n) * core::f64::consts::TAU)) as i32);
        let base = level(176_776);
        let estimates = Estimates::new(&tally_of(sine, base), base, 0.5).unwrap();
        let rms = 1e6 / libm::sqrt(2.0) * 0.5;
        assert!((estimates.rms / rms - 1.0).abs() < 1e-5, "{estimates:?}");
        // E⁴ of a sine is 3/8, so se = rms √(1/2) / (2 √n); a normal distribution would give rms √2 / (2 √n).
        let expected = rms * libm::sqrt(0.5) / (2.0 * libm::sqrt(f64::from(n)));
        assert!((estimates.rms_se.unwrap() / expected - 1.0).abs() < 0.01, "{estimates:?}, not {expected}");
        assert_eq!(estimates.max, 5e5);
    }

    /// Errors with the quantiles of a standardized distribution at `mean` and with standard deviation `sd`.
    fn spread(mean: f64, sd: f64, quantile: impl Fn(f64) -> f64) -> Moments {
        const TRIALS: i32 = 100_000;
        let base = level(libm::floor(0.25 * libm::hypot(mean, sd)) as u32);
        let errors = (0..TRIALS).map(|k| mean + sd * quantile((f64::from(k) + 0.5) / f64::from(TRIALS)));
        tally_of(errors.map(|error| libm::round(error) as i32), base)
    }

    #[test]
    fn the_standard_error_of_the_rms_is_right_however_narrow_and_far_from_0_the_errors_lie() {
        let even = |p: f64| libm::sqrt(12.0) * (p - 0.5);
        let exponential = |p: f64| -libm::log1p(-p) - 1.0;
        // Standard deviations from far below a bin to as wide as the mean; at 0.2 the even distribution has one sign,
        // at 1 both.
        for relative in [1e-6, 1e-5, 1e-3, 0.0077, 0.0079, 0.02, 0.1, 0.2, 1.0] {
            // With their third and fourth standardized moments.
            let cases: [(&str, Moments, f64, f64); 3] = [
                ("even", spread(1e8, 1e8 * relative, even), 0.0, 1.8),
                ("exponential", spread(1e8, 1e8 * relative * 0.3, exponential), 2.0, 9.0),
                ("mirrored", spread(-1e8, -1e8 * relative * 0.3, exponential), 2.0, 9.0),
            ];
            for (name, tally, third, fourth) in cases {
                let (m, s) = (1e8, 1e8 * relative * if name == "even" { 1.0 } else { 0.3 });
                let variance =
                    4.0 * m * m * s * s + 4.0 * m * third * s * s * s + (fourth - 1.0) * s * s * s * s;
                let rms = libm::hypot(m, s);
                let expected = libm::sqrt(variance / tally.count as f64) / (2.0 * rms);
                let base = level(libm::floor(0.25 * rms) as u32);
                let found = Estimates::new(&tally, base, 1.0).unwrap().rms_se.unwrap();
                assert!((found / expected - 1.0).abs() < 0.01, "{name}, {relative}: {found}, not {expected}");
            }
        }
    }

    #[test]
    fn whole_numbers_of_few_units_have_the_standard_error_of_their_own_moments() {
        let errors = [-3, -2, -2, -9, 2, -7, 4, 4, 3, 2, 5];
        let moment = |power| errors.iter().map(|&e| f64::from(e).powi(power)).sum::<f64>() / 11.0;
        let expected = libm::sqrt((moment(4) - moment(2) * moment(2)) / 11.0 / (4.0 * moment(2)));
        let found = Estimates::new(&tally_of(errors, 0), 0, 1.0).unwrap().rms_se.unwrap();
        assert!((found / expected - 1.0).abs() < 1e-12, "{found}, not {expected}");
    }

    #[test]
    fn the_standard_error_of_a_constant_is_exactly_0_and_that_of_an_unknown_variance_is_absent() {
        for error in [77_569_123, -5, 0] {
            let base = level(i32::unsigned_abs(error) / 4);
            let estimates = Estimates::new(&tally_of([error; 1000], base), base, 0.1).unwrap();
            assert_eq!(estimates.rms_se, Some(0.0), "{error}");
        }
        let mut without_histogram = tally_of([-5, 3, 8], 0);
        without_histogram.bins.clear();
        assert_eq!(Estimates::new(&without_histogram, 0, 1.0).unwrap().rms_se, None);
    }

    #[test]
    fn the_quantile_of_an_even_spread_is_found_within_its_bounds() {
        let n = 200_000;
        let base = level(n as u32 / 8);
        let q = Estimates::new(&tally_of(1..=n, base), base, 1.0).unwrap().p99_73.unwrap();
        let exact = LEVEL * f64::from(n);
        assert!((q.value / exact - 1.0).abs() < 1e-3, "{q:?}");
        let (low, high) = (q.low.unwrap(), q.high.unwrap());
        assert!(low < exact && exact < high && high - low < 0.02 * exact, "{q:?}");
    }

    #[test]
    fn a_quantile_that_few_trials_cannot_bound_has_no_upper_end() {
        let base = level(12);
        let q = Estimates::new(&tally_of(1..=100, base), base, 1.0).unwrap().p99_73.unwrap();
        assert_eq!(q.high, None);
        assert!(q.low.is_some());
    }

    #[test]
    fn what_lies_beyond_the_histogram_is_left_blank_and_not_guessed() {
        // Bins end at 32, and one error in a hundred lies far beyond.
        let tally = tally_of((0..10_000).map(|k| if k % 100 == 0 { 5000 } else { 1 + k % 20 }), level(1));
        let found = Estimates::new(&tally, level(1), 1.0).unwrap();
        assert_eq!((found.p99_73, found.rms_se), (None, None));
        assert_eq!(found.max, 5000.0);
    }

    #[test]
    fn one_trial_and_no_trial_and_all_zero_are_answered_without_invention() {
        assert_eq!(Estimates::new(&Moments::empty(true), 0, 1.0), None);
        let one = Estimates::new(&tally_of([7], 0), 0, 1.0).unwrap();
        assert_eq!((one.rms, one.rms_se), (7.0, None));
        let zero = Estimates::new(&tally_of([0, 0, 0], 0), 0, 1.0).unwrap();
        assert_eq!((zero.rms, zero.rms_se, zero.max), (0.0, Some(0.0), 0.0));
    }

    #[test]
    fn binomial_intervals_are_those_of_the_tables() {
        // scipy.stats.binom.ppf([0.025, 0.975], n, 0.0027)
        for (n, interval) in [(100, (0, 2)), (1000, (0, 6)), (100_000, (238, 303)), (100_000, (238, 303))] {
            assert_eq!(central_interval(n, 1.0 - LEVEL), interval, "n = {n}");
        }
    }
}
