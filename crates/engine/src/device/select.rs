//! Selection of devices: `auto`, `all`, or one or a list of `cpu`, a width of the CPU, `gpu`, `gpu:0`, part of an
//! adapter's name, and its PCI address. Capitals do not matter, nor do hyphens and blanks in a width.

use std::cell::LazyCell;

use crate::device::gpu::Gpu;
use crate::device::gpu::adapter::{self, Adapter, unused_card};
use crate::device::group::Group;
use crate::device::{Cpu, Device, GpuError};
use sagnac_kernel::launch::Launch;
use sagnac_kernel::width::Width;

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
        "no GPU was found\nuse `device = cpu`, or install the Vulkan driver of the card: \"A GPU that is not used\" in docs/reference/exit-codes.md says how"
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
    /// A list contains a word that selects devices by itself.
    #[error(
        "`{name}` cannot stand in a list\ngive it alone, or name the devices, as in `device = cpu,gpu:0`"
    )]
    Alone {
        /// The word.
        name: String,
    },
    /// A list names a device twice.
    #[error(
        "`{name}` is the same device as `{earlier}`\nname each device once; `sagnac device list` numbers the adapters as gpu:0, gpu:1 and so on"
    )]
    Twice {
        /// The later name.
        name: String,
        /// The earlier name.
        earlier: String,
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
        matches!(
            self,
            SelectError::NoGpu
                | SelectError::Unknown { .. }
                | SelectError::Alone { .. }
                | SelectError::Twice { .. }
        )
    }
}

/// A device, with the reason for its selection.
pub struct Selection {
    /// The device, ready to run.
    pub device: Device,
    /// Reason for its selection, in one line for the user.
    pub reason: String,
    /// The adapters that `auto` and `all` leave out, each with the reason in one line for the user.
    pub left_out: Vec<String>,
}

/// Opens every adapter of this machine without a self-test, for a check of identity.
///
/// # Errors
/// An adapter cannot be opened.
pub fn every_adapter() -> Result<Vec<Device>, SelectError> {
    Adapter::all().iter().map(|adapter| Ok(Device::Gpu(Box::new(opened(adapter)?)))).collect()
}

/// Selects the device that `wanted` names. `auto` selects a real GPU that passes its self-test, else the CPU. `all`
/// selects the CPU and all real GPUs that pass their self-tests, which share the work, and so do the devices of a list
/// such as `cpu,gpu:0`. The CPU, even where it has to replace a GPU, uses `threads` threads; 0 means all logical cores.
///
/// # Errors
/// There is no such device, it does not work, it computes other bits than the CPU, or a list names it twice.
pub fn select(wanted: &str, threads: usize, self_test: SelfTest) -> Result<Selection, SelectError> {
    Machine { adapters: LazyCell::new(Adapter::all), threads, self_test: Some(self_test) }.select(wanted)
}

/// Selects the device that `wanted` names, as [`select`] does, but without a self-test, for a check of identity.
///
/// # Errors
/// There is no such device, it does not work, or a list names it twice.
pub fn untested(wanted: &str) -> Result<Selection, SelectError> {
    Machine { adapters: LazyCell::new(Adapter::all), threads: 0, self_test: None }.select(wanted)
}

fn selection(device: Device, reason: &str) -> Result<Selection, SelectError> {
    Ok(Selection { device, reason: reason.to_owned(), left_out: vec![] })
}

/// A device by what it runs on.
#[derive(Clone, Copy)]
enum Choice {
    Cpu(Width),
    /// The adapter at this place of the list.
    Gpu(usize),
}

/// The devices to select from, and how they are opened.
struct Machine {
    /// Adapters are queried only where a name may mean one.
    adapters: LazyCell<Vec<Adapter>>,
    threads: usize,
    /// What adapters must pass; without it, they are opened untested.
    self_test: Option<SelfTest>,
}

