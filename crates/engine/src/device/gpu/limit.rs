//! The integer limit of a device: how many operations per second it does in chains that wait for nothing.

use std::fmt::Write as _;
use std::time::Instant;

use wgpu::BufferUsages;

use crate::device::error::GpuError;
use crate::device::gpu::Gpu;

/// Independent chains of an invocation, and the steps of each chain in a round of the loop.
const CHAINS: u64 = 8;
const STEPS: u64 = 8;

/// Rounds of an invocation: some milliseconds on a large GPU, half a second on a small one.
const ROUNDS: u64 = 1024;

/// A multiplication, an addition and two logic operations.
const OPERATIONS: u64 = 4;

/// How long it is measured, so that the clock rate of the device rises.
const SECONDS: f64 = 0.3;

impl Gpu {
    /// Operations of 32 bits per second, best of some runs, measured by the clock of the device, which this starts anew;
    /// `None` where the adapter has no time stamps.
    ///
    /// # Errors
    /// The device is lost, refuses the work or is out of memory.
    pub fn integer_limit(&mut self) -> Result<Option<f64>, GpuError> {
        let groups = self.adapter.capacity().groups;
        let workgroup = self.variant.workgroup;
        let pipeline = self.pipeline((shader(workgroup), false))?;
        let words = self.upload("factors", bytemuck::cast_slice(&FACTORS), BufferUsages::STORAGE)?;
        let results = self.buffer("results", 4 * groups * u64::from(workgroup), BufferUsages::STORAGE)?;
        let resources = vec![(1, words.as_entire_binding()), (2, results.as_entire_binding())];
        let bind_group = self.bind_group(&pipeline, resources);
        let operations = groups * u64::from(workgroup) * ROUNDS * STEPS * CHAINS * OPERATIONS;
        let mut best = 0.0_f64;
        let started = Instant::now();
        while started.elapsed().as_secs_f64() < SECONDS {
            self.start_clock();
            let mut encoder = self.device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
            pipeline.dispatch(&mut encoder, &bind_group, [groups as u32, 1]);
            let submission = self.submit(encoder, operations)?;
            self.wait(&submission)?;
            let Some(seconds) = self.device_seconds() else { return Ok(None) };
            best = best.max(operations as f64 / seconds);
        }
        Ok(Some(best))
    }
}

/// What the chains multiply by, add and combine with, which the compiler must not know.
const FACTORS: [u32; 4] = [0x9E37_79B1, 0x7F4A_7C15, 0x1656_67B1, 0xFFFF_FFFB];

fn shader(workgroup: u32) -> String {
    let mut text = format!(
        "@group(0) @binding(1) var<storage, read> f: array<u32, 4>;
        @group(0) @binding(2) var<storage, read_write> results: array<u32>;
        @compute @workgroup_size({workgroup})
        fn main(@builtin(global_invocation_id) id: vec3<u32>) {{
            let a = f[0]; let b = f[1]; let c = f[2]; let d = f[3];\n"
    );
    for chain in 0..CHAINS {
        let _ = writeln!(text, "var x{chain} = id.x + {chain}u * a;");
    }
    let _ = writeln!(text, "for (var round = 0u; round < {ROUNDS}u; round++) {{");
    for chain in (0..STEPS).flat_map(|_| 0..CHAINS) {
        let _ = writeln!(text, "x{chain} = ((x{chain} * a + b) ^ c) & d;");
    }
    let all: Vec<String> = (0..CHAINS).map(|chain| format!("x{chain}")).collect();
    let _ = writeln!(text, "}}\nresults[id.x] = {};\n}}", all.join(" ^ "));
    text
}
