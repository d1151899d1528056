//! The GPU: the kernels as compute shaders, through wgpu on Vulkan, Metal or DX12; its pipelines and buffers.

pub mod adapter;
pub(crate) mod tile;

use std::collections::HashMap;
use std::sync::Arc;
use std::time::Instant;

use wgpu::BufferUsages;

pub use crate::device::gpu::adapter::Adapter;
#[doc(hidden)]
pub use crate::device::gpu::adapter::{Fault, Faults, Moment};
use crate::device::gpu::adapter::{Heard, within_limit};
use crate::device::select::SelfTest;
use crate::device::tile::{Part, Tiler};
use crate::device::{Advance, GpuError, Job, Tallies};
use sagnac_kernel::curve::Recorded;
use sagnac_kernel::launch::{Launch, MAX_STEPS, Sampled};
use sagnac_kernel::map::Map;
use sagnac_kernel::moments::{Moments, Trials};
use sagnac_kernel::normal_table::NORMAL_TABLE;
use sagnac_kernel::recipe::CHUNK;
use sagnac_kernel::shader::Variant;
use sagnac_kernel::width::Width;

/// Target duration of a tile: short enough for watchdogs, long enough to hide its preparation.
const TILE_SECONDS: f64 = 0.075;
/// Target duration of the first batch of a run.
const FIRST_BATCH_SECONDS: f64 = 0.05;
/// Tiles of the first batch.
const FIRST_TILES: u64 = 4;

/// Least and most steps of a tile. The most are what a few thousand workgroups can take.
const TILES: (u64, u64) = (1 << 14, 1 << 36);

/// An open device.
pub struct Gpu {
    adapter: Adapter,
    name: String,
    device: wgpu::Device,
    queue: wgpu::Queue,
    variant: Variant,
    normal_table: wgpu::Buffer,
    /// The tables of the previous part with their buffer; the next part often has the same.
    table: Option<(Vec<Arc<[u32]>>, wgpu::Buffer)>,
    /// Pipelines of trials by shape and histogram, and those of records by the text of their shaders.
    pipelines: HashMap<(Arc<dyn Sampled>, bool), Pipeline>,
    record_pipelines: HashMap<String, Pipeline>,
    /// Buffers of tiles that are done, for the next ones.
    free: Vec<wgpu::Buffer>,
    heard: Heard,
    /// Steps of the first tile, of the next tile, and the most steps of any tile.
    first_tile: u64,
    tile: u64,
    most_tile: u64,
    /// Records of the last batch, and the most records of any batch.
    lanes: usize,
    most_lanes: usize,
    /// Threads of the processor where it has to replace this device; 0 means all logical cores.
    pub(crate) threads: usize,
    /// Number of losses after which it was opened again.
    pub(crate) losses: u32,
    /// Self-test to pass when the device is opened again.
    pub(crate) self_test: Option<SelfTest>,
    faults: Option<Faults>,
}

impl Gpu {
    /// Opens an adapter for a variant of the kernels.
    ///
    /// # Errors
    /// The driver refuses to open it.
    pub fn open(adapter: &Adapter, variant: Variant) -> Result<Gpu, GpuError> {
        let own = adapter.adapter.limits();
        let limits = wgpu::Limits {
            max_compute_workgroup_storage_size: own.max_compute_workgroup_storage_size,
            max_storage_buffers_per_shader_stage: own.max_storage_buffers_per_shader_stage,
            max_storage_buffer_binding_size: own.max_storage_buffer_binding_size,
            max_buffer_size: own.max_buffer_size,
            ..wgpu::Limits::downlevel_defaults()
        };
        let int64 = if variant.int64 { wgpu::Features::SHADER_INT64 } else { wgpu::Features::empty() };
        let (device, queue) = pollster::block_on(adapter.adapter.request_device(&wgpu::DeviceDescriptor {
            label: Some("sagnac"),
            required_features: int64,
            required_limits: limits,
            ..Default::default()
        }))
        .map_err(|error| GpuError::Open(error.to_string()))?;
        let heard = Heard::new(&device);
        let normal_table = device.create_buffer(&wgpu::BufferDescriptor {
            label: Some("normal_table"),
            size: size_of_val(&NORMAL_TABLE) as u64,
            usage: BufferUsages::STORAGE | BufferUsages::COPY_DST,
            mapped_at_creation: false,
        });
        queue.write_buffer(&normal_table, 0, bytemuck::cast_slice(&NORMAL_TABLE));
        heard.failure()?;
        Ok(Gpu {
            adapter: adapter.clone(),
            name: adapter.name(),
            device,
            queue,
            variant,
            normal_table,
            table: None,
            pipelines: HashMap::new(),
            record_pipelines: HashMap::new(),
            free: Vec::new(),
            heard,
            first_tile: adapter.capacity().first_tile,
            tile: adapter.capacity().first_tile,
            most_tile: TILES.1,
            lanes: 0,
            most_lanes: adapter.capacity().most_records,
            threads: 0,
            losses: 0,
            self_test: None,
            faults: None,
        })
    }