impl Machine {
    fn select(&self, wanted: &str) -> Result<Selection, SelectError> {
        match wanted.to_lowercase().as_str() {
            "auto" => self.auto(),
            "all" => self.all(),
            _ => selection(self.named(wanted)?, "as asked"),
        }
    }

    fn auto(&self) -> Result<Selection, SelectError> {
        let real = self.real();
        if real.is_empty() {
            let reason = unused_card(&self.adapters).unwrap_or_else(|| match self.adapters.first() {
                Some(software) => format!("the only adapter, {}, is a software rasterizer", software.name()),
                None => "no GPU was found".to_owned(),
            });
            return selection(self.cpu()?, &reason);
        }
        let Selection { device, reason, mut left_out } =
            self.first_of(real.into_iter().map(|at| self.open(Choice::Gpu(at))))?;
        left_out.extend(unused_card(&self.adapters));
        Ok(Selection { device, reason, left_out })
    }

    /// The first GPU that can be used, else the CPU, with the reasons why others cannot.
    fn first_of(
        &self,
        gpus: impl Iterator<Item = Result<Device, SelectError>>,
    ) -> Result<Selection, SelectError> {
        let mut failures = vec![];
        for gpu in gpus {
            match gpu {
                Ok(device) => {
                    let reason = "a GPU that passed its self-test".to_owned();
                    return Ok(Selection { device, reason, left_out: failures });
                }
                Err(error) => failures.push(in_one_line(&error)),
            }
        }
        Ok(Selection { device: self.cpu()?, reason: failures.remove(0), left_out: failures })
    }

    /// Places of the adapters that are no software rasterizers, cards first.
    fn real(&self) -> Vec<usize> {
        let adapters = &*self.adapters;
        let mut real: Vec<usize> = (0..adapters.len()).filter(|&at| !adapters[at].is_software()).collect();
        real.sort_by_key(|&at| !adapters[at].is_discrete());
        real
    }

    fn all(&self) -> Result<Selection, SelectError> {
        let (mut device, mut used, mut left_out) = (self.cpu()?, Vec::<&Adapter>::new(), vec![]);
        for (at, adapter) in self.adapters.iter().enumerate() {
            if adapter.is_software() {
                left_out.push(format!(
                    "{} is left out: it is a software rasterizer, which shares the cores of the CPU",
                    adapter.name()
                ));
            } else if !used.iter().any(|used| used.is_device_of(adapter)) {
                match self.open(Choice::Gpu(at)) {
                    Ok(gpu) => {
                        device = device.and(gpu);
                        used.push(adapter);
                    }
                    Err(error) => left_out.push(format!("{}; it is left out", in_one_line(&error))),
                }
            }
        }
        let reason = match device {
            Device::Group(_) => "all that can be used",
            _ => "no GPU can be used",
        };
        Ok(Selection { device, reason: reason.to_owned(), left_out })
    }

    /// The device that a name means, or the group of a list of names.
    fn named(&self, names: &str) -> Result<Device, SelectError> {
        match self.choice(names) {
            // The name of an adapter may contain commas, so only what is no name is a list.
            Err(SelectError::Unknown { .. }) if names.contains(',') => {}
            choice => return self.open(choice?),
        }
        let mut choices: Vec<(&str, Choice)> = Vec::new();
        for name in names.split(',').map(str::trim) {
            if ["auto", "all"].iter().any(|word| name.eq_ignore_ascii_case(word)) {
                return Err(SelectError::Alone { name: name.to_owned() });
            }
            let choice = self.choice(name)?;
            if let Some((earlier, _)) = choices.iter().find(|(_, earlier)| self.are_one(*earlier, choice)) {
                return Err(SelectError::Twice { name: name.to_owned(), earlier: (*earlier).to_owned() });
            }
            choices.push((name, choice));
        }
        let devices = choices.into_iter().map(|(_, choice)| self.open(choice)).collect::<Result<_, _>>()?;
        Ok(Device::Group(Group::new(devices)))
    }

