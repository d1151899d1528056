//! `sagnac device`: the devices of this machine, their verification and their speed.

use std::time::Instant;

use crate::device;
use crate::failure::Failure;
use crate::output::{print, print_json};
use crate::program::{Bench, Verify};
use clap::{Args, Subcommand};
use sagnac::device::gpu::adapter::{Adapter, unused_card};
use sagnac::device::select::{SelectError, every_adapter, untested};
use sagnac::device::{Cpu, Device, GpuError, Job, Work};
use sagnac::tally::cover;
use sagnac::verify::{Measured, digest, measured};
use sagnac_kernel::width::Width;
use serde::Serialize;

const EXAMPLES: &str = "\
Examples:
  sagnac device list";

const TASKS: &str = "\
Examples:
  sagnac device list
  sagnac device verify --device cpu
  sagnac device bench --device cpu";

#[derive(Debug, Args)]
#[command(after_long_help = TASKS)]
pub struct Command {
    #[command(subcommand)]
    task: Task,
}

#[derive(Debug, Subcommand)]
enum Task {
    /// List the devices that kernels can run on
    List(Options),
    /// Verify that every kernel gives the same bits on every device of this machine
    Verify(Verify),
    /// Measure the throughput of the kernels
    Bench(Bench),
}

/// Does what is asked for with the devices.
pub fn device(command: &Command) -> Result<(), Failure> {
    match &command.task {
        Task::List(options) => devices(options),
        Task::Verify(options) => device::verify(options),
        Task::Bench(options) => device::bench(options),
    }
}

#[derive(Debug, Args)]
#[command(after_long_help = EXAMPLES)]
pub struct Options {
    /// Former option: docs/reference/exit-codes.md has a section on GPUs that are not used
    #[arg(long, hide = true)]
    why: bool,
    /// Former option, which printed that as JSON
    #[arg(long, hide = true)]
    json: bool,
}

/// Lists the devices that can run kernels.
pub fn devices(options: &Options) -> Result<(), Failure> {
    if options.why || options.json {
        say!(
            "note: `--why` is gone: \"A GPU that is not used\" in docs/reference/exit-codes.md says what may be missing"
        );
    }
    let widths: Vec<&str> = Width::available().into_iter().map(Width::name).collect();
    print(&format!("cpu: {}", widths.join(", ")))?;
    let adapters = Adapter::all();
    for (at, adapter) in adapters.iter().enumerate() {
        print(&format!("gpu:{at}: {}\n     {}", adapter.name(), adapter.description()))?;
    }
    if adapters.is_empty() {
        say!("no GPU and no software rasterizer was found (Vulkan, Metal, DX12)");
    }
    if let Some(unused) = unused_card(&adapters) {
        say!("{unused}");
    }
    Ok(())
}

/// The rate of a kernel on a device.
#[derive(Debug, Serialize)]
#[cfg_attr(test, derive(schemars::JsonSchema), schemars(deny_unknown_fields))]
struct Figure {
    /// Name of the device.
    device: String,
    /// Name of the kernel.
    kernel: &'static str,
    /// The configuration that is sampled.
    configuration: &'static str,
    /// Number of estimates of a trial, or of averaging times of a record.
    estimates: usize,
    /// Whether the tallies have histograms.
    histogram: bool,
    /// The unit of the rate: trials, runs, samples or steps.
    unit: &'static str,
    /// The best rate of all runs, in millions of this unit per second.
    million_per_second: f64,
}

/// Number of runs of a measurement; each takes about this long.
const RUNS: usize = 5;
const SECONDS: f64 = 0.5;

/// Measures the kernels for trials and records at every width of the CPU and on the device.
pub fn bench(options: &crate::program::Bench) -> Result<(), Failure> {
    let mut devices = options.device.select(true)?.into_devices();
    // The CPU follows at every width.
    devices.retain(|device| matches!(device, Device::Gpu(_)));
    for width in Width::available() {
        devices.push(Device::Cpu(Cpu::new(width, 0).map_err(SelectError::from)?));
    }
    let mut figures = Vec::new();
    for device in &mut devices {
        for measured in measured() {
            let figure = figure(&measured, device)?;
            if !options.json {
                print(&figure.line())?;
            }
            figures.push(figure);
        }
    }
    if options.json { print_json(&figures) } else { Ok(()) }
}

fn figure(measured: &Measured, device: &mut Device) -> Result<Figure, GpuError> {
    let &Measured { kernel, configuration, unit, histogram, .. } = measured;
    let million_per_second = 1e-6 * rate(measured, device)?;
    let estimates = match &measured.work {
        Work::Trials(launch) => launch.sampled().estimates(),
        Work::Records(recipe) => recipe.curve().places(),
    };
    let device = device.name();
    Ok(Figure { device, kernel, configuration, estimates, histogram, unit, million_per_second })
}