    /// Sets the self-test to pass whenever the device is opened again.
    #[doc(hidden)]
    pub fn with_self_test(self, self_test: SelfTest) -> Gpu {
        Gpu { self_test: Some(self_test), ..self }
    }

    /// Begins with tiles, and with a batch, for a device of `steps_per_second`.
    pub(crate) fn paced(self, steps_per_second: f64) -> Gpu {
        let first_tile = (steps_per_second * FIRST_BATCH_SECONDS) as u64 / FIRST_TILES;
        self.beginning_with(first_tile)
    }

    fn beginning_with(mut self, first_tile: u64) -> Gpu {
        self.first_tile = first_tile.clamp(TILES.0, self.most_tile);
        self.begin();
        self
    }

    /// Makes the next tile the first one again, whatever earlier ones showed.
    pub(crate) fn begin(&mut self) {
        self.tile = self.first_tile;
    }

    /// Opens the adapter again, with tiles as small as were found to fit. It begins with smaller ones than before, as a system
    /// may take a device away from a tile that lasts seconds.
    ///
    /// # Errors
    /// The driver refuses, as it does when the device is gone.
    pub(crate) fn opened_again(&self) -> Result<Gpu, GpuError> {
        if let Some(fault) = self.fault(Moment::Opening) {
            return Err(GpuError::Open(format!("{fault:?}, requested by a test")));
        }
        let gpu = Gpu::open(&self.adapter, self.variant)?;
        let (most_tile, most_lanes) = (self.most_tile, self.most_lanes);
        let (threads, losses, self_test, faults) =
            (self.threads, self.losses, self.self_test, self.faults.clone());
        let gpu = Gpu { most_tile, most_lanes, threads, losses, self_test, faults, ..gpu };
        Ok(gpu.beginning_with(self.first_tile / 4))
    }

    /// Has the next start test its adapter again.
    pub(crate) fn distrust(&self) {
        adapter::withdraw(&self.adapter);
    }

    /// The name of its adapter.
    pub fn name(&self) -> &str {
        &self.name
    }

    /// The variant of the kernels that it runs.
    pub fn variant(&self) -> Variant {
        self.variant
    }

    /// The variant that tallies trials.
    pub(crate) fn tallying(&self, histogram: bool) -> Variant {
        let times = if histogram { self.adapter.capacity().sharing } else { 1 };
        Variant { workgroup: times * self.variant.workgroup, ..self.variant }
    }

    /// Number of records that are made in parallel at least.
    pub(crate) fn records_at_once(&self) -> u64 {
        self.adapter.capacity().records_at_once
    }

    /// Steps of trials, or samples of records, with which a run begins.
    pub(crate) fn first_batch(&self) -> u64 {
        FIRST_TILES * self.first_tile
    }

    /// Sets the length of every tile to `steps` steps of trials, until timing changes it.
    pub fn set_tile(&mut self, steps: u64) {
        self.tile = steps.clamp(1, self.most_tile);
    }

    /// Halves the tiles permanently after memory ran out; `false` where they already had the least size.
    pub(crate) fn halve_tiles(&mut self) -> bool {
        if self.tile <= TILES.0 {
            return false;
        }
        self.most_tile = (self.tile / 2).max(TILES.0);
        self.tile = self.most_tile;
        true
    }

