//! The adapters of this machine: their names, whether their drivers are trusted, how long a driver may take, and faults for
//! tests.

use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::{Path, PathBuf};
use std::sync::mpsc::{RecvTimeoutError, channel};
use std::sync::{Arc, Mutex, MutexGuard, OnceLock, PoisonError};
use std::time::{Duration, Instant};
use std::{fs, thread};

use serde::{Deserialize, Serialize};
use sha2::{Digest, Sha256};

use crate::device::gpu::Gpu;
use crate::device::select::{SelectError, SelfTest, trusted};
use crate::device::{Device, GpuError, Job};
use crate::tally::cover;
use sagnac_kernel::PARTS;
use sagnac_kernel::launch::Launch;
use sagnac_kernel::normal_table::NORMAL_TABLE;
use sagnac_kernel::shader::Variant;

/// How much work a device takes at a time.
pub(crate) struct Capacity {
    /// Workgroups that fill it, with some to spare.
    pub groups: u64,
    /// How many times more invocations share a histogram than form a workgroup without one.
    pub sharing: u32,
    /// Steps of trials of the first tile of a device whose speed is not known.
    pub first_tile: u64,
    /// Records that are made in parallel at least.
    pub records_at_once: u64,
    /// Most records of a batch, and most bytes of angles kept for them.
    pub most_records: usize,
    pub most_bytes: u64,
    /// Most rounds of the loops of an invocation that makes records.
    pub most_rounds: u64,
}

/// A software rasterizer runs a workgroup on each core, fastest out of the caches. llvmpipe leaves every loop after 65535
/// rounds of all loops together, without an error.
const SOFTWARE: Capacity = Capacity {
    groups: 64,
    sharing: 1,
    first_tile: 1 << 18,
    records_at_once: 64,
    most_records: 1 << 14,
    most_bytes: 96 << 20,
    most_rounds: 60_000,
};

/// A GPU in the processor, and any that is not known to be a card. Windows takes a device away from a tile of two seconds.
const INTEGRATED: Capacity = Capacity {
    groups: 1024,
    sharing: 1,
    first_tile: 1 << 20,
    records_at_once: 1 << 12,
    most_records: 1 << 15,
    most_bytes: 512 << 20,
    most_rounds: 1 << 24,
};

/// A large card runs a quarter of a million invocations at a time; a small one does the first tile in half a second.
const DISCRETE: Capacity = Capacity {
    groups: 4096,
    sharing: 2,
    first_tile: 1 << 26,
    records_at_once: 1 << 15,
    most_records: 1 << 18,
    most_bytes: 2 << 30,
    most_rounds: 1 << 24,
};

/// Invocations of a workgroup.
const WORKGROUP: u32 = 64;

/// An adapter of this machine.
#[derive(Clone)]
pub struct Adapter {
    pub(crate) adapter: wgpu::Adapter,
    name: String,
}

impl Adapter {
    /// All adapters, one entry for each interface that drives them.
    pub fn all() -> Vec<Adapter> {
        let mut descriptor = wgpu::InstanceDescriptor::new_without_display_handle();
        descriptor.backends = wgpu::Backends::VULKAN | wgpu::Backends::METAL | wgpu::Backends::DX12;
        if cfg!(feature = "gles") {
            descriptor.backends |= wgpu::Backends::GL;
        }
        let instance = wgpu::Instance::new(descriptor);
        let found = pollster::block_on(instance.enumerate_adapters(wgpu::Backends::all()));
        let named = |adapter: &wgpu::Adapter| {
            let info = adapter.get_info();
            (info.name, info.backend.to_string())
        };
        let names = numbered(found.iter().map(named).collect());
        found.into_iter().zip(names).map(|(adapter, name)| Adapter { adapter, name }).collect()
    }

    /// Name of the device, with its number if there are several of that name, and with the driver's interface.
    pub fn name(&self) -> String {
        self.name.clone()
    }

    /// Address on the PCI bus, such as `0000:3b:00.0`, which distinguishes equal devices; empty where the driver does
    /// not give it.
    pub fn pci_address(&self) -> String {
        self.adapter.get_info().device_pci_bus_id
    }

    /// Whether both are the same device, such as one that two interfaces drive.
    pub(crate) fn is_device_of(&self, other: &Adapter) -> bool {
        let [one, other] = [self, other].map(|adapter| adapter.adapter.get_info());
        if [one.backend, other.backend] == [wgpu::Backend::Dx12; 2] {
            // It lists each device once, but gives equal ones the address of the first.
            return false;
        }
        match [&one, &other].map(|info| info.device_pci_bus_id.as_str()) {
            // Adapters of one interface are different devices.
            ["", _] | [_, ""] => one.name == other.name && one.backend != other.backend,
            [address, of_other] => address.eq_ignore_ascii_case(of_other),
        }
    }

