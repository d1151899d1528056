//! `sagnac bench`.

use std::time::Instant;

use sagnac::device::cpu::Cpu;
use sagnac::device::error::GpuError;
use sagnac::device::select::SelectError;
use sagnac::device::{Device, Job};
use sagnac::kernel::launch::Launch;
use sagnac::kernel::width::Width;
use sagnac::kinds::allan::lower::Records;
use sagnac::kinds::allan::verify::{NamedRecords, THINNED, lgk_400};
use sagnac::kinds::gap_fill::verify::configurations;
use sagnac::kinds::relock::inputs::Compensation;
use sagnac::kinds::relock::verify::{launches_of, relock};
use sagnac::kinds::switched_run::verify::hour_launches;
use sagnac::tally::block::cover;
use sagnac::theory::allan::estimator::Estimator;
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

/// Records of nine hours at 1 Hz, with differences spaced by a 64th of τ, and at every sample.
const MEASURED_RECORDS: [(&str, Estimator); 2] =
    [("lgk-400, overlap m/64", THINNED), ("lgk-400, full overlap", Estimator::OVERLAPPING)];
const SAMPLES: u64 = 32_400;

/// Measures the kernels for trials and records at every width of the CPU and on the device.
pub fn bench(options: &crate::program::Bench) -> Result<(), Failure> {
    let mut devices = options.device.select(true)?.into_devices();
    // The CPU follows at every width.
    devices.retain(|device| matches!(device, Device::Gpu(_)));
    for width in Width::available() {
        devices.push(Device::Cpu(Cpu::new(width, 0).map_err(SelectError::from)?));
    }
    let (measured, mut figures) = (measured(), Vec::new());
    for device in &mut devices {
        for measured in &measured {
            let figure = measured.on(device)?;
            if !options.json {
                print(&figure.line())?;
            }
            figures.push(figure);
        }
    }
    if options.json { print_json(&figures) } else { Ok(()) }
}

/// A measured kernel.
struct Measured {
    kernel: &'static str,
    configuration: &'static str,
    work: Work,
    histogram: bool,
}

/// The work of a kernel, by what is counted.
enum Work {
    Trials(Launch),
    Runs(Launch),
    Samples(Box<Records>),
}

/// All measured kernels.
fn measured() -> Vec<Measured> {
    let all = configurations();
    let mut measured = Vec::new();
    let mut add = |kernel, configuration, work: Option<Work>, histogram| {
        measured.extend(work.map(|work| Measured { kernel, configuration, work, histogram }));
    };
    let first = |launches: Vec<Launch>| launches.into_iter().next();
    for (name, histogram) in MEASURED {
        let found = all.iter().find(|configuration| configuration.name == name);
        let launch = found.and_then(|configuration| first(configuration.launches()));
        add("gap_fill", name, launch.map(Work::Trials), histogram);
    }
    add("switched_run", "one hour, MT = 40 s, 89 switches", first(hour_launches()).map(Work::Runs), true);
    for compensation in Compensation::ALL {
        let launch = first(launches_of(&relock(), compensation));
        add("relock", compensation.name(), launch.map(Work::Trials), false);
    }
    for (name, estimator) in MEASURED_RECORDS {
        let (parts, samples) = (lgk_400(), SAMPLES);
        let named = NamedRecords { name, parts, readout_lsb: 0.0, switching: None, samples, estimator };
        add("allan", name, Some(Work::Samples(Box::new(named.lowered()))), false);
    }
    measured
}

impl Measured {
    fn on(&self, device: &mut Device) -> Result<Figure, GpuError> {
        let Measured { kernel, configuration, histogram, .. } = *self;
        let mut trials = |launch, first| {
            best(first, |trials| {
                let blocks = cover(0..trials, 24);
                let jobs: Vec<Job> = blocks.into_iter().map(|block| Job { launch, block }).collect();
                device.tally(&jobs, histogram, &|_| {}).map(drop)
            })
        };
        let (estimates, rate) = match &self.work {
            Work::Trials(launch) => {
                (launch.sampled.estimates(), Rate::Trials(trials(launch, 1 << 20)? / 1e6))
            }
            Work::Runs(launch) => (launch.sampled.estimates(), Rate::Runs(trials(launch, 1 << 12)? / 1e6)),
            Work::Samples(records) => {
                let recipe = records.recipe();
                let made = best(64, |count| device.sums(recipe, 0, count as usize, &|_| {}).map(drop))?;
                (records.ms().len(), Rate::Samples(made * f64::from(recipe.samples) / 1e6))
            }
        };
        Ok(Figure { device: device.name(), kernel, configuration, estimates, histogram, rate })
    }
}

impl Figure {
    fn line(&self) -> String {
        let Figure { device, kernel, configuration, estimates, histogram, rate } = self;
        let with = if *histogram { "with histogram" } else { "without histogram" };
        let (what, rate, digits) = match rate {
            Rate::Trials(rate) => ("trials", rate, 1),
            Rate::Runs(rate) => ("runs", rate, 3),
            Rate::Samples(rate) => ("samples", rate, 1),
        };
        let estimates = match self.rate {
            Rate::Samples(_) => format!("{estimates} averaging times"),
            _ => format!("{estimates} estimates, {with:17}"),
        };
        format!("{kernel}, {configuration}, {estimates} {rate:9.digits$} million {what}/s  {device}")
    }
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
