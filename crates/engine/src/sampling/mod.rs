//! Sampling of the trials that a store lacks: the plan of a study, the estimates that it finds, and a device whose failures do not
//! end a run.

pub(crate) mod batches;

use std::fmt;
use std::ops::Range;
use std::sync::{Mutex, MutexGuard, PoisonError};

use crate::chart::{Chart, Source};
use crate::device::gpu::Gpu;
use crate::device::select::reopen;
use crate::device::{Advance, Cpu, Device, GpuError, Job, RetryProgress, Tallies};
use crate::key::{Unrepresentable, shown};
use crate::sampling::batches::Steps;
use crate::store::error::StoreError;
use crate::store::{Index, Store};
use crate::tally::{Estimates, Id, NORMAL_95, Quantile, Share, z_score};
use sagnac_base::diagnostics::StudyError;
use sagnac_base::progress::Progress;
use sagnac_base::table::column::Band;
use sagnac_base::table::{Cell, Table};
use sagnac_kernel::curve::Recorded;
use sagnac_kernel::moments::Moments;
use sagnac_kernel::width::Width;

/// Why a run ended early. Results computed before are in the store.
#[derive(Debug, thiserror::Error)]
pub enum RunError {
    /// The results folder failed.
    #[error(transparent)]
    Store(#[from] StoreError),
    /// The device failed and could not be replaced.
    #[error(transparent)]
    Gpu(#[from] GpuError),
    /// A point was refused that was lowered before, on another machine; or its closed form is not that of its inputs.
    #[error(transparent)]
    Refused(#[from] Unrepresentable),
}

/// The outcome of a run.
#[derive(Debug, Clone, PartialEq)]
pub struct RunStats {
    /// Trials sampled over all points.
    pub trials: u64,
    /// Duration of the run, s.
    pub seconds: f64,
    /// Whether it ended early, as [`Progress::stops`] requested.
    pub stopped: bool,
    /// Deviations from the requested execution, each a sentence.
    pub degraded: Vec<String>,
}

/// The plan of a study; `None` if progress asked to stop before all points were lowered.
pub(crate) type Planned<'a> = Result<Option<Box<dyn Plan + 'a>>, StudyError>;

/// The plan of a study of any kind.
pub trait Plan: fmt::Debug {
    /// The steps that sample the trials which the store lacks of a share.
    ///
    /// # Errors
    /// A row of the store is damaged, or the disk fails.
    fn steps<'p>(&'p self, store: &Store, share: Share) -> Result<Box<dyn Steps + 'p>, StoreError>;

    /// Stores what a share keeps besides tallies, after its trials.
    ///
    /// # Errors
    /// The disk fails.
    fn keep(&self, _store: &mut Store, _share: Share) -> Result<(), RunError> {
        Ok(())
    }

    /// The amount of missing results that [`keep`](Plan::keep) would store.
    ///
    /// # Errors
    /// A row of the store is damaged, or the disk fails.
    fn lacks_kept(&self, _store: &Store, _share: Share) -> Result<u64, StoreError> {
        Ok(0)
    }

    /// The tables of everything that the store holds; without a store, all rows without estimates.
    ///
    /// # Errors
    /// A row of the store is damaged, or the disk fails.
    fn tables(&self, store: Option<&Store>, progress: &dyn Progress) -> Result<Tables, RunError>;

    /// Number of trials of every estimate, where it is the same for all.
    ///
    /// # Errors
    /// A row of the store is damaged, or the disk fails.
    fn held(&self, index: &Index) -> Result<Option<u64>, StoreError>;

    /// The identities of all points.
    fn ids(&self) -> Vec<Id>;

    /// Notes attached to the results, each a sentence.
    ///
    /// # Errors
    /// A row of the store is damaged, or the disk fails.
    fn notes(&self, store: &Store) -> Result<Vec<String>, StoreError>;

    /// Number of steps of one trial of every point, where trials are of any number; `None` where shares have whole records.
    fn steps_of_a_trial(&self) -> Option<u64> {
        None
    }

    /// Number of trials of all points together.
    fn all_trials(&self) -> u64;

    /// Why points have more trials than the study requests.
    fn surplus(&self) -> &'static str {
        "the folder holds them already"
    }
}

/// The results of a study, as tables.
#[derive(Debug, Clone, PartialEq)]
pub struct Tables {
    /// Table of the points, `points.csv`.
    pub points: Table,
    /// Table of the coefficients, `coefficients.csv`, where coefficients are fitted.
    pub coefficients: Option<Table>,
    /// Table of trajectories, `trajectories.csv`, where some are kept.
    pub trajectories: Option<Table>,
}

impl Tables {
    /// All tables, each with its source.
    pub fn all(&self) -> impl Iterator<Item = (Source, &Table)> {
        let coefficients = self.coefficients.as_ref().map(|table| (Source::Coefficients, table));
        let trajectories = self.trajectories.as_ref().map(|table| (Source::Trajectories, table));
        std::iter::once((Source::Points, &self.points)).chain(coefficients).chain(trajectories)
    }