    /// Whether it is a card with memory of its own.
    pub(crate) fn is_discrete(&self) -> bool {
        self.adapter.get_info().device_type == wgpu::DeviceType::DiscreteGpu
    }

    /// Whether it is a software rasterizer on the processor.
    pub fn is_software(&self) -> bool {
        self.adapter.get_info().device_type == wgpu::DeviceType::Cpu
    }

    /// Number of the vendor, which is that on the PCI bus for a card.
    fn vendor(&self) -> u32 {
        self.adapter.get_info().vendor
    }

    /// Version of its driver; empty where the interface does not give it.
    fn driver_version(&self) -> String {
        self.adapter.get_info().driver_info
    }

    /// Driver and capabilities as text.
    pub fn description(&self) -> String {
        let info = self.adapter.get_info();
        let products = self.variant().products();
        let pci = if info.device_pci_bus_id.is_empty() { "" } else { ", PCI " };
        let address = info.device_pci_bus_id;
        format!(
            "{:?}, driver {} {}, {products}{pci}{address}",
            info.device_type, info.driver, info.driver_info
        )
    }

    /// Whether its shaders have 64-bit registers.
    pub fn has_int64(&self) -> bool {
        self.adapter.features().contains(wgpu::Features::SHADER_INT64)
    }

    /// How much work it takes at a time.
    pub(crate) fn capacity(&self) -> &'static Capacity {
        match self.adapter.get_info().device_type {
            wgpu::DeviceType::Cpu => &SOFTWARE,
            wgpu::DeviceType::DiscreteGpu => &DISCRETE,
            _ => &INTEGRATED,
        }
    }

    /// The fastest variant of the kernels for this adapter.
    pub fn variant(&self) -> Variant {
        Variant { int64: self.has_int64(), checked: false, workgroup: WORKGROUP }
    }
}

/// Names of adapters from those of their devices and interfaces, such as `NVIDIA L4 #2 (Vulkan)` for the second of equal ones.
fn numbered(adapters: Vec<(String, String)>) -> Vec<String> {
    let equal =
        |all: &[(String, String)], one: &(String, String)| all.iter().filter(|other| *other == one).count();
    let name = |(at, one): (usize, &(String, String))| match equal(&adapters, one) {
        1 => format!("{} ({})", one.0, one.1),
        _ => format!("{} #{} ({})", one.0, equal(&adapters[..=at], one), one.1),
    };
    adapters.iter().enumerate().map(name).collect()
}

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

/// How long a shader may take before the user is told, and how much longer before the device is given up. Together
/// they are the time that [`GpuError::Stuck`] names.
const PATIENCE: [Duration; 2] = [Duration::from_secs(20), Duration::from_secs(280)];

static LISTENER: OnceLock<fn(&str)> = OnceLock::new();

/// Sets what receives a sentence for the user while a driver takes long. A self-test compiles shaders before any run
/// has begun, so this is not told as [`Progress`](sagnac_base::progress::Progress). Only the first call has an effect.
pub fn on_wait(listener: fn(&str)) {
    // A second listener is ignored, as documented.
    let _ = LISTENER.set(listener);
}

/// The result of a call into the driver of `name`, if it returns within the limit. `is_stuck` is for tests: the call
/// never returns, and the limit is a thousandth.
///
/// A call into a driver cannot be cancelled. A thread of its own makes it, and if the driver does not return, that thread stays
/// behind.
pub(crate) fn within_limit<T: Send + 'static>(
    name: &str,
    is_stuck: bool,
    call: impl FnOnce() -> T + Send + 'static,
) -> Result<T, GpuError> {
    let [until_told, rest] = if is_stuck { PATIENCE.map(|time| time / 1000) } else { PATIENCE };
    let (sender, receiver) = channel();
    let calling = thread::Builder::new().name("driver".to_owned()).spawn(move || {
        if is_stuck {
            loop {
                thread::park();
            }
        }
        // Nobody receives a result that comes too late.
        let _ = sender.send(call());
    });
    calling.map_err(|error| GpuError::Refused(format!("cannot start a thread: {error}")))?;
    let mut result = receiver.recv_timeout(until_told);
    if matches!(result, Err(RecvTimeoutError::Timeout)) {
        if let Some(tell) = LISTENER.get() {
            tell(&format!(
                "{name}: its driver still compiles a shader; after 5 minutes the device is given up"
            ));
        }
        result = receiver.recv_timeout(rest);
    }
    result.map_err(|error| match error {
        RecvTimeoutError::Timeout => GpuError::Stuck,
        RecvTimeoutError::Disconnected => GpuError::Refused("its driver failed".to_owned()),
    })
}

