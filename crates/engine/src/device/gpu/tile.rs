//! Tiles, the units of work of the device, in reused buffers.

use std::ops::Range;
use std::sync::Arc;

use wgpu::BufferUsages;

use crate::device::error::GpuError;
use crate::device::gpu::Gpu;
use crate::device::gpu::fault::Submission;
use sagnac_kernel::launch::{Launch, MAX_STEPS};
use sagnac_kernel::moments::{BINS, GROUPS_PER_ROW, Moments, PARTIAL_WORDS};

/// Work of one workgroup, in the layout that the shader reads.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Eq, bytemuck::Pod, bytemuck::Zeroable)]
pub(crate) struct Job {
    low: u32,
    high: u32,
    count: u32,
    point: u32,
    slot: u32,
}

/// Ranges of trials of launches with the same shape, which form one dispatch.
#[derive(Debug, Clone, Default)]
pub(crate) struct Part<'a> {
    /// The launches, which the shader calls points.
    launches: Vec<&'a Launch>,
    /// Their tables, each once.
    tables: Vec<&'a Arc<[u32]>>,
    /// Their ranges, in the order of the results.
    pieces: Vec<Piece>,
}

/// Most words of tables that points bring to a dispatch of others.
const MAX_TABLE_WORDS: usize = 1 << 22;

/// A range of trials; its tallies are added to place `to` of the results.
#[derive(Debug, Clone)]
struct Piece {
    /// Index of its launch in the part.
    point: usize,
    trials: Range<u64>,
    to: usize,
}

impl<'a> Part<'a> {
    /// Whether trials of `launch` may join this part.
    pub(crate) fn takes(&self, launch: &Launch) -> bool {
        let words: usize = self.tables.iter().map(|table| table.len()).sum();
        let has_room =
            self.start_of(launch.table()).is_some() || words + launch.table().len() <= MAX_TABLE_WORDS;
        self.launches.first().is_some_and(|own| **own.sampled() == **launch.sampled()) && has_room
    }

    /// Adds trials of a launch that [`takes`](Part::takes) accepts, or the first ones.
    pub(crate) fn push(&mut self, launch: &'a Launch, trials: Range<u64>, to: usize) {
        let point = self.launches.iter().rposition(|&own| std::ptr::eq(own, launch)).unwrap_or_else(|| {
            self.launches.push(launch);
            if self.start_of(launch.table()).is_none() {
                self.tables.push(launch.table());
            }
            self.launches.len() - 1
        });
        self.pieces.push(Piece { point, trials, to });
    }

    /// Word of all tables at which this one starts, if it is one of them.
    fn start_of(&self, table: &Arc<[u32]>) -> Option<usize> {
        let at = self.tables.iter().position(|own| Arc::ptr_eq(own, table))?;
        Some(self.tables[..at].iter().map(|table| table.len()).sum())
    }

    /// Trials of all pieces.
    pub(crate) fn trials(&self) -> u64 {
        self.pieces.iter().map(Piece::count).sum()
    }

    /// Steps of all pieces.
    pub(crate) fn steps(&self) -> u64 {
        self.pieces.iter().map(|piece| piece.count() * self.launches[piece.point].steps()).sum()
    }

    /// Number of trials of a workgroup: as many as give the device `groups` workgroups.
    pub(crate) fn trials_of_group(&self, workgroup: u32, groups: u64) -> u64 {
        let longest = self.launches.iter().map(|launch| launch.steps()).max().unwrap_or(1);
        let rounds = self.trials() / (groups * u64::from(workgroup));
        rounds.clamp(1, (MAX_STEPS / longest).max(1)) * u64::from(workgroup)
    }

    /// The work of each workgroup, in the order of the partial sums.
    pub(crate) fn jobs(&self, trials_of_group: u64) -> Vec<Job> {
        let mut jobs = Vec::new();
        for (slot, piece) in self.pieces.iter().enumerate() {
            for first in piece.trials.clone().step_by(trials_of_group as usize) {
                let count = trials_of_group.min(piece.trials.end - first) as u32;
                let (low, high) = (first as u32, (first >> 32) as u32);
                jobs.push(Job { low, high, count, point: piece.point as u32, slot: slot as u32 });
            }
        }
        jobs
    }