/// The best rate of some runs, in units per second. A run has a power of two of trials or records that makes it long enough.
fn rate(measured: &Measured, device: &mut Device) -> Result<f64, GpuError> {
    let (mut count, in_unit) = match &measured.work {
        Work::Trials(launch) => ((1 << 20_u64) / launch.steps().next_power_of_two(), 1.0),
        Work::Records(recipe) => (64, recipe.steps() as f64),
    };
    let (mut rate, mut runs) = (0.0_f64, 0);
    while runs < RUNS {
        let started = Instant::now();
        run(measured, device, count)?;
        let seconds = started.elapsed().as_secs_f64();
        if seconds < SECONDS / 2.0 {
            count *= 2;
            continue;
        }
        rate = rate.max(count as f64 * in_unit / seconds);
        runs += 1;
    }
    Ok(rate)
}

/// Makes so many trials or records.
fn run(measured: &Measured, device: &mut Device, count: u64) -> Result<(), GpuError> {
    match &measured.work {
        Work::Trials(launch) => {
            let blocks = cover(0..count, 24);
            let jobs: Vec<Job> = blocks.into_iter().map(|block| Job { launch, block }).collect();
            device.tally(&jobs, measured.histogram, &|_| {}).map(drop)
        }
        Work::Records(recipe) => device.sums(&**recipe, 0, count as usize, &|_| {}).map(drop),
    }
}

impl Figure {
    fn line(&self) -> String {
        let Figure { device, kernel, configuration, estimates, histogram, unit, million_per_second } = self;
        let with = if *histogram { "with histogram" } else { "without histogram" };
        let digits = if *unit == "runs" { 3 } else { 1 };
        let estimates = match *unit {
            "samples" | "steps" if *estimates == 0 => "all sums of a record".to_owned(),
            "samples" | "steps" => format!("{estimates} sums of a record"),
            _ => format!("{estimates} estimates, {with:17}"),
        };
        format!(
            "{kernel}, {configuration}, {estimates} {million_per_second:9.digits$} million {unit}/s  {device}"
        )
    }
}

/// Compares every kernel at every width of the CPU and on the device, or on all adapters.
pub fn verify(options: &crate::program::Verify) -> Result<(), Failure> {
    if options.report.is_some() {
        let gone = "--report is gone\nsend what `sagnac device list` and `sagnac device verify` print";
        return Err(Failure::Usage(gone.to_owned()));
    }
    let mut devices = match &options.device {
        Some(name) => untested(name)?.device.into_devices(),
        None => every_adapter()?,
    };
    let widths = Width::available().into_iter().map(|width| format!("CPU ({})", width.name()));
    let mut names: Vec<String> = widths.collect();
    names.extend(devices.iter().filter(|device| matches!(device, Device::Gpu(_))).map(Device::name));
    say!("comparing: {}", names.join(", "));
    if !devices.iter().any(|device| matches!(device, Device::Gpu(_))) {
        say!("no GPU adapter: only the CPU kernels were verified");
    }
    let mut verdicts = Vec::new();
    let mut printed = Ok(());
    let identical = sagnac::verify::verify(&mut devices, options.trials, |verdict| {
        let line = if verdict.differences.is_empty() {
            format!("identical {} {:016x}", verdict.kernel, verdict.digest)
        } else {
            format!("DIFFERENT {} on {}", verdict.kernel, verdict.differences.join(", "))
        };
        if printed.is_ok() {
            printed = print(&line);
        }
        verdicts.push(verdict.clone());
    })?;
    printed?;
    print(&format!("digest of all kernels {:016x}", digest(&verdicts)))?;
    if identical { Ok(()) } else { Err(Failure::Different) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_schema_of_figures_follows_from_their_type() {
        let mut present = schemars::schema_for!(Vec<Figure>).to_value();
        present["title"] = "Output of sagnac device bench --json".into();
        let path = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("../schema/bench.schema.json");
        let shipped: Option<serde_json::Value> =
            std::fs::read(&path).ok().and_then(|text| serde_json::from_slice(&text).ok());
        if shipped != Some(present.clone()) {
            let text = serde_json::to_string_pretty(&present).unwrap() + "\n";
            std::fs::write(path.with_extension("new.json"), text).unwrap();
            panic!(
                "schema/bench.schema.json is out of date; the present one is beside it: compare, then rename it"
            );
        }
    }
}
