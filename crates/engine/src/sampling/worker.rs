//! The device of a run, replaced by the processor, which gives the same bits, if it fails.

use std::ops::Range;
use std::sync::{Mutex, MutexGuard, PoisonError};

use crate::device::attempts::Attempts;
use crate::device::cpu::Cpu;
use crate::device::error::GpuError;
use crate::device::gpu::Gpu;
use crate::device::select::reopen;
use crate::device::{Advance, Device, Job, Tallies};
use sagnac_base::progress::Progress;
use sagnac_kernel::curve::Recorded;
use sagnac_kernel::width::Width;

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
        let attempts = Attempts::new(advance);
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
        let attempts = Attempts::new(advance);
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
        let attempts = Attempts::new(advance);
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
