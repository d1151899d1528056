//! The sums of records as rows of the store.

use std::ops::Range;

use crate::kernel::rows::Rows;
use crate::kinds::allan::run::Planned;
use crate::store::Row;
use crate::tally::block::{Block, cover};

/// The rows of consecutive records, from their sums, in blocks of at most 2^`largest`.
pub(crate) fn rows(planned: &Planned, records: Range<u64>, largest: u32, sums: &[u128]) -> Vec<Row<Rows>> {
    let (first, width) = (records.start, planned.width);
    let row = |block: Block| {
        let [from, to] = [block.first, block.end()].map(|at| (at - first) as usize * width);
        Row { address: planned.address, block, tally: Rows { width, values: sums[from..to].to_vec() } }
    };
    cover(records, largest).into_iter().map(row).collect()
}
