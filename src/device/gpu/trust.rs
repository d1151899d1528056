//! What is known of an adapter from an earlier start: that it passed its self-test, and its fastest variant.

use std::path::PathBuf;
use std::time::Instant;

use serde::{Deserialize, Serialize};
use sha2::{Digest, Sha256};

use crate::device::error::GpuError;
use crate::device::gpu::Gpu;
use crate::device::gpu::adapter::{Adapter, WORKGROUP};
use crate::device::select::{SelectError, SelfTest, trusted};
use crate::device::{Device, Job};
use crate::kernel::PARTS;
use crate::kernel::launch::Launch;
use crate::kernel::normal_table::NORMAL_TABLE;
use crate::kernel::shader::Variant;
use crate::tally::block::cover;

/// Least time of a run that shows the speed of a variant, and of all runs together, in which the clock rate of a card rises.
const RUN_SECONDS: f64 = 0.02;
const SECONDS: f64 = 0.3;

/// A file in the user's cache folder, for an adapter that passed its self-test.
#[derive(Serialize, Deserialize)]
struct Known {
    /// For people who read the file.
    adapter: String,
    int64: bool,
}

/// Opens an adapter that passes its self-test, or that passed it before: on this host and place of the bus, with the same
/// driver and the same shaders. Where it has 64-bit integers, the first start finds out whether they are faster.
///
/// # Errors
/// It cannot be opened, computes other bits than the CPU, or fails.
pub(crate) fn open(adapter: &Adapter, threads: usize, self_test: SelfTest) -> Result<Device, SelectError> {
    let failed = |source| SelectError::Gpu { name: adapter.name(), source };
    let file = file(adapter);
    let known: Option<Known> =
        file.as_ref().and_then(|file| toml::from_str(&std::fs::read_to_string(file).ok()?).ok());
    let variant = match &known {
        Some(known) => Variant { int64: known.int64, ..adapter.variant() },
        None => fastest(adapter, self_test).map_err(failed)?,
    };
    let mut gpu = Gpu::open(adapter, variant).map_err(failed)?;
    gpu.threads = threads;
    if known.is_some() {
        return Ok(Device::Gpu(Box::new(gpu.with_self_test(self_test))));
    }
    let device = trusted(gpu, self_test)?;
    let known = toml::to_string(&Known { adapter: adapter.name(), int64: variant.int64 });
    // Where the file cannot be kept, the next start tests the adapter again.
    if let (Some(file), Ok(text)) = (file, known) {
        let _ = file.parent().map(std::fs::create_dir_all);
        let _ = std::fs::write(file, text);
    }
    Ok(device)
}

/// Withdraws the trust in an adapter that gave other bits than the CPU: the next start tests it again.
pub(crate) fn withdraw(adapter: &Adapter) {
    if let Some(file) = file(adapter) {
        let _ = std::fs::remove_file(file);
    }
}

/// The file of an adapter; none where the driver does not tell its version, or there is no cache folder.
fn file(adapter: &Adapter) -> Option<PathBuf> {
    if adapter.driver_version().trim().is_empty() {
        return None;
    }
    let adapter = format!("{} {}", adapter.name(), adapter.description());
    // Nodes of a cluster share a home folder, and equal cards of theirs have the same place on the bus.
    let host = gethostname::gethostname().to_string_lossy().into_owned();
    Some(dirs::cache_dir()?.join("sagnac").join("adapters").join(file_name(&adapter, &host)))
}

/// A name made of what results and speed depend on: the adapter with its driver, the host, this version and its shaders.
fn file_name(adapter: &str, host: &str) -> String {
    let mut hasher = Sha256::new();
    hasher.update(format!("{adapter}\n{host}\n{WORKGROUP}\n"));
    hasher.update(env!("CARGO_PKG_VERSION"));
    for part in PARTS {
        hasher.update(part.wgsl);
        hasher.update(format!("{:?}", (part.constants)()));
    }
    hasher.update(bytemuck::cast_slice::<_, u8>(&NORMAL_TABLE));
    let hash = hasher.finalize();
    let name: String = hash[..8].iter().map(|byte| format!("{byte:02x}")).collect();
    name + ".toml"
}

/// The variant that is fastest: some drivers emulate 64-bit integers.
fn fastest(adapter: &Adapter, self_test: SelfTest) -> Result<Variant, GpuError> {
    let wide = adapter.variant();
    let narrow = Variant { int64: false, ..wide };
    let Some(launch) = wide.int64.then(self_test.timed).flatten() else { return Ok(wide) };
    let mut trials = 1 << 14;
    let opened = |variant| {
        let mut gpu = Gpu::open(adapter, variant)?;
        // The first run compiles the shader.
        seconds(&mut gpu, &launch, trials).map(|_| gpu)
    };
    let Ok(of_wide) = opened(wide) else { return Ok(narrow) };
    let mut gpus = [of_wide, opened(narrow)?];
    while seconds(&mut gpus[1], &launch, trials)? < RUN_SECONDS {
        trials *= 4;
    }
    let (mut best, started) = ([f64::INFINITY; 2], Instant::now());
    // In turn, so that neither profits from a card that has warmed up.
    while started.elapsed().as_secs_f64() < SECONDS || best[1].is_infinite() {
        for (gpu, best) in gpus.iter_mut().zip(&mut best) {
            *best = best.min(seconds(gpu, &launch, trials)?);
        }
    }
    Ok(if best[0] > best[1] { narrow } else { wide })
}

/// Duration of some trials.
fn seconds(gpu: &mut Gpu, launch: &Launch, trials: u64) -> Result<f64, GpuError> {
    let jobs: Vec<Job> = cover(0..trials, 30).into_iter().map(|block| Job { launch, block }).collect();
    let started = Instant::now();
    gpu.tally(&jobs, true, &|_| {})?;
    Ok(started.elapsed().as_secs_f64())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn another_driver_card_or_host_has_another_file() {
        let own = file_name("Some GPU (Vulkan) DiscreteGpu, driver 570.1, PCI 0000:3b:00.0", "node1");
        assert_eq!(own, file_name("Some GPU (Vulkan) DiscreteGpu, driver 570.1, PCI 0000:3b:00.0", "node1"));
        for (adapter, host) in [
            ("Some GPU (Vulkan) DiscreteGpu, driver 570.2, PCI 0000:3b:00.0", "node1"),
            ("Some GPU (Vulkan) DiscreteGpu, driver 570.1, PCI 0000:af:00.0", "node1"),
            ("Some GPU (Vulkan) DiscreteGpu, driver 570.1, PCI 0000:3b:00.0", "node2"),
        ] {
            assert_ne!(own, file_name(adapter, host), "{adapter} of {host}");
        }
    }
}