/// Errors that wgpu has reported of a device.
#[derive(Clone, Default)]
pub(crate) struct Heard(Arc<Mutex<Told>>);

#[derive(Default)]
struct Told {
    /// First error since the last query; later ones mostly follow from it.
    complaint: Option<GpuError>,
    /// Message of a loss; a lost device stays lost.
    lost: Option<String>,
}

impl Heard {
    /// Listens to a device from now on.
    pub(crate) fn new(device: &wgpu::Device) -> Heard {
        let heard = Heard::default();
        let complaints = heard.clone();
        device.on_uncaptured_error(Arc::new(move |error| complaints.complain(&error)));
        let losses = heard.clone();
        device.set_device_lost_callback(move |reason, message| {
            let message = if message.is_empty() { format!("{reason:?}") } else { message };
            losses.told().lost.get_or_insert(message);
        });
        heard
    }

    fn told(&self) -> MutexGuard<'_, Told> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }

    fn complain(&self, error: &wgpu::Error) {
        let complaint = match error {
            wgpu::Error::OutOfMemory { .. } => GpuError::OutOfMemory,
            other => GpuError::Refused(other.to_string()),
        };
        self.told().complaint.get_or_insert(complaint);
    }

    /// A loss, or the first error since the last query.
    pub(crate) fn failure(&self) -> Result<(), GpuError> {
        let mut told = self.told();
        let complaint = told.complaint.take();
        match &told.lost {
            Some(message) => Err(GpuError::Lost(message.clone())),
            None => complaint.map_or(Ok(()), Err),
        }
    }
}

/// Moments at which a test may make a device fail.
#[doc(hidden)]
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Moment {
    /// Just before it is opened again.
    Opening,
    /// After a new pipeline has computed what the processor knows; any fault makes it wrong.
    Answer,
    /// Just before its driver compiles a shader.
    Pipeline,
    /// Just before it receives work of this size: steps of trials, chunks of records, or items.
    Tile(u64),
}

/// How it fails. Every fault also keeps it from being opened again.
#[doc(hidden)]
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Fault {
    OutOfMemory,
    /// Loss before it receives the tile.
    LostBefore,
    /// Loss while it works on the tile.
    LostAfter,
    /// One wrong bit in the results.
    WrongBits,
    /// Its driver never finishes compiling a shader.
    Stuck,
}

/// The faults of a test, by moment.
#[doc(hidden)]
pub type Faults = Arc<dyn Fn(Moment) -> Option<Fault> + Send + Sync>;

/// Work submitted to a device.
pub(crate) struct Submission {
    index: wgpu::SubmissionIndex,
    /// Whether a test requests a wrong bit in its results.
    pub(crate) wrong: bool,
}

impl Gpu {
    /// Makes the device fail when `faults` says so, even after it was opened again.
    #[doc(hidden)]
    pub fn inject(&mut self, faults: Faults) {
        self.faults = Some(faults);
    }

    pub(crate) fn fault(&self, moment: Moment) -> Option<Fault> {
        self.faults.as_ref().and_then(|faults| faults(moment))
    }

    /// Submits commands of size `work` to the device, unless there is an error.
    pub(crate) fn submit(&self, encoder: wgpu::CommandEncoder, work: u64) -> Result<Submission, GpuError> {
        let commands = encoder.finish();
        let fault = self.fault(Moment::Tile(work));
        match fault {
            Some(Fault::OutOfMemory) => {
                self.heard.complain(&wgpu::Error::OutOfMemory { source: "requested by a test".into() });
            }
            Some(Fault::LostBefore) => self.device.destroy(),
            _ => {}
        }
        self.heard.failure()?;
        let index = self.queue.submit([commands]);
        if fault == Some(Fault::LostAfter) {
            self.device.destroy();
        }
        Ok(Submission { index, wrong: fault == Some(Fault::WrongBits) })
    }

    /// Waits until the device has completed a submission.
    pub(crate) fn wait(&self, submission: &Submission) -> Result<(), GpuError> {
        self.poll(Some(submission.index.clone()))
    }

