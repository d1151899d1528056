//! Tallies of launches on every width and adapter of this machine.
#![allow(dead_code, reason = "each test binary uses a part")]

use std::time::Instant;

use sagnac::device::gpu::Gpu;
use sagnac::device::gpu::adapter::Adapter;
use sagnac::device::{Cpu, Job};
use sagnac::tally::Block;
use sagnac_kernel::launch::Launch;
use sagnac_kernel::moments::Moments;
use sagnac_kernel::shader::Variant;
use sagnac_kernel::width::Width;

/// Every adapter of this machine. The GPU half of these tests is never skipped.
pub fn adapters() -> Vec<Adapter> {
    let adapters = Adapter::all();
    assert!(
        !adapters.is_empty(),
        "no Vulkan adapter was found, so identity on a GPU cannot be shown: run ./test, or install a software one \
         (apt-get install mesa-vulkan-drivers libvulkan1)"
    );
    adapters
}

/// Invocations of a workgroup.
const WORKGROUPS: [u32; 3] = [32, 64, 128];

/// Every way to build the shaders that an adapter can run.
pub fn variants(adapter: &Adapter) -> Vec<Variant> {
    let products: &[bool] = if adapter.has_int64() { &[true, false] } else { &[false] };
    let mut all = Vec::new();
    for &int64 in products {
        for checked in [false, true] {
            all.extend(WORKGROUPS.map(|workgroup| Variant { int64, checked, workgroup }));
        }
    }
    all
}

/// Whether a variant has the size of workgroups with which the configuration at `place` is tested: compilers take seconds for each.
pub fn is_turn(variant: Variant, place: usize) -> bool {
    variant.workgroup == WORKGROUPS[place % WORKGROUPS.len()]
}

pub fn name(adapter: &Adapter, variant: Variant) -> String {
    let products = if variant.int64 { "u64" } else { "split" };
    let checks = if variant.checked { "checked" } else { "unchecked" };
    format!("{} {products} {checks} {}", adapter.name(), variant.workgroup)
}

pub fn open(adapter: &Adapter, variant: Variant) -> Gpu {
    Gpu::open(adapter, variant).unwrap_or_else(|error| panic!("{}: {error}", name(adapter, variant)))
}

pub fn jobs<'a>(launch: &'a Launch, blocks: &[Block]) -> Vec<Job<'a>> {
    blocks.iter().map(|&block| Job { launch, block }).collect()
}

/// The tallies of all parts in one.
pub fn total(launch: &Launch, parts: Vec<Vec<Moments>>, histogram: bool) -> Vec<Moments> {
    let mut total = vec![Moments::empty(histogram); launch.sampled().estimates()];
    for part in parts {
        assert_eq!(part.len(), total.len());
        for (total, part) in total.iter_mut().zip(&part) {
            total.merge(part);
        }
    }
    total
}

pub fn on_cpu(
    width: Width,
    threads: usize,
    launch: &Launch,
    blocks: &[Block],
    histogram: bool,
) -> Vec<Moments> {
    let cpu = Cpu::new(width, threads).unwrap();
    total(launch, cpu.tally(&jobs(launch, blocks), histogram, &|_| {}), histogram)
}

pub fn on_gpu(gpu: &mut Gpu, launch: &Launch, blocks: &[Block], histogram: bool) -> Vec<Moments> {
    let parts =
        gpu.tally(&jobs(launch, blocks), histogram, &|_| {}).unwrap_or_else(|error| panic!("{error}"));
    total(launch, parts, histogram)
}

pub fn reference(launch: &Launch, blocks: &[Block], histogram: bool) -> Vec<Moments> {
    on_cpu(Width::PORTABLE, 0, launch, blocks, histogram)
}

/// Says on the standard output what a test went through.
pub struct Coverage {
    started: Instant,
    pub comparisons: usize,
}

impl Coverage {
    pub fn start() -> Coverage {
        Coverage { started: Instant::now(), comparisons: 0 }
    }

    pub fn end(self, what: &str) {
        println!("{what}: {} comparisons, {:.1} s", self.comparisons, self.started.elapsed().as_secs_f64());
    }
}
