//! A file for each adapter remembers from an earlier start that it passed its self-test, its fastest variant and its speed.

use std::path::PathBuf;
use std::time::Instant;

use serde::{Deserialize, Serialize};
use sha2::{Digest, Sha256};

use crate::device::error::GpuError;
use crate::device::gpu::Gpu;
use crate::device::gpu::adapter::{Adapter, WORKGROUP};
use crate::device::select::{SelectError, SelfTest, trusted};
use crate::device::{Device, Job};
use crate::tally::cover;
use sagnac_kernel::PARTS;
use sagnac_kernel::launch::Launch;
use sagnac_kernel::normal_table::NORMAL_TABLE;
use sagnac_kernel::shader::Variant;

/// Least time of a run that shows the speed of a variant, and of all runs together, in which the clock rate of a card rises.
const RUN_SECONDS: f64 = 0.02;
const SECONDS: f64 = 0.3;

/// A file in the user's cache folder, for an adapter that passed its self-test.
#[derive(Serialize, Deserialize)]
struct Known {
    /// For people who read the file.
    adapter: String,
    #[serde(flatten)]
    speed: Speed,
}

/// The fastest variant of the kernels for an adapter: some drivers emulate 64-bit integers.
#[derive(Clone, Copy, Serialize, Deserialize)]
struct Speed {
    int64: bool,
    /// Steps of trials per second, with which tiles begin; absent where no kernel was timed.
    steps_per_second: Option<f64>,
}

/// Opens an adapter that passes its self-test, or that passed it before: on this host and place of the bus, with the same
/// driver and the same shaders. The first start measures its speed and, where it has 64-bit integers, whether they are faster.
///
/// # Errors
/// It cannot be opened, computes other bits than the CPU, or fails.
pub(crate) fn open(adapter: &Adapter, threads: usize, self_test: SelfTest) -> Result<Device, SelectError> {
    let failed = |source| SelectError::Gpu { name: adapter.name(), source };
    let file = file(adapter);
    let known: Option<Known> =
        file.as_ref().and_then(|file| toml::from_str(&std::fs::read_to_string(file).ok()?).ok());
    let speed = match &known {
        Some(known) => known.speed,
        None => measured(adapter, self_test).map_err(failed)?,
    };
    let variant = Variant { int64: speed.int64, ..adapter.variant() };
    let mut gpu = Gpu::open(adapter, variant).map_err(failed)?;
    gpu.threads = threads;
    if let Some(steps) = speed.steps_per_second {
        gpu = gpu.paced(steps);
    }
    if known.is_some() {
        return Ok(Device::Gpu(Box::new(gpu.with_self_test(self_test))));
    }
    let device = trusted(gpu, self_test)?;
    let known = toml::to_string(&Known { adapter: adapter.name(), speed });
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

/// The speed of an adapter, which runs its variants in turn so that none profits from a card that has warmed up.
fn measured(adapter: &Adapter, self_test: SelfTest) -> Result<Speed, GpuError> {
    let wide = adapter.variant();
    let narrow = Variant { int64: false, ..wide };
    let Some(launch) = (self_test.timed)() else {
        return Ok(Speed { int64: wide.int64, steps_per_second: None });
    };
    let mut trials = 1 << 14;
    let opened = |variant| {
        let mut gpu = Gpu::open(adapter, variant)?;
        // The first run compiles the shader.
        seconds(&mut gpu, &launch, trials).map(|_| gpu)
    };
    let mut gpus = vec![opened(narrow)?];
    // Where the wide variant does not compile, the narrow one is the fastest.
    gpus.extend(wide.int64.then(|| opened(wide).ok()).flatten());
    while seconds(&mut gpus[0], &launch, trials)? < RUN_SECONDS {
        trials *= 4;
    }
    let (mut best, started) = (vec![f64::INFINITY; gpus.len()], Instant::now());
    while best[0].is_infinite() || gpus.len() > 1 && started.elapsed().as_secs_f64() < SECONDS {
        for (gpu, best) in gpus.iter_mut().zip(&mut best) {
            *best = best.min(seconds(gpu, &launch, trials)?);
        }
    }
    let int64 = best.get(1).is_some_and(|of_wide| *of_wide <= best[0]);
    let shortest = best.into_iter().fold(f64::INFINITY, f64::min);
    Ok(Speed { int64, steps_per_second: Some((trials * launch.steps()) as f64 / shortest) })
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
