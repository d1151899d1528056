//! `sagnac bench`.

use std::time::Instant;

use sagnac::backend::cpu::{Cpu, Width};
use sagnac::backend::gpu::GpuError;
use sagnac::backend::{Device, Job, SelectError, select};
use sagnac::block::cover;
use sagnac::verify::Configuration;
use serde::Serialize;

use super::Failure;
use super::output::{print, print_json};

/// One measurement.
#[derive(Debug, Serialize)]
struct Figure {
    device: String,
    kernel: &'static str,
    histogram: bool,
    /// Best of the runs.
    million_trials_per_second: f64,
}

/// Runs of a measurement; each takes about this long.
const RUNS: usize = 5;
const SECONDS: f64 = 0.5;

/// Measures the gap-fill kernel with six estimates, on every width of the CPU and on the device.
pub fn bench(options: &super::Bench) -> Result<(), Failure> {
    let selection = select(&options.device.name)?;
    eprintln!("device: {}, {}", selection.device.name(), selection.reason);
    let mut devices = Vec::new();
    if let Device::Gpu(_) = selection.device {
        devices.push(selection.device);
    }
    for width in Width::available() {
        devices.push(Device::Cpu(Cpu::new(width, 0).map_err(SelectError::from)?));
    }
    let mut figures = Vec::new();
    for device in &mut devices {
        for histogram in [false, true] {
            let rate = measure(device, histogram)?;
            let figure = Figure {
                device: device.name(),
                kernel: "gap_fill",
                histogram,
                million_trials_per_second: rate / 1e6,
            };
            if !options.json {
                let with = if histogram { "with histogram" } else { "without histogram" };
                let Figure { device, kernel, million_trials_per_second: rate, .. } = &figure;
                print(&format!("{kernel}, six estimates, {with:17} {rate:9.1} million trials/s  {device}"))?;
            }
            figures.push(figure);
        }
    }
    if options.json {
        print_json(&figures)?;
    }
    Ok(())
}

/// Best rate of some runs, trials per second.
fn measure(device: &mut Device, histogram: bool) -> Result<f64, GpuError> {
    let launch = &Configuration::new("paper", |_| {}).launches()[0];
    let mut trials = 1_u64 << 20;
    let mut best = 0.0_f64;
    let mut runs = 0;
    while runs < RUNS {
        let jobs: Vec<Job> = cover(0..trials, 24).into_iter().map(|block| Job { launch, block }).collect();
        let started = Instant::now();
        device.tally(&jobs, histogram, &|_| {})?;
        let seconds = started.elapsed().as_secs_f64();
        if seconds < SECONDS / 2.0 {
            trials *= 2;
        } else {
            best = best.max(trials as f64 / seconds);
            runs += 1;
        }
    }
    Ok(best)
}
