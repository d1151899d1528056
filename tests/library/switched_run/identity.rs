//! What the suite of all kernels does not go through: trial numbers beyond 2^32, small tiles, trajectories.

use sagnac::device::Cpu;
use sagnac::tally::cover;
use sagnac_engine::kinds::switched_run::verify::run_launches;
use sagnac_kernel::moments::Trials;
use sagnac_kernel::switched_run::{Shape, trajectory};
use sagnac_kernel::width::Width;

use crate::devices::{adapters, jobs, on_gpu, open, reference, total};

#[test]
fn trials_beyond_2_to_the_32_are_the_same_too() {
    for (name, launch) in run_launches() {
        let blocks = cover((1 << 32) - 64..(1 << 32) + 64, 6);
        let expected = reference(&launch, &blocks, true);
        for width in Width::available() {
            let cpu = Cpu::new(width, 2).unwrap();
            let found = total(&launch, cpu.tally(&jobs(&launch, &blocks), true, &|_| {}), true);
            assert_eq!(found, expected, "{name} in {}", width.name());
        }
        for adapter in adapters() {
            let mut gpu = open(&adapter, adapter.variant());
            assert_eq!(on_gpu(&mut gpu, &launch, &blocks, true), expected, "{name}");
            gpu.set_tile(launch.steps() * 37);
            assert_eq!(on_gpu(&mut gpu, &launch, &blocks, true), expected, "{name} in small tiles");
        }
    }
}

#[test]
fn trajectories_end_where_tallies_say_and_reach_as_far() {
    for (name, launch) in run_launches() {
        let shape: Shape = launch.shape().expect("a run");
        // A trajectory goes on to the end of the last interval, an end that is drawn lies before.
        if !shape.ends || shape.any_end {
            continue;
        }
        for trial in [0, 1, 77, (1 << 33) + 5] {
            let angles = trajectory(&launch, shape, trial);
            let one = Trials { first: trial, count: 1, histogram: false };
            for width in Width::available() {
                let tallies = launch.tally(width, one);
                assert_eq!(angles.last().copied(), Some(tallies[0].least), "{name}, run {trial}");
                assert_eq!(angles.iter().map(|angle| angle.abs()).max(), Some(tallies[1].least), "{name}");
            }
        }
    }
}
