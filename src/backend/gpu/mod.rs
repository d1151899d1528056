//! The GPU: the kernels as compute shaders, through wgpu on Vulkan, Metal or DX12.

mod records;
pub mod source;
mod tile;

use std::collections::HashMap;
use std::sync::{Arc, Mutex};
use std::time::Instant;

use wgpu::BufferUsages;

use self::source::Variant;
use self::tile::{Part, Piece};
use super::Job;
use crate::kernel::launch::Sampled;
use crate::kernel::map::Map;
use crate::kernel::moments::Moments;
use crate::kernel::normal_table::NORMAL_TABLE;

/// Why a device cannot be used, or can no longer.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum GpuError {
    #[error("cannot open the device: {0}")]
    Open(String),
    #[error("the device was lost: {0}")]
    Lost(String),
    #[error("the device refused the work: {0}")]
    Refused(String),
    #[error(
        "a record needs {bytes} bytes on the device, of {most}: shorten the longest averaging time, or overlap = \"m/64\""
    )]
    TooLong { bytes: u64, most: u64 },
}

/// A tile should take this long: short enough for watchdogs, long enough to hide its preparation.
const TILE_SECONDS: f64 = 0.075;

/// Steps of the first tile, and the least and most of any.
const FIRST_TILE: u64 = 1 << 18;
const TILES: (u64, u64) = (1 << 14, 1 << 28);

/// Most pieces of a tile: bounds the buffer that its histograms take.
const MOST_PIECES: usize = 1024;

/// An adapter that this machine has.
pub struct Adapter {
    adapter: wgpu::Adapter,
}

impl Adapter {
    /// All adapters, one entry for each way to drive them.
    pub fn all() -> Vec<Adapter> {
        let mut descriptor = wgpu::InstanceDescriptor::new_without_display_handle();
        descriptor.backends = wgpu::Backends::VULKAN | wgpu::Backends::METAL | wgpu::Backends::DX12;
        let instance = wgpu::Instance::new(descriptor);
        let found = pollster::block_on(instance.enumerate_adapters(wgpu::Backends::all()));
        found.into_iter().map(|adapter| Adapter { adapter }).collect()
    }

    /// The name of the device, with the driver's interface.
    pub fn name(&self) -> String {
        let info = self.adapter.get_info();
        format!("{} ({})", info.name, info.backend)
    }

    /// Whether it is a program on the processor and no device of its own.
    pub fn is_software(&self) -> bool {
        self.adapter.get_info().device_type == wgpu::DeviceType::Cpu
    }

    /// Driver and capabilities in words.
    pub fn description(&self) -> String {
        let info = self.adapter.get_info();
        let int64 = if self.has_int64() { "64-bit products" } else { "16-bit products" };
        format!("{:?}, driver {} {}, {int64}", info.device_type, info.driver, info.driver_info)
    }

    /// Whether its shaders have 64-bit registers.
    pub fn has_int64(&self) -> bool {
        self.adapter.features().contains(wgpu::Features::SHADER_INT64)
    }

    /// The fastest variant for it.
    pub fn variant(&self) -> Variant {
        Variant { int64: self.has_int64(), checked: false, workgroup: 64 }
    }
}

/// An open device.
pub struct Gpu {
    name: String,
    device: wgpu::Device,
    queue: wgpu::Queue,
    variant: Variant,
    normal_table: wgpu::Buffer,
    /// The table of the launch before, with what is in it: neighbours often share one.
    table: Option<(Arc<[u32]>, wgpu::Buffer)>,
    pipelines: HashMap<(Sampled, bool), wgpu::ComputePipeline>,
    failure: Arc<Mutex<Option<String>>>,
    /// Steps of the next tile.
    tile: u64,
}

