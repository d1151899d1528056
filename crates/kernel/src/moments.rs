//! The tally of scalar estimates: count, sum, sum of squares, extremes and a histogram, all exact integers.
//!
//! Twin of `shaders/moments.wgsl`. A lane adds up at most [`FLUSH`] trials in 64 bits before the sums are carried over
//! to 128 bits. Errors below [`LIMIT`] cannot overflow them. (64-bit sums without this bound wrapped once in 1.3e8
//! trials.)

use crate::shader::constants;
use crate::word::{Wide, Word};

constants!(FLUSH, BINS, BIN_BITS, LEVEL_OFFSET, PARTIAL_WORDS, GROUPS_PER_ROW);

/// Words of the totals of one estimate, of an invocation or of its workgroup: Σ and Σ² of three words each, then the least
/// and greatest error.
pub const PARTIAL_WORDS: usize = 8;

/// Workgroups in a row of a dispatch, below every device's limit per dimension.
pub const GROUPS_PER_ROW: u32 = 32768;

/// Most estimates of one launch.
pub const MAX_ESTIMATES: usize = 6;

/// Bound on the magnitude of every error, which lowering proves.
pub const LIMIT: i64 = 1 << 29;

/// Trials that one lane may add up in 64 bits: FLUSH · LIMIT² = 2^64.
pub const FLUSH: u64 = 64;

/// Bins of an estimate's histogram: one below its start, then five octaves, the last bin open at the top.
pub const BINS: usize = 1 + (5 << BIN_BITS);

/// log2 of the bins per octave; no bin is wider than 1/128 of its lower edge.
pub const BIN_BITS: u32 = 7;

/// Samples the errors of a kernel's estimates, trial by trial.
pub trait Sampler: Copy {
    /// Number of estimates.
    fn estimates(&self) -> usize;
    /// The level at which the histogram of an estimate starts; see [`bin`].
    fn bin_base(&self, estimate: usize) -> u32;
    /// The errors of the trials with the 64-bit numbers `high`·2^32 + `low`; only the first `estimates` entries count.
    fn trial<W: Word>(&self, low: W, high: u32) -> [W; MAX_ESTIMATES];
}

/// The exact tally of one estimate over a range of trials; `merge` makes it a commutative monoid.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Moments {
    /// Number of trials.
    pub count: u64,
    /// Σ E, in units of the estimate.
    pub sum: i128,
    /// Σ E².
    pub square: u128,
    /// Smallest E, signed; without trials, the largest `i32`.
    pub least: i32,
    /// Largest E, signed; without trials, the smallest `i32`.
    pub greatest: i32,
    /// Trials in each bin of |error|; empty where no histogram was requested.
    pub bins: Vec<u64>,
}

impl Moments {
    /// The tally of no trials.
    pub fn empty(histogram: bool) -> Moments {
        let bins = if histogram { vec![0; BINS] } else { Vec::new() };
        Moments { count: 0, sum: 0, square: 0, least: i32::MAX, greatest: i32::MIN, bins }
    }

    /// Adds the trials of `other`, which must be different trials of the same estimate.
    pub fn merge(&mut self, other: &Moments) {
        self.count += other.count;
        self.sum += other.sum;
        self.square += other.square;
        self.least = self.least.min(other.least);
        self.greatest = self.greatest.max(other.greatest);
        for (bin, more) in self.bins.iter_mut().zip(&other.bins) {
            *bin += more;
        }
    }
}

/// Consecutive trials whose numbers share one upper half.
#[derive(Debug, Clone, Copy)]
pub struct Trials {
    /// Number of the first trial.
    pub first: u64,
    /// Count of the trials, which stay below the next multiple of 2^32.
    pub count: u64,
    /// Whether their histogram is wanted too.
    pub histogram: bool,
}

/// Tallies of a sampler's estimates over `trials`, whose count must be a multiple of the lanes.
// Only here: in the shader, `main` does the work of this function and of `accumulate`.
#[inline(always)]
pub fn tally<W: Word>(sampler: impl Sampler, trials: Trials) -> Vec<Moments> {
    let Trials { first, count, histogram } = trials;
    let mut tallies = vec![Moments::empty(histogram); sampler.estimates()];
    if !histogram {
        accumulate::<W, false>(sampler, first, count, &mut tallies, &mut []);
        return tallies;
    }
    let mut counts = vec![[0; BINS]; sampler.estimates()];
    accumulate::<W, true>(sampler, first, count, &mut tallies, &mut counts);
    for (tally, counts) in tallies.iter_mut().zip(&counts) {
        tally.bins = counts.iter().map(|&n: &u32| u64::from(n)).collect();
    }
    tallies
}

