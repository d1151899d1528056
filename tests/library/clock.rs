//! The clock of a GPU: time stamps of its own.

use std::time::Instant;

use sagnac::device::load::Work;
use sagnac::tally::block::cover;
use sagnac::verify::measured::measured;

use crate::devices::{adapters, jobs, open};

#[test]
fn the_device_works_no_longer_than_the_calls_take_and_gives_the_same_results() {
    for adapter in adapters() {
        let mut gpu = open(&adapter, adapter.variant());
        for load in measured().iter().filter(|load| ["gap_fill", "allan"].contains(&load.kernel)) {
            let run = |gpu: &mut sagnac::device::gpu::Gpu| match &load.work {
                Work::Trials(launch) => {
                    let blocks = cover(0..100_000, 12);
                    format!("{:?}", gpu.tally(&jobs(launch, &blocks), load.histogram, &|_| {}).unwrap())
                }
                Work::Records(recipe) => format!("{:?}", gpu.sums(&**recipe, 0, 2, &|_| {}).unwrap()),
            };
            let results = run(&mut gpu);
            gpu.start_clock();
            let started = Instant::now();
            let timed = run(&mut gpu);
            let wall = started.elapsed().as_secs_f64();
            assert!(timed == results, "{}: {} differs under a clock", gpu.name(), load.configuration);
            match gpu.device_seconds() {
                Some(seconds) => assert!(
                    0.0 < seconds && seconds <= wall,
                    "{}: {}: {seconds} s on the device in {wall} s",
                    gpu.name(),
                    load.configuration
                ),
                None => assert!(!adapter.is_software(), "{} has time stamps", gpu.name()),
            }
        }
    }
}

#[test]
fn a_clock_starts_from_zero() {
    for adapter in adapters() {
        let mut gpu = open(&adapter, adapter.variant());
        assert_eq!(gpu.device_seconds(), None, "{}: no clock runs", gpu.name());
        let limit = gpu.integer_limit().unwrap_or_else(|error| panic!("{}: {error}", gpu.name()));
        assert_eq!(limit.is_some(), gpu.device_seconds().is_some());
        assert!(limit.is_none_or(|limit| limit > 1e6), "{}: {limit:?} operations/s", gpu.name());
        gpu.start_clock();
        assert_eq!(gpu.device_seconds(), None, "{}: nothing was done", gpu.name());
    }
}
