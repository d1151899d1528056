//! Part `host`: what submissions, buffers, pipelines and reading back cost besides the work of the device.

use std::time::Instant;

use sagnac_kernel::shader::Variant;
use serde_json::json;
use wgpu::BufferUsages as Use;

use crate::lab::{Kernel, Lab};
use crate::{Options, benches, emit};

/// Mean time of `count` runs after a first one.
fn mean(what: &str, count: u32, mut run: impl FnMut()) {
    run();
    let started = Instant::now();
    for _ in 0..count {
        run();
    }
    tell(what, started.elapsed().as_secs_f64() / f64::from(count), None);
}

fn tell(what: &str, seconds: f64, bytes: Option<u64>) {
    let per_second = bytes.map(|bytes| bytes as f64 / seconds);
    eprintln!("{what:64} {:10.2} µs", seconds * 1e6);
    emit(
        &json!({ "part": "host", "what": what, "microseconds": seconds * 1e6, "bytes_per_second": per_second }),
    );
}

pub fn host(options: &Options) {
    let lab = Lab::open(options);
    let times = if options.tiny { 2 } else { 400 };
    let encoder = || lab.device.create_command_encoder(&Default::default());
    mean("submit nothing and wait", times, || {
        lab.seconds(encoder());
    });
    mean("a buffer of 256 bytes with its words", times, || {
        lab.upload(&[0; 64], Use::STORAGE);
    });
    lab.seconds(encoder());
    let bench = &benches()[1];
    let variant = Variant { int64: lab.int64, checked: false, workgroup: 64 };
    let (text, _) = bench.launch.shader(true, variant);
    let mut words = 0;
    mean("a pipeline: naga and the driver", if options.tiny { 1 } else { 5 }, || {
        // Another shader each time, which no cache holds.
        words += 1;
        let shared = format!("array<atomic<u32>, SHARED_WORDS + {words}u>");
        lab.pipeline(&text.replace("array<atomic<u32>, SHARED_WORDS>", &shared), false);
    });
    let kernel = Kernel::new(&lab, &text, bench, variant, [1, 1]);
    let dispatched = |passes: u32| {
        let mut encoder = encoder();
        for _ in 0..passes {
            let mut pass = encoder.begin_compute_pass(&Default::default());
            pass.set_pipeline(&kernel.pipeline);
            pass.set_bind_group(0, &kernel.group, &[]);
            pass.dispatch_workgroups(1, 1, 1);
        }
        encoder
    };
    mean("dispatch one workgroup of one round and wait", times, || {
        lab.seconds(dispatched(1));
    });
    for passes in [64, 512] {
        let started = Instant::now();
        lab.seconds(dispatched(passes));
        let what = format!("each of {passes} passes of one workgroup in one submission (a barrier between)");
        tell(&what, started.elapsed().as_secs_f64() / f64::from(passes), None);
    }
    for log2 in if options.tiny { vec![20] } else { vec![16, 20, 23, 24, 26] } {
        let size = 1_u64 << log2;
        let from = lab.buffer(size, Use::STORAGE | Use::COPY_SRC);
        let made = || lab.buffer(size, Use::MAP_READ | Use::COPY_DST);
        let kept = made();
        for (into, fresh) in [("a buffer that is kept", false), ("a new buffer", true)] {
            let mut best = f64::INFINITY;
            for _ in 0..if options.tiny { 2 } else { 10 } {
                let started = Instant::now();
                read_back(&lab, &from, &if fresh { made() } else { kept.clone() });
                best = best.min(started.elapsed().as_secs_f64());
            }
            tell(&format!("read back 2^{log2} bytes into {into}"), best, Some(size));
        }
    }
}

fn read_back(lab: &Lab, from: &wgpu::Buffer, to: &wgpu::Buffer) {
    let mut encoder = lab.device.create_command_encoder(&Default::default());
    encoder.copy_buffer_to_buffer(from, 0, to, 0, from.size());
    lab.queue.submit([encoder.finish()]);
    to.map_async(wgpu::MapMode::Read, .., |result| result.expect("mapped"));
    lab.wait();
    let bytes = to.get_mapped_range(..).expect("mapped");
    let words: &[u32] = bytemuck::cast_slice(&bytes);
    std::hint::black_box(words.iter().map(|&word| u64::from(word)).sum::<u64>());
    drop(bytes);
    to.unmap();
}