/// Adds the trials `first .. first + count`, a multiple of the lanes, to the tallies and bin counts.
// Only here: see `tally`.
#[inline(always)]
fn accumulate<W: Word, const HISTOGRAM: bool>(
    sampler: impl Sampler,
    first: u64,
    count: u64,
    tallies: &mut [Moments],
    counts: &mut [[u32; BINS]],
) {
    let estimates = sampler.estimates();
    let lanes = W::LANES as u64;
    let mut done = 0;
    while done < count {
        let flush = (count - done).min(FLUSH * lanes);
        let mut sums = [Sums::<W>::empty(); MAX_ESTIMATES];
        for step in 0..flush / lanes {
            let trial = first + done + step * lanes;
            let low = W::splat(trial as u32) + W::iota();
            let error = sampler.trial(low, (trial >> 32) as u32);
            for e in 0..estimates {
                sums[e].add(error[e]);
            }
            if HISTOGRAM {
                for e in 0..estimates {
                    let mut bins = [0; 16];
                    bin(error[e], sampler.bin_base(e)).store(&mut bins);
                    for &bin in &bins[..W::LANES] {
                        debug_assert!((bin as usize) < BINS, "bin {bin} of {BINS}");
                        // SAFETY: `bin` is at most BINS − 1, whatever the error.
                        unsafe { *counts[e].get_unchecked_mut(bin as usize) += 1 };
                    }
                }
            }
        }
        for (tally, sums) in tallies.iter_mut().zip(&sums) {
            sums.flush(flush, tally);
        }
        done += flush;
    }
}

/// Running sums of one estimate.
///
/// The sum is kept as its lower 32 bits and the sum of the upper halves. This takes fewer operations than 64 bits and
/// is just as exact for up to [`FLUSH`] errors.
#[derive(Clone, Copy)]
struct Sums<W: Word> {
    sum: W,
    halves: W,
    square: W::Wide,
    least: W,
    greatest: W,
}

impl<W: Word> Sums<W> {
    #[inline(always)]
    fn empty() -> Sums<W> {
        Sums {
            sum: W::splat(0),
            halves: W::splat(0),
            square: W::Wide::splat(0),
            least: W::splat(i32::MAX as u32),
            greatest: W::splat(i32::MIN as u32),
        }
    }

    #[inline(always)]
    fn add(&mut self, error: W) {
        self.sum = self.sum + error;
        self.halves = self.halves + error.sar(16);
        self.square = self.square + error.mul_wide(error);
        self.least = self.least.min_signed(error);
        self.greatest = self.greatest.max_signed(error);
    }

    #[inline(always)]
    fn flush(&self, trials: u64, tally: &mut Moments) {
        tally.count += trials;
        tally.square += self.square.total_unsigned();
        let [mut sum, mut halves, mut least, mut greatest] = [[0; 16]; 4];
        self.sum.store(&mut sum);
        self.halves.store(&mut halves);
        self.least.store(&mut least);
        self.greatest.store(&mut greatest);
        // By index: adapters of iterators are compiled in one unit of the crate and called from the others.
        for lane in 0..W::LANES {
            tally.sum += i128::from(whole_sum(sum[lane], halves[lane]));
            tally.least = tally.least.min(least[lane] as i32);
            tally.greatest = tally.greatest.max(greatest[lane] as i32);
        }
    }
}

/// A sum of at most [`FLUSH`] errors, from its lower 32 bits and the sum of the errors' upper halves.
///
/// The halves omit a part between 0 and FLUSH·2^16 = 2^22, so its lower 32 bits are all of it.
#[inline]
fn whole_sum(low: u32, halves: u32) -> i64 {
    (i64::from(halves as i32) << 16) + i64::from(low.wrapping_sub(halves << 16))
}