    /// Tallies of each job, in order. `progress` receives numbers of trials as they complete.
    ///
    /// # Errors
    /// The device is lost, refuses the work or is out of memory; no results of the jobs are kept.
    pub fn tally(&mut self, jobs: &[Job], histogram: bool, progress: Advance) -> Result<Tallies, GpuError> {
        let tallied = self.tiles(jobs, histogram, progress);
        tallied.map_err(|error| self.settled(error))
    }

    fn tiles(&mut self, jobs: &[Job], histogram: bool, progress: Advance) -> Result<Tallies, GpuError> {
        let mut results: Tallies = jobs
            .iter()
            .map(|job| vec![Moments::empty(histogram); job.launch.sampled().estimates()])
            .collect();
        let mut rest = Tiler::new(jobs);
        let mut before = None;
        // While one tile runs, the next is prepared and the one before is read.
        loop {
            let started = Instant::now();
            let parts = rest.take(self.tile);
            let trials: u64 = parts.iter().map(Part::trials).sum();
            let steps = parts.iter().map(Part::steps).sum();
            let next =
                if parts.is_empty() { None } else { Some((self.launch(parts, histogram)?, trials, steps)) };
            if let Some((tile, trials, steps)) = before.take() {
                self.collect(tile, &mut results)?;
                progress(trials);
                self.adapt(steps, started.elapsed().as_secs_f64());
            }
            if next.is_none() {
                return Ok(results);
            }
            before = next;
        }
    }

    /// Lengthens or shortens the next tile towards the target duration.
    fn adapt(&mut self, steps: u64, seconds: f64) {
        if steps >= self.tile {
            let factor = (TILE_SECONDS / seconds.max(1e-6)).clamp(0.5, 8.0);
            self.tile = ((self.tile as f64 * factor) as u64).clamp(TILES.0, self.most_tile);
        }
    }

    /// The results of a building block for a list of items.
    ///
    /// # Errors
    /// The device is lost, refuses the work or is out of memory.
    pub fn map(&mut self, map: &Map, items: &[u32]) -> Result<Vec<u32>, GpuError> {
        let mapped = self.mapped_items(map, items);
        mapped.map_err(|error| self.settled(error))
    }

    fn mapped_items(&self, map: &Map, items: &[u32]) -> Result<Vec<u32>, GpuError> {
        let count = items.len() / map.inputs;
        let size = 4 * (count * map.outputs) as u64;
        let pipeline = self.pipeline(map.shader(self.variant))?;
        let input = self.upload("items", bytemuck::cast_slice(items), BufferUsages::STORAGE)?;
        let output = self.buffer("results", size, BufferUsages::STORAGE | BufferUsages::COPY_SRC)?;
        let read = self.buffer("read", size, BufferUsages::MAP_READ | BufferUsages::COPY_DST)?;
        let resources = vec![(1, input.as_entire_binding()), (2, output.as_entire_binding())];
        let bind_group = self.bind_group(&pipeline, resources);
        let mut encoder = self.device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
        pipeline.dispatch(&mut encoder, &bind_group, [(count as u32).div_ceil(self.variant.workgroup), 1]);
        encoder.copy_buffer_to_buffer(&output, 0, &read, 0, size);
        let submission = self.submit(encoder, count as u64)?;
        read.map_async(wgpu::MapMode::Read, .., |_| {});
        self.wait(&submission)?;
        let bytes = self.mapped(&read)?;
        let mut results = bytemuck::cast_slice(&bytes).to_vec();
        if submission.wrong {
            results[0] ^= 1;
        }
        Ok(results)
    }
}

/// Most buffers kept for the next tiles: those of two tiles of some parts.
const MAX_FREE: usize = 36;

/// A compiled shader.
#[derive(Clone)]
pub(crate) struct Pipeline {
    pipeline: wgpu::ComputePipeline,
    has_normals: bool,
}

impl Pipeline {
    /// Encodes a compute pass of `workgroups` workgroups.
    pub(crate) fn dispatch(
        &self,
        encoder: &mut wgpu::CommandEncoder,
        bind_group: &wgpu::BindGroup,
        [columns, rows]: [u32; 2],
    ) {
        let mut pass = encoder.begin_compute_pass(&wgpu::ComputePassDescriptor::default());
        pass.set_pipeline(&self.pipeline);
        pass.set_bind_group(0, bind_group, &[]);
        pass.dispatch_workgroups(columns, rows, 1);
    }
}

