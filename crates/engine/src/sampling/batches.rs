//! The trials and records that a store lacks, in batches, and their sampling.

use std::collections::{HashMap, HashSet, VecDeque};
use std::ops::Range;
use std::panic::resume_unwind;
use std::sync::Arc;
use std::sync::mpsc::sync_channel;
use std::thread;

use rayon::prelude::*;

use crate::device::{Advance, GpuError, Job, Tallies};
use crate::key::Unrepresentable;
use crate::sampling::{RowEstimates, RunError, RunStats, Worker};
use crate::store::error::StoreError;
use crate::store::{Address, Index, Provenance, Row, Store};
use crate::tally::{Block, Share, base_log2, cover, fold, missing};
use sagnac_base::progress::{Progress, Stopwatch};
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
) -> Result<Vec<RowEstimates>, StoreError> {
    let Some(store) = store else { return Ok(vec![RowEstimates::default(); rows.len()]) };
    let addresses: Vec<Address> = rows.iter().map(|row| of(row).0).collect();
    store.of_totals(&addresses, |at, tally| {
        let (_, bin_base, unit) = of(&rows[at]);
        RowEstimates::new(tally, bin_base, unit)
    })
}

/// A run as the batches that a store lacks, in rounds.
///
/// A driver takes a batch by [`next`](Steps::next), lets a device make it, puts the results into the store, and takes the next one.
/// It may take the next batch before. After the last batch of a round it asks for [`more`](Steps::more).
pub trait Steps: Send {
    /// The amount of this round that was done before it began, and its whole amount, as [`Batch::amount`] counts them.
    fn amounts(&self) -> [u64; 2];

    /// Number of trials that this round lacks.
    fn missing_trials(&self) -> u64;

    /// The next batch of this round.
    ///
    /// # Errors
    /// A point is refused that was proven to fit, which is a fault of the program.
    fn next(&mut self, budget: Budget) -> Result<Option<Batch>, Unrepresentable>;

    /// Begins the next round, where the results of all batches are in the store. Returns whether there is one.
    ///
    /// # Errors
    /// A row of the store is damaged, or the disk fails.
    fn more(&mut self, _store: &Store) -> Result<bool, StoreError> {
        Ok(false)
    }

    /// The unit of [`Batch::amount`].
    fn unit(&self) -> &'static str;

    /// Number of records that make a trial.
    fn records_of_a_trial(&self) -> u64 {
        1
    }
}

/// About how much a batch has.
#[derive(Debug, Clone, Copy)]
pub struct Budget {
    /// Steps of trials, or samples of records.
    pub steps: u64,
    /// The least number of records, which a device makes in parallel.
    pub records: u64,
}

/// A part of what a store lacks, which refers to nothing else.
#[derive(Debug)]
pub enum Batch {
    /// Blocks of trials of launches.
    Trials(Vec<Task>),
    /// Consecutive records.
    Records(RecordsTask),
}

/// A block of the trials of a launch.
#[derive(Debug, Clone)]
pub struct Task {
    addressed: Arc<Addressed>,
    block: Block,
}

/// Consecutive records of a point.
#[derive(Debug, Clone)]
pub struct RecordsTask {
    recipe: Arc<dyn Recorded>,
    of: Records,
    records: Range<u64>,
    /// log2 of the most records of a row of the store.
    largest: u32,
}

/// The results of a batch.
#[derive(Debug)]
pub enum Results {
    /// For each task of trials a tally of each of its estimates.
    Tallies(Tallies),
    /// Sums of records, record by record.
    Sums(Vec<u128>),
}

impl Batch {
    /// Number of trials or records.
    pub fn trials(&self) -> u64 {
        match self {
            Batch::Trials(tasks) => tasks.iter().map(|task| task.block.trials()).sum(),
            Batch::Records(task) => task.records.end - task.records.start,
        }
    }

    /// Number of trials, or of samples of records.
    pub fn amount(&self) -> u64 {
        match self {
            Batch::Trials(_) => self.trials(),
            Batch::Records(task) => self.trials() * task.of.samples,
        }
    }

