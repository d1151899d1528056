//! Where the kernels run: the processor or a GPU, with the same bits.

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

/// Trials to be tallied: a block of a launch.
#[derive(Debug, Clone, Copy)]
pub struct Job<'a> {
    /// What is sampled, in fixed point.
    pub launch: &'a Launch,
    /// Which trials of it.
    pub block: Block,
}

/// A device that runs the kernels.
pub enum Device {
    /// In lanes, on threads.
    Cpu(crate::device::cpu::Cpu),
    /// As a shader.
    Gpu(Box<crate::device::gpu::Gpu>),
}

impl Device {
    /// As it is called in messages and provenance.
    pub fn name(&self) -> String {
        match self {
            Device::Cpu(cpu) => cpu.name(),
            Device::Gpu(gpu) => gpu.name().to_owned(),
        }
    }

    /// Tallies of each job, in order; `progress` hears of trials as they are done.
    ///
    /// # Errors
    /// A GPU is lost, refuses or is out of memory; nothing of the jobs is kept.
    pub fn tally(
        &mut self,
        jobs: &[Job],
        histogram: bool,
        progress: &(dyn Fn(u64) + Sync),
    ) -> Result<Vec<Vec<Moments>>, GpuError> {
        match self {
            Device::Cpu(cpu) => Ok(cpu.tally(jobs, histogram, progress)),
            Device::Gpu(gpu) => gpu.tally(jobs, histogram, progress),
        }
    }

    /// Sums of the squared differences of some records: record by record, in each the places of the curve; `progress` hears of
    /// records as they are done.
    ///
    /// # Errors
    /// A GPU is lost, refuses or is out of memory, or a record is too long for it: [`TooLong`](GpuError::TooLong), which
    /// the CPU takes.
    pub fn sums(
        &mut self,
        recipe: &Recipe,
        first: u64,
        count: usize,
        progress: &(dyn Fn(u64) + Sync),
    ) -> Result<Vec<u128>, GpuError> {
        match self {
            Device::Cpu(cpu) => Ok(cpu.sums(recipe, first, count, progress)),
            Device::Gpu(gpu) => gpu.sums(recipe, first, count, progress),
        }
    }

    /// Records that it makes in the time of one.
    pub fn records_at_once(&self) -> u64 {
        match self {
            Device::Cpu(cpu) => cpu.records_at_once(),
            // A workgroup; more of them are found out by the time that they take.
            Device::Gpu(_) => 64,
        }
    }

    /// The results of a building block for a list of items.
    ///
    /// # Errors
    /// A GPU is lost, refuses or is out of memory.
    pub fn map(&mut self, map: &Map, items: &[u32]) -> Result<Vec<u32>, GpuError> {
        match self {
            Device::Cpu(cpu) => Ok((map.cpu)(cpu.width(), items)),
            Device::Gpu(gpu) => gpu.map(map, items),
        }
    }
}
