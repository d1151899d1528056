//! Sampling of the trials and records that the store lacks, batch by batch; a batch is stored while the device works on the next.

use std::collections::{HashMap, HashSet};
use std::ops::Range;
use std::panic::resume_unwind;
use std::sync::Arc;
use std::sync::mpsc::sync_channel;
use std::thread;

use rayon::prelude::*;

use crate::device::Job;
use crate::key::Unrepresentable;
use crate::sampling::{Found, RunError, RunStats, Worker};
use crate::store::error::StoreError;
use crate::store::{Address, Index, Provenance, Row, Store, Tally};
use crate::tally::{Block, Share, base_log2, cover, fold, missing};
use sagnac_base::progress::Progress;
use sagnac_base::stopwatch::Stopwatch;
use sagnac_kernel::curve::Recorded;
use sagnac_kernel::launch::Launch;
use sagnac_kernel::moments::Moments;
use sagnac_kernel::rows::Rows;

/// A launch, with the addresses of the tallies of its estimates.
pub(crate) type Addressed = (Launch, Vec<Address>);

/// The missing blocks of a launch.
pub(crate) struct Work<'a> {
    /// Makes the launch for the batches that need it, because those of a hundred thousand points take much memory.
    launch: Box<dyn Fn() -> Result<Addressed, Unrepresentable> + Send + Sync + 'a>,
    /// Steps of one trial.
    steps: u64,
    pub(crate) blocks: Vec<Block>,
}

impl<'a> Work<'a> {
    pub(crate) fn new(
        steps: u64,
        launch: impl Fn() -> Result<Addressed, Unrepresentable> + Send + Sync + 'a,
        blocks: Vec<Block>,
    ) -> Work<'a> {
        Work { steps, launch: Box::new(launch), blocks }
    }

    /// Number of missing trials.
    pub(crate) fn trials(&self) -> u64 {
        self.blocks.iter().map(Block::trials).sum()
    }
}

/// Most jobs in a batch, whose tallies of some 30 KiB each are held in memory together.
const MAX_JOBS: usize = 1024;

/// Target duration of a batch in seconds, after which results are on disk.
const BATCH_SECONDS: f64 = 0.3;

/// log2 of the most steps of a block. Losing a block with its batch, or waiting for it after a signal, then costs
/// seconds at most.
const MAX_STEPS_LOG2: u32 = 30;

/// The blocks of at most 2^`log2` trials that some estimates lack within these `trials`.
pub(crate) fn lacking(
    index: &Index,
    addresses: &[Address],
    trials: Range<u64>,
    log2: u32,
) -> Result<Vec<Block>, StoreError> {
    let mut blocks = Vec::new();
    for address in addresses {
        blocks.extend(
            missing(index.blocks(address)?, trials.clone()).into_iter().flat_map(|gap| cover(gap, log2)),
        );
    }
    // The blocks of one estimate may lie within those of another.
    let blocks = fold(blocks.into_iter().map(|block| (block, ())).collect());
    Ok(blocks.into_iter().map(|(block, ())| block).collect())
}

/// The number of first trials that all of some estimates have, where it is the same for all.
pub(crate) fn held_by_all(
    index: &Index,
    addresses: impl Iterator<Item = Address>,
) -> Result<Option<u64>, StoreError> {
    let mut held = None;
    for address in addresses {
        let trials = index.trials(&address)?;
        if trials.is_none() || *held.get_or_insert(trials) != trials {
            return Ok(None);
        }
    }
    Ok(held.flatten())
}

/// Trials and estimates for the rows of a table; none without a store. `of` gives the address of a row's tally, the
/// level at which its histogram starts, and its unit, ″.
pub(crate) fn estimates<T: Sync>(
    store: Option<&Store>,
    rows: &[T],
    of: impl Fn(&T) -> (Address, u32, f64) + Sync,
) -> Result<Vec<Found>, StoreError> {
    let Some(store) = store else { return Ok(vec![Found::default(); rows.len()]) };
    let addresses: Vec<Address> = rows.iter().map(|row| of(row).0).collect();
    store.of_totals(&addresses, |at, tally| {
        let (_, bin_base, unit) = of(&rows[at]);
        Found::of(tally, bin_base, unit)
    })
}