    /// Lets a device make the batch. `advance` receives parts of its [`amount`](Batch::amount) as they complete.
    ///
    /// # Errors
    /// The device fails, and no threads can be started for the processor to replace it.
    pub fn make(&self, worker: &mut Worker, advance: Advance) -> Result<Results, GpuError> {
        match self {
            Batch::Trials(tasks) => {
                let jobs = tasks.iter().map(|task| Job { launch: &task.addressed.0, block: task.block });
                let jobs: Vec<Job> = jobs.collect();
                Ok(Results::Tallies(worker.tally(&jobs, advance)?))
            }
            Batch::Records(RecordsTask { recipe, of, records, .. }) => {
                let advance = |records| advance(records * of.samples);
                Ok(Results::Sums(worker.sums(&**recipe, records.clone(), &advance)?))
            }
        }
    }

    /// Puts the results of the batch into a store, with how they and those before were made.
    ///
    /// # Errors
    /// The disk fails.
    pub fn put(&self, results: Results, store: &mut Store, made: &Provenance) -> Result<(), StoreError> {
        match (self, results) {
            (Batch::Trials(tasks), Results::Tallies(tallies)) => {
                let rows = tasks.iter().zip(tallies).flat_map(|(task, tallies)| {
                    let addressed = task.addressed.1.iter().zip(tallies);
                    let block = task.block;
                    addressed.map(move |(&address, tally)| Row { address, block, tally })
                });
                store.insert(&rows.collect::<Vec<Row<Moments>>>(), Some(made))
            }
            (Batch::Records(task), Results::Sums(sums)) => {
                store.insert(&task.of.rows(task.records.clone(), task.largest, &sums), Some(made))
            }
            _ => unreachable!("a batch of trials has tallies, and one of records has sums"),
        }
    }
}

/// Takes all steps, round by round, until `progress` stops them. A batch is stored on a thread of its own, while the device makes
/// the next one and the points of the one after that are lowered.
///
/// # Errors
/// The disk or the device fails; all batches that were made before are stored.
pub(crate) fn drive(
    steps: &mut dyn Steps,
    store: &mut Store,
    worker: &mut Worker,
    progress: &dyn Progress,
) -> Result<RunStats, RunError> {
    let (started, mut trials) = (Stopwatch::start(), 0);
    let stopped = loop {
        let [done, all] = steps.amounts();
        progress.start(steps.unit(), done, all);
        let is_complete = while_storing(store, |stored| {
            let mut budget = Budget { steps: worker.first_batch(), records: worker.records_at_once() };
            let mut next = steps.next(budget)?.map(|batch| (batch, budget.steps));
            while let Some((batch, batch_steps)) = next {
                if progress.stops() {
                    return Ok(false);
                }
                let (batch_started, mut following) = (Stopwatch::start(), Ok(None));
                let results = rayon::in_place_scope(|scope| {
                    scope.spawn(|_| following = steps.next(budget));
                    batch.make(worker, &|amount| progress.advance(amount))
                })?;
                trials += batch.trials();
                let made = Provenance { device: worker.name(), trials, seconds: started.seconds() };
                if !stored((batch, results, made)) {
                    return Ok(false);
                }
                next = following?.map(|batch| (batch, budget.steps));
                let factor = (BATCH_SECONDS / batch_started.seconds().max(1e-3)).clamp(0.25, 4.0);
                budget.steps = ((batch_steps as f64 * factor) as u64).max(1);
            }
            Ok(true)
        })?;
        if !is_complete || !steps.more(store)? {
            break !is_complete;
        }
    };
    let trials = trials / steps.records_of_a_trial();
    Ok(RunStats { trials, seconds: started.seconds(), stopped, degraded: vec![] })
}

/// A batch with its results and how they were made.
type Made = (Batch, Results, Provenance);

