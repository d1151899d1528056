//! Sampling the records that the store lacks, batch by batch, and what they and their fits cost.

use std::ops::Range;
use std::time::Instant;

use crate::kernel::rows::Rows;
use crate::kinds::allan::lower::curve::LoweredCurve;
use crate::kinds::allan::run::estimates::Estimates;
use crate::kinds::allan::run::rows::rows;
use crate::kinds::allan::run::{Plan, Planned};
use crate::run::{BATCH_SECONDS, Done, Progress, RunError};
use crate::sampling::worker::Worker;
use crate::store::{Provenance, Store};
use crate::tally::block::base_log2;
use crate::tally::share::Share;

/// Samples of the first batch.
const FIRST_BATCH: u64 = 1 << 22;

/// From so many samples on, some tenths of a second, it pays to try first what points cost.
const TRIED_FROM: u64 = 16 * FIRST_BATCH;

/// Of very long records one in so many is made first to see what they cost; of all one in so many is fitted, which is done again
/// later. Much fewer would tell more of what else the machine does.
const TRIED_RECORDS: u64 = 50;
const TRIED_FITS: u64 = 32;

/// Fewest fits that are tried.
const FEWEST_FITS: u64 = 64;

/// Who samples, and for what.
struct Sampler<'a, 'w> {
    store: &'a mut Store,
    worker: &'a mut Worker<'w>,
    progress: &'a (dyn Progress + Sync),
    started: Instant,
    /// Records of each point of the study.
    trials: u64,
    /// Records made so far.
    made: u64,
}

impl Sampler<'_, '_> {
    /// Makes and keeps about so many of the first records of `gap`, as few as are made at once at least; returns where they end
    /// and their sums.
    fn batch(
        &mut self,
        planned: &Planned,
        lowered: &LoweredCurve,
        gap: Range<u64>,
        records: u64,
    ) -> Result<(u64, Vec<u128>), RunError> {
        let records = records.max(self.worker.records_at_once());
        // Whole blocks where a batch holds some, smaller ones of very long records.
        let align = 1 << base_log2(self.trials).min(records.ilog2());
        let batch = gap.start..gap.end.min((gap.start + records).next_multiple_of(align));
        let advance = |records| self.progress.advance(records * planned.samples);
        let sums = self.worker.sums(lowered.records.recipe(), batch.clone(), &advance)?;
        let end = batch.end;
        self.made += batch.end - batch.start;
        let seconds = self.started.elapsed().as_secs_f64();
        let so_far = Provenance { device: self.worker.name(), trials: self.made, seconds };
        self.store.insert(&rows(planned, batch, base_log2(self.trials), &sums), Some(&so_far))?;
        Ok((end, sums))
    }
}

/// What a run costs, s: of points that were tried as they showed, of the others as those on average.
#[derive(Debug, Default)]
struct Outlook {
    done: f64,
    samples: Costs,
    fits: Costs,
    /// What of it was sampled since all points were tried, and how long that took.
    since: (f64, f64),
}

/// What units cost that differ from point to point.
#[derive(Debug, Default)]
struct Costs {
    /// Units of points that were tried, and what they cost.
    known: f64,
    cost: f64,
    /// Units of the others.
    unknown: f64,
}

impl Costs {
    /// So many units become known to cost so much.
    fn learn(&mut self, units: f64, cost: f64) {
        self.unknown -= units;
        self.known += units;
        self.cost += cost;
    }

    fn total(&self) -> f64 {
        self.cost + if self.known > 0.0 { self.unknown * self.cost / self.known } else { 0.0 }
    }
}

impl Outlook {
    fn tell(&self, progress: &dyn Progress) {
        let (cost, seconds) = self.since;
        let slower = if cost > 0.0 { (seconds / cost).clamp(0.25, 4.0) } else { 1.0 };
        // A machine that has become slower may be so for sampling alone, as one that gets hot, or for fits as well: half of each.
        progress.cost(self.done, self.samples.total() + self.fits.total() / libm::sqrt(slower));
    }

    /// So much was sampled in so many seconds.
    fn pay(&mut self, cost: f64, seconds: f64) {
        self.done += cost;
        self.since = (self.since.0 + cost, self.since.1 + seconds);
    }
}