    /// All tables with the names of their files, that of the first of these charts before the others.
    pub fn into_files(self, charts: &[Chart]) -> Vec<(&'static str, Table)> {
        let first = charts.first().map_or(Source::Points, |chart| chart.source);
        let all = [
            (Source::Points, Some(self.points)),
            (Source::Coefficients, self.coefficients),
            (Source::Trajectories, self.trajectories),
        ];
        let mut all: Vec<_> =
            all.into_iter().filter_map(|(source, table)| Some((source.file(), table?))).collect();
        all.sort_by_key(|(file, _)| *file != first.file());
        all
    }

    /// The tables with the names of their files, in any order.
    pub fn from_files(files: Vec<(&'static str, Table)>) -> Tables {
        let mut tables = Tables::of_points(Table::default());
        for (file, table) in files {
            match file {
                _ if file == Source::Coefficients.file() => tables.coefficients = Some(table),
                _ if file == Source::Trajectories.file() => tables.trajectories = Some(table),
                _ => tables.points = table,
            }
        }
        tables
    }

    /// Tables that consist of the points only.
    pub(crate) fn of_points(points: Table) -> Tables {
        Tables { points, coefficients: None, trajectories: None }
    }

    /// The table for a source.
    pub fn of(&self, source: Source) -> &Table {
        self.all().find(|(known, _)| *known == source).map_or(&self.points, |(_, table)| table)
    }
}

/// Meanings of the columns that every such table has.
pub(crate) const RMS_SE: &str =
    "Standard error (1 σ) of `rms`; 0 where every trial has the same error. The 95 % band is ±1.96 of these.";
pub(crate) const LEVEL_LOWER: &str =
    "Lower end of the 95 % interval of `p99_73`; blank where the trials cannot bound it.";
pub(crate) const LEVEL_UPPER: &str =
    "Upper end of the 95 % interval of `p99_73`; blank where the trials cannot bound it.";
pub(crate) const Z: &str = "Deviation of `rms` from `theory_rms` in standard errors; beyond ±5 something is wrong. Blank without a closed form.";

pub(crate) const REPRESENTATION: &str = "Relative difference of `theory_rms`, that of the integers that are sampled, from the closed form of the inputs, \
     which shares no computed number with them. What exceeds the proven bound of rounding is refused. Blank without a closed form, and where rounding explains the whole value.";

/// The relative difference of two closed forms: of what is sampled, and of the inputs; `None` for values that rounding
/// explains altogether.
pub(crate) fn representation(sampled: Option<f64>, inputs: Option<f64>, rounding: f64) -> Option<f64> {
    let (sampled, inputs) = (sampled?, inputs?);
    (inputs.abs() > rounding).then(|| sampled / inputs - 1.0)
}

/// Checks that closed forms of the sampled integers and of the inputs, ″, differ by no more than the rounding of words.
///
/// # Errors
/// They do, which is a fault of the program; `what` is estimated, and `key` is named.
pub(crate) fn check_representation(
    key: &'static str,
    what: &str,
    [words, inputs]: [f64; 2],
    most: f64,
) -> Result<(), Unrepresentable> {
    if (words - inputs).abs() <= most {
        return Ok(());
    }
    let found = format!(
        "{what} is {}″ rms for the integers that would be sampled and {}″ rms for the inputs, more apart than \
         the {}″ that rounding explains",
        shown(words),
        shown(inputs),
        shown(most)
    );
    Err(Unrepresentable::new(key, found, "this is a fault of the program: please report the study"))
}

/// The trials of a row and the estimates from them, which are absent before anything is sampled.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct RowEstimates {
    pub(crate) trials: u64,
    pub(crate) estimates: Option<Estimates>,
}

impl RowEstimates {
    /// What a tally gives whose histogram starts at level `bin_base`, with `unit` as the size of one unit of it.
    pub(crate) fn new(tally: &Moments, bin_base: u32, unit: f64) -> RowEstimates {
        RowEstimates { trials: tally.count, estimates: Estimates::new(tally, bin_base, unit) }
    }

