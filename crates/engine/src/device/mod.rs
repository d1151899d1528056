//! The processor and GPUs, on which the kernels give the same bits; their jobs, errors and loads for tests.

#[cfg_attr(not(feature = "gpu"), path = "no_gpu.rs")]
pub mod gpu;
pub mod group;
pub mod remote;
pub mod samples;
pub mod select;
pub(crate) mod tile;

use core::ops::Range;
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};

use rayon::prelude::*;

use crate::device::group::Group;
use crate::tally::Block;
use sagnac_kernel::curve::Recorded;
use sagnac_kernel::launch::Launch;
use sagnac_kernel::map::Map;
use sagnac_kernel::moments::{Moments, Trials};
use sagnac_kernel::width::Width;

/// Receives numbers of trials or records as they complete.
pub(crate) type Advance<'a> = &'a (dyn Fn(u64) + Sync);

/// Tallies of jobs, in their order: one for each estimate of a job.
pub type Tallies = Vec<Vec<Moments>>;

/// Trials to be tallied: one block of a launch.
#[derive(Debug, Clone, Copy)]
pub struct Job<'a> {
    /// The launch to sample, in fixed point.
    pub launch: &'a Launch,
    /// The trials.
    pub block: Block,
}

/// A device that runs the kernels.
pub enum Device {
    /// The processor, which runs kernels in lanes on threads.
    Cpu(crate::device::Cpu),
    /// A GPU, which runs kernels as shaders.
    Gpu(Box<crate::device::gpu::Gpu>),
    /// A device elsewhere, which takes shaders and words.
    Remote(remote::Remote),
    /// Several of them, which share the work by their measured speed.
    Group(Group),
}

impl Device {
    /// This device and another one, which share the work by their measured speed.
    pub fn and(self, other: Device) -> Device {
        Device::Group(Group::new([self, other].into_iter().flat_map(Device::into_devices).collect()))
    }

    /// The devices of a group, or this one.
    pub fn into_devices(self) -> Vec<Device> {
        match self {
            Device::Group(group) => group.into_devices(),
            one => vec![one],
        }
    }

    /// Name in messages and provenance.
    pub fn name(&self) -> String {
        match self {
            Device::Cpu(cpu) => cpu.name(),
            Device::Gpu(gpu) => gpu.name().to_owned(),
            Device::Remote(remote) => remote.name(),
            Device::Group(group) => group.devices().map(Device::name).collect::<Vec<_>>().join(" and "),
        }
    }

    /// Tallies of each job, in order. `progress` receives numbers of trials as they complete.
    ///
    /// # Errors
    /// A GPU is lost, refuses the work or is out of memory; no results of the jobs are kept. In a group the last device
    /// fails; those that failed before have left it, and the others have done their parts.
    pub fn tally(&mut self, jobs: &[Job], histogram: bool, progress: Advance) -> Result<Tallies, GpuError> {
        match self {
            Device::Cpu(cpu) => Ok(cpu.tally(jobs, histogram, progress)),
            Device::Gpu(gpu) => gpu.tally(jobs, histogram, progress),
            Device::Remote(remote) => remote.tally(jobs, histogram, progress),
            Device::Group(group) => {
                group.tally(jobs, progress, &|device, jobs, progress| device.tally(jobs, histogram, progress))
            }
        }
    }

    /// Sums of the squared differences of some records: record by record, and within a record by the places of the
    /// curve. `progress` receives numbers of records as they complete.
    ///
    /// # Errors
    /// A GPU is lost, refuses the work or is out of memory, or a record is too long for it
    /// ([`TooLong`](GpuError::TooLong)); the CPU can make such a record, and does in a group.
    pub fn sums(
        &mut self,
        recipe: &dyn Recorded,
        first: u64,
        count: usize,
        progress: Advance,
    ) -> Result<Vec<u128>, GpuError> {
        match self {
            Device::Cpu(cpu) => Ok(cpu.sums(recipe, first, count, progress)),
            Device::Gpu(gpu) => gpu.sums(recipe, first, count, progress),
            Device::Remote(remote) => remote.sums(recipe, first, count, progress),
            Device::Group(group) => {
                let records = first..first + count as u64;
                group.sums(
                    u64::from(recipe.curve().samples),
                    records,
                    progress,
                    &|device, records, progress| {
                        let count = (records.end - records.start) as usize;
                        device.sums(recipe, records.start, count, progress)
                    },
                )
            }
        }
    }

