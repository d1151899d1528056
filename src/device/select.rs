//! Selection of a device: `auto`, `cpu`, `gpu`, a width of the CPU, or part of an adapter's name or its PCI address.

use crate::device::Device;
use crate::device::cpu::Cpu;
use crate::device::error::GpuError;
use crate::device::gpu::Gpu;
use crate::device::gpu::adapter::Adapter;
use crate::device::gpu::trust;
use crate::kernel::launch::Launch;
use crate::kernel::width::Width;

/// What an adapter must show before it is used.
#[derive(Debug, Clone, Copy)]
pub struct SelfTest {
    /// Returns the first kernel, if any, in which a device differs from the portable CPU.
    pub differs: fn(&mut Device) -> Result<Option<&'static str>, GpuError>,
    /// Returns a launch that shows how fast a device is.
    pub timed: fn() -> Option<Launch>,
}

/// Why the requested device is not available.
#[derive(Debug, thiserror::Error)]
pub enum SelectError {
    /// A GPU was requested, but no adapter is one.
    #[error(
        "no GPU was found\nuse `device = cpu`, or install a Vulkan driver; `sagnac devices` lists the available devices"
    )]
    NoGpu,
    /// No width and no adapter has the requested name.
    #[error("no device is called `{name}`; the devices are {}", known.join(", "))]
    Unknown {
        /// Requested name.
        name: String,
        /// Available names.
        known: Vec<String>,
    },
    /// The requested adapter cannot be opened or fails.
    #[error("{name} cannot be used: {source}")]
    Gpu {
        /// Name of the adapter.
        name: String,
        /// Error of the adapter.
        source: GpuError,
    },
    /// The adapter failed its self-test: it computes other bits than the CPU.
    #[error(
        "{name} computes other bits than the CPU in {kernel}: it is not used\nupdate its driver, or use `device = cpu`"
    )]
    Untrusted {
        /// Name of the adapter.
        name: String,
        /// The first kernel that differs.
        kernel: &'static str,
    },
    /// The requested threads cannot be started.
    #[error("cannot start threads: {0}")]
    Threads(#[from] rayon::ThreadPoolBuildError),
}

impl SelectError {
    /// Whether the request was wrong, rather than the machine at fault.
    pub fn is_usage(&self) -> bool {
        matches!(self, SelectError::NoGpu | SelectError::Unknown { .. })
    }
}

/// A device, with the reason for its selection.
pub struct Selection {
    /// The device, ready to run.
    pub device: Device,
    /// Reason for its selection, in one line for the user.
    pub reason: String,
}

/// Opens every adapter of this machine without a self-test, for a check of identity.
///
/// # Errors
/// An adapter cannot be opened.
pub fn every_adapter() -> Result<Vec<Device>, SelectError> {
    Adapter::all().iter().map(|adapter| Ok(Device::Gpu(Box::new(opened(adapter)?)))).collect()
}

/// Selects the device that `wanted` names. `auto` selects a real GPU that passes its self-test, else the CPU. The CPU,
/// even where it has to replace a GPU, uses `threads` threads; 0 means all logical cores.
///
/// # Errors
/// There is no such device, it does not work, or it computes other bits than the CPU.
pub fn select(wanted: &str, threads: usize, self_test: SelfTest) -> Result<Selection, SelectError> {
    match wanted {
        "cpu" => cpu(Width::widest(), threads, "as asked"),
        "auto" => auto(threads, self_test),
        "gpu" => {
            let adapters = Adapter::all();
            let adapter = adapters.iter().find(|adapter| !adapter.is_software()).or(adapters.first());
            open(adapter.ok_or(SelectError::NoGpu)?, threads, "as asked", self_test)
        }
        part => {
            let is_wanted = |width: &Width| width.name().eq_ignore_ascii_case(part);
            if let Some(width) = Width::available().into_iter().find(is_wanted) {
                return cpu(width, threads, "as asked");
            }
            let adapters = Adapter::all();
            let is_meant = |adapter: &&Adapter| means(part, &adapter.name(), &adapter.pci_address());
            match adapters.iter().find(is_meant) {
                Some(adapter) => open(adapter, threads, "as asked", self_test),
                None => {
                    let widths = Width::available().into_iter().map(Width::name);
                    let known = ["auto", "cpu", "gpu"].into_iter().chain(widths).map(str::to_owned);
                    let known = known.chain(adapters.iter().map(Adapter::name)).collect();
                    Err(SelectError::Unknown { name: part.to_owned(), known })
                }
            }
        }
    }
}

