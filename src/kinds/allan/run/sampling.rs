//! Sampling of the records that the store lacks, batch by batch.

use std::ops::Range;
use std::time::Instant;

use crate::kernel::rows::Rows;
use crate::kinds::allan::run::{Plan, Planned};
use crate::progress::Progress;
use crate::sampling::batches::BATCH_SECONDS;
use crate::sampling::plan::{Done, RunError};
use crate::sampling::worker::Worker;
use crate::sampling::writer::while_storing;
use crate::store::{Provenance, Row, Store};
use crate::tally::block::{Block, base_log2, cover};
use crate::tally::share::Share;

impl Plan<'_> {
    /// Makes the records that the store lacks of a share. Each batch is stored as soon as it is complete.
    pub(crate) fn sample(
        &self,
        store: &mut Store,
        worker: &mut Worker,
        share: Share,
        progress: &dyn Progress,
    ) -> Result<Done, RunError> {
        let (trials, started) = (self.study.trials, Instant::now());
        let lacking = self.missing(store, share)?;
        let samples = |(planned, gap): &(&Planned, Range<u64>)| (gap.end - gap.start) * planned.samples;
        let left: u64 = lacking.iter().map(samples).sum();
        let all = self.distinct().map(|(turn, planned)| samples(&(planned, share.trials(trials, turn))));
        let total = all.sum::<u64>().max(left);
        progress.start("samples", total - left, total);
        let (mut batch_samples, mut made, mut stopped) = (worker.first_batch(), 0, false);
        while_storing(store, |stored| {
            'points: for (planned, gap) in lacking {
                let lowered = self.lowered(planned.point)?;
                let mut first = gap.start;
                while first < gap.end {
                    stopped = progress.stops();
                    if stopped {
                        break 'points;
                    }
                    let batch_started = Instant::now();
                    let records = (batch_samples / planned.samples).max(worker.records_at_once());
                    // Whole blocks where a batch contains some, smaller ones for very long records.
                    let align = 1 << base_log2(trials).min(records.ilog2());
                    let batch = first..gap.end.min((first + records).next_multiple_of(align));
                    let advance = |records| progress.advance(records * planned.samples);
                    let sums = worker.sums(lowered.records.recipe(), batch.clone(), &advance)?;
                    made += batch.end - batch.start;
                    first = batch.end;
                    let seconds = started.elapsed().as_secs_f64();
                    let so_far = Provenance { device: worker.name(), trials: made, seconds };
                    if !stored(rows(planned, batch, base_log2(trials), &sums), so_far) {
                        break 'points;
                    }
                    let factor = BATCH_SECONDS / batch_started.elapsed().as_secs_f64().max(1e-3);
                    batch_samples = ((batch_samples as f64 * factor.clamp(0.25, 4.0)) as u64).max(1);
                }
            }
            Ok(())
        })?;
        Ok(Done { trials: made, seconds: started.elapsed().as_secs_f64(), stopped, degraded: vec![] })
    }
}

/// The rows of consecutive records, from their sums, in blocks of at most 2^`largest`.
pub(crate) fn rows(planned: &Planned, records: Range<u64>, largest: u32, sums: &[u128]) -> Vec<Row<Rows>> {
    let (first, width) = (records.start, planned.width);
    let row = |block: Block| {
        let [from, to] = [block.first, block.end()].map(|at| (at - first) as usize * width);
        Row { address: planned.address, block, tally: Rows { width, values: sums[from..to].to_vec() } }
    };
    cover(records, largest).into_iter().map(row).collect()
}
