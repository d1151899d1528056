//! Throughput of each kernel at each width of this processor: `cargo bench`.

use std::sync::Arc;

use divan::counter::ItemsCount;
use sagnac::device::Cpu;
use sagnac_engine::kinds::gap_fill::verify::Configuration;
use sagnac_engine::kinds::relock::Compensation;
use sagnac_engine::kinds::relock::verify::{launches_of, relock};
use sagnac_engine::kinds::switched_run::verify::hour_launches;
use sagnac_kernel::launch::Launch;
use sagnac_kernel::moments::Trials;
use sagnac_kernel::recipe::{Level, Recipe};
use sagnac_kernel::width::Width;
use sagnac_kernel::{Form, KERNELS};

fn main() {
    divan::main();
}

const ITEMS: u64 = 1 << 16;

fn widths() -> Vec<&'static str> {
    Width::available().into_iter().map(Width::name).collect()
}

fn width(name: &str) -> Width {
    Width::available().into_iter().find(|width| width.name() == name).expect("an available width")
}

/// Building blocks over a list of items, including packing into lanes and unpacking.
fn map(bencher: divan::Bencher, kernel: &str, name: &str) {
    let Some(Form::Map(map)) = KERNELS.iter().find(|entry| entry.name == kernel).map(|entry| entry.form)
    else {
        panic!("{kernel} is no building block");
    };
    let items: Vec<u32> =
        (0..ITEMS as u32 * map.inputs as u32).map(|k| k.wrapping_mul(0x9E37_79B9)).collect();
    bencher.counter(ItemsCount::new(ITEMS)).bench_local(|| (map.cpu)(width(name), &items));
}

#[divan::bench(args = widths())]
fn philox(bencher: divan::Bencher, name: &str) {
    map(bencher, "philox", name);
}

#[divan::bench(args = widths())]
fn normal(bencher: divan::Bencher, name: &str) {
    map(bencher, "normal", name);
}

#[divan::bench(args = widths())]
fn sine(bencher: divan::Bencher, name: &str) {
    map(bencher, "sine", name);
}

fn trials(bencher: divan::Bencher, launches: &[Launch], name: &str, count: u64, histogram: bool) {
    let launch = &launches[0];
    bencher
        .counter(ItemsCount::new(count))
        .bench_local(|| launch.tally(width(name), Trials { first: 0, count, histogram }));
}

#[divan::bench(args = widths())]
fn gap_fill_six_estimates(bencher: divan::Bencher, name: &str) {
    trials(bencher, &Configuration::new("paper", |_| {}).launches(), name, ITEMS, false);
}

#[divan::bench(args = widths())]
fn gap_fill_with_histogram(bencher: divan::Bencher, name: &str) {
    trials(bencher, &Configuration::new("paper", |_| {}).launches(), name, ITEMS, true);
}

/// Runs of an hour with 89 or 90 switches each.
#[divan::bench(args = widths(), sample_count = 20)]
fn runs_of_an_hour(bencher: divan::Bencher, name: &str) {
    trials(bencher, &hour_launches(), name, 1 << 12, true);
}

#[divan::bench(args = widths())]
fn relock_uncompensated(bencher: divan::Bencher, name: &str) {
    trials(bencher, &launches_of(&relock(), Compensation::None), name, ITEMS, false);
}

#[divan::bench(args = widths())]
fn relock_from_frequency(bencher: divan::Bencher, name: &str) {
    trials(bencher, &launches_of(&relock(), Compensation::Frequency), name, ITEMS, false);
}

#[divan::bench(args = widths())]
fn relock_from_detuning(bencher: divan::Bencher, name: &str) {
    trials(bencher, &launches_of(&relock(), Compensation::Detuning), name, ITEMS, false);
}

const RECORDS: usize = 1024;

/// Records of 32768 samples on all cores; m and the spacing of differences are powers of two.
fn records(bencher: divan::Bencher, name: &str, overlap: u32) {
    const SAMPLES: u32 = 32_768;
    let mut levels: Vec<Level> = Vec::new();
    for m in (0..14).map(|octave| 1 << octave) {
        let stride = (m / overlap).max(1);
        match levels.last_mut() {
            Some(level) if level.stride == stride => level.spans.push(m / stride),
            _ => levels.push(Level { stride, spans: vec![m / stride] }),
        }
    }
    let recipe = Recipe {
        key: [1, 2],
        samples: SAMPLES,
        white: 16 * 1000,
        rate_scale: 1 << 24,
        walk: 16 * 30,
        flicker: vec![16 * 3000; 15],
        markov: None,
        sine: None,
        quantization: 0,
        pulse: Some(10),
        switching: None,
        drift: Arc::new([]),
        order: 2,
        levels,
    };
    let cpu = Cpu::new(width(name), 0).expect("threads");
    bencher
        .counter(ItemsCount::new(RECORDS as u64 * u64::from(SAMPLES)))
        .bench_local(|| cpu.sums(&recipe, 0, RECORDS, &|_| {}));
}

#[divan::bench(args = widths(), sample_count = 8)]
fn records_with_every_difference(bencher: divan::Bencher, name: &str) {
    records(bencher, name, u32::MAX);
}

#[divan::bench(args = widths(), sample_count = 8)]
fn records_with_differences_a_64th_apart(bencher: divan::Bencher, name: &str) {
    records(bencher, name, 64);
}