impl Gpu {
    /// Opens an adapter to run a variant of the kernels.
    ///
    /// # Errors
    /// The driver refuses.
    pub fn open(adapter: &Adapter, variant: Variant) -> Result<Gpu, GpuError> {
        let own = adapter.adapter.limits();
        let limits = wgpu::Limits {
            max_compute_workgroup_storage_size: own.max_compute_workgroup_storage_size,
            max_storage_buffers_per_shader_stage: own.max_storage_buffers_per_shader_stage,
            max_storage_buffer_binding_size: own.max_storage_buffer_binding_size,
            max_buffer_size: own.max_buffer_size,
            ..wgpu::Limits::downlevel_defaults()
        };
        let features = if variant.int64 { wgpu::Features::SHADER_INT64 } else { wgpu::Features::empty() };
        let (device, queue) = pollster::block_on(adapter.adapter.request_device(&wgpu::DeviceDescriptor {
            label: Some("sagnac"),
            required_features: features,
            required_limits: limits,
            ..Default::default()
        }))
        .map_err(|error| GpuError::Open(error.to_string()))?;
        let failure = Arc::new(Mutex::new(None));
        let heard = Arc::clone(&failure);
        device.on_uncaptured_error(Arc::new(move |error: wgpu::Error| note(&heard, error.to_string())));
        let heard = Arc::clone(&failure);
        device
            .set_device_lost_callback(move |reason, message| note(&heard, format!("{reason:?}: {message}")));
        let normal_table = wgpu::util::DeviceExt::create_buffer_init(
            &device,
            &wgpu::util::BufferInitDescriptor {
                label: Some("normal_table"),
                contents: bytemuck::cast_slice(&NORMAL_TABLE),
                usage: BufferUsages::STORAGE,
            },
        );
        let pipelines = HashMap::new();
        let name = adapter.name();
        Ok(Gpu {
            name,
            device,
            queue,
            variant,
            normal_table,
            table: None,
            pipelines,
            failure,
            tile: FIRST_TILE,
        })
    }

    /// The name of its adapter.
    pub fn name(&self) -> &str {
        &self.name
    }

    /// Makes every tile this many steps of trials long, from now on until timing changes it.
    pub fn set_tile(&mut self, steps: u64) {
        self.tile = steps.clamp(1, TILES.1);
    }

