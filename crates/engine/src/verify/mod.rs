//! Verification that every width and device gives the same bits, run on the user's own machine.
//!
//! ```
//! let mut kernels = Vec::new();
//! let identical = sagnac_engine::verify::verify(&mut [], 1000, |verdict| kernels.push(verdict.kernel))?;
//! assert!(identical && kernels.contains(&"gap_fill"));
//! # Ok::<(), sagnac_engine::device::GpuError>(())
//! ```

#[cfg(test)]
mod tests;

use std::sync::Arc;

use sha2::{Digest, Sha256};

use crate::device::select::{self, SelectError, Selection, SelfTest};
use crate::device::{Cpu, Device, GpuError, Job, Work, Workload};
use crate::kinds::KINDS;
use crate::kinds::allan::verify::{NamedRecords, THINNED, lgk_400};
use crate::kinds::gap_fill::verify::configurations;
use crate::kinds::lock_in::verify::{checked, lowered};
use crate::kinds::navigation::verify::navigator;
use crate::kinds::navigation::{self, Solution};
use crate::kinds::relock::Compensation;
use crate::kinds::relock::verify::{launches_of, relock};
use crate::kinds::switched_run::verify::hour_launches;
use crate::tally::{base_log2, cover};
use sagnac_kernel::curve::Recorded;
use sagnac_kernel::launch::Launch;
use sagnac_kernel::map::Map;
use sagnac_kernel::moments::{Moments, Trials};
use sagnac_kernel::width::Width;
use sagnac_kernel::word::Scalar;
use sagnac_kernel::{Form, KERNELS, Kernel, philox};
use sagnac_theory::allan::Estimator;

/// The loads on which a kernel is checked; a building block has none.
pub fn loads(kernel: &Kernel) -> Vec<Workload> {
    KINDS.iter().flat_map(|kind| (kind.loads)()).filter(|load| load.kernel() == kernel.name).collect()
}

/// Selects the device that `wanted` names, which must pass the self-test; see [`select::select`].
///
/// # Errors
/// There is no such device, it does not work, or it computes other bits than the CPU.
pub fn select(wanted: &str, threads: usize) -> Result<Selection, SelectError> {
    select::select(wanted, threads, SELF_TEST)
}

/// Makes a device of a GPU that passes the self-test; see [`select::trusted`].
///
/// # Errors
/// It computes other bits than the CPU, or fails.
pub fn trusted(gpu: crate::device::gpu::Gpu) -> Result<Device, SelectError> {
    select::trusted(gpu, SELF_TEST)
}

/// The result of checking one kernel.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Verdict {
    /// Name of the kernel in the registry.
    pub kernel: &'static str,
    /// First 64 bits of a SHA-256 over all results of the reference, the same on every machine.
    pub digest: u64,
    /// Widths and devices that differ from the reference, with the place of the difference.
    pub differences: Vec<String>,
}

/// Runs every kernel for a total of `units` trials, samples or items on the portable width, on every other width of
/// this machine and on `devices`, and compares the results bit for bit. `report` receives each verdict as it is
/// reached.
///
/// # Errors
/// A device is lost or refuses the work.
pub fn verify(
    devices: &mut [Device],
    units: u64,
    mut report: impl FnMut(&Verdict),
) -> Result<bool, GpuError> {
    let mut identical = true;
    for kernel in KERNELS {
        let verdict = verify_kernel(kernel, devices, units)?;
        identical &= verdict.differences.is_empty();
        for device in &*devices {
            if let Device::Gpu(gpu) = device
                && verdict.differences.iter().any(|difference| difference.starts_with(gpu.name()))
            {
                gpu.distrust();
            }
        }
        report(&verdict);
    }
    Ok(identical)
}

/// Largest number of items of a building block held at a time.
const ITEMS: u64 = 1 << 20;

