//! What is known of an adapter from an earlier start: that it passed its self-test, and its fastest variant.

use std::path::PathBuf;
use std::time::Instant;

use serde::{Deserialize, Serialize};
use sha2::{Digest, Sha256};

use crate::device::error::GpuError;
use crate::device::gpu::Gpu;
use crate::device::gpu::adapter::Adapter;
use crate::device::select::{SelectError, SelfTest, trusted};
use crate::device::{Device, Job};
use crate::kernel::PARTS;
use crate::kernel::launch::Launch;
use crate::kernel::normal_table::NORMAL_TABLE;
use crate::kernel::shader::Variant;
use crate::tally::block::cover;

/// Time in which a variant shows its speed.
const TIMED_SECONDS: f64 = 0.02;

/// A file in the user's cache folder, for an adapter that passed its self-test.
#[derive(Debug, PartialEq, Eq, Serialize, Deserialize)]
struct Known {
    adapter: String,
    int64: bool,
}

/// Opens an adapter that passes its self-test, or that passed it before: on this place of the bus, with the same driver
/// and the same shaders. Where it has 64-bit integers, the first start finds out whether they are faster.
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

/// The file of an adapter, named by all on which its results and its speed depend.
fn file(adapter: &Adapter) -> Option<PathBuf> {
    let mut hasher = Sha256::new();
    hasher.update(format!("{} {}\n", adapter.name(), adapter.description()));
    hasher.update(env!("CARGO_PKG_VERSION"));
    for part in PARTS {
        hasher.update(part.wgsl);
        hasher.update(format!("{:?}", (part.constants)()));
    }
    hasher.update(bytemuck::cast_slice::<_, u8>(&NORMAL_TABLE));
    let hash = hasher.finalize();
    let name: String = hash[..8].iter().map(|byte| format!("{byte:02x}")).collect();
    Some(dirs::cache_dir()?.join("sagnac").join("adapters").join(name + ".toml"))
}

/// The variant that is fastest: some drivers emulate 64-bit integers.
fn fastest(adapter: &Adapter, self_test: SelfTest) -> Result<Variant, GpuError> {
    let wide = adapter.variant();
    let narrow = Variant { int64: false, ..wide };
    let Some(launch) = wide.int64.then(self_test.timed).flatten() else { return Ok(wide) };
    let is_slower = rate(adapter, wide, &launch)? < rate(adapter, narrow, &launch)?;
    Ok(if is_slower { narrow } else { wide })
}

/// Trials of a launch per second.
fn rate(adapter: &Adapter, variant: Variant, launch: &Launch) -> Result<f64, GpuError> {
    let mut gpu = Gpu::open(adapter, variant)?;
    let mut trials = 1 << 14;
    loop {
        let jobs: Vec<Job> = cover(0..trials, 30).into_iter().map(|block| Job { launch, block }).collect();
        let started = Instant::now();
        gpu.tally(&jobs, true, &|_| {})?;
        let seconds = started.elapsed().as_secs_f64();
        // The first call compiles the shader.
        if trials > 1 << 14 && seconds > TIMED_SECONDS {
            return Ok(trials as f64 / seconds);
        }
        trials *= 4;
    }
}