/// The bin of |error|, below [`BINS`]. Bins are log-linear, 128 to the octave, starting at the level `base`.
///
/// A level is 128·⌊log2 a⌋ plus the next 7 bits of a = max(|error|, 1). Bin 0 holds everything below level `base`, bin
/// 1 that level, and the last bin everything above.
#[inline(always)]
pub fn bin<W: Word>(error: W, base: u32) -> W {
    let sign = error.sar(31);
    let a = ((error ^ sign) - sign).max_signed(W::splat(1));
    let zeros = a.leading_zeros();
    let level = (a.shift_left(zeros) >> (31 - BIN_BITS)) - (zeros << BIN_BITS);
    // Levels are kept less a constant: the leading zeros are subtracted, and the leading one is not masked off.
    let above = level - W::splat(base.wrapping_sub(LEVEL_OFFSET).wrapping_sub(1));
    above.max_signed(W::splat(0)).min_signed(W::splat(BINS as u32 - 1))
}

/// The constant by which the levels in [`bin`] are too low.
pub(crate) const LEVEL_OFFSET: u32 = (31 << BIN_BITS) - (1 << BIN_BITS);

/// The level of the whole number `a` ≥ 1.
pub fn level(a: u32) -> u32 {
    let octave = a.max(1).ilog2();
    let next = (u64::from(a.max(1)) << BIN_BITS >> octave) as u32 & ((1 << BIN_BITS) - 1);
    (octave << BIN_BITS) + next
}

/// The least |error| of `level`.
pub fn level_edge(level: u32) -> u64 {
    let (octave, next) = (level >> BIN_BITS, u64::from(level & ((1 << BIN_BITS) - 1)));
    (((1 << BIN_BITS) + next) << octave).div_ceil(1 << BIN_BITS)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::word::Scalar;

    fn trials(count: u64) -> Trials {
        Trials { first: 0, count, histogram: true }
    }

    #[test]
    fn bins_follow_the_levels() {
        for base in [0, level(5), level(1000), level(123_456_789)] {
            for error in
                [0, 1, -1, 2, 3, 5, -6, 999, 1000, 1007, -1008, 12345, 123_456_789, 1 << 28, (1 << 29) - 1]
            {
                let above = (i64::from(level(i32::unsigned_abs(error))) - i64::from(base) + 1).max(0);
                let expected = above.min(BINS as i64 - 1) as u32;
                assert_eq!(bin(Scalar(error as u32), base).0, expected, "error {error}, base {base}");
            }
        }
    }

    #[test]
    fn a_level_starts_at_its_edge() {
        for level_ in 0..(29 << BIN_BITS) {
            let edge = level_edge(level_);
            // Below 128 whole numbers are sparser than levels, so the next number belongs to a later level.
            assert!(level(edge as u32) >= level_, "level {level_}, edge {edge}");
            assert!(edge <= 1 || level(edge as u32 - 1) < level_, "level {level_}, edge {edge}");
        }
    }

    /// A sampler that returns the same error in every trial.
    #[derive(Clone, Copy)]
    struct Constant(i32);

    impl Sampler for Constant {
        fn estimates(&self) -> usize {
            1
        }
        fn bin_base(&self, _: usize) -> u32 {
            0
        }
        fn trial<W: Word>(&self, _: W, _: u32) -> [W; MAX_ESTIMATES] {
            [W::splat(self.0 as u32); MAX_ESTIMATES]
        }
    }

    #[test]
    fn sums_of_the_largest_errors_are_exact() {
        let largest = LIMIT - 1;
        for error in [largest, -largest] {
            for count in [1, FLUSH - 1, FLUSH, FLUSH + 1, 10 * FLUSH] {
                let tally = &tally::<Scalar>(Constant(error as i32), trials(count))[0];
                assert_eq!(tally.sum, i128::from(error) * i128::from(count));
                assert_eq!(tally.square, (i128::from(error) * i128::from(error)) as u128 * u128::from(count));
                assert_eq!((tally.least, tally.greatest), (error as i32, error as i32));
                assert_eq!(tally.bins[BINS - 1], count, "the last bin is open");
            }
        }
    }

    #[test]
    fn merging_is_adding() {
        let mut left = tally::<Scalar>(Constant(3), trials(5)).remove(0);
        let right = tally::<Scalar>(Constant(-8), trials(7)).remove(0);
        left.merge(&right);
        left.merge(&Moments::empty(true));
        assert_eq!((left.count, left.sum, left.square, left.least, left.greatest), (12, -41, 493, -8, 3));
        assert_eq!(left.bins.iter().sum::<u64>(), 12);
    }
}
