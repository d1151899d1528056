//! Tiles, the units of work of the device, in reused buffers: of trials, and of records.

use std::time::Instant;

use wgpu::BufferUsages;

use crate::device::gpu::adapter::Submission;
use crate::device::gpu::{Gpu, Pipeline, TILE_SECONDS};
use crate::device::tile::{Part, Place, add_results, grid, sums_of_records};
use crate::device::{Advance, GpuError};
use sagnac_kernel::curve::{RING_LANES, Recorded};
use sagnac_kernel::moments::Moments;
use sagnac_kernel::record::SUM_WORDS;

/// A submitted tile whose results have not been read.
pub(crate) struct InFlight<'a> {
    parts: Vec<(Part<'a>, Place)>,
    results: wgpu::Buffer,
    /// The other buffers, which the device uses until it has completed the tile.
    used: Vec<wgpu::Buffer>,
    submission: Submission,
}

impl Gpu {
    /// Submits a tile to the device.
    pub(crate) fn launch<'a>(
        &mut self,
        parts: Vec<Part<'a>>,
        histogram: bool,
    ) -> Result<InFlight<'a>, GpuError> {
        let steps = parts.iter().map(Part::steps).sum();
        let (workgroup, groups) = (self.tallying(histogram).workgroup, self.adapter.capacity().groups);
        let mut size = 0;
        let mut place = |part: Part<'a>| {
            let of_group = part.trials_of_group(workgroup, groups);
            let place = Place::new(&part, size, histogram, of_group);
            size = place.end;
            (part, place)
        };
        let parts: Vec<_> = parts.into_iter().map(&mut place).collect();
        let usage = BufferUsages::STORAGE | BufferUsages::COPY_SRC | BufferUsages::COPY_DST;
        let work = self.borrow("work", size, usage)?;
        let results = self.borrow("results", size, BufferUsages::MAP_READ | BufferUsages::COPY_DST)?;
        let mut encoder = self.device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
        encoder.clear_buffer(&work, 0, Some(size));
        let mut used = Vec::new();
        for (part, place) in &parts {
            used.extend(self.encode(&mut encoder, part, place, histogram, &work)?);
        }
        encoder.copy_buffer_to_buffer(&work, 0, &results, 0, size);
        let submission = self.submit(encoder, steps)?;
        results.map_async(wgpu::MapMode::Read, .., |_| {});
        used.push(work);
        Ok(InFlight { parts, results, used, submission })
    }

    fn encode(
        &mut self,
        encoder: &mut wgpu::CommandEncoder,
        part: &Part,
        place: &Place,
        histogram: bool,
        work: &wgpu::Buffer,
    ) -> Result<[wgpu::Buffer; 2], GpuError> {
        let words = part.parameters();
        let usage = BufferUsages::STORAGE | BufferUsages::COPY_DST;
        let parameters = self.borrow("parameters", 4 * words.len() as u64, usage)?;
        self.queue.write_buffer(&parameters, 0, bytemuck::cast_slice(&words));
        let all = part.jobs(place.trials_of_group);
        let job_bytes = 4 * all.len() as u64;
        let jobs = self.borrow("jobs", job_bytes, usage)?;
        self.queue.write_buffer(&jobs, 0, bytemuck::cast_slice(&all));
        let launch = part.launches[0];
        let table = launch.sampled().has_table().then(|| self.table(&part.tables)).transpose()?;
        let pipeline = self.pipeline_of(launch, histogram)?;
        let range = |buffer, offset: u64, end: u64| {
            let size = std::num::NonZeroU64::new(end - offset);
            wgpu::BindingResource::Buffer(wgpu::BufferBinding { buffer, offset, size })
        };
        let mut resources = vec![
            (1, parameters.as_entire_binding()),
            // The shader takes the number of jobs from this range; a reused buffer may be longer.
            (2, range(&jobs, 0, job_bytes)),
            (3, range(work, place.partials, place.histograms)),
        ];
        if histogram {
            resources.push((4, range(work, place.histograms, place.end)));
        }
        if let Some(table) = &table {
            resources.push((5, table.as_entire_binding()));
        }
        let bind_group = self.bind_group(&pipeline, resources);
        pipeline.dispatch(encoder, &bind_group, grid(place.groups));
        Ok([parameters, jobs])
    }

    /// Waits for a tile and adds its tallies to the results.
    pub(crate) fn collect(&mut self, tile: InFlight, results: &mut [Vec<Moments>]) -> Result<(), GpuError> {
        self.wait(&tile.submission)?;
        let bytes = self.mapped(&tile.results)?;
        let words: &[u32] = bytemuck::cast_slice(&bytes);
        for (part, place) in &tile.parts {
            add_results(part, place, words, results);
        }
        let first = tile.parts.first().and_then(|(part, _)| part.pieces.first());
        if let Some(piece) = first.filter(|_| tile.submission.wrong) {
            results[piece.to][0].sum ^= 1;
        }
        drop(bytes);
        tile.results.unmap();
        tile.used.into_iter().chain([tile.results]).for_each(|buffer| self.give_back(buffer));
        Ok(())
    }
}

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
        let mut all = sums_of_records(words, lanes, recipe.values());
        if wrong {
            all[0] ^= 1;
        }
        Ok(all)
    }
}