/// Whether `wanted` is part of an adapter's name, or its PCI address.
fn means(wanted: &str, name: &str, pci_address: &str) -> bool {
    // An empty text is part of every name, and some adapters have no address, but neither selects an adapter.
    let is_named = name.to_lowercase().contains(&wanted.to_lowercase());
    !wanted.trim().is_empty() && (is_named || pci_address.eq_ignore_ascii_case(wanted))
}

fn auto(threads: usize, self_test: SelfTest) -> Result<Selection, SelectError> {
    let adapters = Adapter::all();
    match (adapters.iter().find(|adapter| !adapter.is_software()), adapters.first()) {
        (Some(gpu), _) => or_cpu(open(gpu, threads, "a GPU that passed its self-test", self_test), threads),
        (None, None) => cpu(Width::widest(), threads, "no GPU was found"),
        (None, Some(software)) => {
            let reason = format!("the only adapter, {}, is a software rasteriser", software.name());
            cpu(Width::widest(), threads, &reason)
        }
    }
}

/// Falls back to the CPU where a GPU cannot be used, and gives the reason.
fn or_cpu(opened: Result<Selection, SelectError>, threads: usize) -> Result<Selection, SelectError> {
    match opened {
        Err(error) => cpu(Width::widest(), threads, &error.to_string().replace('\n', "; ")),
        selected => selected,
    }
}

fn cpu(width: Width, threads: usize, reason: &str) -> Result<Selection, SelectError> {
    Ok(Selection { device: Device::Cpu(Cpu::new(width, threads)?), reason: reason.to_owned() })
}

fn opened(adapter: &Adapter) -> Result<Gpu, SelectError> {
    let failed = |source| SelectError::Gpu { name: adapter.name(), source };
    Gpu::open(adapter, adapter.variant()).map_err(failed)
}

fn open(
    adapter: &Adapter,
    threads: usize,
    reason: &str,
    self_test: SelfTest,
) -> Result<Selection, SelectError> {
    Ok(Selection { device: trust::open(adapter, threads, self_test)?, reason: reason.to_owned() })
}

/// Opens the adapter of a lost device again.
///
/// # Errors
/// It cannot be opened, or fails its self-test.
pub(crate) fn reopen(lost: &Gpu) -> Result<Device, SelectError> {
    let opened = lost.opened_again();
    let gpu = opened.map_err(|source| SelectError::Gpu { name: lost.name().to_owned(), source })?;
    match lost.self_test {
        Some(self_test) => trusted(gpu, self_test),
        None => Ok(Device::Gpu(Box::new(gpu))),
    }
}

/// Makes a device of a GPU that passes its self-test.
///
/// # Errors
/// It computes other bits than the CPU, or fails.
pub fn trusted(gpu: Gpu, self_test: SelfTest) -> Result<Device, SelectError> {
    let name = gpu.name().to_owned();
    let mut device = Device::Gpu(Box::new(gpu.with_self_test(self_test)));
    match (self_test.differs)(&mut device) {
        Ok(None) => Ok(device),
        Ok(Some(kernel)) => Err(SelectError::Untrusted { name, kernel }),
        Err(source) => Err(SelectError::Gpu { name, source }),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn auto_takes_the_cpu_for_a_gpu_that_cannot_be_trusted_and_says_why() {
        let untrusted = SelectError::Untrusted { name: "Some GPU".to_owned(), kernel: "sine" };
        let Selection { device, reason } = or_cpu(Err(untrusted), 0).unwrap();
        assert!(matches!(device, Device::Cpu(_)), "{}", device.name());
        assert!(reason.contains("Some GPU computes other bits than the CPU in sine"), "{reason}");
        assert!(!reason.contains('\n'), "{reason:?}");
    }

    #[test]
    fn equal_adapters_are_told_apart_by_their_pci_address() {
        let name = "NVIDIA L4 (Vulkan)";
        let meant = |wanted: &str| {
            ["0000:3b:00.0", "0000:af:00.0", ""].map(|pci_address| means(wanted, name, pci_address))
        };
        assert_eq!(meant("nvidia l4"), [true, true, true]);
        assert_eq!(meant("0000:AF:00.0"), [false, true, false], "as nvidia-smi writes it");
        assert_eq!(meant("00.0"), [false; 3], "a part of an address means none");
        assert_eq!(meant(" "), [false; 3]);
        assert_eq!(meant(""), [false; 3]);
    }
}
