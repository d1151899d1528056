//! The processor and GPUs, on which the kernels give the same bits.

pub(crate) mod attempts;
pub mod cpu;
pub mod error;
#[cfg_attr(not(feature = "gpu"), path = "no_gpu.rs")]
pub mod gpu;
pub mod group;
pub mod load;
pub mod select;

use crate::device::error::GpuError;
use crate::device::group::Group;
use crate::tally::Block;
use sagnac_kernel::curve::Recorded;
use sagnac_kernel::launch::Launch;
use sagnac_kernel::map::Map;
use sagnac_kernel::moments::Moments;

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
            Device::Cpu(_) => 0,
            Device::Gpu(gpu) => gpu.threads,
            Device::Group(group) => group.devices().map(Device::threads).max().unwrap_or(0),
        }
    }

    /// Number of records that the device makes in parallel.
    pub fn records_at_once(&self) -> u64 {
        match self {
            Device::Cpu(cpu) => cpu.records_at_once(),
            Device::Gpu(gpu) => gpu.records_at_once(),
            Device::Group(group) => group.devices().map(Device::records_at_once).sum(),
        }
    }

    /// Steps of trials, or samples of records, with which a run begins; timing tells how many the device takes.
    pub(crate) fn first_batch(&self) -> u64 {
        match self {
            Device::Cpu(_) => 1 << 20,
            Device::Gpu(gpu) => gpu.first_batch(),
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
            Device::Group(group) => group.first().map(map, items),
        }
    }
}