fn verify_kernel(kernel: &Kernel, devices: &mut [Device], units: u64) -> Result<Verdict, GpuError> {
    let mut hasher = Sha256::new();
    let mut differences = Vec::new();
    let mut compare = |same: bool, name: String| {
        if !same && !differences.contains(&name) {
            differences.push(name);
        }
    };
    match kernel.form {
        Form::Map(map) => {
            for first in (0..units).step_by(ITEMS as usize) {
                let items = items(&map, first..units.min(first + ITEMS));
                let reference = (map.cpu)(Width::PORTABLE, &items);
                for width in Width::available() {
                    compare((map.cpu)(width, &items) == reference, width.name().to_owned());
                }
                for device in &mut *devices {
                    compare(device.map(&map, &items)? == reference, device.name());
                }
                reference.iter().for_each(|word| hasher.update(word.to_le_bytes()));
            }
        }
        Form::Moments | Form::Records => {
            let loads = loads(kernel);
            for Workload { name, work, .. } in &loads {
                let units = units.div_ceil(loads.len() as u64);
                let reference = on_cpu(Width::PORTABLE, work, units)?;
                for width in Width::available() {
                    let same = on_cpu(width, work, units)? == reference;
                    compare(same, format!("{} ({name})", width.name()));
                }
                for device in &mut *devices {
                    let same = on_device(device, work, units)? == reference;
                    compare(same, format!("{} ({name})", device.name()));
                }
                hasher.update(&reference);
            }
        }
    }
    Ok(Verdict { kernel: kernel.name, digest: first_64_bits(hasher), differences })
}

/// First 64 bits of a SHA-256 over the digests of all kernels, which is the same on every machine.
pub fn digest(verdicts: &[Verdict]) -> u64 {
    let mut hasher = Sha256::new();
    verdicts.iter().for_each(|verdict| hasher.update(verdict.digest.to_le_bytes()));
    first_64_bits(hasher)
}

fn first_64_bits(hasher: Sha256) -> u64 {
    hasher.finalize()[..8].iter().fold(0, |digest, &byte| digest << 8 | u64::from(byte))
}

/// The self-test of devices: small loads of every kernel. The first load of trials shows the speed.
pub const SELF_TEST: SelfTest = SelfTest {
    differs: self_test,
    timed: || KERNELS.iter().flat_map(loads).find_map(|load| load.launch().cloned()),
};

/// The first kernel, if any, in which a device differs from the portable CPU on a small load.
///
/// # Errors
/// The device is lost or refuses the work.
fn self_test(device: &mut Device) -> Result<Option<&'static str>, GpuError> {
    for kernel in KERNELS {
        let same = match kernel.form {
            Form::Map(map) => {
                let items = items(&map, 0..4096);
                device.map(&map, &items)? == (map.cpu)(Width::PORTABLE, &items)
            }
            Form::Moments | Form::Records => {
                let mut same = true;
                for Workload { work, self_test_units, .. } in &loads(kernel) {
                    if let &Some(units) = self_test_units {
                        same &= on_device(device, work, units)? == on_cpu(Width::PORTABLE, work, units)?;
                    }
                }
                same
            }
        };
        if !same {
            return Ok(Some(kernel.name));
        }
    }
    Ok(None)
}

/// Input words for some items of a building block, taken from the generator in whole blocks.
pub fn items(map: &Map, range: core::ops::Range<u64>) -> Vec<u32> {
    let blocks = map.inputs.div_ceil(4) as u64;
    let keys = philox::schedule([Scalar(0); 2]);
    let block = |n: u64| philox::philox([n as u32, (n >> 32) as u32, 0, u32::MAX].map(Scalar), keys);
    range
        .flat_map(|item| (item * blocks..(item + 1) * blocks).flat_map(block).take(map.inputs))
        .map(|word| word.0)
        .collect()
}

/// Number of records of a load for `units` samples.
fn records(recipe: &dyn Recorded, units: u64) -> usize {
    units.div_ceil(u64::from(recipe.curve().samples)) as usize
}

/// The results of a load on the processor, as those [of a device](on_device).
fn on_cpu(width: Width, work: &Work, units: u64) -> Result<Vec<u8>, GpuError> {
    match (Cpu::new(width, 0), work) {
        (Ok(cpu), work) => on_device(&mut Device::Cpu(cpu), work, units),
        // If no threads can be started, the kernel still runs in this one.
        (Err(_), Work::Trials(launch)) => {
            Ok(of_tallies(&launch.tally(width, Trials { first: 0, count: units, histogram: true })))
        }
        (Err(_), Work::Records(recipe)) => Ok(of_sums(&recipe.sums(width, 0, records(&**recipe, units)))),
    }
}