    /// The parameters of its launches.
    pub(crate) fn parameters(&self) -> Vec<u32> {
        let of = |launch: &&Launch| launch.parameters(self.start_of(launch.table()).unwrap_or(0) as u32);
        self.launches.iter().flat_map(of).collect()
    }
}

/// Columns and rows of a dispatch of some workgroups.
pub(crate) fn grid(groups: u32) -> [u32; 2] {
    [groups.min(GROUPS_PER_ROW), groups.div_ceil(GROUPS_PER_ROW)]
}

impl Piece {
    fn count(&self) -> u64 {
        self.trials.end - self.trials.start
    }

    /// Number of workgroups that share its trials, with `of_group` trials each.
    fn groups(&self, of_group: u64) -> u64 {
        self.count().div_ceil(of_group)
    }
}

/// A submitted tile whose results have not been read.
pub(crate) struct InFlight<'a> {
    parts: Vec<(Part<'a>, Place)>,
    results: wgpu::Buffer,
    /// The other buffers, which the device uses until it has completed the tile.
    used: Vec<wgpu::Buffer>,
    submission: Submission,
}

/// Alignment of each part's partial sums and histograms in the buffer, in bytes.
const ALIGNMENT: u64 = 256;

/// Division of a part among workgroups, with the offsets of its results in the buffer of a tile, in bytes.
struct Place {
    trials_of_group: u64,
    groups: u32,
    partials: u64,
    histograms: u64,
    end: u64,
}

impl Place {
    fn of(part: &Part, from: u64, histogram: bool, trials_of_group: u64) -> Place {
        let estimates = part.launches[0].sampled().estimates() as u64;
        let groups = part.pieces.iter().map(|piece| piece.groups(trials_of_group)).sum::<u64>();
        let histogram_bytes = if histogram { 4 * estimates * (BINS * part.pieces.len()) as u64 } else { 0 };
        let histograms = (from + 4 * estimates * PARTIAL_WORDS as u64 * groups).next_multiple_of(ALIGNMENT);
        let end = (histograms + histogram_bytes).next_multiple_of(ALIGNMENT);
        Place { trials_of_group, groups: groups as u32, partials: from, histograms, end }
    }
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
            let place = Place::of(&part, size, histogram, of_group);
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
        let job_bytes = size_of_val(&*all) as u64;
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

fn add_results(part: &Part, place: &Place, words: &[u32], results: &mut [Vec<Moments>]) {
    let estimates = part.launches[0].sampled().estimates();
    let mut partials = words[place.partials as usize / 4..].chunks_exact(estimates * PARTIAL_WORDS);
    let mut histograms = words[place.histograms as usize / 4..].chunks_exact(BINS);
    for piece in &part.pieces {
        let tallies = &mut results[piece.to];
        for group in partials.by_ref().take(piece.groups(place.trials_of_group) as usize) {
            for (tally, sums) in tallies.iter_mut().zip(group.chunks_exact(PARTIAL_WORDS)) {
                add_partial(tally, sums);
            }
        }
        for tally in tallies.iter_mut() {
            tally.count += piece.count();
            // Without a histogram a tally has no bins.
            if !tally.bins.is_empty() {
                for (bin, &count) in tally.bins.iter_mut().zip(histograms.next().into_iter().flatten()) {
                    *bin += u64::from(count);
                }
            }
        }
    }
}

fn add_partial(tally: &mut Moments, sums: &[u32]) {
    let word96 = |at: usize| -> u128 { (0..3).map(|i| u128::from(sums[at + i]) << (32 * i)).sum() };
    tally.sum += (word96(0) << 32) as i128 >> 32;
    tally.square += word96(3);
    tally.least = tally.least.min(sums[6] as i32);
    tally.greatest = tally.greatest.max(sums[7] as i32);
}
