//! Identity: the same bits from every width and device, shown on the user's own machine.
//!
//! ```
//! let mut kernels = Vec::new();
//! let identical = sagnac::verify::verify(&mut [], 1000, |verdict| kernels.push(verdict.kernel))?;
//! assert!(identical && kernels.contains(&"gap_fill"));
//! # Ok::<(), sagnac::device::gpu::GpuError>(())
//! ```

pub mod configurations;
pub mod recipes;
pub mod relocks;
pub mod runs;

use sha2::{Digest, Sha256};

use crate::device::cpu::Cpu;
use crate::device::gpu::GpuError;
use crate::device::{Device, Job};
use crate::kernel::launch::Launch;
use crate::kernel::map::Map;
use crate::kernel::moments::{Moments, Trials};
use crate::kernel::recipe::Recipe;
use crate::kernel::width::Width;
use crate::kernel::word::Scalar;
use crate::kernel::{Form, KERNELS, Kernel, allan, philox};
use crate::tally::block::{base_log2, cover};
pub use crate::verify::configurations::{Configuration, configurations};
pub use crate::verify::recipes::{NamedRecords, THINNED, lgk_400, named_records};
pub use crate::verify::relocks::{launches_of, relock};
pub use crate::verify::runs::{hour_launches, run_launches};

/// What a check of one kernel found.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Verdict {
    /// Its name, as in the registry.
    pub kernel: &'static str,
    /// The first 64 bits of a SHA-256 over all results of the reference: the same on every machine.
    pub digest: u64,
    /// Which width or device differs from the reference, and where.
    pub differences: Vec<String>,
}

/// Runs every kernel for `units` trials, samples or items in all on the portable width, on every other width of this machine and
/// on `devices`, and compares bit for bit; `report` hears each verdict as it is reached.
///
/// # Errors
/// A device is lost or refuses.
pub fn verify(
    devices: &mut [Device],
    units: u64,
    mut report: impl FnMut(&Verdict),
) -> Result<bool, GpuError> {
    let mut identical = true;
    for kernel in KERNELS {
        let verdict = verify_kernel(&kernel, devices, units)?;
        identical &= verdict.differences.is_empty();
        report(&verdict);
    }
    Ok(identical)
}

/// The launches that a kernel of trials is checked on, by name.
pub fn launches(kernel: &Kernel) -> Vec<(&'static str, Launch)> {
    let of_gap_fill = |c: Configuration| c.launches().into_iter().map(move |launch| (c.name, launch));
    match kernel.name {
        "gap_fill" => configurations().into_iter().flat_map(of_gap_fill).collect(),
        "switched_run" => run_launches(),
        "relock" => crate::verify::relocks::launches(),
        _ => vec![],
    }
}

/// Items of a building block that are held at a time.
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
                hasher.update(bytemuck::cast_slice::<u32, u8>(&reference));
            }
        }
        Form::Moments => {
            let launches = launches(kernel);
            let trials = units.div_ceil(launches.len() as u64);
            for (name, launch) in launches {
                let reference = on_cpu(Width::PORTABLE, &launch, trials);
                for width in Width::available() {
                    let same = on_cpu(width, &launch, trials) == reference;
                    compare(same, format!("{} ({name})", width.name()));
                }
                for device in &mut *devices {
                    let same = tally(device, &launch, trials)? == reference;
                    compare(same, format!("{} ({name})", device.name()));
                }
                reference.iter().for_each(|tally| digest(tally, &mut hasher));
            }
        }
        Form::Records => {
            let all = named_records();
            for named in &all {
                let records = named.lowered();
                let count = units.div_ceil(all.len() as u64 * named.samples) as usize;
                let reference = sums_on_cpu(Width::PORTABLE, records.recipe(), count);
                for width in Width::available() {
                    let same = sums_on_cpu(width, records.recipe(), count) == reference;
                    compare(same, format!("{} ({})", width.name(), named.name));
                }
                for device in &mut *devices {
                    let same = device.sums(records.recipe(), 0, count, &|_| {})? == reference;
                    compare(same, format!("{} ({})", device.name(), named.name));
                }
                reference.iter().for_each(|sum| hasher.update(sum.to_le_bytes()));
            }
        }
    }
    let hash = hasher.finalize();
    let digest = hash[..8].iter().fold(0, |digest, &byte| digest << 8 | u64::from(byte));
    Ok(Verdict { kernel: kernel.name, digest, differences })
}

/// The configurations of the self-test: sums of 32 bits and of 64; and its records.
const SELF_TEST: [&str; 6] =
    ["paper", "sparse-fit-ticks", "by-frequency", "by-detuning", "spreads", "warm-up"];
const SELF_TEST_RECORDS: (&str, usize) = ("everything", 40);

/// The first kernel, if any, in which a device differs from the portable CPU on a small load.
///
/// # Errors
/// The device is lost or refuses.
pub fn self_test(device: &mut Device) -> Result<Option<&'static str>, GpuError> {
    for kernel in KERNELS {
        let same = match kernel.form {
            Form::Map(map) => {
                let items = items(&map, 0..4096);
                device.map(&map, &items)? == (map.cpu)(Width::PORTABLE, &items)
            }
            Form::Moments => {
                let mut same = true;
                for (name, launch) in launches(&kernel) {
                    if SELF_TEST.contains(&name) {
                        same &= tally(device, &launch, 5000)? == on_cpu(Width::PORTABLE, &launch, 5000);
                    }
                }
                same
            }
            Form::Records => {
                let (name, count) = SELF_TEST_RECORDS;
                let mut same = true;
                for named in named_records().iter().filter(|named| named.name == name) {
                    let records = named.lowered();
                    let reference = sums_on_cpu(Width::PORTABLE, records.recipe(), count);
                    same &= device.sums(records.recipe(), 0, count, &|_| {})? == reference;
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

/// Input words of some items of a building block, from the generator itself; an item takes whole blocks of it.
fn items(map: &Map, range: core::ops::Range<u64>) -> Vec<u32> {
    let blocks = map.inputs.div_ceil(4) as u64;
    let keys = philox::schedule([Scalar(0); 2]);
    let block = |n: u64| philox::philox([n as u32, (n >> 32) as u32, 0, u32::MAX].map(Scalar), keys);
    range
        .flat_map(|item| (item * blocks..(item + 1) * blocks).flat_map(block).take(map.inputs))
        .map(|word| word.0)
        .collect()
}

fn on_cpu(width: Width, launch: &Launch, trials: u64) -> Vec<Moments> {
    match Cpu::new(width, 0) {
        Ok(cpu) => fold(launch, cpu.tally(&jobs(launch, trials), true, &|_| {})),
        // Without threads the kernel still runs here.
        Err(_) => launch.tally(width, Trials { first: 0, count: trials, histogram: true }),
    }
}

fn sums_on_cpu(width: Width, recipe: &Recipe, count: usize) -> Vec<u128> {
    match Cpu::new(width, 0) {
        Ok(cpu) => cpu.sums(recipe, 0, count, &|_| {}),
        Err(_) => allan::sums(width, recipe, 0, count),
    }
}

fn tally(device: &mut Device, launch: &Launch, trials: u64) -> Result<Vec<Moments>, GpuError> {
    Ok(fold(launch, device.tally(&jobs(launch, trials), true, &|_| {})?))
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
