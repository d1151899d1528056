//! Tiles, the units of work of the device, in reused buffers.

use wgpu::BufferUsages;

use crate::device::error::GpuError;
use crate::device::gpu::Gpu;
use crate::device::gpu::fault::Submission;
use crate::kernel::launch::Launch;
use crate::kernel::moments::{BINS, GROUPS_PER_ROW, Moments, PARTIAL_WORDS};

/// Work of one workgroup, in the layout that the shader reads.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Eq, bytemuck::Pod, bytemuck::Zeroable)]
pub(crate) struct Job {
    low: u32,
    high: u32,
    count: u32,
    slot: u32,
}

/// Ranges of trials of one launch, which form one dispatch.
#[derive(Debug, Clone)]
pub(crate) struct Part<'a> {
    /// The launch.
    pub launch: &'a Launch,
    /// Its ranges, in order.
    pub pieces: Vec<Piece>,
}

impl Part<'_> {
    /// Trials of all pieces.
    pub(crate) fn trials(&self) -> u64 {
        self.pieces.iter().map(|piece| piece.count).sum()
    }

    /// Steps of all pieces.
    pub(crate) fn steps(&self) -> u64 {
        self.trials() * self.launch.steps()
    }

    /// Number of trials of a workgroup.
    fn trials_of_group(&self, workgroup: u32) -> u64 {
        self.launch.most_rounds() * u64::from(workgroup)
    }
}

/// A range of trials; its tallies are added to place `to` of the results.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Piece {
    /// Number of the first trial.
    pub first: u64,
    /// Number of trials.
    pub count: u64,
    /// Index of their tallies in the results.
    pub to: usize,
}

impl Piece {
    /// Number of workgroups that share its trials, with `of_group` trials each.
    fn groups(&self, of_group: u64) -> u64 {
        self.count.div_ceil(of_group)
    }
}

/// A submitted tile whose results have not been read.
pub(crate) struct InFlight<'a> {
    parts: Vec<Part<'a>>,
    histogram: bool,
    results: wgpu::Buffer,
    submission: Submission,
}

/// Alignment of each part's partial sums and histograms in the buffer, in bytes.
const ALIGNMENT: u64 = 256;

/// Offsets of a part's results in the buffer of a tile, in bytes.
struct Place {
    groups: u32,
    partials: u64,
    histograms: u64,
    end: u64,
}

impl Place {
    fn of(part: &Part, from: u64, histogram: bool, workgroup: u32) -> Place {
        let of_group = part.trials_of_group(workgroup);
        let estimates = part.launch.sampled.estimates() as u64;
        let groups = part.pieces.iter().map(|piece| piece.groups(of_group)).sum::<u64>();
        let histogram_bytes = if histogram { 4 * estimates * (BINS * part.pieces.len()) as u64 } else { 0 };
        let histograms = (from + 4 * estimates * PARTIAL_WORDS as u64 * groups).next_multiple_of(ALIGNMENT);
        let end = (histograms + histogram_bytes).next_multiple_of(ALIGNMENT);
        Place { groups: groups as u32, partials: from, histograms, end }
    }
}

