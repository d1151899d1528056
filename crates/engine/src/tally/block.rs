//! Blocks: dyadic ranges of trial numbers, the unit of dispatch, storage and sharding.
//!
//! Two blocks nest or are disjoint, so a set of rows folds to one answer in any order, however it was written.

use core::ops::Range;

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
pub fn base_log2(trials: u64) -> u32 {
    (trials / 32).max(1).ilog2().clamp(MIN_LOG2, MAX_LOG2)
}

/// log2 of the steps, some milliseconds, below which storing and reading a row costs more than resampling it.
const QUICK: u32 = 18;

/// log2 of the largest rows of a study with this many trials of this many steps each: its base block, or what is
/// sampled in no time. Thousands of points then have few rows.
pub fn row_log2(trials: u64, steps: u64) -> u32 {
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

#[cfg(test)]
mod tests {
    use super::*;

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
}
