//! Time on the device, by its own time stamps before and after each submission.

use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};

use wgpu::{BufferUsages, Features};

use crate::device::gpu::Gpu;

/// Time stamps of the submissions since it was started.
pub(crate) struct Clock {
    stamps: wgpu::QuerySet,
    resolved: wgpu::Buffer,
    /// Ticks of all completed submissions.
    ticks: Arc<AtomicU64>,
}

impl Gpu {
    /// Measures the time of all later work on the device, from zero. Where the adapter has no time stamps, this does
    /// nothing.
    pub fn start_clock(&mut self) {
        let buffer =
            |usage| wgpu::BufferDescriptor { label: None, size: 16, usage, mapped_at_creation: false };
        self.clock = self.device.features().contains(Features::TIMESTAMP_QUERY).then(|| Clock {
            stamps: self.device.create_query_set(&wgpu::QuerySetDescriptor {
                label: None,
                ty: wgpu::QueryType::Timestamp,
                count: 2,
            }),
            resolved: self
                .device
                .create_buffer(&buffer(BufferUsages::QUERY_RESOLVE | BufferUsages::COPY_SRC)),
            ticks: Arc::default(),
        });
    }

    /// Seconds for which the device has worked since its clock was started; `None` without a clock or work. The work of
    /// methods that have returned is included.
    pub fn device_seconds(&self) -> Option<f64> {
        let ticks = self.clock.as_ref()?.ticks.load(Ordering::Relaxed);
        (ticks > 0).then(|| ticks as f64 * f64::from(self.queue.get_timestamp_period()) * 1e-9)
    }

    /// Submits commands, between two time stamps where a clock runs.
    pub(crate) fn submit_timed(&self, commands: wgpu::CommandBuffer) -> wgpu::SubmissionIndex {
        let Some(Clock { stamps, resolved, ticks }) = &self.clock else {
            return self.queue.submit([commands]);
        };
        // Passes without work: a stamp within an encoder would need a feature that fewer devices have.
        let stamp = |beginning_of_pass_write_index, end_of_pass_write_index| {
            let mut encoder = self.device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
            let timestamp_writes = Some(wgpu::ComputePassTimestampWrites {
                query_set: stamps,
                beginning_of_pass_write_index,
                end_of_pass_write_index,
            });
            encoder.begin_compute_pass(&wgpu::ComputePassDescriptor { label: None, timestamp_writes });
            encoder
        };
        let (before, mut after) = (stamp(Some(0), None), stamp(None, Some(1)));
        let usage = BufferUsages::MAP_READ | BufferUsages::COPY_DST;
        let read = self.device.create_buffer(&wgpu::BufferDescriptor {
            label: None,
            size: resolved.size(),
            usage,
            mapped_at_creation: false,
        });
        after.resolve_query_set(stamps, 0..2, resolved, 0);
        after.copy_buffer_to_buffer(resolved, 0, &read, 0, read.size());
        let index = self.queue.submit([before.finish(), commands, after.finish()]);
        let (mapped, ticks) = (read.clone(), Arc::clone(ticks));
        // Whoever waits for the submission makes wgpu call this.
        read.map_async(wgpu::MapMode::Read, .., move |_| {
            if let Ok(bytes) = mapped.get_mapped_range(..) {
                let [from, to]: [u64; 2] = bytemuck::pod_read_unaligned(&bytes);
                ticks.fetch_add(to.saturating_sub(from), Ordering::Relaxed);
            }
        });
        index
    }
}
