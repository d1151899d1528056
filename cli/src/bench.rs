//! `sagnac device bench`.

use std::time::Instant;

use sagnac::device::cpu::Cpu;
use sagnac::device::error::GpuError;
use sagnac::device::load::Work;
use sagnac::device::select::SelectError;
use sagnac::device::{Device, Job};
use sagnac::kernel::width::Width;
use sagnac::tally::block::cover;
use sagnac::verify::measured::{Measured, measured};
use serde::ser::SerializeMap;
use serde::{Serialize, Serializer};

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
    #[serde(flatten)]
    rates: Rates,
    /// Part of the integer operations that the device could do while it worked.
    #[serde(skip_serializing_if = "Option::is_none")]
    part_of_integer_limit: Option<f64>,
    #[serde(skip)]
    is_gpu: bool,
}

/// Best rates of all runs, in units per second.
#[derive(Debug)]
struct Rates {
    /// Trials, runs, samples or steps.
    unit: &'static str,
    /// By the clock of the processor.
    wall: f64,
    /// By the clock of a GPU that has one.
    device: Option<f64>,
}

impl Serialize for Rates {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let mut map = serializer.serialize_map(None)?;
        map.serialize_entry(&format!("million_{}_per_second", self.unit), &(self.wall / 1e6))?;
        if let Some(rate) = self.device {
            map.serialize_entry(&format!("million_{}_per_device_second", self.unit), &(rate / 1e6))?;
        }
        map.end()
    }
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
        let limit = integer_limit(device)?;
        match (&*device, limit) {
            (Device::Gpu(gpu), Some(limit)) => {
                say!("integer limit of {}: {:.0} billion operations/s", gpu.name(), limit / 1e9);
            }
            (Device::Gpu(gpu), None) => {
                say!(
                    "{} has no time stamps: its own time and its integer limit are not measured",
                    gpu.name()
                );
            }
            _ => {}
        }
        for measured in measured() {
            let figure = figure(&measured, device, limit)?;
            if !options.json {
                print(&figure.line())?;
            }
            figures.push(figure);
        }
    }
    if options.json { print_json(&figures) } else { Ok(()) }
}

/// Integer operations per second of a GPU.
fn integer_limit(device: &mut Device) -> Result<Option<f64>, GpuError> {
    match device {
        Device::Gpu(gpu) => gpu.integer_limit(),
        _ => Ok(None),
    }
}

fn figure(measured: &Measured, device: &mut Device, limit: Option<f64>) -> Result<Figure, GpuError> {
    let &Measured { kernel, configuration, histogram, .. } = measured;
    let rates = rates(measured, device)?;
    let estimates = match &measured.work {
        Work::Trials(launch) => launch.sampled().estimates(),
        Work::Records(recipe) => recipe.curve().places(),
    };
    let part_of_integer_limit = match (&*device, rates.device, limit) {
        (Device::Gpu(gpu), Some(rate), Some(limit)) => {
            Some(rate * f64::from(measured.operations(gpu.variant())) / limit)
        }
        _ => None,
    };
    let (device, is_gpu) = (device.name(), matches!(device, Device::Gpu(_)));
    Ok(Figure { device, kernel, configuration, estimates, histogram, rates, part_of_integer_limit, is_gpu })
}

/// The best rates of some runs. A run has a power of two of trials or records that makes it long enough.
fn rates(measured: &Measured, device: &mut Device) -> Result<Rates, GpuError> {
    let (mut count, in_unit) = match &measured.work {
        Work::Trials(launch) => ((1 << 20_u64) / launch.steps().next_power_of_two(), 1.0),
        Work::Records(recipe) => (64, recipe.steps() as f64),
    };
    let mut rates = Rates { unit: measured.unit, wall: 0.0, device: None };
    let mut runs = 0;
    while runs < RUNS {
        if let Device::Gpu(gpu) = device {
            gpu.start_clock();
        }
        let started = Instant::now();
        run(measured, device, count)?;
        let seconds = started.elapsed().as_secs_f64();
        if seconds < SECONDS / 2.0 {
            count *= 2;
            continue;
        }
        let units = count as f64 * in_unit;
        rates.wall = rates.wall.max(units / seconds);
        if let Device::Gpu(gpu) = device
            && let Some(seconds) = gpu.device_seconds()
        {
            rates.device = Some(rates.device.unwrap_or(0.0).max(units / seconds));
        }
        runs += 1;
    }
    Ok(rates)
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
        let Figure { device, kernel, configuration, estimates, histogram, rates, .. } = self;
        let with = if *histogram { "with histogram" } else { "without histogram" };
        let (unit, digits) = (rates.unit, if rates.unit == "runs" { 3 } else { 1 });
        let estimates = match unit {
            "samples" | "steps" if *estimates == 0 => "all sums of a record".to_owned(),
            "samples" | "steps" => format!("{estimates} sums of a record"),
            _ => format!("{estimates} estimates, {with:17}"),
        };
        let million = |rate: f64| format!("{:9.digits$}", rate / 1e6);
        let mut of_device = String::new();
        if self.is_gpu {
            let rate = rates.device.map_or_else(|| format!("{:>9}", "–"), million);
            let part =
                self.part_of_integer_limit.map_or("–".to_owned(), |part| format!("{:.0}", 100.0 * part));
            of_device = format!(", {rate} by the device's clock, {part:>3} % of its integer limit");
        }
        let rate = million(rates.wall);
        format!("{kernel}, {configuration}, {estimates} {rate} million {unit}/s{of_device}  {device}")
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn figure(is_gpu: bool, device: Option<f64>) -> Figure {
        Figure {
            device: "A device".to_owned(),
            kernel: "gap_fill",
            configuration: "paper",
            estimates: 6,
            histogram: false,
            rates: Rates { unit: "trials", wall: 25e6, device },
            part_of_integer_limit: device.map(|rate| rate / 100e6),
            is_gpu,
        }
    }

    #[test]
    fn a_gpu_has_rates_of_its_own_clock_or_dashes_and_a_cpu_has_neither() {
        let line = |is_gpu, device| figure(is_gpu, device).line();
        let start = "gap_fill, paper, 6 estimates, without histogram      25.0 million trials/s";
        assert_eq!(line(false, None), format!("{start}  A device"));
        let of_device = ",      50.0 by the device's clock,  50 % of its integer limit";
        assert_eq!(line(true, Some(50e6)), format!("{start}{of_device}  A device"));
        let dashes = ",         – by the device's clock,   – % of its integer limit";
        assert_eq!(line(true, None), format!("{start}{dashes}  A device"));
    }

    #[test]
    fn figures_are_what_the_schema_says() {
        let schema = serde_json::from_str(include_str!("../../schema/bench.schema.json")).unwrap();
        let figures = [figure(false, None), figure(true, Some(50e6))];
        let document = serde_json::to_value(&figures).unwrap();
        jsonschema::validate(&schema, &document).unwrap_or_else(|error| panic!("{error}"));
        assert_eq!(document[0].get("million_trials_per_device_second"), None);
        assert_eq!(document[1]["million_trials_per_device_second"], 50.0);
        assert_eq!(document[1]["part_of_integer_limit"], 0.5);
    }
}
