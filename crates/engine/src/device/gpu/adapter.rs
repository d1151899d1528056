//! The adapters of this machine.

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
pub(crate) const WORKGROUP: u32 = 64;

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
    pub(crate) fn vendor(&self) -> u32 {
        self.adapter.get_info().vendor
    }

    /// Version of its driver; empty where the interface does not give it.
    pub(crate) fn driver_version(&self) -> String {
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

#[cfg(test)]
mod tests {
    use super::numbered;

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
}