    /// Tallies of each job, in order; `progress` hears of trials as they are done.
    ///
    /// # Errors
    /// The device is lost or refuses; nothing of the jobs is kept.
    pub fn tally(
        &mut self,
        jobs: &[Job],
        histogram: bool,
        progress: &(dyn Fn(u64) + Sync),
    ) -> Result<Vec<Vec<Moments>>, GpuError> {
        let mut results: Vec<Vec<Moments>> =
            jobs.iter().map(|job| vec![Moments::empty(histogram); job.launch.sampled.estimates()]).collect();
        let mut rest = Rest::of(jobs);
        let mut before = None;
        // One tile runs while the next is prepared and the one before is read.
        loop {
            let started = Instant::now();
            let parts = rest.take(self.tile);
            let trials: u64 = parts.iter().map(Part::trials).sum();
            let steps = parts.iter().map(|part| part.trials() * part.launch.sampled.steps()).sum();
            let next =
                if parts.is_empty() { None } else { Some((self.submit(parts, histogram)?, trials, steps)) };
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

    /// Lengthens or shortens the next tile towards the time wanted.
    fn adapt(&mut self, steps: u64, seconds: f64) {
        if steps >= self.tile {
            let factor = (TILE_SECONDS / seconds.max(1e-6)).clamp(0.5, 2.0);
            self.tile = ((self.tile as f64 * factor) as u64).clamp(TILES.0, TILES.1);
        }
    }

    /// The results of a building block for a list of items.
    ///
    /// # Errors
    /// The device is lost or refuses.
    pub fn map(&mut self, map: &Map, items: &[u32]) -> Result<Vec<u32>, GpuError> {
        let count = items.len() / map.inputs;
        let size = 4 * (count * map.outputs) as u64;
        let pipeline = self.pipeline(&source::map(map, self.variant))?;
        let input = self.upload("items", bytemuck::cast_slice(items), BufferUsages::STORAGE);
        let output = self.buffer("results", size, BufferUsages::STORAGE | BufferUsages::COPY_SRC);
        let read = self.buffer("read", size, BufferUsages::MAP_READ | BufferUsages::COPY_DST);
        let mut resources = vec![(1, input.as_entire_binding()), (2, output.as_entire_binding())];
        if map.table {
            resources.push((0, self.normal_table.as_entire_binding()));
        }
        let bind_group = self.bind_group(&pipeline, resources);
        let mut encoder = self.device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
        {
            let mut pass = encoder.begin_compute_pass(&wgpu::ComputePassDescriptor::default());
            pass.set_pipeline(&pipeline);
            pass.set_bind_group(0, &bind_group, &[]);
            pass.dispatch_workgroups((count as u32).div_ceil(self.variant.workgroup), 1, 1);
        }
        encoder.copy_buffer_to_buffer(&output, 0, &read, 0, size);
        self.queue.submit([encoder.finish()]);
        read.map_async(wgpu::MapMode::Read, .., |_| {});
        self.device
            .poll(wgpu::PollType::wait_indefinitely())
            .map_err(|error| GpuError::Lost(error.to_string()))?;
        self.failure()?;
        let bytes = read.get_mapped_range(..).map_err(|error| GpuError::Lost(error.to_string()))?;
        Ok(bytemuck::cast_slice(&bytes).to_vec())
    }

    /// A buffer with the table of a launch.
    fn table(&mut self, table: &Arc<[u32]>) -> wgpu::Buffer {
        if let Some((held, buffer)) = &self.table
            && Arc::ptr_eq(held, table)
        {
            return buffer.clone();
        }
        let buffer = self.upload("table", bytemuck::cast_slice(table), BufferUsages::STORAGE);
        self.table = Some((Arc::clone(table), buffer.clone()));
        buffer
    }

    fn pipeline_of(&mut self, sampled: Sampled, histogram: bool) -> Result<wgpu::ComputePipeline, GpuError> {
        if let Some(pipeline) = self.pipelines.get(&(sampled, histogram)) {
            return Ok(pipeline.clone());
        }
        let pipeline = self.pipeline(&source::moments(sampled, histogram, self.variant))?;
        self.pipelines.insert((sampled, histogram), pipeline.clone());
        Ok(pipeline)
    }

    fn pipeline(&self, source: &str) -> Result<wgpu::ComputePipeline, GpuError> {
        let descriptor =
            wgpu::ShaderModuleDescriptor { label: None, source: wgpu::ShaderSource::Wgsl(source.into()) };
        let module = if self.variant.checked {
            self.device.create_shader_module(descriptor)
        } else {
            // SAFETY: no index of the kernels leaves its array and no loop is endless; the identity suite runs both
            // forms and finds the same bits.
            unsafe {
                self.device.create_shader_module_trusted(descriptor, wgpu::ShaderRuntimeChecks::unchecked())
            }
        };
        let pipeline = self.device.create_compute_pipeline(&wgpu::ComputePipelineDescriptor {
            label: None,
            layout: None,
            module: &module,
            entry_point: Some("main"),
            compilation_options: wgpu::PipelineCompilationOptions {
                zero_initialize_workgroup_memory: self.variant.checked,
                ..Default::default()
            },
            cache: None,
        });
        self.failure()?;
        Ok(pipeline)
    }

    fn bind_group(
        &self,
        pipeline: &wgpu::ComputePipeline,
        resources: Vec<(u32, wgpu::BindingResource)>,
    ) -> wgpu::BindGroup {
        let entries: Vec<wgpu::BindGroupEntry> = resources
            .into_iter()
            .map(|(binding, resource)| wgpu::BindGroupEntry { binding, resource })
            .collect();
        self.device.create_bind_group(&wgpu::BindGroupDescriptor {
            label: None,
            layout: &pipeline.get_bind_group_layout(0),
            entries: &entries,
        })
    }

    /// What the driver complained of since it was last asked.
    fn failure(&self) -> Result<(), GpuError> {
        let heard = self.failure.lock().ok().and_then(|mut failure| failure.take());
        heard.map_or(Ok(()), |message| Err(GpuError::Refused(message)))
    }
}

fn note(failure: &Mutex<Option<String>>, message: String) {
    if let Ok(mut failure) = failure.lock() {
        failure.get_or_insert(message);
    }
}

/// The trials of some jobs that are still to be handed out, tile by tile.
struct Rest<'a> {
    jobs: &'a [Job<'a>],
    job: usize,
    done: u64,
}

impl<'a> Rest<'a> {
    fn of(jobs: &'a [Job<'a>]) -> Rest<'a> {
        Rest { jobs, job: 0, done: 0 }
    }

    /// The next parts, of `steps` steps together, or as many as are left; one trial at least.
    fn take(&mut self, steps: u64) -> Vec<Part<'a>> {
        let mut parts: Vec<Part<'a>> = Vec::new();
        let (mut room, mut pieces) = (steps, 0);
        while room > 0 && pieces < MOST_PIECES && self.job < self.jobs.len() {
            let Job { launch, block } = self.jobs[self.job];
            let first = block.first + self.done;
            // A piece has one upper half of trial numbers: it ends where the lower half does.
            let to_half = (1 << 32) - (first & u64::from(u32::MAX));
            let steps = launch.sampled.steps();
            let count = (room / steps).max(1).min(block.trials() - self.done).min(to_half);
            let piece = Piece { first, count, to: self.job };
            match parts.last_mut() {
                Some(part) if std::ptr::eq(part.launch, launch) => part.pieces.push(piece),
                _ => parts.push(Part { launch, pieces: vec![piece] }),
            }
            pieces += 1;
            room = room.saturating_sub(count * steps);
            self.done += count;
            if self.done == block.trials() {
                (self.job, self.done) = (self.job + 1, 0);
            }
        }
        parts
    }
}
