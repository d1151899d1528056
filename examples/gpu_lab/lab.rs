//! A device of the lab's own, with time stamps where it has any, and shaders of trials on it.

use std::time::Instant;

use sagnac_kernel::moments::{BINS, GROUPS_PER_ROW, Moments, PARTIAL_WORDS};
use sagnac_kernel::normal_table::NORMAL_TABLE;
use sagnac_kernel::shader::Variant;
use wgpu::{BufferUsages as Use, Features};

use crate::{Bench, Options, chosen};

pub fn adapters() -> Vec<wgpu::Adapter> {
    let mut descriptor = wgpu::InstanceDescriptor::new_without_display_handle();
    descriptor.backends = wgpu::Backends::VULKAN | wgpu::Backends::METAL | wgpu::Backends::DX12;
    pollster::block_on(wgpu::Instance::new(descriptor).enumerate_adapters(wgpu::Backends::all()))
}

pub struct Lab {
    pub device: wgpu::Device,
    pub queue: wgpu::Queue,
    pub int64: bool,
    pub has_stamps: bool,
    pub most_invocations: u32,
    pub normals: wgpu::Buffer,
}

impl Lab {
    pub fn open(options: &Options) -> Lab {
        let adapter = chosen(options, adapters(), |adapter| {
            let info = adapter.get_info();
            (info.name, info.device_type == wgpu::DeviceType::Cpu)
        });
        eprintln!("{}", adapter.get_info().name);
        let features = adapter.features() & (Features::SHADER_INT64 | Features::TIMESTAMP_QUERY);
        let limits = adapter.limits();
        let most_invocations = limits.max_compute_invocations_per_workgroup;
        let (device, queue) = pollster::block_on(adapter.request_device(&wgpu::DeviceDescriptor {
            label: Some("gpu_lab"),
            required_features: features,
            required_limits: limits,
            ..Default::default()
        }))
        .expect("a device");
        // An edit that a driver refuses must not end the others.
        device.on_uncaptured_error(std::sync::Arc::new(|error| eprintln!("REFUSED: {error}")));
        let normals = device.create_buffer(&wgpu::BufferDescriptor {
            label: None,
            size: size_of_val(&NORMAL_TABLE) as u64,
            usage: Use::STORAGE | Use::COPY_DST,
            mapped_at_creation: false,
        });
        queue.write_buffer(&normals, 0, bytemuck::cast_slice(&NORMAL_TABLE));
        let int64 = features.contains(Features::SHADER_INT64);
        let has_stamps = features.contains(Features::TIMESTAMP_QUERY);
        Lab { device, queue, int64, has_stamps, most_invocations, normals }
    }

    pub fn buffer(&self, size: u64, usage: Use) -> wgpu::Buffer {
        let size = size.max(16).next_multiple_of(16);
        self.device.create_buffer(&wgpu::BufferDescriptor {
            label: None,
            size,
            usage,
            mapped_at_creation: false,
        })
    }

    pub fn upload(&self, words: &[u32], usage: Use) -> wgpu::Buffer {
        let buffer = self.buffer(4 * words.len() as u64, usage | Use::COPY_DST);
        self.queue.write_buffer(&buffer, 0, bytemuck::cast_slice(words));
        buffer
    }

    pub fn pipeline(&self, source: &str, checked: bool) -> wgpu::ComputePipeline {
        let descriptor =
            wgpu::ShaderModuleDescriptor { label: None, source: wgpu::ShaderSource::Wgsl(source.into()) };
        let module = if checked {
            self.device.create_shader_module(descriptor)
        } else {
            // SAFETY: the identity suite runs the kernels both ways, and edits keep their indices and loops.
            unsafe {
                self.device.create_shader_module_trusted(descriptor, wgpu::ShaderRuntimeChecks::unchecked())
            }
        };
        self.device.create_compute_pipeline(&wgpu::ComputePipelineDescriptor {
            label: None,
            layout: None,
            module: &module,
            entry_point: Some("main"),
            compilation_options: wgpu::PipelineCompilationOptions {
                zero_initialize_workgroup_memory: checked,
                ..Default::default()
            },
            cache: None,
        })
    }

