//! Who does the work of a run: its device, as long as that does not fail, else the processor with the same bits.

use std::ops::Range;
use std::sync::atomic::{AtomicU64, Ordering};

use crate::device::cpu::Cpu;
use crate::device::error::GpuError;
use crate::device::gpu::Gpu;
use crate::device::select::reopen;
use crate::device::{Device, Job};
use crate::kernel::moments::Moments;
use crate::kernel::recipe::Recipe;
use crate::kernel::width::Width;
use crate::progress::Progress;

/// How often a device that is lost is opened again: one that is lost in batch after batch is no good.
const MOST_LOSSES: u32 = 3;

/// A device whose failures end no run.
///
/// Out of memory, it goes on with smaller tiles. Lost, it is opened again, has to pass its self-test and does the batch once
/// more. Where that does not help, at its fourth loss, and where it refuses, the processor takes its place for good.
pub(crate) struct Worker<'a> {
    device: &'a mut Device,
    progress: &'a dyn Progress,
    /// For records that are too long for the device.
    beside: Option<Cpu>,
    /// How often the device was lost.
    losses: u32,
    /// All that have worked.
    names: Vec<String>,
    notes: Vec<String>,
}

impl<'a> Worker<'a> {
    /// `progress` hears at once of what goes wrong.
    pub(crate) fn new(device: &'a mut Device, progress: &'a dyn Progress) -> Worker<'a> {
        let names = vec![device.name()];
        Worker { device, progress, beside: None, losses: 0, names, notes: vec![] }
    }

    /// For the provenance of rows.
    pub(crate) fn name(&self) -> String {
        self.names.join(" and ")
    }

    /// Records that it makes in the time of one.
    pub(crate) fn records_at_once(&self) -> u64 {
        self.device.records_at_once()
    }

    /// What went wrong, each kind in a sentence.
    pub(crate) fn into_notes(self) -> Vec<String> {
        self.notes
    }

    /// Tallies of each job, in order; `advance` hears of trials as they are done, of each once.
    ///
    /// # Errors
    /// The device fails, and the processor has no threads to take its place.
    pub(crate) fn tally(
        &mut self,
        jobs: &[Job],
        advance: &(dyn Fn(u64) + Sync),
    ) -> Result<Vec<Vec<Moments>>, GpuError> {
        self.persist(Gpu::halve_tiles, advance, |device, progress| device.tally(jobs, true, progress))
    }

    /// The sums of some records, one after the other; `advance` hears of records as they are made, of each once.
    ///
    /// # Errors
    /// The device fails, and the processor has no threads to take its place.
    pub(crate) fn sums(
        &mut self,
        recipe: &Recipe,
        records: Range<u64>,
        advance: &(dyn Fn(u64) + Sync),
    ) -> Result<Vec<u128>, GpuError> {
        let (first, count) = (records.start, (records.end - records.start) as usize);
        let made = self.persist(Gpu::halve_batches, advance, |device, progress| {
            device.sums(recipe, first, count, progress)
        });
        let Err(error @ GpuError::TooLong { .. }) = made else { return made };
        let cpu = match self.beside.take() {
            Some(cpu) => cpu,
            None => self.processor(&error)?,
        };
        let why = format!("records of {} samples were made on the CPU: {error}", recipe.samples);
        if !self.notes.contains(&why) {
            self.say(why);
        }
        Ok(self.beside.insert(cpu).sums(recipe, first, count, advance))
    }

    /// Does some work until it succeeds.
    fn persist<T>(
        &mut self,
        halve: fn(&mut Gpu) -> bool,
        advance: &(dyn Fn(u64) + Sync),
        work: impl Fn(&mut Device, &(dyn Fn(u64) + Sync)) -> Result<T, GpuError>,
    ) -> Result<T, GpuError> {
        let told = AtomicU64::new(0);
        let (mut was_lost, mut was_short) = (false, false);
        loop {
            let done = AtomicU64::new(0);
            // What a failed attempt had done is not told again.
            let progress = |more: u64| {
                let done = done.fetch_add(more, Ordering::Relaxed) + more;
                let before = told.fetch_max(done, Ordering::Relaxed);
                if done > before {
                    advance(done - before);
                }
            };
            let error = match work(self.device, &progress) {
                Err(error) if !matches!(error, GpuError::TooLong { .. }) => error,
                result => return result,
            };
            let Device::Gpu(gpu) = &mut *self.device else { return Err(error) };
            match error {
                GpuError::OutOfMemory if halve(gpu) => {
                    let name = gpu.name().to_owned();
                    // Once, though it may take several halvings.
                    if !was_short {
                        self.say(format!("{name} is out of memory: it goes on with smaller tiles"));
                    }
                    was_short = true;
                }
                GpuError::Lost(_) if !was_lost && self.losses < MOST_LOSSES => {
                    was_lost = true;
                    self.losses += 1;
                    self.open_again(&error)?;
                }
                error => self.replace(&error, &error.to_string())?,
            }
        }
    }

    /// Opens a lost device again, or replaces it.
    fn open_again(&mut self, lost: &GpuError) -> Result<(), GpuError> {
        let Device::Gpu(gpu) = &*self.device else { return Ok(()) };
        match reopen(gpu) {
            Ok(device) => {
                *self.device = device;
                let name = self.device.name();
                self.say(format!("{name}: {lost}; it was opened again, passed its self-test and goes on"));
                Ok(())
            }
            Err(error) => {
                let error = error.to_string().replace('\n', "; ");
                self.replace(lost, &format!("{lost}, then {error}"))
            }
        }
    }

    /// Lets the processor do the rest.
    fn replace(&mut self, error: &GpuError, why: &str) -> Result<(), GpuError> {
        let cpu = match self.beside.take() {
            Some(cpu) => cpu,
            None => self.processor(error)?,
        };
        let (failed, cpu) = (self.device.name(), Device::Cpu(cpu));
        self.say(format!("{failed}: {why}; from here on {} computes", cpu.name()));
        *self.device = cpu;
        Ok(())
    }

    /// The processor, or what it is needed for where it has no threads.
    fn processor(&mut self, error: &GpuError) -> Result<Cpu, GpuError> {
        let threads = match &*self.device {
            Device::Gpu(gpu) => gpu.threads(),
            Device::Cpu(_) => 0,
        };
        let cpu = Cpu::new(Width::widest(), threads).map_err(|_| error.clone())?;
        self.names.push(cpu.name());
        Ok(cpu)
    }

    fn say(&mut self, sentence: String) {
        self.progress.note(&sentence);
        if !self.notes.contains(&sentence) {
            self.notes.push(sentence);
        }
    }
}
