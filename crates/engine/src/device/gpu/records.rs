//! Synthetic records on the device: each dispatch makes some chunks of many records, whose state is kept in between.

use std::time::Instant;

use wgpu::BufferUsages;

use crate::device::Advance;
use crate::device::error::GpuError;
use crate::device::gpu::fault::Submission;
use crate::device::gpu::resource::Pipeline;
use crate::device::gpu::{Gpu, TILE_SECONDS};
use sagnac_kernel::curve::{RING_LANES, Recorded};
use sagnac_kernel::record::SUM_WORDS;

impl Gpu {
    /// Sums of the squared differences of some records: record by record, and within a record by the places of the
    /// curve. `progress` receives numbers of records as they complete.
    ///
    /// # Errors
    /// The device is lost, refuses the work or is out of memory, or one record needs more memory than is allowed. No
    /// results of the records are kept.
    pub fn sums(
        &mut self,
        recipe: &dyn Recorded,
        first: u64,
        count: usize,
        progress: Advance,
    ) -> Result<Vec<u128>, GpuError> {
        let made = self.batches(recipe, first, count, progress);
        made.map_err(|error| self.settled(error))
    }

    /// Halves the batches of records permanently after memory ran out; `false` where they already had the least size.
    pub(crate) fn halve_batches(&mut self) -> bool {
        let halves = self.lanes > 1;
        // Applies too where memory ran out before a batch was begun.
        self.lanes /= 2;
        self.most_lanes = self.lanes.max(1);
        halves
    }

    fn batches(
        &mut self,
        recipe: &dyn Recorded,
        first: u64,
        count: usize,
        progress: Advance,
    ) -> Result<Vec<u128>, GpuError> {
        let ring_bytes = 4 * recipe.curve().depth() as u64;
        let budget =
            self.adapter.capacity().most_bytes.min(self.device.limits().max_storage_buffer_binding_size);
        if ring_bytes > budget {
            return Err(GpuError::TooLong { bytes: ring_bytes, most: budget });
        }
        let table_bytes = 4 * recipe.table().len() as u64;
        let most = self.device.limits().max_storage_buffer_binding_size;
        if table_bytes > most {
            return Err(GpuError::TooLong { bytes: table_bytes, most });
        }
        if recipe.rounds() as u64 > self.adapter.capacity().most_rounds {
            let places = recipe.curve().places();
            return Err(GpuError::Refused(format!("{places} averaging times are more than a device takes")));
        }
        let pipeline = self.pipeline_of_records(recipe)?;
        let table = self.upload("table", bytemuck::cast_slice(recipe.table()), BufferUsages::STORAGE)?;
        let most = self.most_lanes.min((budget / ring_bytes.max(1)) as usize).max(1);
        // Whole rows of the rings.
        let most = most - if most > RING_LANES { most % RING_LANES } else { 0 };
        let mut sums = Vec::with_capacity(count * recipe.values());
        let mut done = 0;
        while done < count {
            let at = first + done as u64;
            // The record numbers of a batch share one upper half.
            let to_half = (1 << 32) - (at & u64::from(u32::MAX));
            let lanes = most.min(count - done).min(to_half as usize);
            self.lanes = lanes;
            sums.extend(self.batch(recipe, &pipeline, &table, at, lanes)?);
            progress(lanes as u64);
            done += lanes;
        }
        Ok(sums)
    }

    /// The sums of `lanes` records, whose numbers share one upper half.
    pub(crate) fn batch(
        &mut self,
        recipe: &dyn Recorded,
        pipeline: &Pipeline,
        table: &wgpu::Buffer,
        first: u64,
        lanes: usize,
    ) -> Result<Vec<u128>, GpuError> {
        let size = |words: usize| 4 * (words * lanes) as u64;
        let rings =
            self.buffer("rings", 4 * recipe.curve().ring_words(lanes) as u64, BufferUsages::STORAGE)?;
        let state = self.buffer("state", size(recipe.state_words()), BufferUsages::STORAGE)?;
        let sums_size = size(SUM_WORDS * recipe.values());
        let sums = self.buffer("sums", sums_size, BufferUsages::STORAGE | BufferUsages::COPY_SRC)?;
        let read = self.buffer("read", sums_size, BufferUsages::MAP_READ | BufferUsages::COPY_DST)?;
        let chunks = recipe.curve().chunks();
        let most = (self.adapter.capacity().most_rounds / recipe.rounds() as u64) as u32;
        let (mut from, mut tile, mut wrong) = (0, 1, false);
        let mut before: Option<(Submission, u32)> = None;
        let mut started = Instant::now();
        // While the device works on some chunks, the next are submitted.
        while from < chunks {
            let to = chunks.min(from + tile);
            let words = recipe.parameters(first, lanes as u32, [from, to]);
            let parameters =
                self.upload("parameters", bytemuck::cast_slice(&words), BufferUsages::UNIFORM)?;
            let mut resources = vec![
                (1, parameters.as_entire_binding()),
                (3, sums.as_entire_binding()),
                (4, state.as_entire_binding()),
            ];
            if recipe.curve().depth() > 0 {
                resources.push((2, rings.as_entire_binding()));
            }
            if !recipe.table().is_empty() {
                resources.push((5, table.as_entire_binding()));
            }
            let bind_group = self.bind_group(pipeline, resources);
            let mut encoder = self.device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
            let groups = (lanes as u32).div_ceil(self.variant.workgroup);
            pipeline.dispatch(&mut encoder, &bind_group, [groups, 1]);
            if to == chunks {
                encoder.copy_buffer_to_buffer(&sums, 0, &read, 0, sums_size);
            }
            let submission = self.submit(encoder, lanes as u64 * u64::from(to - from))?;
            wrong |= submission.wrong;
            if let Some((submission, length)) = before.replace((submission, to - from)) {
                self.wait(&submission)?;
                let factor = (TILE_SECONDS / started.elapsed().as_secs_f64().max(1e-6)).clamp(0.5, 8.0);
                tile = ((f64::from(length) * factor) as u32).clamp(1, most);
                started = Instant::now();
            }
            from = to;
        }
        read.map_async(wgpu::MapMode::Read, .., |_| {});
        if let Some((submission, _)) = before {
            self.wait(&submission)?;
        }
        let bytes = self.mapped(&read)?;
        let words: &[u32] = bytemuck::cast_slice(&bytes);
        let sum = |lane: usize, place: usize| -> u128 {
            (0..SUM_WORDS)
                .map(|word| u128::from(words[(SUM_WORDS * place + word) * lanes + lane]) << (32 * word))
                .sum()
        };
        let places = recipe.values();
        let mut all: Vec<u128> =
            (0..lanes).flat_map(|lane| (0..places).map(move |place| sum(lane, place))).collect();
        if wrong {
            all[0] ^= 1;
        }
        Ok(all)
    }
}
