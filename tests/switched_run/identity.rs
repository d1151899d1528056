//! Every width, number of threads, division of the trials and variant of the shaders.

use sagnac::backend::cpu::{Cpu, Width};
use sagnac::block::{Block, cover};
use sagnac::kernel::launch::Launch;
use sagnac::verify::run_launches;

use crate::devices::{Coverage, adapters, jobs, name, on_cpu, on_gpu, open, reference, total, variants};

/// So many that all run some million intervals.
fn trials(launch: &Launch) -> u64 {
    (1 << 20) / launch.steps().next_power_of_two() + 5
}

/// The same trials whole, and in uneven parts from the last to the first.
fn divisions(trials: u64) -> [Vec<Block>; 2] {
    let cuts = [0, 1, trials / 13, trials / 2 + 1, trials];
    [cover(0..trials, 63), cuts.windows(2).rev().flat_map(|cut| cover(cut[0]..cut[1], 9)).collect()]
}

#[test]
fn every_named_run_is_the_same_in_any_width_threads_division_and_shader() {
    let mut coverage = Coverage::start();
    let adapters = adapters();
    for (named, launch) in run_launches() {
        let trials = trials(&launch);
        let blocks = divisions(trials);
        for histogram in [false, true] {
            let expected = reference(&launch, &blocks[0], histogram);
            for width in Width::available() {
                for threads in [1, 2, 3] {
                    for blocks in &blocks {
                        let found = on_cpu(width, threads, &launch, blocks, histogram);
                        assert_eq!(found, expected, "{named} in {}, {threads} threads", width.name());
                        coverage.comparisons += 1;
                    }
                }
            }
            for adapter in &adapters {
                // Without the histogram one way to build it is enough.
                let all = variants(adapter).into_iter().filter(|v| histogram || v.workgroup == 64);
                for variant in all {
                    let mut gpu = open(adapter, variant);
                    let found = on_gpu(&mut gpu, &launch, &blocks[1], histogram);
                    assert_eq!(found, expected, "{named} on {}", name(adapter, variant));
                    gpu.set_tile(launch.steps() * 37);
                    let found = on_gpu(&mut gpu, &launch, &blocks[0], histogram);
                    assert_eq!(found, expected, "{named} on {} in small tiles", name(adapter, variant));
                    coverage.comparisons += 2;
                }
            }
        }
    }
    coverage.end("runs");
}

#[test]
fn trials_beyond_2_to_the_32_are_the_same_too() {
    let (_, launch) = run_launches().remove(2);
    let blocks = cover((1 << 32) - 64..(1 << 32) + 64, 6);
    let expected = reference(&launch, &blocks, true);
    for width in Width::available() {
        let cpu = Cpu::new(width, 2).unwrap();
        assert_eq!(total(&launch, cpu.tally(&jobs(&launch, &blocks), true, &|_| {}), true), expected);
    }
    for adapter in adapters() {
        let mut gpu = open(&adapter, adapter.variant());
        assert_eq!(on_gpu(&mut gpu, &launch, &blocks, true), expected);
    }
}
