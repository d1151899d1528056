//! Sampling of the records that a store lacks, batch by batch.

use std::ops::Range;
use std::sync::Arc;

use crate::key::refusal::Refusal;
use crate::sampling::batches::BATCH_SECONDS;
use crate::sampling::plan::{Done, RunError};
use crate::sampling::worker::Worker;
use crate::sampling::writer::while_storing;
use crate::store::error::StoreError;
use crate::store::{Address, Provenance, Row, Store};
use crate::tally::block::{Block, base_log2, cover, missing};
use crate::tally::share::Share;
use sagnac_base::progress::Progress;
use sagnac_base::stopwatch::Stopwatch;
use sagnac_kernel::curve::Recorded;
use sagnac_kernel::rows::Rows;

/// The records of a point, as far as the store needs to know them.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Records {
    /// Address of their values.
    pub(crate) address: Address,
    /// Samples of a record.
    pub(crate) samples: u64,
    /// Integers of a record.
    pub(crate) width: usize,
}

/// The records of all points of a study.
pub(crate) struct Wanted<'a> {
    /// Records of each point.
    pub(crate) trials: u64,
    /// The points, in order.
    pub(crate) points: &'a [Records],
    /// What makes the records of a point, by its place. It is asked whenever it is needed, because its tables may be large.
    pub(crate) recipe: &'a dyn Fn(usize) -> Result<Arc<dyn Recorded>, Refusal>,
}

impl Wanted<'_> {
    /// The points in order, without those whose draws and sums are the same as those of an earlier one.
    fn distinct(&self) -> impl Iterator<Item = (usize, &Records)> {
        let is_first = |(turn, records): &(usize, &Records)| {
            self.points[..*turn].iter().all(|before| before.address != records.address)
        };
        self.points.iter().enumerate().filter(is_first)
    }

    /// The records that the store lacks of a share, each with the place of its point.
    fn missing(&self, store: &Store, share: Share) -> Result<Vec<(usize, Range<u64>)>, StoreError> {
        let index = store.index()?;
        let mut lacking = Vec::new();
        for (turn, records) in self.distinct() {
            let gaps = missing(index.blocks(&records.address)?, share.trials(self.trials, turn));
            lacking.extend(gaps.into_iter().map(|gap| (turn, gap)));
        }
        Ok(lacking)
    }

    /// Number of records that the store lacks of a share.
    pub(crate) fn lacks(&self, store: &Store, share: Share) -> Result<u64, StoreError> {
        Ok(self.missing(store, share)?.iter().map(|(_, gap)| gap.end - gap.start).sum())
    }

    /// Makes the records that the store lacks of a share. Each batch is stored as soon as it is complete.
    pub(crate) fn sample(
        &self,
        store: &mut Store,
        worker: &mut Worker,
        share: Share,
        progress: &dyn Progress,
    ) -> Result<Done, RunError> {
        let (trials, started) = (self.trials, Stopwatch::start());
        let lacking = self.missing(store, share)?;
        let samples = |turn: usize, gap: Range<u64>| (gap.end - gap.start) * self.points[turn].samples;
        let left: u64 = lacking.iter().map(|(turn, gap)| samples(*turn, gap.clone())).sum();
        let all = self.distinct().map(|(turn, _)| samples(turn, share.trials(trials, turn)));
        let total = all.sum::<u64>().max(left);
        progress.start("samples", total - left, total);
        let (mut batch_samples, mut made, mut stopped) = (worker.first_batch(), 0, false);
        while_storing(store, |stored| {
            'points: for (turn, gap) in lacking {
                let recipe = (self.recipe)(turn)?;
                let point = &self.points[turn];
                let mut first = gap.start;
                while first < gap.end {
                    stopped = progress.stops();
                    if stopped {
                        break 'points;
                    }
                    let batch_started = Stopwatch::start();
                    let records = (batch_samples / point.samples).max(worker.records_at_once());
                    // Whole blocks where a batch contains some, smaller ones for very long records.
                    let align = 1 << base_log2(trials).min(records.ilog2());
                    let batch = first..gap.end.min((first + records).next_multiple_of(align));
                    let advance = |records| progress.advance(records * point.samples);
                    let sums = worker.sums(&*recipe, batch.clone(), &advance)?;
                    made += batch.end - batch.start;
                    first = batch.end;
                    let seconds = started.seconds();
                    let so_far = Provenance { device: worker.name(), trials: made, seconds };
                    if !stored(point.rows(batch, base_log2(trials), &sums), so_far) {
                        break 'points;
                    }
                    let factor = BATCH_SECONDS / batch_started.seconds().max(1e-3);
                    batch_samples = ((batch_samples as f64 * factor.clamp(0.25, 4.0)) as u64).max(1);
                }
            }
            Ok(())
        })?;
        Ok(Done { trials: made, seconds: started.seconds(), stopped, degraded: vec![] })
    }
}

impl Records {
    /// The rows of consecutive records, from their values, in blocks of at most 2^`largest`.
    pub(crate) fn rows(&self, records: Range<u64>, largest: u32, values: &[u128]) -> Vec<Row<Rows>> {
        let (first, width) = (records.start, self.width);
        let row = |block: Block| {
            let [from, to] = [block.first, block.end()].map(|at| (at - first) as usize * width);
            Row { address: self.address, block, tally: Rows { width, values: values[from..to].to_vec() } }
        };
        cover(records, largest).into_iter().map(row).collect()
    }
}