impl Gpu {
    /// Submits a tile to the device.
    pub(crate) fn launch<'a>(
        &mut self,
        parts: Vec<Part<'a>>,
        histogram: bool,
    ) -> Result<InFlight<'a>, GpuError> {
        let workgroup = self.variant.workgroup;
        let mut places = Vec::new();
        let mut size = 0;
        for part in &parts {
            let place = Place::of(part, size, histogram, workgroup);
            size = place.end;
            places.push(place);
        }
        let work = self.buffer(
            "work",
            size,
            BufferUsages::STORAGE | BufferUsages::COPY_SRC | BufferUsages::COPY_DST,
        )?;
        let results = self.buffer("results", size, BufferUsages::MAP_READ | BufferUsages::COPY_DST)?;
        let mut encoder = self.device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
        encoder.clear_buffer(&work, 0, None);
        for (part, place) in parts.iter().zip(&places) {
            self.encode(&mut encoder, part, place, histogram, &work)?;
        }
        encoder.copy_buffer_to_buffer(&work, 0, &results, 0, size);
        let submission = self.submit(encoder, parts.iter().map(Part::steps).sum())?;
        results.map_async(wgpu::MapMode::Read, .., |_| {});
        Ok(InFlight { parts, histogram, results, submission })
    }

    fn encode(
        &mut self,
        encoder: &mut wgpu::CommandEncoder,
        part: &Part,
        place: &Place,
        histogram: bool,
        work: &wgpu::Buffer,
    ) -> Result<(), GpuError> {
        let step = part.trials_of_group(self.variant.workgroup);
        let mut jobs = Vec::new();
        for (slot, piece) in part.pieces.iter().enumerate() {
            for group in 0..piece.groups(step) {
                let first = piece.first + group * step;
                let count = step.min(piece.first + piece.count - first) as u32;
                jobs.push(Job { low: first as u32, high: (first >> 32) as u32, count, slot: slot as u32 });
            }
        }
        let mut words = part.launch.words.clone();
        words.resize(words.len().next_multiple_of(4), 0);
        let parameters = self.upload("parameters", bytemuck::cast_slice(&words), BufferUsages::UNIFORM)?;
        let jobs = self.upload("jobs", bytemuck::cast_slice(&jobs), BufferUsages::STORAGE)?;
        let has_table = part.launch.sampled.has_table();
        let table = has_table.then(|| self.table(&part.launch.table)).transpose()?;
        let pipeline = self.pipeline_of(part.launch, histogram)?;
        let range = |offset: u64, end: u64| {
            let size = std::num::NonZeroU64::new(end - offset);
            wgpu::BindingResource::Buffer(wgpu::BufferBinding { buffer: work, offset, size })
        };
        let mut resources = vec![
            (1, parameters.as_entire_binding()),
            (2, jobs.as_entire_binding()),
            (3, range(place.partials, place.histograms)),
        ];
        if histogram {
            resources.push((4, range(place.histograms, place.end)));
        }
        if let Some(table) = &table {
            resources.push((5, table.as_entire_binding()));
        }
        let bind_group = self.bind_group(&pipeline, resources);
        let groups = [place.groups.min(GROUPS_PER_ROW), place.groups.div_ceil(GROUPS_PER_ROW)];
        pipeline.dispatch(encoder, &bind_group, groups);
        Ok(())
    }

    /// Waits for a tile and adds its tallies to the results.
    pub(crate) fn collect(&self, tile: InFlight, results: &mut [Vec<Moments>]) -> Result<(), GpuError> {
        self.wait(&tile.submission)?;
        let bytes = self.mapped(&tile.results)?;
        let words: &[u32] = bytemuck::cast_slice(&bytes);
        let mut from = 0;
        for part in &tile.parts {
            let place = Place::of(part, from, tile.histogram, self.variant.workgroup);
            from = place.end;
            add_results(part, &place, tile.histogram, self.variant.workgroup, words, results);
        }
        let first = tile.parts.first().and_then(|part| part.pieces.first());
        if let Some(piece) = first.filter(|_| tile.submission.wrong) {
            results[piece.to][0].sum ^= 1;
        }
        Ok(())
    }
}

fn add_results(
    part: &Part,
    place: &Place,
    histogram: bool,
    workgroup: u32,
    words: &[u32],
    results: &mut [Vec<Moments>],
) {
    let estimates = part.launch.sampled.estimates();
    let of_group = part.trials_of_group(workgroup);
    let mut partials = words[place.partials as usize / 4..].chunks_exact(estimates * PARTIAL_WORDS);
    let mut histograms = words[place.histograms as usize / 4..].chunks_exact(BINS);
    for piece in &part.pieces {
        let tallies = &mut results[piece.to];
        for group in partials.by_ref().take(piece.groups(of_group) as usize) {
            for (tally, sums) in tallies.iter_mut().zip(group.chunks_exact(PARTIAL_WORDS)) {
                add_partial(tally, sums);
            }
        }
        for tally in tallies.iter_mut() {
            tally.count += piece.count;
            if histogram {
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