    fn choice(&self, name: &str) -> Result<Choice, SelectError> {
        let is_named = |width: &Width| spelled(width.name()) == spelled(name);
        if name.eq_ignore_ascii_case("cpu") {
            return Ok(Choice::Cpu(Width::widest()));
        }
        if let Some(width) = Width::available().into_iter().find(is_named) {
            return Ok(Choice::Cpu(width));
        }
        let adapters = &*self.adapters;
        let found = match name.to_lowercase().strip_prefix("gpu") {
            Some("") if adapters.is_empty() => return Err(SelectError::NoGpu),
            Some("") => Some(self.real().first().copied().unwrap_or(0)),
            Some(number) if number.starts_with(':') => {
                number[1..].parse().ok().filter(|&at| at < adapters.len())
            }
            _ => adapters.iter().position(|adapter| means(name, &adapter.name(), &adapter.pci_address())),
        };
        found.map(Choice::Gpu).ok_or_else(|| {
            let widths = Width::available().into_iter().map(|width| width.name().to_owned());
            let words = ["auto", "cpu", "gpu", "all"].map(str::to_owned);
            let adapters = adapters.iter().enumerate();
            let adapters = adapters.map(|(at, adapter)| format!("gpu:{at} = {}", adapter.name()));
            let known = words.into_iter().chain(widths).chain(adapters).collect();
            SelectError::Unknown { name: name.to_owned(), known }
        })
    }

    /// Whether two choices are one device.
    fn are_one(&self, one: Choice, other: Choice) -> bool {
        match (one, other) {
            (Choice::Cpu(_), Choice::Cpu(_)) => true,
            (Choice::Gpu(one), Choice::Gpu(other)) => {
                one == other || self.adapters[one].is_device_of(&self.adapters[other])
            }
            _ => false,
        }
    }

    fn open(&self, choice: Choice) -> Result<Device, SelectError> {
        match choice {
            Choice::Cpu(width) => Ok(Device::Cpu(Cpu::new(width, self.threads)?)),
            Choice::Gpu(at) => match self.self_test {
                Some(self_test) => adapter::open(&self.adapters[at], self.threads, self_test),
                None => Ok(Device::Gpu(Box::new(opened(&self.adapters[at])?))),
            },
        }
    }

    fn cpu(&self) -> Result<Device, SelectError> {
        self.open(Choice::Cpu(Width::widest()))
    }
}

/// The letters and figures of a name, in lower case: `avx512` for `AVX-512`.
fn spelled(name: &str) -> String {
    name.chars().filter(|sign| sign.is_alphanumeric()).collect::<String>().to_lowercase()
}

/// Whether `wanted` is part of an adapter's name, or its PCI address.
fn means(wanted: &str, name: &str, pci_address: &str) -> bool {
    // An empty text is part of every name, and some adapters have no address, but neither selects an adapter.
    let is_named = name.to_lowercase().contains(&wanted.to_lowercase());
    !wanted.trim().is_empty() && (is_named || pci_address.eq_ignore_ascii_case(wanted))
}

fn in_one_line(error: &SelectError) -> String {
    error.to_string().replace('\n', "; ")
}

fn opened(adapter: &Adapter) -> Result<Gpu, SelectError> {
    let failed = |source| SelectError::Gpu { name: adapter.name(), source };
    Gpu::open(adapter, adapter.variant()).map_err(failed)
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
        Ok(None) => {
            // The loads of the test are too small to show how long tiles take.
            if let Device::Gpu(gpu) = &mut device {
                gpu.begin();
            }
            Ok(device)
        }
        Ok(Some(kernel)) => {
            if let Device::Gpu(gpu) = &device {
                gpu.distrust();
            }
            Err(SelectError::Untrusted { name, kernel })
        }
        Err(source) => Err(SelectError::Gpu { name, source }),
    }
}

#[cfg(test)]
mod tests;