impl Plan<'_> {
    /// Samples what the store lacks of a share, each batch kept as soon as it is done.
    pub(crate) fn run(
        &self,
        store: &mut Store,
        worker: &mut Worker,
        share: Share,
        progress: &(dyn Progress + Sync),
    ) -> Result<Done, RunError> {
        let trials = self.study.trials;
        let mut lacking = self.missing(store, share)?;
        let samples = |(planned, gap): &(&Planned, Range<u64>)| (gap.end - gap.start) * planned.samples;
        let left: u64 = lacking.iter().map(samples).sum();
        let of_point = |(turn, planned): (usize, &Planned)| {
            let trials = share.trials(trials, turn);
            (trials.end - trials.start) * planned.samples
        };
        let total = self.distinct().map(of_point).sum::<u64>().max(left);
        progress.start("samples", total - left, total);
        let mut sampler = Sampler { store, worker, progress, started: Instant::now(), trials, made: 0 };
        // Tables of shares are made when they are put together.
        let fits = if share.is_whole() { self.all_records() } else { 0 };
        let mut outlook = Outlook::default();
        outlook.samples.unknown = left as f64;
        outlook.fits.unknown = fits as f64;
        let is_tried = left >= TRIED_FROM && (fits > 0 || lacking.len() > 1);
        let prices = match is_tried {
            true => self.try_each(&mut lacking, &mut sampler, &mut outlook)?,
            false => vec![],
        };
        let (mut batch_samples, mut stopped) = (FIRST_BATCH, false);
        for (at, (planned, gap)) in lacking.into_iter().enumerate().filter(|(_, (_, gap))| !gap.is_empty()) {
            stopped = stopped || progress.stops();
            if stopped {
                break;
            }
            let lowered = self.lowered(planned.point)?;
            let mut first = gap.start;
            while first < gap.end {
                stopped = progress.stops();
                if stopped {
                    break;
                }
                let started = Instant::now();
                let records = batch_samples / planned.samples;
                let (end, _) = sampler.batch(planned, &lowered, first..gap.end, records)?;
                let seconds = started.elapsed().as_secs_f64();
                if let Some(price) = prices.get(at) {
                    outlook.pay(price * (end - first) as f64, seconds);
                    outlook.tell(progress);
                }
                first = end;
                let factor = BATCH_SECONDS / seconds.max(1e-3);
                batch_samples = ((batch_samples as f64 * factor.clamp(0.25, 4.0)) as u64).max(1);
            }
        }
        let seconds = sampler.started.elapsed().as_secs_f64();
        Ok(Done { trials: sampler.made, seconds, stopped, degraded: vec![] })
    }

    /// Makes the first few records of each gap, which it takes out of it, and fits some: what a record of each costs, s. A run
    /// that is stopped meanwhile knows fewer.
    fn try_each(
        &self,
        lacking: &mut [(&Planned, Range<u64>)],
        sampler: &mut Sampler,
        outlook: &mut Outlook,
    ) -> Result<Vec<f64>, RunError> {
        let mut prices = Vec::new();
        let mut before: Option<&Planned> = None;
        for (planned, gap) in lacking {
            if sampler.progress.stops() {
                break;
            }
            let lowered = self.lowered(planned.point)?;
            let all = (gap.end - gap.start) as f64;
            let started = Instant::now();
            // A whole block, unless that takes long: rows of a run that is resumed are then those of one that was not.
            let block = 1 << base_log2(self.study.trials);
            let most = TRIED_FROM / planned.samples;
            let few = if block <= most { block } else { (gap.end - gap.start) / TRIED_RECORDS };
            let (end, sums) = sampler.batch(planned, &lowered, gap.clone(), few.min(most))?;
            let (records, seconds) = ((end - gap.start) as f64, started.elapsed().as_secs_f64());
            gap.start = end;
            let price = seconds / records;
            prices.push(price);
            outlook.done += seconds;
            outlook.samples.learn(all * planned.samples as f64, all * price);
            // All records of a point are fitted, whichever gaps it has.
            let is_another = before.replace(planned).is_none_or(|before| !std::ptr::eq(before, *planned));
            if is_another && outlook.fits.unknown > 0.0 {
                let fits = self.study.trials as f64;
                outlook.fits.learn(fits, self.cost_of_fits(planned, &lowered, sums));
            }
            outlook.tell(sampler.progress);
        }
        Ok(prices)
    }

    /// What the tables and the fits of all records of a point cost, s, as those of some show whose sums are known.
    fn cost_of_fits(&self, planned: &Planned, lowered: &LoweredCurve, mut sums: Vec<u128>) -> f64 {
        let width = planned.width;
        let trials = self.study.trials;
        let tried = FEWEST_FITS.max(trials / TRIED_FITS).min((trials / 8).max(2));
        sums.truncate(tried as usize * width);
        let count = sums.len() / width;
        let seconds = |values: Vec<u128>| {
            let started = Instant::now();
            let estimates =
                Estimates::of(vec![Rows { width, values }], |sums| lowered.records.variances(sums));
            self.add(&mut self.empty_tables(), planned.point, Some(lowered), &estimates, &|_| {});
            started.elapsed().as_secs_f64()
        };
        // What a point takes beside its records, as the covariance of them all, shows in the fits of two.
        let few = count.min(2);
        let of_few = seconds(sums[..few * width].to_vec());
        let more = if count > few { (seconds(sums) - of_few).max(0.0) / (count - few) as f64 } else { 0.0 };
        of_few + more * self.study.trials.saturating_sub(few as u64) as f64
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_was_not_tried_costs_what_the_rest_does_on_average() {
        let mut outlook = Outlook::default();
        outlook.samples.unknown = 400.0;
        outlook.fits.unknown = 20.0;
        assert_eq!(outlook.samples.total(), 0.0);
        outlook.samples.learn(100.0, 1.0);
        outlook.samples.learn(100.0, 3.0);
        outlook.fits.learn(10.0, 5.0);
        assert_eq!((outlook.samples.total(), outlook.fits.total()), (8.0, 10.0));
        outlook.samples.learn(200.0, 1.0);
        assert_eq!(outlook.samples.total(), 5.0);
    }
}
