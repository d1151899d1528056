//! Verification that every width and device gives the same bits, run on the user's own machine.
//!
//! ```
//! let mut kernels = Vec::new();
//! let identical = sagnac::verify::verify(&mut [], 1000, |verdict| kernels.push(verdict.kernel))?;
//! assert!(identical && kernels.contains(&"gap_fill"));
//! # Ok::<(), sagnac::device::error::GpuError>(())
//! ```

#[cfg(test)]
mod tests;

use sha2::{Digest, Sha256};

use crate::device::cpu::Cpu;
use crate::device::error::GpuError;
use crate::device::load::{Load, Work};
use crate::device::select::{self, SelectError, Selection};
use crate::device::{Device, Job};
use crate::kernel::launch::Launch;
use crate::kernel::map::Map;
use crate::kernel::moments::{Moments, Trials};
use crate::kernel::recipe::Recipe;
use crate::kernel::width::Width;
use crate::kernel::word::Scalar;
use crate::kernel::{Form, KERNELS, Kernel, philox};
use crate::kinds::KINDS;
use crate::tally::block::{base_log2, cover};

/// The loads on which a kernel is checked; a building block has none.
pub fn loads(kernel: &Kernel) -> Vec<Load> {
    KINDS.iter().flat_map(|kind| (kind.loads)()).filter(|load| load.kernel() == kernel.name).collect()
}

/// Selects the device that `wanted` names, which must pass the self-test; see [`select::select`].
///
/// # Errors
/// There is no such device, it does not work, or it computes other bits than the CPU.
pub fn select(wanted: &str, threads: usize) -> Result<Selection, SelectError> {
    select::select(wanted, threads, self_test)
}

/// Makes a device of a GPU that passes the self-test; see [`select::trusted`].
///
/// # Errors
/// It computes other bits than the CPU, or fails.
pub fn trusted(gpu: crate::device::gpu::Gpu) -> Result<Device, SelectError> {
    select::trusted(gpu, self_test)
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
            for Load { name, work, .. } in &loads {
                let units = units.div_ceil(loads.len() as u64);
                let reference = on_cpu(Width::PORTABLE, work, units);
                for width in Width::available() {
                    let same = on_cpu(width, work, units) == reference;
                    compare(same, format!("{} ({name})", width.name()));
                }
                for device in &mut *devices {
                    let same = on_device(device, work, units)? == reference;
                    compare(same, format!("{} ({name})", device.name()));
                }
                reference.digest(&mut hasher);
            }
        }
    }
    let hash = hasher.finalize();
    let digest = hash[..8].iter().fold(0, |digest, &byte| digest << 8 | u64::from(byte));
    Ok(Verdict { kernel: kernel.name, digest, differences })
}

/// The first kernel, if any, in which a device differs from the portable CPU on a small load.
///
/// # Errors
/// The device is lost or refuses the work.
pub fn self_test(device: &mut Device) -> Result<Option<&'static str>, GpuError> {
    for kernel in KERNELS {
        let same = match kernel.form {
            Form::Map(map) => {
                let items = items(&map, 0..4096);
                device.map(&map, &items)? == (map.cpu)(Width::PORTABLE, &items)
            }
            Form::Moments | Form::Records => {
                let mut same = true;
                for Load { work, self_test_units, .. } in &loads(kernel) {
                    if let &Some(units) = self_test_units {
                        same &= on_device(device, work, units)? == on_cpu(Width::PORTABLE, work, units);
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
fn items(map: &Map, range: core::ops::Range<u64>) -> Vec<u32> {
    let blocks = map.inputs.div_ceil(4) as u64;
    let keys = philox::schedule([Scalar(0); 2]);
    let block = |n: u64| philox::philox([n as u32, (n >> 32) as u32, 0, u32::MAX].map(Scalar), keys);
    range
        .flat_map(|item| (item * blocks..(item + 1) * blocks).flat_map(block).take(map.inputs))
        .map(|word| word.0)
        .collect()
}

/// The results of a load.
#[derive(PartialEq)]
enum Outcome {
    Tallies(Vec<Moments>),
    Sums(Vec<u128>),
}

impl Outcome {
    fn digest(&self, hasher: &mut Sha256) {
        match self {
            Outcome::Tallies(tallies) => tallies.iter().for_each(|tally| digest(tally, hasher)),
            Outcome::Sums(sums) => sums.iter().for_each(|sum| hasher.update(sum.to_le_bytes())),
        }
    }
}

/// Number of records of a load for `units` samples.
fn records(recipe: &Recipe, units: u64) -> usize {
    units.div_ceil(u64::from(recipe.samples)) as usize
}

fn on_cpu(width: Width, work: &Work, units: u64) -> Outcome {
    match (Cpu::new(width, 0), work) {
        (Ok(cpu), Work::Trials(launch)) => {
            Outcome::Tallies(fold(launch, cpu.tally(&jobs(launch, units), true, &|_| {})))
        }
        (Ok(cpu), Work::Records(recipe)) => {
            Outcome::Sums(cpu.sums(recipe, 0, records(recipe, units), &|_| {}))
        }
        // If no threads can be started, the kernel still runs in this one.
        (Err(_), Work::Trials(launch)) => {
            Outcome::Tallies(launch.tally(width, Trials { first: 0, count: units, histogram: true }))
        }
        (Err(_), Work::Records(recipe)) => Outcome::Sums(recipe.sums(width, 0, records(recipe, units))),
    }
}

fn on_device(device: &mut Device, work: &Work, units: u64) -> Result<Outcome, GpuError> {
    Ok(match work {
        Work::Trials(launch) => {
            Outcome::Tallies(fold(launch, device.tally(&jobs(launch, units), true, &|_| {})?))
        }
        Work::Records(recipe) => Outcome::Sums(device.sums(recipe, 0, records(recipe, units), &|_| {})?),
    })
}

fn jobs(launch: &Launch, trials: u64) -> Vec<Job<'_>> {
    cover(0..trials, base_log2(trials)).into_iter().map(|block| Job { launch, block }).collect()
}

fn fold(launch: &Launch, parts: Vec<Vec<Moments>>) -> Vec<Moments> {
    let mut total = vec![Moments::empty(true); launch.sampled.estimates()];
    for part in parts {
        for (total, part) in total.iter_mut().zip(&part) {
            total.merge(part);
        }
    }
    total
}

fn digest(tally: &Moments, hasher: &mut Sha256) {
    hasher.update(tally.count.to_le_bytes());
    hasher.update(tally.sum.to_le_bytes());
    hasher.update(tally.square.to_le_bytes());
    hasher.update(tally.least.to_le_bytes());
    hasher.update(tally.greatest.to_le_bytes());
    tally.bins.iter().for_each(|bin| hasher.update(bin.to_le_bytes()));
}
