//! Groups of devices: the same bits, whatever share of the work each of them has.

use crate::devices::{Coverage, adapters, jobs, open, reference};
use sagnac::device::{Cpu, Device};
use sagnac::tally::{Block, cover};
use sagnac::verify::loads;
use sagnac_kernel::KERNELS;
use sagnac_kernel::width::Width;

fn cpu(width: Width, threads: usize) -> Device {
    Device::Cpu(Cpu::new(width, threads).unwrap())
}

/// Two processors of different speed, and a processor and an adapter.
fn groups() -> [Device; 2] {
    let adapter = &adapters()[0];
    let gpu = Device::Gpu(Box::new(open(adapter, adapter.variant())));
    [cpu(Width::PORTABLE, 1).and(cpu(Width::widest(), 2)), gpu.and(cpu(Width::widest(), 1))]
}

#[test]
fn a_group_gives_the_tallies_of_one_device() {
    let mut coverage = Coverage::start();
    let wrap = 1 << 32;
    let of_blocks: [Vec<Block>; 4] = [
        vec![Block { first: 0, log2: 0 }],
        vec![Block { first: wrap - (1 << 11), log2: 11 }],
        cover(wrap - 1500..wrap + 77, 9),
        cover(5..6000, 10),
    ];
    for mut group in groups() {
        for load in KERNELS.iter().flat_map(|kernel| loads(kernel).into_iter().step_by(7)) {
            let Some(launch) = load.launch() else { continue };
            // The shares differ from batch to batch, as they follow the measured speed.
            for blocks in &of_blocks {
                let found = group.tally(&jobs(launch, blocks), true, &|_| {}).unwrap();
                for (&block, found) in blocks.iter().zip(found) {
                    let place = format!("{}, {block:?}, {}", load.name, group.name());
                    assert_eq!(found, reference(launch, &[block], true), "{place}");
                }
                coverage.comparisons += blocks.len();
            }
        }
    }
    coverage.end("groups of devices");
}