    pub fn wait(&self) {
        self.device.poll(wgpu::PollType::wait_indefinitely()).expect("the device answers");
    }

    /// Submits work, waits for it, and returns the seconds.
    pub fn seconds(&self, encoder: wgpu::CommandEncoder) -> f64 {
        let commands = encoder.finish();
        self.wait();
        let started = Instant::now();
        self.queue.submit([commands]);
        self.wait();
        started.elapsed().as_secs_f64()
    }

    pub fn read(&self, from: &wgpu::Buffer) -> Vec<u32> {
        let read = self.buffer(from.size(), Use::MAP_READ | Use::COPY_DST);
        let mut encoder = self.device.create_command_encoder(&Default::default());
        encoder.copy_buffer_to_buffer(from, 0, &read, 0, from.size());
        self.queue.submit([encoder.finish()]);
        read.map_async(wgpu::MapMode::Read, .., |result| result.expect("mapped"));
        self.wait();
        let bytes = read.get_mapped_range(..).expect("mapped");
        bytemuck::cast_slice(&bytes).to_vec()
    }

    pub fn group<'a>(
        &self,
        pipeline: &wgpu::ComputePipeline,
        bound: impl IntoIterator<Item = (u32, &'a wgpu::Buffer)>,
    ) -> wgpu::BindGroup {
        let entry = |(binding, buffer): (u32, &'a wgpu::Buffer)| wgpu::BindGroupEntry {
            binding,
            resource: buffer.as_entire_binding(),
        };
        let entries: Vec<_> = bound.into_iter().map(entry).collect();
        let layout = &pipeline.get_bind_group_layout(0);
        self.device.create_bind_group(&wgpu::BindGroupDescriptor { label: None, layout, entries: &entries })
    }

    /// Seconds of one dispatch on the device; by the clock of the host where there are no time stamps.
    pub fn dispatch(
        &self,
        pipeline: &wgpu::ComputePipeline,
        group: &wgpu::BindGroup,
        [columns, rows]: [u32; 2],
    ) -> f64 {
        let mut encoder = self.device.create_command_encoder(&Default::default());
        let set = wgpu::QuerySetDescriptor { label: None, ty: wgpu::QueryType::Timestamp, count: 2 };
        let stamps = self.has_stamps.then(|| {
            (self.device.create_query_set(&set), self.buffer(16, Use::QUERY_RESOLVE | Use::COPY_SRC))
        });
        {
            let mut pass = encoder.begin_compute_pass(&wgpu::ComputePassDescriptor {
                label: None,
                timestamp_writes: stamps.as_ref().map(|(set, _)| wgpu::ComputePassTimestampWrites {
                    query_set: set,
                    beginning_of_pass_write_index: Some(0),
                    end_of_pass_write_index: Some(1),
                }),
            });
            pass.set_pipeline(pipeline);
            pass.set_bind_group(0, group, &[]);
            pass.dispatch_workgroups(columns, rows, 1);
        }
        if let Some((set, resolved)) = &stamps {
            encoder.resolve_query_set(set, 0..2, resolved, 0);
        }
        let seconds = self.seconds(encoder);
        let Some((_, resolved)) = &stamps else { return seconds };
        let words = self.read(resolved);
        let ticks = |at: usize| u64::from(words[at]) | u64::from(words[at + 1]) << 32;
        let period = f64::from(self.queue.get_timestamp_period()) * 1e-9;
        ticks(2).saturating_sub(ticks(0)) as f64 * period
    }
}

/// A shader of trials with its buffers, for `groups` workgroups of `rounds` trials an invocation.
pub struct Kernel<'a> {
    lab: &'a Lab,
    bench: &'a Bench,
    pub pipeline: wgpu::ComputePipeline,
    pub group: wgpu::BindGroup,
    partials: wgpu::Buffer,
    bins: wgpu::Buffer,
    groups: u32,
    pub trials: u64,
}

