//! Throughput of each kernel on each width of this processor: `cargo bench`.

use divan::counter::ItemsCount;
use sagnac::backend::cpu::Width;
use sagnac::kernel::{Form, KERNELS, gap_fill};
use sagnac::verify::Configuration;

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

/// Building blocks over a list of items; packing items into lanes and out again is part of it.
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

#[divan::bench(args = widths())]
fn gap_fill_six_estimates(bencher: divan::Bencher, name: &str) {
    let launch = &Configuration::new("paper", |_| {}).launches()[0];
    bencher
        .counter(ItemsCount::new(ITEMS))
        .bench_local(|| gap_fill::tally(width(name), launch, 0, ITEMS, false));
}

#[divan::bench(args = widths())]
fn gap_fill_with_histogram(bencher: divan::Bencher, name: &str) {
    let launch = &Configuration::new("paper", |_| {}).launches()[0];
    bencher
        .counter(ItemsCount::new(ITEMS))
        .bench_local(|| gap_fill::tally(width(name), launch, 0, ITEMS, true));
}