    pub(crate) fn value(&self, of: fn(&Estimates) -> f64) -> Option<f64> {
        self.estimates.as_ref().map(of)
    }

    pub(crate) fn cell(&self, of: fn(&Estimates) -> f64) -> Cell {
        self.value(of).into()
    }

    pub(crate) fn rms_se(&self) -> Option<f64> {
        self.estimates?.rms_se
    }

    /// The 99.73 % level.
    pub(crate) fn level(&self, of: fn(&Quantile) -> Option<f64>) -> Option<f64> {
        of(&self.estimates?.p99_73?)
    }

    /// The 95 % interval of the mean.
    pub(crate) fn mean_band(&self) -> Band {
        let Estimates { mean, rms, .. } = self.estimates?;
        let variance = (rms * rms - mean * mean).max(0.0);
        let half = NORMAL_95
            * libm::sqrt(variance / self.trials.checked_sub(1).filter(|&others| others > 0)? as f64);
        Some((mean - half, mean + half))
    }

    pub(crate) fn rms_band(&self) -> Band {
        let (rms, half) = (self.estimates?.rms, NORMAL_95 * self.rms_se()?);
        Some((rms - half, rms + half))
    }

    pub(crate) fn level_band(&self) -> Band {
        self.level(|q| q.low).zip(self.level(|q| q.high))
    }

    /// The deviation of the rms from its closed form in standard errors.
    pub(crate) fn z(&self, theory: Option<f64>, rounding: f64) -> Option<f64> {
        z_score(self.estimates?.rms, theory?, self.rms_se()?, rounding)
    }
}

/// Number of times that a lost device is opened again; one lost in batch after batch is unusable.
const MAX_LOSSES: u32 = 3;

/// A device whose failures do not end a run.
///
/// Out of memory, it continues with smaller tiles. If it is lost, it is opened again, must pass its self-test and
/// repeats the batch. If that does not help, at its fourth loss, or if it refuses the work, it leaves its group, or, as
/// the last or only device, is replaced by the processor permanently.
pub struct Worker<'a> {
    device: &'a mut Device,
    notes: Notes<'a>,
    /// The processor, for records that are too long for the device.
    beside: Option<Cpu>,
    /// Names of all devices that have worked.
    names: Vec<String>,
}

