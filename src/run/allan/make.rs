//! Making records on a device, and their sums as rows of the store.

use std::ops::Range;

use super::Planned;
use crate::backend::Device;
use crate::backend::cpu::{Cpu, Width};
use crate::backend::gpu::GpuError;
use crate::block::{Block, cover};
use crate::kernel::recipe::Recipe;
use crate::kernel::rows::Rows;
use crate::store::Row;

/// Where records are made: on the device, but such as are too long for it on the processor.
pub(super) struct Maker<'a> {
    pub(super) device: &'a mut Device,
    pub(super) cpu: Option<Cpu>,
    /// Why the processor was needed.
    pub(super) degraded: Option<String>,
}

impl Maker<'_> {
    /// The sums of some records, one after the other.
    pub(super) fn sums(
        &mut self,
        recipe: &Recipe,
        records: Range<u64>,
        progress: &(dyn Fn(u64) + Sync),
    ) -> Result<Vec<u128>, GpuError> {
        let (first, count) = (records.start, (records.end - records.start) as usize);
        let why = match self.device.sums(recipe, first, count, progress) {
            Err(error @ GpuError::TooLong { .. }) => error.to_string(),
            made => return made,
        };
        if self.cpu.is_none() {
            let threads = Cpu::new(Width::widest(), 0);
            self.cpu = Some(threads.map_err(|error| GpuError::Refused(error.to_string()))?);
            self.degraded =
                Some(format!("records of {} samples were made on the CPU: {why}", recipe.samples));
        }
        Ok(self.cpu.as_ref().map_or(vec![], |cpu| cpu.sums(recipe, first, count, progress)))
    }

    /// For the provenance of rows.
    pub(super) fn name(&self) -> String {
        match &self.cpu {
            Some(cpu) => format!("{} and {}", self.device.name(), cpu.name()),
            None => self.device.name(),
        }
    }
}

/// The rows of consecutive records, from their sums, in blocks of at most 2^`largest`.
pub(super) fn rows(planned: &Planned, records: Range<u64>, largest: u32, sums: &[u128]) -> Vec<Row<Rows>> {
    let (first, width) = (records.start, planned.width);
    let row = |block: Block| {
        let [from, to] = [block.first, block.end()].map(|at| (at - first) as usize * width);
        Row { address: planned.address, block, tally: Rows { width, values: sums[from..to].to_vec() } }
    };
    cover(records, largest).into_iter().map(row).collect()
}