/// Samples all of `work` in batches, each of which is stored as soon as it is complete, until `progress` stops it.
/// Returns the number of trials sampled. The run started at `started` and had sampled `before` trials.
pub(crate) fn sample(
    work: &[Work],
    before: u64,
    store: &mut Store,
    worker: &mut Worker,
    progress: &dyn Progress,
    started: Stopwatch,
) -> Result<u64, RunError> {
    let mut rest: Vec<Piece> = work
        .iter()
        .flat_map(|work| {
            let log2 = MAX_STEPS_LOG2.saturating_sub(work.steps.ilog2());
            let blocks = work.blocks.iter().flat_map(move |block| cover(block.first..block.end(), log2));
            blocks.map(move |block| (work, block))
        })
        .collect();
    interleave(&mut rest);
    rest.reverse();
    let (mut steps, mut sampled) = (worker.first_batch(), 0);
    let mut launches = Launches::default();
    while_storing(store, |stored| {
        let mut next = (take_batch(&mut rest, steps), steps);
        let mut made = launches.of(&next.0);
        while !next.0.is_empty() && !progress.stops() {
            let batch_started = Stopwatch::start();
            let of_batch = made?;
            let (batch, batch_steps) = std::mem::replace(&mut next, (take_batch(&mut rest, steps), steps));
            made = Ok(vec![]);
            // While the device samples a batch, the points of the next one are lowered.
            let results = rayon::in_place_scope(|scope| {
                scope.spawn(|_| made = launches.of(&next.0));
                let pieces = batch.iter().zip(&of_batch);
                let jobs: Vec<Job> =
                    pieces.map(|(&(_, block), made)| Job { launch: &made.0, block }).collect();
                worker.tally(&jobs, &|trials| progress.advance(trials))
            })?;
            let rows: Vec<Row<Moments>> = batch
                .iter()
                .zip(&of_batch)
                .zip(results)
                .flat_map(|((&(_, block), made), tallies)| {
                    let addressed = made.1.iter().zip(tallies);
                    addressed.map(move |(&address, tally)| Row { address, block, tally })
                })
                .collect();
            sampled += batch.iter().map(|(_, block)| block.trials()).sum::<u64>();
            let (trials, seconds) = (before + sampled, started.seconds());
            if !stored(rows, Provenance { device: worker.name(), trials, seconds }) {
                break;
            }
            let factor = (BATCH_SECONDS / batch_started.seconds().max(1e-3)).clamp(0.25, 4.0);
            steps = ((batch_steps as f64 * factor) as u64).max(1);
        }
        Ok(sampled)
    })
}

/// A block of some work.
type Piece<'a> = (&'a Work<'a>, Block);

/// Identifies work.
fn place(work: &Work) -> usize {
    std::ptr::from_ref(work).addr()
}

/// The launches of the last batches by the places of their work, at most as many as a batch has jobs.
#[derive(Default)]
struct Launches {
    made: HashMap<usize, Arc<Addressed>>,
}

impl Launches {
    /// The launch of each piece of a batch. Those that the batches before did not need are made.
    ///
    /// # Errors
    /// A point is refused, which a run has proven to fit.
    fn of(&mut self, batch: &[Piece]) -> Result<Vec<Arc<Addressed>>, Unrepresentable> {
        let mut missing = HashSet::new();
        let is_new = |work: &&Work| !self.made.contains_key(&place(work)) && missing.insert(place(work));
        let new: Vec<&Work> = batch.iter().map(|(work, _)| *work).filter(is_new).collect();
        if self.made.len() + new.len() > MAX_JOBS {
            let needed: HashSet<usize> = batch.iter().map(|(work, _)| place(work)).collect();
            self.made.retain(|work, _| needed.contains(work));
        }
        let launch = |work: &&Work| Ok((place(work), Arc::new((work.launch)()?)));
        self.made.extend(new.par_iter().map(launch).collect::<Result<Vec<_>, Unrepresentable>>()?);
        Ok(batch.iter().map(|(work, _)| self.made[&place(work)].clone()).collect())
    }
}

/// Interleaves the blocks of all work, each work in its own order. The work done so far is then representative of the
/// rest, even where trials of different points take different times, and a run that ends early has some trials of every
/// point.
fn interleave(rest: &mut Vec<Piece>) {
    let same = |a: &Piece, b: &Piece| std::ptr::eq(a.0, b.0);
    let mut placed: Vec<(f64, Piece)> = Vec::with_capacity(rest.len());
    for group in rest.chunk_by(same) {
        let trials: u64 = group.iter().map(|(_, block)| block.trials()).sum();
        let mut before = 0;
        for one in group {
            placed.push(((before as f64 + 0.5 * one.1.trials() as f64) / trials as f64, *one));
            before += one.1.trials();
        }
    }
    placed.sort_by(|a, b| a.0.total_cmp(&b.0));
    *rest = placed.into_iter().map(|(_, block)| block).collect();
}