    /// Threads of the processor where it has to replace the device; 0 means all logical cores.
    pub(crate) fn threads(&self) -> usize {
        match self {
            Device::Cpu(_) | Device::Remote(_) => 0,
            Device::Gpu(gpu) => gpu.threads,
            Device::Group(group) => group.devices().map(Device::threads).max().unwrap_or(0),
        }
    }

    /// Number of records that the device makes in parallel.
    pub fn records_at_once(&self) -> u64 {
        match self {
            Device::Cpu(cpu) => cpu.records_at_once(),
            Device::Gpu(gpu) => gpu.records_at_once(),
            Device::Remote(_) => remote::RECORDS,
            Device::Group(group) => group.devices().map(Device::records_at_once).sum(),
        }
    }

    /// Steps of trials, or samples of records, with which a run begins; timing tells how many the device takes.
    pub(crate) fn first_batch(&self) -> u64 {
        match self {
            Device::Cpu(_) => 1 << 20,
            Device::Gpu(gpu) => gpu.first_batch(),
            Device::Remote(_) => remote::STEPS,
            Device::Group(group) => group.devices().map(Device::first_batch).sum(),
        }
    }

    /// The results of a building block for a list of items, in a group those of its first device.
    ///
    /// # Errors
    /// A GPU is lost, refuses the work or is out of memory.
    pub fn map(&mut self, map: &Map, items: &[u32]) -> Result<Vec<u32>, GpuError> {
        match self {
            Device::Cpu(cpu) => Ok((map.cpu)(cpu.width(), items)),
            Device::Gpu(gpu) => gpu.map(map, items),
            Device::Remote(remote) => remote.map(map, items),
            Device::Group(group) => group.first().map(map, items),
        }
    }
}

/// Attempts at the same work, which report each of its units once.
pub(crate) struct RetryProgress<'a> {
    progress: Advance<'a>,
    /// Most units that an attempt has reported.
    told: AtomicU64,
}

impl<'a> RetryProgress<'a> {
    pub(crate) fn new(progress: Advance<'a>) -> RetryProgress<'a> {
        RetryProgress { progress, told: AtomicU64::new(0) }
    }

    /// The progress of the next attempt. Units that an earlier one has reported are not reported again.
    pub(crate) fn next(&self) -> impl Fn(u64) + Sync {
        let done = AtomicU64::new(0);
        move |more| {
            let done = done.fetch_add(more, Ordering::Relaxed) + more;
            let before = self.told.fetch_max(done, Ordering::Relaxed);
            if done > before {
                (self.progress)(done - before);
            }
        }
    }
}

/// Why a device cannot be used, or no longer.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum GpuError {
    /// The device cannot be opened, with the message of the driver.
    #[error("cannot open the device: {0}")]
    Open(String),
    /// The device is gone, as after a watchdog or an unplugged adapter, with the message of the driver. Earlier tallies
    /// are intact.
    #[error("the device was lost: {0}")]
    Lost(String),
    /// The driver does not return from compiling a shader. The thread that waits for it is left behind.
    #[error("its driver did not compile a shader within 5 minutes")]
    Stuck,
    /// The device has too little memory for the work at hand.
    #[error("the device is out of memory")]
    OutOfMemory,
    /// The device rejects a shader or a buffer, with the message of the validation.
    #[error("the device refused the work: {0}")]
    Refused(String),
    /// The device computes other bits than the CPU on the first work of a shader.
    #[error("it computes other bits than the CPU: update its driver")]
    WrongBits,
    /// A record does not fit into the buffers; the CPU can make it.
    #[error(
        "a record needs {bytes} bytes on the device, of {most}: shorten the longest averaging time, or overlap = \"m/64\""
    )]
    TooLong {
        /// Bytes that its angles need.
        bytes: u64,
        /// Bytes that the device offers for them.
        most: u64,
    },
}

/// A named load of a kernel. A kind of study provides loads that cover every distinction its kernel makes.
#[derive(Debug, Clone)]
pub struct Workload {
    /// Name in reports.
    pub name: &'static str,
    /// The computation.
    pub work: Work,
    /// Number of trials or samples that every device must compute correctly before it is used.
    pub self_test_units: Option<u64>,
}

/// The computation of a load.
#[derive(Debug, Clone)]
pub enum Work {
    /// Trials of a launch.
    Trials(Launch),
    /// Synthetic records.
    Records(Arc<dyn Recorded>),
}