    /// Waits for one submission, or for all.
    fn poll(&self, submission_index: Option<wgpu::SubmissionIndex>) -> Result<(), GpuError> {
        let wait = wgpu::PollType::Wait { submission_index, timeout: None };
        // If the driver finds a loss during this call, wgpu reports it first and then panics.
        let polled = catch_unwind(AssertUnwindSafe(|| self.device.poll(wait)));
        self.heard.failure()?;
        match polled {
            Ok(Ok(_)) => Ok(()),
            Ok(Err(error)) => Err(GpuError::Refused(error.to_string())),
            Err(_) => Err(GpuError::Lost("its driver failed".to_owned())),
        }
    }

    /// Waits for all work after a failure, so that nothing of it affects later work, and returns the cause: wgpu
    /// reports some losses only when all work is done, and before that the errors that follow from them.
    pub(crate) fn settled(&self, error: GpuError) -> GpuError {
        // A driver that is stuck may not end this wait either.
        if matches!(error, GpuError::Lost(_) | GpuError::Stuck) {
            return error;
        }
        let end = self.poll(None);
        // Other errors that follow from the failure are not errors of later work.
        let rest = self.heard.failure();
        match end.and(rest) {
            Err(lost @ GpuError::Lost(_)) => lost,
            _ => error,
        }
    }
}

/// The vendors of GPUs by their numbers on the PCI bus.
const VENDORS: [(u32, &str); 3] =
    [(0x10de, "an NVIDIA card"), (0x1002, "an AMD card"), (0x8086, "an Intel card")];

/// In one line: a card that the kernel of this machine shows, and that is of another vendor than all GPUs among these adapters.
pub fn unused_card(adapters: &[Adapter]) -> Option<String> {
    let real = adapters.iter().filter(|adapter| !adapter.is_software());
    unused(Path::new("/"), &real.map(Adapter::vendor).collect::<Vec<_>>())
}

/// The line for the machine whose files are in the folder `root`, given the vendors of the GPUs that Vulkan offers.
fn unused(root: &Path, offered: &[u32]) -> Option<String> {
    let vendors = |folder: &str, file: &str| -> Vec<u32> {
        let entries = fs::read_dir(root.join(folder)).into_iter().flatten().flatten();
        let number = |text: String| u32::from_str_radix(text.trim().trim_start_matches("0x"), 16).ok();
        entries.filter_map(|entry| number(fs::read_to_string(entry.path().join(file)).ok()?)).collect()
    };
    // A container may hide the bus of a card whose driver it has.
    let nvidia = root.join("dev/nvidia0").exists().then_some(VENDORS[0].0);
    let present: Vec<u32> = vendors("sys/class/drm", "device/vendor").into_iter().chain(nvidia).collect();
    let (_, name) =
        VENDORS.iter().find(|(vendor, _)| present.contains(vendor) && !offered.contains(vendor))?;
    Some(format!(
        "this machine has {name}, but Vulkan does not offer it (see \"A GPU that is not used\" in docs/reference/exit-codes.md)"
    ))
}

#[cfg(test)]
mod tests {
    use super::{numbered, *};

    #[test]
    fn equal_adapters_of_one_interface_are_numbered() {
        let adapters =
            [("NVIDIA L4", "Vulkan"), ("NVIDIA L4", "Vulkan"), ("NVIDIA L4", "Dx12"), ("llvmpipe", "Vulkan")];
        let names = numbered(adapters.map(|(name, backend)| (name.to_owned(), backend.to_owned())).into());
        assert_eq!(
            names,
            ["NVIDIA L4 #1 (Vulkan)", "NVIDIA L4 #2 (Vulkan)", "NVIDIA L4 (Dx12)", "llvmpipe (Vulkan)"]
        );
    }

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

    #[test]
    fn a_card_without_an_adapter_is_named() {
        let machine = tempfile::tempdir().unwrap();
        let device = machine.path().join("sys/class/drm/renderD128/device");
        fs::create_dir_all(&device).unwrap();
        fs::write(device.join("vendor"), "0x1002\n").unwrap();
        assert!(unused(machine.path(), &[]).unwrap().starts_with("this machine has an AMD card"));
        assert_eq!(unused(machine.path(), &[0x1002]), None);
        fs::create_dir(machine.path().join("dev")).unwrap();
        fs::write(machine.path().join("dev/nvidia0"), "").unwrap();
        assert!(unused(machine.path(), &[0x1002]).unwrap().starts_with("this machine has an NVIDIA card"));
        assert_eq!(unused(&machine.path().join("empty"), &[]), None);
    }
}