impl<'a> Kernel<'a> {
    pub fn new(
        lab: &'a Lab,
        source: &str,
        bench: &'a Bench,
        variant: Variant,
        [groups, rounds]: [u32; 2],
    ) -> Kernel<'a> {
        let Bench { launch, histogram, .. } = bench;
        let of_group = rounds * variant.workgroup;
        // The words of a job: low, high, count, point, slot.
        let jobs: Vec<u32> = (0..groups).flat_map(|group| [group * of_group, 0, of_group, 0, 0]).collect();
        let jobs = lab.upload(&jobs, Use::STORAGE);
        let estimates = launch.sampled().estimates();
        let usage = Use::STORAGE | Use::COPY_SRC | Use::COPY_DST;
        let partials = lab.buffer(4 * (estimates * PARTIAL_WORDS) as u64 * u64::from(groups), usage);
        let bins = lab.buffer(4 * (estimates * BINS) as u64, usage);
        // Edits bind the parameters otherwise.
        let parameters = lab.upload(&launch.parameters(0), Use::UNIFORM | Use::STORAGE);
        let table = lab.upload(launch.table(), Use::STORAGE);
        let pipeline = lab.pipeline(source, variant.checked);
        let (_, has_normals) = launch.shader(*histogram, variant);
        let bound = [
            (0, &lab.normals, has_normals),
            (1, &parameters, true),
            (2, &jobs, true),
            (3, &partials, true),
            (4, &bins, *histogram),
            (5, &table, launch.sampled().has_table()),
        ];
        let bound = bound.into_iter().filter(|bound| bound.2).map(|(binding, buffer, _)| (binding, buffer));
        let group = lab.group(&pipeline, bound);
        let trials = u64::from(groups) * u64::from(of_group);
        Kernel { lab, bench, pipeline, group, partials, bins, groups, trials }
    }

    /// Seconds of one dispatch.
    fn dispatch(&self) -> f64 {
        let size = [self.groups.min(GROUPS_PER_ROW), self.groups.div_ceil(GROUPS_PER_ROW)];
        self.lab.dispatch(&self.pipeline, &self.group, size)
    }

    /// The tallies of one dispatch.
    pub fn tallies(&self) -> Vec<Moments> {
        for buffer in [&self.partials, &self.bins] {
            let mut encoder = self.lab.device.create_command_encoder(&Default::default());
            encoder.clear_buffer(buffer, 0, None);
            self.lab.queue.submit([encoder.finish()]);
        }
        self.dispatch();
        let Bench { launch, histogram, .. } = self.bench;
        let estimates = launch.sampled().estimates();
        let mut tallies = vec![Moments::empty(*histogram); estimates];
        let words = self.lab.read(&self.partials);
        for group in words.chunks_exact(estimates * PARTIAL_WORDS).take(self.groups as usize) {
            for (tally, sums) in tallies.iter_mut().zip(group.chunks_exact(PARTIAL_WORDS)) {
                let word96 =
                    |at: usize| -> u128 { (0..3).map(|i| u128::from(sums[at + i]) << (32 * i)).sum() };
                tally.sum += (word96(0) << 32) as i128 >> 32;
                tally.square += word96(3);
                tally.least = tally.least.min(sums[6] as i32);
                tally.greatest = tally.greatest.max(sums[7] as i32);
            }
        }
        let bins = self.lab.read(&self.bins);
        for (tally, bins) in tallies.iter_mut().zip(bins.chunks_exact(BINS)) {
            tally.count = self.trials;
            tally.bins.iter_mut().zip(bins).for_each(|(bin, &count)| *bin = count.into());
        }
        tallies
    }

    /// Least seconds of a dispatch among as many as take about so long.
    pub fn best(&self, seconds: f64) -> f64 {
        best(seconds, || self.dispatch())
    }
}

/// The least of the seconds that `dispatch` gives in about so many seconds.
pub fn best(seconds: f64, dispatch: impl Fn() -> f64) -> f64 {
    let mut best = dispatch();
    let started = Instant::now();
    while started.elapsed().as_secs_f64() < seconds {
        best = best.min(dispatch());
    }
    best
}