impl Workload {
    /// Loads of launches; those named in `self_test` are part of the self-test.
    pub fn of_launches(launches: Vec<(&'static str, Launch)>, self_test: &[&str]) -> Vec<Workload> {
        let load = |(name, launch)| Workload {
            name,
            work: Work::Trials(launch),
            self_test_units: self_test.contains(&name).then_some(5000),
        };
        launches.into_iter().map(load).collect()
    }

    /// The launch, if the load has one.
    pub fn launch(&self) -> Option<&Launch> {
        match &self.work {
            Work::Trials(launch) => Some(launch),
            Work::Records(_) => None,
        }
    }

    /// The stem of the kernel that computes the load.
    pub fn kernel(&self) -> &'static str {
        match &self.work {
            Work::Trials(launch) => launch.sampled().part().stem,
            Work::Records(recipe) => recipe.part().stem,
        }
    }
}

/// Steps that a thread takes at a time, which last some milliseconds.
const PIECE_STEPS: u64 = 1 << 16;

/// The cores of this machine, or some of them.
#[derive(Debug)]
pub struct Cpu {
    width: Width,
    /// Absent in WebAssembly, which has one thread.
    pool: Option<rayon::ThreadPool>,
}

impl Cpu {
    /// A processor that runs kernels in lanes of `width` on `threads` threads; 0 means one thread for each core.
    ///
    /// # Errors
    /// The system provides no threads.
    pub fn new(width: Width, threads: usize) -> Result<Cpu, rayon::ThreadPoolBuildError> {
        let pool = match rayon::ThreadPoolBuilder::new().num_threads(threads).build() {
            Err(_) if cfg!(target_family = "wasm") => None,
            built => Some(built?),
        };
        Ok(Cpu { width, pool })
    }

    /// The lanes of its kernels.
    pub fn width(&self) -> Width {
        self.width
    }

    /// Number of records made in parallel: one for each lane of each thread.
    pub fn records_at_once(&self) -> u64 {
        (self.width.lanes() * self.threads()) as u64
    }

    fn threads(&self) -> usize {
        self.pool.as_ref().map_or(1, rayon::ThreadPool::current_num_threads)
    }

    fn install<T: Send>(&self, work: impl FnOnce() -> T + Send) -> T {
        match &self.pool {
            Some(pool) => pool.install(work),
            None => work(),
        }
    }

    /// Name with lanes and threads.
    pub fn name(&self) -> String {
        format!("CPU ({}, {} threads)", self.width.name(), self.threads())
    }

    /// Tallies of each job, in order. `progress` receives numbers of trials as they complete.
    pub fn tally(&self, jobs: &[Job], histogram: bool, progress: Advance) -> Tallies {
        self.install(|| jobs.par_iter().map(|job| self.tally_job(job, histogram, progress)).collect())
    }

    /// Sums of the squared differences of some records: record by record, and within a record by the places of the
    /// curve. `progress` receives numbers of records as they complete.
    pub fn sums(&self, recipe: &dyn Recorded, first: u64, count: usize, progress: Advance) -> Vec<u128> {
        let lanes = recipe.lanes(self.width) as u64;
        let end = first + count as u64;
        // The record numbers of a group share one upper half.
        let half = ((first | u64::from(u32::MAX)) + 1).min(end);
        let starts = |range: Range<u64>| range.step_by(lanes as usize);
        let groups: Vec<u64> = starts(first..half).chain(starts(half..end)).collect();
        let group = |&at: &u64| {
            let count = lanes.min(if at < half { half } else { end } - at);
            let sums = recipe.sums(self.width, at, count as usize);
            progress(count);
            sums
        };
        self.install(|| groups.par_iter().flat_map_iter(group).collect())
    }

    fn tally_job(&self, job: &Job, histogram: bool, progress: Advance) -> Vec<Moments> {
        let Job { launch, block } = job;
        let empty = || vec![Moments::empty(histogram); launch.sampled().estimates()];
        // Pieces of an aligned block never straddle a multiple of 2^32, as the kernel requires.
        let most = (PIECE_STEPS / launch.steps().next_power_of_two()).max(64);
        (0..block.trials().div_ceil(most))
            .into_par_iter()
            .map(|piece| {
                let first = block.first + piece * most;
                let count = most.min(block.end() - first);
                let tallies = launch.tally(self.width, Trials { first, count, histogram });
                progress(count);
                tallies
            })
            .reduce(empty, |mut left, right| {
                for (tally, other) in left.iter_mut().zip(&right) {
                    tally.merge(other);
                }
                left
            })
    }
}