/// The checks that the shader compiler adds to a variant.
pub(crate) fn runtime_checks(variant: Variant) -> wgpu::ShaderRuntimeChecks {
    if variant.checked {
        wgpu::ShaderRuntimeChecks::checked()
    } else {
        wgpu::ShaderRuntimeChecks::unchecked()
    }
}

impl Gpu {
    /// Creates a buffer of zeros.
    pub(crate) fn buffer(
        &self,
        label: &str,
        size: u64,
        usage: BufferUsages,
    ) -> Result<wgpu::Buffer, GpuError> {
        let label = Some(label);
        let buffer = self.device.create_buffer(&wgpu::BufferDescriptor {
            label,
            size,
            usage,
            mapped_at_creation: false,
        });
        // A buffer for which memory was too short must not be used.
        self.heard.failure()?;
        Ok(buffer)
    }

    /// A buffer of at least `size` bytes with any contents: one that was [given back](Gpu::give_back), or a new one.
    pub(crate) fn borrow(
        &mut self,
        label: &str,
        size: u64,
        usage: BufferUsages,
    ) -> Result<wgpu::Buffer, GpuError> {
        let suits = |free: &wgpu::Buffer| free.usage() == usage && free.size() >= size;
        match self.free.iter().position(suits) {
            Some(at) => Ok(self.free.remove(at)),
            None => self.buffer(label, size, usage),
        }
    }

    /// Keeps a buffer that the device no longer uses for the next tile.
    pub(crate) fn give_back(&mut self, buffer: wgpu::Buffer) {
        if self.free.len() == MAX_FREE {
            self.free.remove(0);
        }
        self.free.push(buffer);
    }

    /// Creates a buffer that contains these words.
    pub(crate) fn upload(
        &self,
        label: &str,
        words: &[u8],
        usage: BufferUsages,
    ) -> Result<wgpu::Buffer, GpuError> {
        let buffer = self.buffer(label, words.len() as u64, usage | BufferUsages::COPY_DST)?;
        self.queue.write_buffer(&buffer, 0, words);
        self.heard.failure()?;
        Ok(buffer)
    }

    /// The contents of a mapped buffer.
    pub(crate) fn mapped(&self, buffer: &wgpu::Buffer) -> Result<wgpu::BufferView, GpuError> {
        buffer.get_mapped_range(..).map_err(|error| GpuError::Refused(error.to_string()))
    }

    /// The buffer with some tables, one after the other.
    pub(crate) fn table(&mut self, tables: &[&Arc<[u32]>]) -> Result<wgpu::Buffer, GpuError> {
        if let Some((held, buffer)) = &self.table
            && held.len() == tables.len()
            && held.iter().zip(tables).all(|(held, table)| Arc::ptr_eq(held, table))
        {
            return Ok(buffer.clone());
        }
        let words: Vec<u32> = tables.iter().flat_map(|table| table.iter().copied()).collect();
        let buffer = self.upload("table", bytemuck::cast_slice(&words), BufferUsages::STORAGE)?;
        self.table = Some((tables.iter().map(|&table| Arc::clone(table)).collect(), buffer.clone()));
        Ok(buffer)
    }

    /// The pipeline that samples a launch, compiled once for its shape.
    pub(crate) fn pipeline_of(&mut self, launch: &Launch, histogram: bool) -> Result<Pipeline, GpuError> {
        let key = (Arc::clone(launch.sampled()), histogram);
        if let Some(pipeline) = self.pipelines.get(&key) {
            return Ok(pipeline.clone());
        }
        let pipeline = self.pipeline(launch.shader(histogram, self.tallying(histogram)))?;
        self.pipelines.insert(key.clone(), pipeline.clone());
        let answered = self.answers(|gpu| gpu.tallies_as_the_cpu(launch, histogram));
        answered.inspect_err(|_| drop(self.pipelines.remove(&key)))?;
        Ok(pipeline)
    }

    /// The pipeline that makes the records of a recipe, compiled once for its shader.
    pub(crate) fn pipeline_of_records(&mut self, recipe: &dyn Recorded) -> Result<Pipeline, GpuError> {
        let shader = recipe.shader(self.variant);
        if let Some(pipeline) = self.record_pipelines.get(&shader.0) {
            return Ok(pipeline.clone());
        }
        let pipeline = self.pipeline(shader.clone())?;
        self.answers(|gpu| gpu.sums_as_the_cpu(recipe, &pipeline))?;
        self.record_pipelines.insert(shader.0, pipeline.clone());
        Ok(pipeline)
    }