/// Runs `sample`, whose batches are stored on a thread of their own, and returns when all are stored. Each is handed over after
/// the one before is stored; `false` is returned for one that could not be stored.
///
/// # Errors
/// A batch cannot be stored, or `sample` fails; all that it handed over before are stored.
fn while_storing<R>(
    store: &mut Store,
    sample: impl FnOnce(&mut dyn FnMut(Made) -> bool) -> Result<R, RunError>,
) -> Result<R, RunError> {
    let mut put = |(batch, results, made): Made| batch.put(results, store, &made);
    if cfg!(target_family = "wasm") {
        // A page has no threads.
        let mut stored = Ok(());
        let sampled = sample(&mut |made| {
            stored = put(made);
            stored.is_ok()
        });
        return stored.map_err(RunError::from).and(sampled);
    }
    thread::scope(|scope| {
        // A channel without room: a batch waits while the one before is stored, and no third one is begun.
        let (sender, receiver) = sync_channel(0);
        let stored = scope.spawn(move || receiver.into_iter().try_for_each(put));
        let sampled = sample(&mut |made| sender.send(made).is_ok());
        drop(sender);
        stored.join().unwrap_or_else(|panic| resume_unwind(panic))?;
        sampled
    })
}

/// The trials that a store lacks of launches, in batches.
#[derive(Default)]
pub(crate) struct Trials<'a> {
    work: Vec<Work<'a>>,
    /// The blocks that are left, each with the place of its work, the next one at the end.
    rest: Vec<(usize, Block)>,
    /// The launches of the last batches by the places of their work, at most as many as a batch has jobs.
    launches: HashMap<usize, Arc<Addressed>>,
}

impl<'a> Trials<'a> {
    pub(crate) fn new(work: Vec<Work<'a>>) -> Trials<'a> {
        let blocks = |(place, work): (usize, &Work)| {
            let log2 = MAX_STEPS_LOG2.saturating_sub(work.steps.ilog2());
            let blocks = work.blocks.iter().flat_map(|block| cover(block.first..block.end(), log2));
            blocks.map(|block| (place, block)).collect::<Vec<_>>()
        };
        let mut rest: Vec<(usize, Block)> = work.iter().enumerate().flat_map(blocks).collect();
        interleave(&mut rest);
        rest.reverse();
        Trials { work, rest, launches: HashMap::new() }
    }

    /// Number of missing trials.
    pub(crate) fn missing(&self) -> u64 {
        self.work.iter().map(Work::trials).sum()
    }

    /// The next batch of about so many steps, with at least one block.
    ///
    /// # Errors
    /// A point is refused.
    pub(crate) fn next(&mut self, steps: u64) -> Result<Option<Batch>, Unrepresentable> {
        let (mut batch, mut taken) = (Vec::new(), 0);
        let of = |(place, block): &(usize, Block)| block.trials() * self.work[*place].steps;
        while batch.len() < MAX_JOBS
            && let Some(next) = self.rest.pop_if(|next| taken == 0 || taken + of(next) <= steps)
        {
            taken += of(&next);
            batch.push(next);
        }
        self.make_launches(&batch)?;
        let task = |(place, block)| Task { addressed: self.launches[&place].clone(), block };
        Ok((!batch.is_empty()).then(|| Batch::Trials(batch.into_iter().map(task).collect())))
    }

    /// Makes the launches of a batch that the batches before did not need.
    fn make_launches(&mut self, batch: &[(usize, Block)]) -> Result<(), Unrepresentable> {
        let mut missing = HashSet::new();
        let is_new = |place: &usize| !self.launches.contains_key(place) && missing.insert(*place);
        let new: Vec<usize> = batch.iter().map(|(place, _)| *place).filter(is_new).collect();
        if self.launches.len() + new.len() > MAX_JOBS {
            let needed: HashSet<usize> = batch.iter().map(|(place, _)| *place).collect();
            self.launches.retain(|place, _| needed.contains(place));
        }
        let launch = |&place: &usize| Ok((place, Arc::new((self.work[place].launch)()?)));
        let made = new.par_iter().map(launch).collect::<Result<Vec<_>, Unrepresentable>>()?;
        self.launches.extend(made);
        Ok(())
    }
}

/// Interleaves the blocks of all work, each work in its own order. The work done so far is then representative of the
/// rest, even where trials of different points take different times, and a run that ends early has some trials of every
/// point.
fn interleave(rest: &mut Vec<(usize, Block)>) {
    let mut placed: Vec<(f64, (usize, Block))> = Vec::with_capacity(rest.len());
    for group in rest.chunk_by(|a, b| a.0 == b.0) {
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
pub(crate) type Recipes<'a> =
    Box<dyn Fn(usize) -> Result<Vec<Arc<dyn Recorded>>, Unrepresentable> + Send + 'a>;

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
    /// Number of records that make a trial.
    pub(crate) of_trial: u64,
}

/// The records that a store lacks, in batches.
pub(crate) struct RecordsSteps<'a> {
    wanted: Wanted<'a>,
    /// The missing records, each range with the place of its records.
    rest: VecDeque<(usize, Range<u64>)>,
    /// Missing samples, and all of the share.
    samples: [u64; 2],
    /// Missing records.
    missing: u64,
    /// The recipes of the point of the last batch.
    recipes: Option<(usize, Vec<Arc<dyn Recorded>>)>,
}

impl<'a> Wanted<'a> {
    /// The points in order, without those whose draws and sums are the same as those of an earlier one.
    fn distinct(&self) -> impl Iterator<Item = (usize, &Records)> {
        let is_first = |(turn, records): &(usize, &Records)| {
            self.records[..*turn].iter().all(|before| before.address != records.address)
        };
        self.records.iter().enumerate().filter(is_first)
    }