/// The next blocks, of `steps` steps together, but at least one block.
fn take_batch<'a>(rest: &mut Vec<Piece<'a>>, steps: u64) -> Vec<Piece<'a>> {
    let of = |(work, block): &Piece| block.trials() * work.steps;
    let (mut batch, mut taken) = (Vec::new(), 0);
    while batch.len() < MAX_JOBS
        && let Some(next) = rest.pop_if(|next| taken == 0 || taken + of(next) <= steps)
    {
        taken += of(&next);
        batch.push(next);
    }
    batch
}

/// Stores the rows of a batch after those of the batch before. Returns whether to go on: not after rows could not be stored.
pub(crate) type Storing<'a, T> = &'a mut dyn FnMut(Vec<Row<T>>, Provenance) -> bool;

/// Runs `sample`, whose rows are stored on a thread of their own, and returns when all are stored.
///
/// # Errors
/// Rows cannot be stored, or `sample` fails; all rows that it handed over before are stored.
fn while_storing<T: Tally + Send, R>(
    store: &mut Store,
    sample: impl FnOnce(Storing<T>) -> Result<R, RunError>,
) -> Result<R, RunError> {
    let mut insert = |(rows, so_far): (Vec<Row<T>>, Provenance)| store.insert(&rows, Some(&so_far));
    if cfg!(target_family = "wasm") {
        // A page has no threads.
        let mut stored = Ok(());
        let sampled = sample(&mut |rows, so_far| {
            stored = insert((rows, so_far));
            stored.is_ok()
        });
        return stored.map_err(RunError::from).and(sampled);
    }
    thread::scope(|scope| {
        // A channel without room: a batch waits while the one before is stored, and no third one is begun.
        let (sender, receiver) = sync_channel(0);
        let stored = scope.spawn(move || receiver.into_iter().try_for_each(insert));
        let sampled = sample(&mut |rows, so_far| sender.send((rows, so_far)).is_ok());
        drop(sender);
        stored.join().unwrap_or_else(|panic| resume_unwind(panic))?;
        sampled
    })
}

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

/// Makes the recipes of the records of a point.
pub(crate) type Recipes<'a> = Box<dyn Fn(usize) -> Result<Vec<Arc<dyn Recorded>>, Unrepresentable> + 'a>;

/// The records of all points of a study.
pub(crate) struct Wanted<'a> {
    /// Number of records of each recipe.
    pub(crate) trials: u64,
    /// The records of each recipe, point by point.
    pub(crate) records: &'a [Records],
    /// Number of recipes of a point.
    pub(crate) of_point: usize,
    /// The recipes of a point. They are made once for all of its records, because their tables may be large.
    pub(crate) recipes: Recipes<'a>,
}

impl Wanted<'_> {
    /// The points in order, without those whose draws and sums are the same as those of an earlier one.
    fn distinct(&self) -> impl Iterator<Item = (usize, &Records)> {
        let is_first = |(turn, records): &(usize, &Records)| {
            self.records[..*turn].iter().all(|before| before.address != records.address)
        };
        self.records.iter().enumerate().filter(is_first)
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
    ) -> Result<RunStats, RunError> {
        let (trials, started) = (self.trials, Stopwatch::start());
        let lacking = self.missing(store, share)?;
        let samples = |turn: usize, gap: Range<u64>| (gap.end - gap.start) * self.records[turn].samples;
        let left: u64 = lacking.iter().map(|(turn, gap)| samples(*turn, gap.clone())).sum();
        let all = self.distinct().map(|(turn, _)| samples(turn, share.trials(trials, turn)));
        let total = all.sum::<u64>().max(left);
        progress.start("samples", total - left, total);
        let (mut batch_samples, mut made, mut stopped) = (worker.first_batch(), 0, false);
        while_storing(store, |stored| {
            let (mut recipes, mut of) = (vec![], None);
            'points: for (turn, gap) in lacking {
                if of.replace(turn / self.of_point) != Some(turn / self.of_point) {
                    recipes = (self.recipes)(turn / self.of_point)?;
                }
                let recipe: &Arc<dyn Recorded> = &recipes[turn % self.of_point];
                let point = &self.records[turn];
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
                    let sums = worker.sums(&**recipe, batch.clone(), &advance)?;
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
        Ok(RunStats { trials: made, seconds: started.seconds(), stopped, degraded: vec![] })
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