/// The results of a load on a device, as the bytes of their numbers.
fn on_device(device: &mut Device, work: &Work, units: u64) -> Result<Vec<u8>, GpuError> {
    match work {
        Work::Trials(launch) => {
            let blocks = cover(0..units, base_log2(units));
            let jobs: Vec<Job> = blocks.into_iter().map(|block| Job { launch, block }).collect();
            let mut total = vec![Moments::empty(true); launch.sampled().estimates()];
            for part in device.tally(&jobs, true, &|_| {})? {
                total.iter_mut().zip(&part).for_each(|(total, part)| total.merge(part));
            }
            Ok(of_tallies(&total))
        }
        Work::Records(recipe) => {
            Ok(of_sums(&device.sums(&**recipe, 0, records(&**recipe, units), &|_| {})?))
        }
    }
}

fn of_sums(sums: &[u128]) -> Vec<u8> {
    sums.iter().flat_map(|sum| sum.to_le_bytes()).collect()
}

fn of_tallies(tallies: &[Moments]) -> Vec<u8> {
    let mut bytes = Vec::new();
    for Moments { count, sum, square, least, greatest, bins } in tallies {
        bytes.extend(count.to_le_bytes());
        bytes.extend(sum.to_le_bytes());
        bytes.extend(square.to_le_bytes());
        bytes.extend(least.to_le_bytes());
        bytes.extend(greatest.to_le_bytes());
        bytes.extend(bins.iter().flat_map(|bin| bin.to_le_bytes()));
    }
    bytes
}

/// A measured kernel.
pub struct Measured {
    /// The kernel.
    pub kernel: &'static str,
    /// Name of what is sampled.
    pub configuration: &'static str,
    /// What a rate counts: trials, runs, samples or steps.
    pub unit: &'static str,
    /// What is sampled.
    pub work: Work,
    /// Whether the tallies have histograms.
    pub histogram: bool,
}

/// Gap-fill configurations: those of `verify`, and whether they have a histogram as in studies.
const GAP_FILLS: [(&str, bool); 5] = [
    ("paper", false),
    ("paper", true),
    ("minimum-variance", false),
    ("eight-tones", false),
    ("profile", false),
];

/// Records of nine hours at 1 Hz, with differences spaced by a 64th of τ, and at every sample.
const RECORDS: [(&str, Estimator); 2] =
    [("lgk-400, overlap m/64", THINNED), ("lgk-400, full overlap", Estimator::OVERLAPPING)];
const SAMPLES: u64 = 32_400;

/// Records of ten seconds of a dithered gyro.
const GYRO_SAMPLES: u64 = 4000;

/// All measured loads.
pub fn measured() -> Vec<Measured> {
    let mut measured = Vec::new();
    let mut trials = |kernel, configuration, unit, launches: Vec<Launch>, histogram| {
        let work = launches.into_iter().next().map(Work::Trials);
        measured.extend(work.map(|work| Measured { kernel, configuration, unit, work, histogram }));
    };
    let all = configurations();
    for (name, histogram) in GAP_FILLS {
        let found = all.iter().find(|configuration| configuration.name == name);
        let launches = found.map(|configuration| configuration.launches()).unwrap_or_default();
        trials("gap_fill", name, "trials", launches, histogram);
    }
    trials("switched_run", "one hour, MT = 40 s, 89 or 90 switches", "runs", hour_launches(), true);
    for compensation in Compensation::ALL {
        let launches = launches_of(&relock(), compensation);
        trials("relock", compensation.name(), "trials", launches, false);
    }
    for (configuration, estimator) in RECORDS {
        let (parts, samples) = (lgk_400(), SAMPLES);
        let named = NamedRecords {
            name: configuration,
            parts,
            readout_lsb: 0.0,
            switching: None,
            samples,
            estimator,
        };
        let work = Work::Records(Arc::new(named.lowered().recipe().clone()));
        let (kernel, unit, histogram) = ("allan", "samples", false);
        measured.push(Measured { kernel, configuration, unit, work, histogram });
    }
    let gyros = lowered(&checked(), 1, GYRO_SAMPLES, THINNED);
    measured.push(Measured {
        kernel: "lock_in",
        configuration: "400 Hz, 450 rad, amplitude noise",
        unit: "steps",
        work: Work::Records(gyros.shared()),
        histogram: false,
    });
    // The north gyro, with seven functionals.
    let navigator = navigator(Solution::Inertial, navigation::verify::lgk_400(), SAMPLES as f64);
    measured.extend(navigator.gyros.into_iter().next().map(|gyro| Measured {
        kernel: "navigation",
        configuration: "lgk-400, inertial",
        unit: "samples",
        work: Work::Records(Arc::new(gyro.navigation)),
        histogram: false,
    }));
    measured
}