    /// The records that the store lacks of a share.
    ///
    /// # Errors
    /// A row of the store is damaged, or the disk fails.
    pub(crate) fn steps(self, store: &Store, share: Share) -> Result<RecordsSteps<'a>, StoreError> {
        let index = store.index()?;
        let (mut rest, mut samples, mut missing_records) = (VecDeque::new(), [0, 0], 0);
        for (turn, records) in self.distinct() {
            let trials = share.trials(self.trials, turn);
            samples[1] += (trials.end - trials.start) * records.samples;
            for gap in missing(index.blocks(&records.address)?, trials) {
                samples[0] += (gap.end - gap.start) * records.samples;
                missing_records += gap.end - gap.start;
                rest.push_back((turn, gap));
            }
        }
        samples[1] = samples[1].max(samples[0]);
        Ok(RecordsSteps { wanted: self, rest, samples, missing: missing_records, recipes: None })
    }
}

impl RecordsSteps<'_> {
    fn recipe(&mut self, turn: usize) -> Result<Arc<dyn Recorded>, Unrepresentable> {
        let (point, place) = (turn / self.wanted.of_point, turn % self.wanted.of_point);
        let recipes = match self.recipes.take() {
            Some((of, recipes)) if of == point => recipes,
            _ => (self.wanted.recipes)(point)?,
        };
        let (_, recipes) = self.recipes.insert((point, recipes));
        Ok(recipes[place].clone())
    }
}

impl Steps for RecordsSteps<'_> {
    fn unit(&self) -> &'static str {
        "samples"
    }

    fn amounts(&self) -> [u64; 2] {
        let [left, all] = self.samples;
        [all - left, all]
    }

    fn missing_trials(&self) -> u64 {
        self.missing
    }

    fn records_of_a_trial(&self) -> u64 {
        self.wanted.of_trial
    }

    fn next(&mut self, budget: Budget) -> Result<Option<Batch>, Unrepresentable> {
        let Some((turn, gap)) = self.rest.pop_front() else { return Ok(None) };
        let (recipe, of, largest) =
            (self.recipe(turn)?, self.wanted.records[turn], base_log2(self.wanted.trials));
        let count = (budget.steps / of.samples).max(budget.records);
        // Whole blocks where a batch contains some, smaller ones for very long records.
        let align = 1 << largest.min(count.ilog2());
        let end = gap.end.min((gap.start + count).next_multiple_of(align));
        if end < gap.end {
            self.rest.push_front((turn, end..gap.end));
        }
        Ok(Some(Batch::Records(RecordsTask { recipe, of, records: gap.start..end, largest })))
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
