//! The device of a run, replaced by the processor, which gives the same bits, if it fails.

use std::ops::Range;
use std::sync::atomic::{AtomicU64, Ordering};

use crate::device::cpu::Cpu;
use crate::device::error::GpuError;
use crate::device::gpu::Gpu;
use crate::device::select::reopen;
use crate::device::{Advance, Device, Job, Tallies};
use crate::kernel::recipe::Recipe;
use crate::kernel::width::Width;
use crate::progress::Progress;

/// Number of times that a lost device is opened again; one lost in batch after batch is unusable.
const MOST_LOSSES: u32 = 3;

/// A device whose failures do not end a run.
///
/// Out of memory, it continues with smaller tiles. If it is lost, it is opened again, must pass its self-test and
/// repeats the batch. If that does not help, at its fourth loss, or if it refuses the work, the processor replaces it
/// permanently.
pub(crate) struct Worker<'a> {
    device: &'a mut Device,
    progress: &'a dyn Progress,
    /// The processor, for records that are too long for the device.
    beside: Option<Cpu>,
    /// Number of losses of the device.
    losses: u32,
    /// Names of all devices that have worked.
    names: Vec<String>,
    notes: Vec<String>,
}

impl<'a> Worker<'a> {
    /// `progress` receives a note about each failure at once.
    pub(crate) fn new(device: &'a mut Device, progress: &'a dyn Progress) -> Worker<'a> {
        let names = vec![device.name()];
        Worker { device, progress, beside: None, losses: 0, names, notes: vec![] }
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
    pub(crate) fn into_notes(self) -> Vec<String> {
        self.notes
    }

    /// Tallies of each job, in order. `advance` receives numbers of trials as they complete, each trial once.
    ///
    /// # Errors
    /// The device fails, and no threads can be started for the processor to replace it.
    pub(crate) fn tally(&mut self, jobs: &[Job], advance: Advance) -> Result<Tallies, GpuError> {
        self.persist(Gpu::halve_tiles, advance, |device, progress| device.tally(jobs, true, progress))
    }

    /// The sums of some records, one after the other. `advance` receives numbers of records as they complete, each
    /// record once.
    ///
    /// # Errors
    /// The device fails, and no threads can be started for the processor to replace it.
    pub(crate) fn sums(
        &mut self,
        recipe: &Recipe,
        records: Range<u64>,
        advance: Advance,
    ) -> Result<Vec<u128>, GpuError> {
        let (first, count) = (records.start, (records.end - records.start) as usize);
        let made = self.persist(Gpu::halve_batches, advance, |device, progress| {
            device.sums(recipe, first, count, progress)
        });
        let Err(error @ GpuError::TooLong { .. }) = made else { return made };
        let cpu = self.processor(&error)?;
        let why = format!("records of {} samples were made on the CPU: {error}", recipe.samples);
        if !self.notes.contains(&why) {
            self.say(why);
        }
        Ok(self.beside.insert(cpu).sums(recipe, first, count, advance))
    }

    /// Repeats some work until it succeeds.
    fn persist<T>(
        &mut self,
        halve: fn(&mut Gpu) -> bool,
        advance: Advance,
        work: impl Fn(&mut Device, Advance) -> Result<T, GpuError>,
    ) -> Result<T, GpuError> {
        let told = AtomicU64::new(0);
        let (mut was_lost, mut was_short) = (false, false);
        loop {
            let done = AtomicU64::new(0);
            // Work that a failed attempt had already reported is not reported again.
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
                    // Reported once, although several halvings may be needed.
                    if !was_short {
                        self.say(format!("{name} is out of memory: it continues with smaller tiles"));
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
                self.say(format!("{name}: {lost}; it was opened again, passed its self-test and continues"));
                Ok(())
            }
            Err(error) => {
                let error = error.to_string().replace('\n', "; ");
                self.replace(lost, &format!("{lost}, then {error}"))
            }
        }
    }

    /// Replaces the device by the processor for the rest of the run.
    fn replace(&mut self, error: &GpuError, why: &str) -> Result<(), GpuError> {
        let (cpu, failed) = (Device::Cpu(self.processor(error)?), self.device.name());
        self.say(format!("{failed}: {why}; from here on {} computes", cpu.name()));
        *self.device = cpu;
        Ok(())
    }

    /// The processor, the one beside the device where there is one, or `error` where it can start no threads.
    fn processor(&mut self, error: &GpuError) -> Result<Cpu, GpuError> {
        if let Some(cpu) = self.beside.take() {
            return Ok(cpu);
        }
        let threads = match &*self.device {
            Device::Gpu(gpu) => gpu.threads,
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
