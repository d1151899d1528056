//! `sagnac bench`.

use std::time::Instant;

use sagnac::backend::cpu::{Cpu, Width};
use sagnac::backend::gpu::GpuError;
use sagnac::backend::{Device, Job, SelectError, select};
use sagnac::block::cover;
use sagnac::kernel::launch::Launch;
use sagnac::verify::configurations;
use serde::Serialize;

use super::Failure;
use super::output::{print, print_json};

/// One measurement.
#[derive(Debug, Serialize)]
struct Figure {
    device: String,
    kernel: &'static str,
    /// The configuration that is sampled.
    configuration: &'static str,
    estimates: usize,
    histogram: bool,
    /// Best of the runs.
    million_trials_per_second: f64,
}

/// Runs of a measurement; each takes about this long.
const RUNS: usize = 5;
const SECONDS: f64 = 0.5;

/// What is measured: configurations of `verify`, and whether with the histogram that a run has.
const MEASURED: [(&str, bool); 5] = [
    ("paper", false),
    ("paper", true),
    ("minimum-variance", false),
    ("eight-tones", false),
    ("profile", false),
];

/// Measures the gap-fill kernel on every width of the CPU and on the device.
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
    let all = configurations();
    for device in &mut devices {
        for (name, histogram) in MEASURED {
            let Some(launch) =
                all.iter().find(|c| c.name == name).and_then(|c| c.launches().into_iter().next())
            else {
                continue;
            };
            let figure = Figure {
                device: device.name(),
                kernel: "gap_fill",
                configuration: name,
                estimates: launch.shape.estimates(),
                histogram,
                million_trials_per_second: measure(device, &launch, histogram)? / 1e6,
            };
            if !options.json {
                let with = if histogram { "with histogram" } else { "without histogram" };
                let Figure { device, kernel, estimates, million_trials_per_second: rate, .. } = &figure;
                print(&format!(
                    "{kernel}, {name}, {estimates} estimates, {with:17} {rate:9.1} million trials/s  {device}"
                ))?;
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
fn measure(device: &mut Device, launch: &Launch, histogram: bool) -> Result<f64, GpuError> {
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
