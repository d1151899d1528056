//! Why the GPUs of this machine can be used or not.

mod cards;
mod drivers;
mod machine;
mod packages;
#[cfg(all(test, target_os = "linux"))]
mod tests;

use crate::device::gpu::Gpu;
use crate::device::gpu::adapter::Adapter;
use crate::device::gpu::diagnosis::cards::{Card, cards};
use crate::device::gpu::diagnosis::machine::Machine;
use crate::device::select::{SelectError, SelfTest, trusted};

/// A fact about the GPUs of this machine.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Finding {
    /// What was found, and what it means.
    pub found: String,
    /// What to do about it; empty where nothing has to be done.
    pub remedy: String,
}

impl Finding {
    fn new(found: impl Into<String>, remedy: impl Into<String>) -> Finding {
        Finding { found: found.into(), remedy: remedy.into() }
    }
}

/// Opens and tests every adapter, and looks for what the other cards of this machine lack.
pub(crate) fn diagnose(self_test: SelfTest) -> Vec<Finding> {
    let adapters = Adapter::all();
    let mut findings: Vec<Finding> =
        adapters.iter().flat_map(|adapter| of_adapter(adapter, self_test)).collect();
    let real = adapters.iter().filter(|adapter| !adapter.is_software());
    let vendors: Vec<u32> = real.map(Adapter::vendor).collect();
    if cfg!(target_os = "linux") {
        findings.extend(lacking(&Machine::own(), &vendors, adapters.is_empty()));
    } else if vendors.is_empty() {
        let interface = if cfg!(target_os = "macos") { "Metal" } else { "Vulkan or DX12" };
        findings.push(Finding::new(
            format!("no GPU was found: no adapter for {interface} is real hardware"),
            "update the system and the driver of the card; the CPU gives the same results",
        ));
    }
    findings
}

/// What an adapter is good for.
fn of_adapter(adapter: &Adapter, self_test: SelfTest) -> Vec<Finding> {
    let name = adapter.name();
    let opened = Gpu::open(adapter, adapter.variant());
    let failed = |source| SelectError::Gpu { name: name.clone(), source };
    if let Err(error) = opened.map_err(failed).and_then(|gpu| trusted(gpu, self_test)) {
        let message = error.to_string();
        let (found, remedy) =
            message.split_once('\n').unwrap_or((&message, "update its driver, or use `device = cpu`"));
        return vec![Finding::new(found, remedy)];
    }
    let mut findings = vec![if adapter.is_software() {
        Finding::new(
            format!(
                "{name} passed its self-test, but it is a software rasterizer, which runs on the processor"
            ),
            "use the CPU, which is faster: `device = auto` does",
        )
    } else {
        Finding::new(format!("{name} can be used: it passed its self-test"), "")
    }];
    if !adapter.has_int64() {
        findings.push(Finding::new(
            format!(
                "{name} offers no 64-bit integers: products are made of 16-bit parts, which is slower and gives the \
                 same bits"
            ),
            "a newer driver may offer them; nothing has to be done",
        ));
    }
    findings
}

/// What the cards lack for which there is no adapter, given the vendors of the existing adapters.
fn lacking(machine: &Machine, vendors: &[u32], no_adapters: bool) -> Vec<Finding> {
    let cards = cards(machine);
    let unused: Vec<&Card> = cards.iter().filter(|card| !card.is_among(vendors)).collect();
    let mut findings = Vec::new();
    if cards.is_empty() && vendors.is_empty() {
        findings.push(Finding::new(
            "no GPU was found: there is neither /dev/nvidia0 nor /dev/dri/renderD128, nor a card on the PCI bus",
            "nothing has to be done, the CPU gives the same results; start a container with `--gpus all` (NVIDIA) \
             or `--device /dev/dri` (AMD, Intel) to show it the GPUs of its host",
        ));
    }
    if no_adapters {
        findings.extend(drivers::loader(machine));
    }
    if no_adapters || !unused.is_empty() {
        findings.extend(drivers::overridden(machine));
    }
    if no_adapters && unused.is_empty() {
        findings.extend(drivers::none(machine));
    }
    let is_explained = !findings.is_empty();
    for card in unused {
        let mut own = card.refused(machine);
        own.extend(drivers::lacking(machine, card));
        if own.is_empty() && !is_explained {
            own.push(Finding::new(
                format!("this machine has {}, but Vulkan does not offer it, although its driver is installed", card.name()),
                "install libEGL and libGL (libegl1 and libgl1 on Debian and Ubuntu) if they are missing: NVIDIA's driver needs \
                 them even without a display; `VK_LOADER_DEBUG=error,warn,driver sagnac devices` prints what the Vulkan \
                 loader tries",
            ));
        }
        findings.extend(own);
    }
    findings
}

/// In one line: a card of this machine, given the vendors of the GPUs that Vulkan offers.
pub(crate) fn unused_card(vendors: &[u32]) -> Option<String> {
    unused(&Machine::own(), vendors)
}

fn unused(machine: &Machine, vendors: &[u32]) -> Option<String> {
    let is_unused = |card: &Card| card.is_known() && !card.is_among(vendors);
    let name = cards(machine).into_iter().find(is_unused)?.name();
    Some(format!(
        "this machine has {name}, but Vulkan does not offer it (`sagnac device list --why` explains)"
    ))
}