impl<'a> Worker<'a> {
    /// `progress` receives a note about each failure at once.
    pub fn new(device: &'a mut Device, progress: &'a dyn Progress) -> Worker<'a> {
        let names = vec![device.name()];
        Worker { device, notes: Notes { progress, said: Mutex::default() }, beside: None, names }
    }

    /// Name for the provenance of rows.
    pub(crate) fn name(&self) -> String {
        self.names.join(" and ")
    }

    /// Steps of trials, or samples of records, of the first batch.
    pub(crate) fn first_batch(&self) -> u64 {
        self.device.first_batch()
    }

    /// Number of records that the device makes in parallel.
    pub(crate) fn records_at_once(&self) -> u64 {
        self.device.records_at_once()
    }

    /// The failures, each kind as one sentence.
    pub fn into_notes(self) -> Vec<String> {
        self.notes.said().clone()
    }

    /// Tallies of each job, in order. `advance` receives numbers of trials as they complete, each trial once.
    ///
    /// # Errors
    /// The device fails, and no threads can be started for the processor to replace it.
    pub fn tally(&mut self, jobs: &[Job], advance: Advance) -> Result<Tallies, GpuError> {
        let attempts = RetryProgress::new(advance);
        let notes = &self.notes;
        let tally = |device: &mut Device, jobs: &[Job], progress: Advance| {
            notes.persist(device, Gpu::halve_tiles, progress, |device, progress| {
                device.tally(jobs, true, progress)
            })
        };
        let tallied = match &mut *self.device {
            Device::Group(group) => group.tally(jobs, &attempts.next(), &tally),
            one => tally(one, jobs, &attempts.next()),
        };
        self.say_left();
        tallied.or_else(|error| {
            self.replace(&error)?;
            self.device.tally(jobs, true, &attempts.next())
        })
    }

    /// The sums of some records, one after the other. `advance` receives numbers of records as they complete, each
    /// record once.
    ///
    /// # Errors
    /// The device fails, and no threads can be started for the processor to replace it.
    pub(crate) fn sums(
        &mut self,
        recipe: &dyn Recorded,
        records: Range<u64>,
        advance: Advance,
    ) -> Result<Vec<u128>, GpuError> {
        let attempts = RetryProgress::new(advance);
        let notes = &self.notes;
        let sums = |device: &mut Device, records: Range<u64>, progress: Advance| {
            let count = (records.end - records.start) as usize;
            let made = notes.persist(device, Gpu::halve_batches, progress, |device, progress| {
                device.sums(recipe, records.start, count, progress)
            });
            if let Err(error @ GpuError::TooLong { .. }) = &made {
                notes.say_once(format!(
                    "records of {} samples were made on the CPU: {error}",
                    recipe.curve().samples
                ));
            }
            made
        };
        let made = match &mut *self.device {
            Device::Group(group) => {
                group.sums(u64::from(recipe.curve().samples), records.clone(), &attempts.next(), &sums)
            }
            one => sums(one, records.clone(), &attempts.next()),
        };
        self.say_left();
        made.or_else(|error| {
            let count = (records.end - records.start) as usize;
            if let GpuError::TooLong { .. } = error {
                let cpu = self.processor(&error)?;
                return Ok(self.beside.insert(cpu).sums(recipe, records.start, count, &attempts.next()));
            }
            self.replace(&error)?;
            self.device.sums(recipe, records.start, count, &attempts.next())
        })
    }

    /// Says which members have left a group.
    fn say_left(&mut self) {
        if let Device::Group(group) = &mut *self.device {
            group.take_left().into_iter().for_each(|sentence| self.notes.say(sentence));
        }
    }

    /// Replaces the device by the processor for the rest of the run.
    fn replace(&mut self, error: &GpuError) -> Result<(), GpuError> {
        let (cpu, failed) = (Device::Cpu(self.processor(error)?), self.device.name());
        self.notes.say(format!("{failed}: {error}; from here on {} computes", cpu.name()));
        *self.device = cpu;
        Ok(())
    }

    /// The processor, the one beside the device where there is one, or `error` where it can start no threads.
    fn processor(&mut self, error: &GpuError) -> Result<Cpu, GpuError> {
        if let Some(cpu) = self.beside.take() {
            return Ok(cpu);
        }
        let cpu = Cpu::new(Width::widest(), self.device.threads()).map_err(|_| error.clone())?;
        self.names.push(cpu.name());
        Ok(cpu)
    }
}

/// The failures of a run.
struct Notes<'a> {
    progress: &'a dyn Progress,
    /// Each kind as one sentence.
    said: Mutex<Vec<String>>,
}

impl Notes<'_> {
    fn said(&self) -> MutexGuard<'_, Vec<String>> {
        self.said.lock().unwrap_or_else(PoisonError::into_inner)
    }

    fn say(&self, sentence: String) {
        self.progress.note(&sentence);
        let mut said = self.said();
        if !said.contains(&sentence) {
            said.push(sentence);
        }
    }

    fn say_once(&self, sentence: String) {
        if !self.said().contains(&sentence) {
            self.say(sentence);
        }
    }

    /// Repeats some work on a device that is not a group until it succeeds, or until repeating does not help.
    fn persist<T>(
        &self,
        device: &mut Device,
        halve: fn(&mut Gpu) -> bool,
        advance: Advance,
        work: impl Fn(&mut Device, Advance) -> Result<T, GpuError>,
    ) -> Result<T, GpuError> {
        let attempts = RetryProgress::new(advance);
        let (mut was_lost, mut was_short) = (false, false);
        loop {
            let error = match work(device, &attempts.next()) {
                Err(error) if !matches!(error, GpuError::TooLong { .. }) => error,
                result => return result,
            };
            let Device::Gpu(gpu) = &mut *device else { return Err(error) };
            match error {
                GpuError::OutOfMemory if halve(gpu) => {
                    // Reported once, although several halvings may be needed.
                    if !was_short {
                        self.say(format!("{} is out of memory: it continues with smaller tiles", gpu.name()));
                    }
                    was_short = true;
                }
                GpuError::Lost(why) if !was_lost && gpu.losses < MAX_LOSSES => {
                    was_lost = true;
                    gpu.losses += 1;
                    let again = reopen(gpu).map_err(|error| {
                        GpuError::Lost(format!("{why}, then {}", error.to_string().replace('\n', "; ")))
                    });
                    *device = again?;
                    self.say(format!(
                        "{}: {}; it was opened again, passed its self-test and continues",
                        device.name(),
                        GpuError::Lost(why)
                    ));
                }
                error => return Err(error),
            }
        }
    }
}
