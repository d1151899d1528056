//! Resources of a device: buffers, pipelines and bind groups.

use std::sync::Arc;

use wgpu::BufferUsages;

use crate::device::error::GpuError;
use crate::device::gpu::Gpu;
use crate::device::gpu::fault::{Fault, Moment};
use crate::device::gpu::patience::within_limit;
use crate::device::gpu::tile::Part;
use sagnac_kernel::curve::Recorded;
use sagnac_kernel::launch::{Launch, MAX_STEPS};
use sagnac_kernel::moments::{Moments, Trials};
use sagnac_kernel::recipe::CHUNK;
use sagnac_kernel::shader::Variant;
use sagnac_kernel::width::Width;

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
