//! `sagnac bench`.

use std::time::Instant;

use sagnac::device::cpu::Cpu;
use sagnac::device::error::GpuError;
use sagnac::device::select::SelectError;
use sagnac::device::{Device, Job};
use sagnac::kernel::launch::Launch;
use sagnac::kernel::recipe::Recipe;
use sagnac::kernel::width::Width;
use sagnac::kinds::allan::verify::{NamedRecords, THINNED, lgk_400};
use sagnac::kinds::gap_fill::verify::configurations;
use sagnac::kinds::relock::inputs::Compensation;
use sagnac::kinds::relock::verify::{launches_of, relock};
use sagnac::kinds::switched_run::verify::hour_launches;
use sagnac::tally::block::cover;
use sagnac::theory::allan::estimator::Estimator;
use sagnac::verify::select;
use serde::Serialize;

use crate::failure::Failure;
use crate::output::{print, print_json};

/// One measurement.
#[derive(Debug, Serialize)]
struct Figure {
    device: String,
    kernel: &'static str,
    /// The configuration that is sampled.
    configuration: &'static str,
    /// Number of estimates of a trial, or of averaging times of a record.
    estimates: usize,
    histogram: bool,
    /// Best rate of all runs.
    #[serde(flatten)]
    rate: Rate,
}

#[derive(Debug, Serialize)]
enum Rate {
    #[serde(rename = "million_trials_per_second")]
    Trials(f64),
    #[serde(rename = "million_runs_per_second")]
    Runs(f64),
    #[serde(rename = "million_samples_per_second")]
    Samples(f64),
}

/// Number of runs of a measurement; each takes about this long.
const RUNS: usize = 5;
const SECONDS: f64 = 0.5;

/// Measured gap-fill configurations: those of `verify`, and whether they have a histogram as in studies.
const MEASURED: [(&str, bool); 5] = [
    ("paper", false),
    ("paper", true),
    ("minimum-variance", false),
    ("eight-tones", false),
    ("profile", false),
];

/// The kernel whose trials are whole runs.
const RUNS_KERNEL: &str = "switched_run";

/// Records of nine hours at 1 Hz, with differences spaced by a 64th of τ, and at every sample.
const MEASURED_RECORDS: [(&str, Estimator); 2] =
    [("lgk-400, overlap m/64", THINNED), ("lgk-400, full overlap", Estimator::OVERLAPPING)];
const SAMPLES: u64 = 32_400;

/// Measures the kernels for trials and records at every width of the CPU and on the device.
pub fn bench(options: &crate::program::Bench) -> Result<(), Failure> {
    let selection = select(&options.device.name, options.device.threads.unwrap_or(0))?;
    say!("device: {}, {}", selection.device.name(), selection.reason);
    let mut devices = Vec::new();
    if let Device::Gpu(_) = selection.device {
        devices.push(selection.device);
    }
    for width in Width::available() {
        devices.push(Device::Cpu(Cpu::new(width, 0).map_err(SelectError::from)?));
    }
    let mut figures = Vec::new();
    let mut found = |figure: Figure| {
        if !options.json {
            print(&figure.line())?;
        }
        figures.push(figure);
        Ok::<_, Failure>(())
    };
    let measured = measured();
    for device in &mut devices {
        for Measured { kernel, configuration, launch, histogram } in &measured {
            let rate = if *kernel == RUNS_KERNEL {
                Rate::Runs(trials_per_second(device, launch, *histogram, 1 << 12)? / 1e6)
            } else {
                Rate::Trials(trials_per_second(device, launch, *histogram, 1 << 20)? / 1e6)
            };
            found(Figure {
                device: device.name(),
                kernel,
                configuration,
                estimates: launch.sampled.estimates(),
                histogram: *histogram,
                rate,
            })?;
        }
        for (name, estimator) in MEASURED_RECORDS {
            let named = NamedRecords {
                name,
                parts: lgk_400(),
                readout_lsb: 0.0,
                switching: None,
                samples: SAMPLES,
                estimator,
            };
            let records = named.lowered();
            found(Figure {
                device: device.name(),
                kernel: "allan",
                configuration: name,
                estimates: records.ms().len(),
                histogram: false,
                rate: Rate::Samples(samples_per_second(device, records.recipe())? / 1e6),
            })?;
        }
    }
    if options.json {
        print_json(&figures)?;
    }
    Ok(())
}

/// A measured kernel of trials.
struct Measured {
    kernel: &'static str,
    configuration: &'static str,
    launch: Launch,
    histogram: bool,
}

/// All measured kernels of trials.
fn measured() -> Vec<Measured> {
    let all = configurations();
    let mut measured = Vec::new();
    let mut add = |kernel, configuration, launches: Vec<Launch>, histogram| {
        let first = launches.into_iter().next();
        measured.extend(first.map(|launch| Measured { kernel, configuration, launch, histogram }));
    };
    for (name, histogram) in MEASURED {
        if let Some(configuration) = all.iter().find(|configuration| configuration.name == name) {
            add("gap_fill", name, configuration.launches(), histogram);
        }
    }
    add(RUNS_KERNEL, "one hour, MT = 40 s, 89 switches", hour_launches(), true);
    for compensation in Compensation::ALL {
        add("relock", compensation.name(), launches_of(&relock(), compensation), false);
    }
    measured
}

impl Figure {
    fn line(&self) -> String {
        let Figure { device, kernel, configuration, estimates, .. } = self;
        match self.rate {
            Rate::Trials(rate) | Rate::Runs(rate) => {
                let with = if self.histogram { "with histogram" } else { "without histogram" };
                let (what, digits) = if let Rate::Runs(_) = self.rate { ("runs", 3) } else { ("trials", 1) };
                format!(
                    "{kernel}, {configuration}, {estimates} estimates, {with:17} {rate:9.digits$} million {what}/s  {device}"
                )
            }
            Rate::Samples(rate) => {
                format!(
                    "{kernel}, {configuration}, {estimates} averaging times {rate:9.1} million samples/s  {device}"
                )
            }
        }
    }
}

/// The best rate of some runs, of which the first has this number of trials.
fn trials_per_second(
    device: &mut Device,
    launch: &Launch,
    histogram: bool,
    first: u64,
) -> Result<f64, GpuError> {
    best(first, |trials| {
        let jobs: Vec<Job> = cover(0..trials, 24).into_iter().map(|block| Job { launch, block }).collect();
        device.tally(&jobs, histogram, &|_| {}).map(drop)
    })
}

/// The best rate of some runs.
fn samples_per_second(device: &mut Device, recipe: &Recipe) -> Result<f64, GpuError> {
    let records = best(64, |records| device.sums(recipe, 0, records as usize, &|_| {}).map(drop))?;
    Ok(records * f64::from(recipe.samples))
}

/// The best rate of some runs, in units per second. The number of units is `units` times the power of two that makes a
/// run long enough.
fn best(mut units: u64, mut run: impl FnMut(u64) -> Result<(), GpuError>) -> Result<f64, GpuError> {
    let mut best = 0.0_f64;
    let mut runs = 0;
    while runs < RUNS {
        let started = Instant::now();
        run(units)?;
        let seconds = started.elapsed().as_secs_f64();
        if seconds < SECONDS / 2.0 {
            units *= 2;
        } else {
            best = best.max(units as f64 / seconds);
            runs += 1;
        }
    }
    Ok(best)
}
