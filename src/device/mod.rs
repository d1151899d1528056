//! The processor and GPUs, on which the kernels give the same bits.

pub mod cpu;
pub mod error;
#[cfg_attr(not(feature = "gpu"), path = "no_gpu.rs")]
pub mod gpu;
pub mod load;
pub mod select;

use crate::device::error::GpuError;
use crate::kernel::launch::Launch;
use crate::kernel::map::Map;
use crate::kernel::moments::Moments;
use crate::kernel::recipe::Recipe;
use crate::tally::block::Block;

/// Receives numbers of trials or records as they complete.
pub type Advance<'a> = &'a (dyn Fn(u64) + Sync);

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
    Cpu(crate::device::cpu::Cpu),
    /// A GPU, which runs kernels as shaders.
    Gpu(Box<crate::device::gpu::Gpu>),
}

impl Device {
    /// Name in messages and provenance.
    pub fn name(&self) -> String {
        match self {
            Device::Cpu(cpu) => cpu.name(),
            Device::Gpu(gpu) => gpu.name().to_owned(),
        }
    }

    /// Tallies of each job, in order. `progress` receives numbers of trials as they complete.
    ///
    /// # Errors
    /// A GPU is lost, refuses the work or is out of memory; no results of the jobs are kept.
    pub fn tally(&mut self, jobs: &[Job], histogram: bool, progress: Advance) -> Result<Tallies, GpuError> {
        match self {
            Device::Cpu(cpu) => Ok(cpu.tally(jobs, histogram, progress)),
            Device::Gpu(gpu) => gpu.tally(jobs, histogram, progress),
        }
    }

    /// Sums of the squared differences of some records: record by record, and within a record by the places of the
    /// curve. `progress` receives numbers of records as they complete.
    ///
    /// # Errors
    /// A GPU is lost, refuses the work or is out of memory, or a record is too long for it
    /// ([`TooLong`](GpuError::TooLong)); the CPU can make such a record.
    pub fn sums(
        &mut self,
        recipe: &Recipe,
        first: u64,
        count: usize,
        progress: Advance,
    ) -> Result<Vec<u128>, GpuError> {
        match self {
            Device::Cpu(cpu) => Ok(cpu.sums(recipe, first, count, progress)),
            Device::Gpu(gpu) => gpu.sums(recipe, first, count, progress),
        }
    }

    /// Number of records that the device makes in parallel.
    pub fn records_at_once(&self) -> u64 {
        match self {
            Device::Cpu(cpu) => cpu.records_at_once(),
            Device::Gpu(gpu) => gpu.records_at_once(),
        }
    }

    /// Steps of trials, or samples of records, with which a run begins; timing tells how many the device takes.
    pub(crate) fn first_batch(&self) -> u64 {
        match self {
            Device::Cpu(_) => 1 << 20,
            Device::Gpu(gpu) => gpu.first_batch(),
        }
    }

    /// The results of a building block for a list of items.
    ///
    /// # Errors
    /// A GPU is lost, refuses the work or is out of memory.
    pub fn map(&mut self, map: &Map, items: &[u32]) -> Result<Vec<u32>, GpuError> {
        match self {
            Device::Cpu(cpu) => Ok((map.cpu)(cpu.width(), items)),
            Device::Gpu(gpu) => gpu.map(map, items),
        }
    }
}