    /// Asks a new pipeline for an answer that the processor knows. Some drivers make a pipeline that computes nothing, or
    /// lose the device, without an error.
    fn answers(&mut self, same: impl FnOnce(&mut Gpu) -> Result<bool, GpuError>) -> Result<(), GpuError> {
        // It is no tile of the work, whose faults a test places.
        let faults = self.faults.take();
        let same = same(self);
        self.faults = faults;
        if same? && self.fault(Moment::Answer).is_none() {
            return Ok(());
        }
        self.distrust();
        Err(GpuError::WrongBits)
    }

    fn tallies_as_the_cpu(&mut self, launch: &Launch, histogram: bool) -> Result<bool, GpuError> {
        let count = (MAX_STEPS / launch.steps()).clamp(1, u64::from(self.variant.workgroup));
        let mut part = Part::default();
        part.push(launch, 0..count, 0);
        let tile = self.launch(vec![part], histogram)?;
        let mut found = [vec![Moments::empty(histogram); launch.sampled().estimates()]];
        self.collect(tile, &mut found)?;
        Ok(found[0] == launch.tally(Width::widest(), Trials { first: 0, count, histogram }))
    }

    fn sums_as_the_cpu(&mut self, recipe: &dyn Recorded, pipeline: &Pipeline) -> Result<bool, GpuError> {
        // The shader does not depend on the length of the records.
        let short = recipe.shortened(2 * CHUNK as u32);
        let table = self.upload("table", bytemuck::cast_slice(short.table()), BufferUsages::STORAGE)?;
        Ok(self.batch(&*short, pipeline, &table, 0, 2)? == short.sums(Width::widest(), 0, 2))
    }

    /// Compiles a shader, given as its text and whether it draws normal numbers.
    pub(crate) fn pipeline(&self, (source, has_normals): (String, bool)) -> Result<Pipeline, GpuError> {
        let (device, variant) = (self.device.clone(), self.variant);
        let is_stuck = self.fault(Moment::Pipeline) == Some(Fault::Stuck);
        let pipeline = within_limit(&self.name, is_stuck, move || compiled(&device, source, variant))?;
        self.heard.failure()?;
        Ok(Pipeline { pipeline, has_normals })
    }

    /// Binds resources, and the table of normal numbers where the shader reads it.
    pub(crate) fn bind_group(
        &self,
        pipeline: &Pipeline,
        resources: Vec<(u32, wgpu::BindingResource)>,
    ) -> wgpu::BindGroup {
        let normals = pipeline.has_normals.then(|| (0, self.normal_table.as_entire_binding()));
        let entries: Vec<wgpu::BindGroupEntry> = resources
            .into_iter()
            .chain(normals)
            .map(|(binding, resource)| wgpu::BindGroupEntry { binding, resource })
            .collect();
        self.device.create_bind_group(&wgpu::BindGroupDescriptor {
            label: None,
            layout: &pipeline.pipeline.get_bind_group_layout(0),
            entries: &entries,
        })
    }
}

fn compiled(device: &wgpu::Device, source: String, variant: Variant) -> wgpu::ComputePipeline {
    let descriptor =
        wgpu::ShaderModuleDescriptor { label: None, source: wgpu::ShaderSource::Wgsl(source.into()) };
    // SAFETY: the text is that of a kernel of `sagnac-kernel`, because nothing else implements the sealed `Shape` and `Recorded`. Its loops
    // end, and its indices stay within what is bound: `Launch::new` and `Recorded::parameters` refuse words and tables beyond
    // which a trial or a record would read. The identity suite finds the same bits with and without checks.
    let module = unsafe { device.create_shader_module_trusted(descriptor, runtime_checks(variant)) };
    device.create_compute_pipeline(&wgpu::ComputePipelineDescriptor {
        label: None,
        layout: None,
        module: &module,
        entry_point: Some("main"),
        compilation_options: wgpu::PipelineCompilationOptions {
            zero_initialize_workgroup_memory: variant.checked,
            ..Default::default()
        },
        cache: None,
    })
}
